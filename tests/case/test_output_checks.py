"""[output]: snapshots that the case cannot give, references that cannot be read, and their way into the run folder."""

import pytest

from fbcouple.case.load import load_case
from fbcouple.errors import CaseError


def problems_of(name, *sets):
    with pytest.raises(CaseError) as caught:
        load_case(str(name), sets)
    return caught.value.problems


def test_snapshots_need_both_phases(spoil):
    path = spoil()
    text = path.read_text()
    path.write_text(text[: text.index("[gas]")] + text[text.index("[particles]") : text.index("[exchange]")])
    (problem,) = problems_of(path, "output.snapshots_every=0.01")
    assert "output.snapshots_every: 0.01 s is given and the case has no [gas]" in problem


def test_too_many_snapshots_are_refused():
    (problem,) = problems_of("patil/c2", "output.snapshots_every=1e-9")
    assert "at least 0.0002 s is allowed" in problem


def test_references_are_copied_into_the_run_folder(spoil, call, tmp_path):
    path = spoil()
    (tmp_path / "flux.csv").write_text("x,value\n0.01,1.0\n")
    done = call("setup", path, "-o", "run", "--set", 'output.references=["solids_flux@0.023=flux.csv"]')
    assert done.exit_code == 0, done.output
    assert (tmp_path / "run/flux.csv").read_text() == "x,value\n0.01,1.0\n"
    assert load_case(str(tmp_path / "run")).output.references == ("solids_flux@0.023=flux.csv",)


@pytest.mark.parametrize(
    ("reference", "told"),
    [
        ("flux@0.02=flux.csv", "`flux` in"),
        ("solids_flux@0.02=none.csv", "none.csv cannot be read"),
        ("solids_flux@0.02=../flux.csv", "bare name of a .csv file"),
        ("solids_flux@2.3=flux.csv", "the box is 0.25 m high"),
        ("solids_flux@0.02,0:0.9=flux.csv", "from y = 0 to 0.9 m, 0 to 0.015 m is allowed"),
        ("solids_flux@0.02,r=flux.csv", 'domain.shape is "box", which has no radius; give solids_flux@0.02=file'),
        ("solids_flux@0.02=mm.csv", "x from 10 to 20 m, 0 to 0.08 m is allowed"),
    ],
)
def test_references_that_cannot_serve_are_told(spoil, tmp_path, reference, told):
    (tmp_path / "flux.csv").write_text("x,value\n0.01,1.0\n")
    (tmp_path / "mm.csv").write_text("x,value\n10,1.0\n20,1.0\n")
    (problem,) = problems_of(spoil(), f'output.references=["{reference}"]')
    assert "output.references: " in problem and told in problem


@pytest.mark.parametrize(
    ("setting", "told"),
    [
        ("output.particles_every=1e-9", "at least 0.002 s is allowed"),
        ("output.tracked=[57297]", "particle 57297 is given and there are 57296"),
        ("output.tracked=[5, 5]", "name each particle once"),
        (f"output.tracked={list(range(1, 102))}", "at most 100 are allowed"),
        ("output.tracked=[0]", "output.tracked"),
    ],
)
def test_frames_and_tracked_particles_that_cannot_be_had(setting, told):
    (problem,) = problems_of("patil/c2", setting)
    assert told in problem


@pytest.mark.parametrize("setting", ["output.particles_every=0.1", "output.tracked=[1]"])
def test_they_need_particles(spoil, setting):
    path = spoil()
    text = path.read_text()
    path.write_text(text[: text.index("[particles]")] + text[text.index("[averages]") : text.index("[output]")])
    (problem,) = problems_of(path, setting)
    assert "the case has no [particles]" in problem


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("x,y,z,vx,vy\n0.01,0.01,0.01,0,0\n", "not all of the columns vx, vy and vz"),
        ("x,y,z,vx,vy,vz\n0.01,0.01,0.01,0,0,inf\n", "line 2 has `inf` for vz; give a finite number"),
    ],
)
def test_start_velocities_that_cannot_serve_are_told(spoil, tmp_path, text, told):
    (tmp_path / "bead.csv").write_text(text)
    path = spoil(("mass = 0.075", 'count = 1\npositions = "bead.csv"'), ("[start]\n", ""))
    (problem,) = problems_of(path)
    assert "particles.positions: " in problem and told in problem


def test_profiles_are_taken_inside_of_the_box():
    case = load_case("patil/c2", ["output.profile_heights=[0.01, 0.2]"])
    assert case.output.profile_heights == (0.01, 0.2)
    (problem,) = problems_of("patil/c2", "output.profile_heights=[0.01, 25.0]")
    assert "output.profile_heights: 25 m is given and the box is 0.25 m high" in problem
    (problem,) = problems_of("patil/c2", "output.profile_heights=[0.0, -1.0]")
    assert "a list, each entry a number above 0 (in m) is allowed" in problem


def test_radial_profiles_are_of_what_may_be_round():
    (problem,) = problems_of("patil/c2", "output.radial_heights=[0.01]")
    assert 'output.radial_heights: [0.01] is given and domain.shape is "box", which has no radius; remove it' in problem
    assert load_case("birmingham/small", ["output.radial_heights=[0.01]"]).output.radial_heights == (0.01,)
    (problem,) = problems_of("birmingham/small", "output.radial_heights=[9.0]")
    assert "output.radial_heights: 9 m is given and the box is" in problem
