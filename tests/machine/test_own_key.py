"""The key of one's own: kept private, made once, never of somebody else."""

import os
import stat
from pathlib import Path

import pytest

from fbcouple.machine.own_key import is_own, key_file, make_key, sign


@pytest.fixture
def states(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "states"))
    return tmp_path / "states"


def test_key_is_made_once_and_readable_by_its_owner_alone(states):
    assert sign("index") == ""
    make_key()
    key = key_file().read_bytes()
    make_key()
    assert key_file().read_bytes() == key and len(set(key)) > 8
    assert stat.S_IMODE(key_file().stat().st_mode) == 0o600 and os.listdir(key_file().parent) == ["checkpoint-key"]


def test_signature_is_of_one_text_and_one_key(states, monkeypatch, tmp_path):
    make_key()
    signature = sign("index")
    assert is_own("index", signature)
    assert not is_own("indeX", signature) and not is_own("index", "") and not is_own("index", None)
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "another"))
    assert not is_own("index", signature)
    make_key()
    assert not is_own("index", signature)


@pytest.mark.parametrize("spoil", ["readable", "link", "short", "empty"])
def test_a_key_that_others_may_know_is_none(states, tmp_path, spoil):
    make_key()
    if spoil == "readable":
        key_file().chmod(0o644)
    elif spoil == "link":
        key_file().rename(tmp_path / "elsewhere")
        key_file().symlink_to(tmp_path / "elsewhere")
    else:
        key_file().write_bytes(b"" if spoil == "empty" else b"0123")
    assert sign("index") == "" and not is_own("index", "")


def test_no_key_where_none_can_be_written(states):
    states.write_text("a file in the folder's place")
    make_key()
    assert sign("index") == ""


def test_without_a_home_the_key_is_in_the_cache(monkeypatch, tmp_path):
    monkeypatch.delenv("XDG_STATE_HOME", raising=False)
    monkeypatch.setenv("HOME", "")
    monkeypatch.setenv("FBCOUPLE_CACHE", str(tmp_path))
    assert key_file() == tmp_path / "checkpoint-key"
