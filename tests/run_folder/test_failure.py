"""Why a run failed: the first rank's note, else the solvers' last error, else the launcher's last words."""

import pytest

from fbcouple.run_folder.failure import (
    correct_note,
    give_room_back,
    prepare_failure,
    read_failure,
    read_note,
    write_failure,
)

LAUNCHER = "\n".join(f"line {n}" for n in range(40))
# Both as the solvers print them.
GRAINS = "LIGGGHTS (Version LIGGGHTS-PUBLIC 3.8.0)\nERROR: Numeric index is out of bounds (./src/force.cpp:786)\n"
FLUID = (
    "Create time\n\n\n--> FOAM FATAL IO ERROR: \nUnknown ddt type Nonsense\n\nValid ddt types :\n"
    "file: CFD/system/fvSchemes.ddtSchemes at line 11.\n\nFOAM exiting\n"
)


@pytest.fixture
def run(tmp_path):
    (tmp_path / "logs").mkdir()
    prepare_failure(tmp_path)
    return tmp_path


def test_a_note_is_read_with_its_exit_code(run):
    write_failure(run, "2 of 50 particles are lost\nat t = 1 s", 4)
    assert read_failure(run, LAUNCHER) == ("2 of 50 particles are lost\nat t = 1 s", 4)


def test_a_note_is_corrected_and_none_is_made(run):
    correct_note(run, "stopped by SIGINT", 75)
    assert read_note(run) == ""
    write_failure(run, "stopped by SIGUSR1 at t = 1 s", 75)
    correct_note(run, "stopped by SIGINT at t = 1 s", 75)
    assert read_failure(run, LAUNCHER) == ("stopped by SIGINT at t = 1 s", 75)


def test_the_first_rank_to_say_so_is_heard(run):
    write_failure(run, "the cause", 4)
    write_failure(run, "what followed on another rank", 3)
    assert read_failure(run, "") == ("the cause", 4)


def test_a_note_goes_before_the_logs(run):
    (run / "logs/liggghts.log").write_text(GRAINS)
    write_failure(run, "the cause", 4)
    assert read_failure(run, LAUNCHER) == ("the cause", 4)


def test_a_note_is_forgotten_by_the_next_run(run):
    write_failure(run, "an earlier run", 4)
    prepare_failure(run)
    write_failure(run, "this run", 3)
    assert read_failure(run, "") == ("this run", 3)


def test_a_note_needs_no_room_of_the_disk(run):
    """It takes the place of the room that was kept for it, whatever is in it."""
    room = (run / "logs/failure.room").stat().st_size
    write_failure(run, "\u20ac" * 100_000, 3)
    assert [path.name for path in (run / "logs").iterdir()] == ["failure.json"]
    assert (run / "logs/failure.json").stat().st_size == room
    assert read_failure(run, "")[0].strip("\u20ac") == ""


def test_without_room_a_note_is_written_all_the_same(run):
    give_room_back(run)
    write_failure(run, "the cause", 4)
    write_failure(run, "what followed", 3)
    assert read_failure(run, "") == ("the cause", 4)


def test_particles_that_liggghts_lost_are_a_divergence(run):
    (run / "logs/liggghts.log").write_text("ERROR: Lost atoms: original 530 current 529 (./src/thermo.cpp:442)\n")
    assert read_failure(run, "")[1] == 4


def test_words_of_liggghts(run):
    (run / "logs/liggghts.log").write_text(GRAINS)
    text, code = read_failure(run, LAUNCHER)
    assert text == "LIGGGHTS: ERROR: Numeric index is out of bounds (./src/force.cpp:786) (in logs/liggghts.log)"
    assert code == 3


def test_words_of_openfoam_go_on_over_the_next_lines(run):
    (run / "logs/liggghts.log").write_text("no error here: 'ERROR' within a line is none\n")
    (run / "logs/openfoam.log").write_text(FLUID)
    text, code = read_failure(run, LAUNCHER)
    assert text.startswith("OpenFOAM: --> FOAM FATAL IO ERROR:") and "Unknown ddt type Nonsense" in text
    assert text.endswith("(in logs/openfoam.log)") and code == 3


def test_the_last_error_of_several_is_told(run):
    (run / "logs/liggghts.log").write_text("ERROR: first\nmore\nmore\nERROR: second\n")
    assert read_failure(run, LAUNCHER)[0] == "LIGGGHTS: ERROR: second (in logs/liggghts.log)"


def test_bytes_that_are_no_text_do_not_hide_the_words(run):
    (run / "logs/liggghts.log").write_bytes(b"\xff\xfe\x00\nERROR: after rubbish\n")
    assert "ERROR: after rubbish" in read_failure(run, "")[0]


@pytest.mark.parametrize("torn", ["", '{"text": "the cau'])
def test_a_torn_note_does_not_hide_the_logs(run, torn):
    (run / "logs/failure.json").write_text(torn)
    (run / "logs/liggghts.log").write_text(GRAINS)
    assert read_failure(run, LAUNCHER)[0].startswith("LIGGGHTS: ERROR: Numeric index")


def test_without_any_words_the_launchers_last_fifteen_lines(run):
    text, code = read_failure(run, LAUNCHER + "\n\n")
    assert code == 3 and text.splitlines()[1:] == [f"line {n}" for n in range(25, 40)]


def test_a_batch_system_with_too_few_places_is_told_in_one_line(run):
    words = "There are not enough slots available in the system to satisfy the 2\nslots that were requested"
    text, code = read_failure(run, f"{'-' * 70}\n{words}\n{LAUNCHER}")
    assert code == 3 and len(text.splitlines()) == 1 and "fewer places than the run has ranks" in text
