"""Errors that nobody foresaw: one line, exit code 3, where the archive for a report is made; the traceback is kept."""

from __future__ import annotations

import tarfile

import pytest
from click.testing import CliRunner

import fbcouple.case.source
from fbcouple.cli.main import cli
from fbcouple.doctor.bundle import write_bundle
from fbcouple.errors import CaseError
from fbcouple.machine.unexpected import describe

ERRORS = {
    "memory": (MemoryError(), "MemoryError: more memory is needed than this machine gives"),
    "permission": (PermissionError(13, "Permission denied", "/ro/figures"), "Permission denied: '/ro/figures'"),
    "read-only": (OSError(30, "Read-only file system", "/ro/x"), "Read-only file system: '/ro/x'"),
    "code": (UnicodeDecodeError("utf-8", b"\xff", 0, 1, "bad"), "a text is not in the code that is read or written"),
    "depth": (RecursionError("maximum recursion depth exceeded"), "the input is nested too deeply"),
    "key": (KeyError("complete"), "KeyError: 'complete'"),
    "lines": (ValueError("first\nsecond\n" + "x" * 1000), "ValueError: first second xxx"),
}


@pytest.fixture
def fail(monkeypatch, tmp_path):
    """Call `fbcouple cases`, in which an error is raised."""
    monkeypatch.setenv("FBCOUPLE_CACHE", str(tmp_path / "cache"))
    monkeypatch.delenv("FBCOUPLE_TRACEBACK", raising=False)

    def call(error: BaseException):
        def list_badly() -> None:
            raise error

        monkeypatch.setattr(fbcouple.case.source, "list_shipped", list_badly)
        return CliRunner().invoke(cli, ["cases"])

    return call


@pytest.mark.parametrize("name", ERRORS)
def test_unexpected_error_is_one_line_and_exit_code_3(fail, tmp_path, name):
    error, words = ERRORS[name]
    done = fail(error)
    assert done.exit_code == 3 and done.stdout == "" and len(done.stderr.splitlines()) == 1
    assert words in done.stderr and "(at fbcouple/cli/main.py:" in done.stderr and len(done.stderr) < 800
    assert "`fbcouple doctor --bundle [RUN]` makes the archive for a bug report" in done.stderr
    kept = tmp_path / "cache/last-error.txt"
    assert str(kept) in done.stderr and kept.read_text().startswith("Traceback") and "list_badly" in kept.read_text()


def test_traceback_is_shown_to_who_asks_for_it(fail, monkeypatch):
    monkeypatch.setenv("FBCOUPLE_TRACEBACK", "1")
    done = fail(KeyError("complete"))
    assert done.exit_code == 3 and done.stderr.startswith("Traceback") and "list_badly" in done.stderr


def test_traceback_that_cannot_be_kept_is_not_promised(fail, monkeypatch, tmp_path):
    (tmp_path / "file").touch()
    monkeypatch.setenv("FBCOUPLE_CACHE", str(tmp_path / "file/cache"))
    done = fail(KeyError("complete"))
    assert done.exit_code == 3 and "FBCOUPLE_TRACEBACK=1 shows its traceback" in done.stderr


def test_archive_for_a_report_has_the_traceback(fail, tmp_path):
    fail(KeyError("complete"))
    archive = write_bundle([], None, tmp_path)
    with tarfile.open(archive) as opened:
        (name,) = (name for name in opened.getnames() if name.endswith("/last-error.txt"))
        text = opened.extractfile(name).read()
    assert b"Traceback" in text and b"fbcouple/cli/group.py" in text


def test_foreseen_errors_and_usage_are_as_before(fail):
    assert fail(CaseError(["one", "two"])).exit_code == 1
    assert fail(KeyboardInterrupt()).exit_code == 130
    assert CliRunner().invoke(cli, ["cases", "--no-such-option"]).exit_code == 2


def test_place_is_the_last_of_our_own_lines():
    with pytest.raises(TypeError) as caught:
        fbcouple.case.source.find_case(3)
    assert "(at fbcouple/case/source.py:" in describe(caught.value)
