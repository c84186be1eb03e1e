"""The cache of built things: whose it may be, where it may lie, and that one which cannot be written serves too."""

from __future__ import annotations

import os
import shutil
import stat
import subprocess
import sys
from pathlib import Path

import pytest

import fbcouple
from fbcouple.errors import SolverError
from fbcouple.machine.cache import make_folder, prepare_compiled, require_trusted
from fbcouple.paths import cache_folder
from fbcouple.solvers.openfoam import build

STRANGER = 54321
# The administrator may write anywhere, until this is taken from him.
OBEDIENT = ["setpriv", "--bounding-set=-dac_override,-dac_read_search"] if os.geteuid() == 0 else []
PACKAGE = Path(fbcouple.__file__).parent
PROGRAM = """
from fbcouple.physics.drag.laws import DRAG_LAWS
print(repr(float(DRAG_LAWS["wen-yu"](0.6, 1.0, 1e-3, 1.2, 1.8e-5))))
"""


@pytest.fixture
def cache(tmp_path):
    folder = tmp_path / "cache"
    folder.mkdir(mode=0o755)
    (folder / "adapter.so").write_bytes(b"code")
    return folder


@pytest.fixture
def give_away(monkeypatch):
    """Let files belong to a stranger: really where that is allowed, else by being somebody else oneself."""

    def give(*paths: Path) -> None:
        if os.geteuid() == 0:
            for path in paths:
                os.chown(path, STRANGER, STRANGER, follow_symlinks=False)
        else:
            monkeypatch.setattr(os, "geteuid", lambda: STRANGER)

    return give


def refused(cache: Path, *files: Path) -> str:
    with pytest.raises(SolverError) as caught:
        require_trusted(cache, files)
    text = str(caught.value)
    assert len(text.splitlines()) == 1 and "FBCOUPLE_CACHE" in text and str(cache) in text
    return text


@pytest.mark.parametrize("mode", [0o700, 0o755, 0o555, 0o500])
def test_a_cache_of_ones_own(cache, mode):
    cache.chmod(mode)
    require_trusted(cache, [cache / "adapter.so"])
    cache.chmod(0o755)


@pytest.mark.parametrize("mode", [0o777, 0o1777, 0o757])
def test_a_cache_that_all_write_is_refused(cache, mode):
    cache.chmod(mode)
    assert f"mode {mode:04o}" in refused(cache)


def test_the_group_that_has_only_the_owner_is_nobody_else(cache, monkeypatch):
    cache.chmod(0o775)
    monkeypatch.setattr("fbcouple.machine.cache._is_private_group", lambda group, owner: True)
    require_trusted(cache)
    monkeypatch.setattr("fbcouple.machine.cache._is_private_group", lambda group, owner: False)
    assert "mode 0775" in refused(cache)


def test_a_folder_above_that_all_write_is_refused_but_for_the_sticky_bit(cache):
    cache.parent.chmod(0o777)
    assert f"{cache.parent} belongs to" in refused(cache)
    cache.parent.chmod(0o1777)
    require_trusted(cache)
    cache.parent.chmod(0o700)


def test_a_strangers_cache_where_anybody_could_have_made_it_is_refused(cache, give_away):
    cache.parent.chmod(0o1777)
    give_away(cache)
    assert "belongs to" in refused(cache)
    cache.parent.chmod(0o700)


def test_a_strangers_file_in_ones_own_cache_is_refused(cache, give_away):
    if os.geteuid() != 0:
        cache.chmod(0o1777)  # and not one's own: the same words
    give_away(cache / "adapter.so")
    refused(cache, cache / "adapter.so")


def test_a_file_that_all_write_is_refused_where_they_reach_it(cache):
    (cache / "adapter.so").chmod(0o777)
    assert "adapter.so" in refused(cache, cache / "adapter.so")
    cache.chmod(0o700)
    require_trusted(cache, [cache / "adapter.so"])


def test_a_file_that_has_gone_meanwhile_is_no_reason(cache):
    require_trusted(cache, [cache / "adapter.so.part", cache / "adapter.so"])


@pytest.mark.parametrize(("umask", "mode"), [(0o022, 0o755), (0o077, 0o700), (0o002, 0o700), (0o000, 0o700)])
def test_what_is_made_nobody_else_writes(tmp_path, umask, mode):
    before = os.umask(umask)
    try:
        make_folder(tmp_path / "made")
    finally:
        os.umask(before)
    assert stat.S_IMODE((tmp_path / "made").stat().st_mode) == mode
    require_trusted(tmp_path / "made")


