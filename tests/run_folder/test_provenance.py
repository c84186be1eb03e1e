"""What results.nc says of what a run was made with."""

from __future__ import annotations

from fbcouple.run_folder.provenance import Making


def test_source_names_the_programs_that_the_run_needs():
    versions = {"fbcouple": "0.1.0, sources 0123", "commit": "abc", "LIGGGHTS": "LIGGGHTS-PUBLIC 3.8.0"}
    attributes = Making(versions, [], []).list_attributes()
    assert attributes["source"] == "fbcouple 0.1.0, sources 0123; LIGGGHTS LIGGGHTS-PUBLIC 3.8.0"
    assert attributes == versions | {"source": attributes["source"]}


def test_changes_and_updates_are_named_only_where_there_are_some():
    attributes = Making({"fbcouple": "1"}, ["DEM/in.liggghts"], ["a", "b"]).list_attributes()
    assert attributes["changed_since_set_up"] == "DEM/in.liggghts" and attributes["updates"] == "a\nb"


def test_changes_of_the_inlet_have_their_times():
    changes = [{"time": 0.5, "inlet": "inlet 1: a"}, {"time": 0.5, "inlet": "inlet 2: b"}]
    attributes = Making({"fbcouple": "1"}, [], [], changes).list_attributes()
    assert attributes["inlet_changes"] == "from t = 0.5 s on: inlet 1: a\nfrom t = 0.5 s on: inlet 2: b"
    assert attributes["inlet_changed_at"] == [0.5]


def test_a_prediction_is_that_of_the_steps_and_of_the_means():
    told = {"stages": {"start-up": 3.0, "dem": 80.0, "cfd": 20.0}, "simulated_seconds": 2.0, "wall_factor": 1.3}
    told |= {"means_error": 0.1, "means_factor": 1.5}
    found = Making({}, [], [], predicted=told).list_attributes()
    assert found == {
        "predicted_seconds": 100.0,
        "predicted_end": 2.0,
        "predicted_factor": 1.3,
        "predicted_error": 0.1,
        "predicted_error_factor": 1.5,
    }
    without = Making({}, [], [], predicted=told | {"means_error": None, "means_factor": None}).list_attributes()
    assert "predicted_error" not in without and without["predicted_seconds"] == 100.0
