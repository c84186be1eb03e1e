"""What has become of a case since its run was set up, told option by option."""

import pytest

from fbcouple.case.changes import list_changes, list_inflows, list_values
from fbcouple.case.load import load_case

NAME = "van-wachem/0.9"


@pytest.fixture(scope="module")
def before():
    return list_values(load_case(NAME))


@pytest.mark.parametrize(
    ("setting", "words"),
    [
        ("gas.inlet_velocity=1.3", "gas.inlet_velocity was 0.9 and is 1.3 now"),
        ("output.particles_every=0.1", "output.particles_every was not given and is 0.1 now"),
        ("output.tracked=[1]", "output.tracked was [] and is [1] now"),
        ("start.seed=7", "start.seed was 1 and is 7 now"),
        ("title=other", 'and is "other" now'),
    ],
)
def test_an_option_that_was_changed_is_named(before, setting, words):
    (change,) = list_changes(before, load_case(NAME, [setting]))
    assert words in str(change)


def test_of_a_table_the_option_in_it_is_named():
    feed = "particles.feeds=[{{low=[0.0,0.0,0.2],high=[0.04,0.008,0.3],rate={rate}}}]"
    held = list_values(load_case(NAME, [feed.format(rate=10.0)]))
    (change,) = list_changes(held, load_case(NAME, [feed.format(rate=5.0)]))
    assert str(change) == "particles.feeds.1.rate was 10.0 and is 5.0 now"


@pytest.mark.parametrize(
    "setting", ["output.save_every=5.0", "checkpoint.wall_every=60.0", "end_time=50.0", "monitors.overlap=0.5"]
)
def test_when_a_run_ends_and_how_often_it_is_saved_may_change(before, setting):
    assert list_changes(before, load_case(NAME, [setting])) == []


@pytest.mark.parametrize(
    ("ramp", "until", "is_same"),
    [
        ([[0.0, 0.9], [0.5, 0.9], [0.5, 1.3]], 0.5, True),
        ([[0.0, 0.9], [0.5, 0.9], [0.5, 1.3]], 0.6, False),
        ([[0.0, 0.9], [0.4, 0.9], [0.6, 1.3]], 0.4, True),
        ([[0.0, 0.9], [0.4, 0.9], [0.6, 1.3]], 0.5, False),
        ([[0.0, 0.8], [0.4, 0.9]], 0.4, False),
        ([[0.1, 0.9]], 2.0, True),
    ],
)
def test_the_velocity_of_the_inlet_counts_up_to_a_time(before, ramp, until, is_same):
    case = load_case(NAME)
    case = case.model_copy(
        update={"gas": case.gas.model_copy(update={"inlet_velocity": None, "inlet_ramp": tuple(map(tuple, ramp))})}
    )
    assert (list_changes(before, case, until) == []) is is_same
    assert {change.key for change in list_changes(before, case)} == {"gas.inlet_velocity", "gas.inlet_ramp"}


def test_where_gas_comes_in_counts_at_all_times():
    one = {"rectangle": [[0.0, 0.0], [0.1, 0.1]], "velocity": 1.0, "profile_file": None}
    values = [{"gas.inlets": [one]}, {"gas.inlets": [one | {"velocity": 2.0}]}, {"gas.inlets": [one, one]}]
    openings = [[opening for opening, _ in list_inflows(value)] for value in values]
    assert openings[0] == openings[1] != openings[2]
    assert openings[0] != [opening for opening, _ in list_inflows({"gas.inlets": [one | {"profile_file": "a.csv"}]})]


def test_an_option_that_is_younger_than_the_run_had_its_default(before):
    older = {key: value for key, value in before.items() if key not in ("output.tracked", "gas.top")}
    assert list_changes(older, load_case(NAME)) == []
    assert [change.key for change in list_changes(older, load_case(NAME, ["output.tracked=[3]"]))] == ["output.tracked"]


def test_a_section_that_comes_or_goes_is_a_change(before):
    without = {key: value for key, value in before.items() if key.partition(".")[0] != "averages"} | {"averages": None}
    assert "averages" in {change.key for change in list_changes(without, load_case(NAME))}
    assert "start" in {change.key for change in list_changes(before | {"start": None}, load_case(NAME))}


def test_what_a_table_of_an_older_run_does_not_know_was_not_given():
    case = load_case("yue/spout")
    older = list_values(case)
    assert [table.pop("temperature") for table in older["gas.inlets"]] == [None] * len(case.gas.inlets)
    assert list_changes(older, case) == []
    older["gas.inlets"][0]["velocity"] = 77.0
    assert [change.key for change in list_changes(older, case)] == ["gas.inlets"]