def test_the_adapter_and_the_loops_of_a_cache_that_all_write_are_not_used(cache, monkeypatch):
    monkeypatch.setenv("FBCOUPLE_CACHE", str(cache))
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    cache.chmod(0o777)
    for use in (build.adapter_path, build.build_adapter, prepare_compiled):
        with pytest.raises(SolverError, match="somebody else may have put it there"):
            use()
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(cache))
    with pytest.raises(SolverError, match="in NUMBA_CACHE_DIR"):
        prepare_compiled()
    assert [path.name for path in cache.iterdir()] == ["adapter.so"]


def test_a_compiler_that_is_switched_off_is_told(monkeypatch):
    monkeypatch.setenv("NUMBA_DISABLE_JIT", "1")
    with pytest.raises(SolverError, match=r"NUMBA_DISABLE_JIT is set: .*; unset it"):
        prepare_compiled()


@pytest.mark.parametrize(
    ("home", "xdg", "found"), [("/h", "", "/h/.cache"), ("/h", "x", "/h/.cache"), ("", "/x", "/x")]
)
def test_where_it_lies(monkeypatch, home, xdg, found):
    monkeypatch.delenv("FBCOUPLE_CACHE", raising=False)
    monkeypatch.setenv("HOME", home)
    monkeypatch.setenv("XDG_CACHE_HOME", xdg)
    assert cache_folder() == Path(found) / "fbcouple"


def test_without_a_home_it_has_to_be_named(monkeypatch):
    monkeypatch.delenv("FBCOUPLE_CACHE", raising=False)
    monkeypatch.setenv("HOME", "")
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    with pytest.raises(SolverError, match="name a folder in FBCOUPLE_CACHE"):
        cache_folder()


def find_drag(place: Path, scratch: Path, variable: str, *before: str) -> tuple[str, str]:
    """beta by a process whose compiled loops lie in `place`, and what Numba says of them."""
    environment = {name: text for name, text in os.environ.items() if name != "NUMBA_CACHE_DIR"}
    environment |= {"PYTHONPATH": str(PACKAGE.parent), variable: str(place)}
    environment |= {"TMPDIR": str(scratch), "NUMBA_DEBUG_CACHE": "1"}
    command = [*before, sys.executable, "-c", PROGRAM]
    done = subprocess.run(command, env=environment, cwd=scratch, capture_output=True, encoding="utf-8", check=False)
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    return lines[-1], "\n".join(lines[:-1])


@pytest.mark.parametrize("variable", ["FBCOUPLE_CACHE", "NUMBA_CACHE_DIR"])
def test_a_cache_that_cannot_be_written_serves_all_the_same(tmp_path, variable):
    """As where homes are read-only on compute nodes: nothing is compiled again, and nothing is left behind."""
    place, scratch = tmp_path / "it's a c\u00e4che", tmp_path / "scratch"
    place.mkdir()
    scratch.mkdir()
    wanted, said = find_drag(place, scratch, variable)
    assert "data saved to" in said and list(scratch.iterdir()) == []
    folders = [place, *(path for path in place.rglob("*") if path.is_dir())]
    for folder in folders:
        folder.chmod(0o555)
    try:
        found, said = find_drag(place, scratch, variable, *OBEDIENT)
    finally:
        for folder in folders:
            folder.chmod(0o755)
    assert found == wanted and "data loaded from" in said and "data saved to" not in said
    assert list(scratch.iterdir()) == []


def test_an_adapter_cannot_be_built_into_a_cache_that_cannot_be_written(tmp_path):
    (tmp_path / "cache").mkdir(mode=0o555)
    command = [*OBEDIENT, sys.executable, "-m", "fbcouple.solvers.openfoam.build"]
    for place in (tmp_path / "cache", tmp_path / "cache/inner"):
        environment = os.environ | {"FBCOUPLE_CACHE": str(place), "PYTHONPATH": str(PACKAGE.parent)}
        done = subprocess.run(command, env=environment, capture_output=True, encoding="utf-8", check=False)
        assert done.returncode == 3 and "the cache cannot be written (Permission denied)" in done.stderr, done.stderr
        assert "FBCOUPLE_CACHE" in done.stderr and "Traceback" not in done.stderr
    shutil.rmtree(tmp_path / "cache")
