"""A checkpoint on file systems that cannot do all that a disk can."""

from __future__ import annotations

import errno
import os
import stat
from pathlib import Path

import pytest

from fbcouple.run_folder.checkpoint import add_up, begin, finish


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
