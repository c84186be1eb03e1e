"""What the compiler made of the loops is kept, and never that of other sources."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import fbcouple

PACKAGE = Path(fbcouple.__file__).parent
PROGRAM = """
from fbcouple.physics.drag.laws import DRAG_LAWS
print(repr(float(DRAG_LAWS["wen-yu"](0.6, 1.0, 1e-3, 1.2, 1.8e-5))))
"""


def find_drag(place: Path) -> tuple[float, list[str]]:
    """beta by the package copied to `place`, in a process of its own, and what its cache holds."""
    environment = os.environ | {"PYTHONPATH": str(place), "FBCOUPLE_CACHE": str(place / "cache")}
    command = [sys.executable, "-c", PROGRAM]
    done = subprocess.run(command, env=environment, cwd=place, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return float(done.stdout), sorted(path.name for path in (place / "cache").rglob("*.nb?"))


def test_a_function_that_is_compiled_into_others_is_not_taken_from_before(tmp_path):
    """The drag laws' own file stays as it is; a power in them is another one."""
    shutil.copytree(PACKAGE, tmp_path / "fbcouple", ignore=shutil.ignore_patterns("__pycache__"))
    before, kept = find_drag(tmp_path)
    assert kept and find_drag(tmp_path) == (before, kept), "a second process takes what is there"
    power = tmp_path / "fbcouple/physics/elementary.py"
    text = power.read_text()
    changed = text.replace("return exponential(exponent * logarithm", "return 2.0 * exponential(exponent * logarithm")
    assert changed != text
    power.write_text(changed)
    assert find_drag(tmp_path)[0] > 1.5 * before


EXCHANGE = """
import numpy as np
from fbcouple.coupling.box.corners import Stencil
from fbcouple.coupling.kernels import write_volume
field = np.zeros((8, 1))
write_volume(Stencil(np.zeros(1, np.uint64), np.full((1, 3), 0.25), np.arange(8, dtype=np.uint64)), np.ones(1), field)
print(field[0, 0] / field.sum())
"""


def test_fields_of_an_argument_that_are_swapped_elsewhere_are_not_those_of_before(tmp_path, monkeypatch):
    """Numba looks at the file of the loop alone, and a NamedTuple is known to it by its order."""
    monkeypatch.setitem(globals(), "PROGRAM", EXCHANGE)
    shutil.copytree(PACKAGE, tmp_path / "fbcouple", ignore=shutil.ignore_patterns("__pycache__"))
    before, kept = find_drag(tmp_path)
    assert before == pytest.approx(0.75**3, rel=1e-14) and kept
    corners = tmp_path / "fbcouple/coupling/box/corners.py"
    text = corners.read_text()
    changed = text.replace("    base: np.ndarray", "    first: np.ndarray", 1).replace("    upper:", "    base:", 1)
    changed = changed.replace("    first: np.ndarray", "    upper: np.ndarray", 1)
    assert changed != text
    corners.write_text(changed)
    environment = os.environ | {"PYTHONPATH": str(tmp_path), "FBCOUPLE_CACHE": str(tmp_path / "cache")}
    command = [sys.executable, "-c", EXCHANGE]
    done = subprocess.run(command, env=environment, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode != 0 and "TypingError" in done.stderr, "the loop was compiled anew, for the new order"
