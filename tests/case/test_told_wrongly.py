"""What was told of a case and was not so."""

import pytest

from fbcouple.case.kinds.registry import Wanted
from fbcouple.case.load import load_case
from fbcouple.case.new_case import write_new_case
from fbcouple.case.preflight import estimate
from fbcouple.errors import CaseError
from fbcouple.launcher.change_case import ask


def test_a_new_case_has_the_overlap_that_is_told(tmp_path):
    told = {number.name: number for number in write_new_case(tmp_path, "column", Wanted(diameter=2e-3))}
    found = {number.name: number for number in estimate(load_case(str(tmp_path)))}
    assert told["overlap"] == found["overlap"] and told["overlap"].verdict == "fit"


def test_parcels_larger_than_the_box_are_told_by_their_ratio():
    with pytest.raises(CaseError) as error:
        load_case("patil/c2", ["particles.coarse_graining=16"])
    text = "particles.coarse_graining: 16 is given, so that a parcel has 0.016 m, but the box is 0.015 m along y"
    assert text in str(error.value)


def test_a_key_that_is_none_is_told_with_the_one_meant(tmp_path):
    with pytest.raises(CaseError, match=r"gas.inlet_velocty: is no key of a case; did you mean `gas.inlet_velocity`"):
        ask(load_case("patil/c2"), ["gas.inlet_velocty=2.0"], tmp_path)
    with pytest.raises(CaseError, match=r"particles.diameter: is fixed once a run has begun"):
        ask(load_case("patil/c2"), ["particles.diameter=2e-3"], tmp_path)
