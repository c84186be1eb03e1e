"""What the compiler made of the loops is kept, and never that of other sources."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

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
