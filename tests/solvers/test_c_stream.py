"""What a C library writes to its standard output: in a file, each line at once, and never without bound."""

from __future__ import annotations

import subprocess
import sys

import pytest

from fbcouple.errors import SolverError
from fbcouple.solvers import c_stream
from fbcouple.solvers.c_stream import shorten, standard_output_into

PROGRAM = """
import ctypes, os, sys
from pathlib import Path
from fbcouple.solvers.c_stream import standard_output_into
library = ctypes.CDLL(None)
with standard_output_into(Path(sys.argv[1])):
    library.puts(b"ERROR on this rank alone")
print("of Python", flush=True)
os._exit(7)
"""


def test_a_line_is_there_though_the_process_ends_in_the_next_moment(tmp_path):
    log = tmp_path / "d\u00fc 'x' log"
    log.write_text("before\n", encoding="utf-8")
    done = subprocess.run([sys.executable, "-c", PROGRAM, log], capture_output=True, check=False)
    assert done.returncode == 7 and done.stdout == b"of Python\n", done.stderr
    assert log.read_text(encoding="utf-8") == "before\nERROR on this rank alone\n"


def test_a_log_that_cannot_be_written_is_told(tmp_path):
    words = r"nowhere/log: cannot be written: No such file"
    with pytest.raises(SolverError, match=words), standard_output_into(tmp_path / "nowhere/log"):
        pytest.fail("it was opened")


def test_a_long_log_keeps_its_beginning_and_its_end(tmp_path, monkeypatch):
    log = tmp_path / "log"
    monkeypatch.setattr(c_stream, "LARGEST", 10_000)
    monkeypatch.setattr(c_stream, "_BEGINNING", 1000)
    monkeypatch.setattr(c_stream, "_END", 1000)
    with log.open("a", encoding="utf-8") as file:
        for number in range(5000):
            print(f"line {number}", file=file, flush=True)
            shorten(log)
            assert log.stat().st_size <= 10_000
        print("the last", file=file, flush=True)
    lines = log.read_text(encoding="utf-8").splitlines()
    assert lines[:3] == ["line 0", "line 1", "line 2"] and lines[-3:] == ["line 4998", "line 4999", "the last"]
    assert any("bytes are left out" in line for line in lines)
    short = tmp_path / "short"
    short.write_text("all of it\n", encoding="utf-8")
    shorten(short)
    assert short.read_text(encoding="utf-8") == "all of it\n"
