"""A measured bed of its own, whose deviation from the synthetic run of `tests/postproc/whole_run.py` is known."""

from __future__ import annotations

from pathlib import Path

import pytest

CASE = """
title = "A bed"
[output]
references = ["solids_velocity@0.025=line.csv"]
"""
VALIDATION = """
source = "Somebody 2020, A journal 1:1"
cost = "nothing"

[[measurements]]
name = "velocity"
compare = "line"
of = "solids_velocity@0.0250"
wanted = 0.4

[[measurements]]
name = "velocity, right half"
compare = "line"
of = "solids_velocity@0.025"
span = [0.04, 0.08]

[[measurements]]
name = "height"
compare = "mean"
of = "bed_height"
value = 0.08
error = 0.001
wanted = 0.005

[[measurements]]
name = "pulses"
compare = "fluctuation"
of = "pressure_drop"
value = 20.0

[[measurements]]
name = "beat"
compare = "frequency"
of = "pressure_drop"
value = 2.4

[[measurements]]
name = "ramp"
compare = "rate"
of = "inlet_velocity"
value = 0.1
span = [0.0, 6.0]
origin = 2.0

[[measurements]]
name = "ramp in time"
compare = "curve"
of = "inlet_velocity"
file = "ramp.csv"
origin = 2.0

[[peers]]
of = "velocity"
name = "Another code"
source = "Somebody else 2021"
file = "peer.csv"

[[peers]]
of = "height"
name = "Another code"
source = "Somebody else 2021"
value = 0.085

[[peers]]
of = "ramp in time"
name = "A third"
source = "Yet another 2022"
rms = 0.25
"""
FILES = {
    "case.toml": CASE,
    "validation.toml": VALIDATION,
    "line.csv": "x,value,error\n0.01,0.6,0.1\n0.03,-0.1,0.1\n0.05,0.2,0.1\n0.07,1.4,0.1\n",
    "peer.csv": "x,value\n0.01,0.8\n0.07,1.4\n",
    "ramp.csv": "time [ms],value\n0,0.24\n4000,0.72\n6000,0.86\n",
}


@pytest.fixture
def write(tmp_path: Path):
    """Write the bed with texts of its files replaced; returns its folder."""

    def write_bed(file: str = "", old: str = "", new: str = "") -> Path:
        folder = tmp_path / "bed"
        folder.mkdir(exist_ok=True)
        for name, text in FILES.items():
            if name == file:
                assert text.count(old) >= 1, f"{old!r} must stand in {name}"
            (folder / name).write_text(text.replace(old, new, 1) if name == file else text)
        return folder

    return write_bed
