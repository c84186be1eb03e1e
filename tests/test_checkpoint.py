"""Whether a checkpoint is of a case: told by its options, the younger ones only where they are used."""

import errno
import hashlib
import json
import os
import stat
from pathlib import Path

import pytest

from fbcouple.case.load import load_case
from fbcouple.checkpoint import _YOUNGER, add_up, begin, fingerprint, finish


def test_a_checkpoint_from_before_an_option_stands_where_it_is_not_used():
    """Younger options at their defaults leave no key in what is compared: neither the section nor a null."""
    case = load_case("mueller/0.9")
    unsaid = {"checkpoint": True, "output": {"save_every"}, "monitors": True}
    told = case.model_dump(mode="json", exclude=unsaid)
    for dotted in _YOUNGER:
        *section, key = dotted.split(".")
        del (told[section[0]] if section else told)[key]
    assert fingerprint(case, with_end=True) == hashlib.sha256(json.dumps(told, sort_keys=True).encode()).hexdigest()


@pytest.mark.parametrize(
    "setting",
    [
        "accuracy=standard",
        "output.particles_every=0.1",
        "output.tracked=[1]",
        "output.record_every=0.02",
        "gas.inlet_velocity=1.3",
    ],
)
def test_another_case_is_another_fingerprint(setting):
    assert fingerprint(load_case("van-wachem/0.9", [setting])) != fingerprint(load_case("van-wachem/0.9"))


@pytest.mark.parametrize("setting", ["output.save_every=5.0", "checkpoint.wall_every=60.0", "end_time=50.0"])
def test_how_often_files_are_saved_and_when_the_run_ends_does_not_matter(setting):
    assert fingerprint(load_case("van-wachem/0.9", [setting])) == fingerprint(load_case("van-wachem/0.9"))


def test_file_system_that_cannot_sync_folders_takes_checkpoints(tmp_path, monkeypatch):
    """CIFS and some of FUSE; a plain file that cannot be brought to the disk is still an error."""
    sync = os.fsync

    def refuse_folders(number: int) -> None:
        if stat.S_ISDIR(os.fstat(number).st_mode):
            raise OSError(errno.EINVAL, "Invalid argument")
        sync(number)

    monkeypatch.setattr(os, "fsync", refuse_folders)
    folder = begin(tmp_path, 3)
    (folder / "state.json").write_text("{}")
    about = {"case": "", "step": 3, "time": 0.0, "ranks": 1}
    assert finish(folder, about, add_up(folder, [Path("state.json")])).name == "step-000000000003"

    def refuse_all(number: int) -> None:
        raise OSError(errno.EINVAL, "Invalid argument")

    monkeypatch.setattr(os, "fsync", refuse_all)
    folder = begin(tmp_path, 4)
    (folder / "state.json").write_text("{}")
    with pytest.raises(OSError, match="Invalid argument"):
        add_up(folder, [Path("state.json")])
