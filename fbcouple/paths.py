"""Where templates and shipped cases lie, inside an installed package or beside it in a checkout, and built things."""

import os
import re
from collections.abc import Iterable
from pathlib import Path

from fbcouple.errors import CaseError, SolverError

PACKAGE = Path(__file__).resolve().parent
ABOVE = PACKAGE.parent
"""The checkout, or the folder of installed packages."""


def _find(name: str) -> Path:
    installed = PACKAGE / name
    return installed if installed.is_dir() else ABOVE / name


TEMPLATES = _find("templates")
CASES = _find("cases")
START = "DEM/particles.data"
"""In a run folder: the particles as they start."""
TEMPERATURES = "DEM/temperatures.txt"
"""In a run folder: temperature [K] of each particle at the start, a line each in their order, where they differ."""
WALLS = "DEM/walls.stl"
"""In a run folder: the surface that the particles have for a wall, where the region is no plain box."""
HEARTBEAT = "logs/heartbeat"
"""In a run folder: touched while coupling steps are taken."""
LOG = "logs/run.jsonl"
"""In a run folder: the history, a row a line, while the run goes on."""
PROBES = "probes"
"""In a run folder: rows of the probes as they were taken, a file a set."""
FRAMES = "frames"
"""In a run folder: particles and gas at single moments, a netCDF file each."""

REPLICA = "replica-"
"""How the names of replicas begin, run folders of one case with different seeds in one folder, counted from 1."""


def list_replicas(folder: Path) -> list[Path]:
    """The replicas in `folder` by their numbers; none if it is a run folder itself, or holds other runs."""
    runs = [path.parent for path in folder.glob("*/case.toml")]
    if (folder / "case.toml").is_file() or not all(re.fullmatch(rf"{REPLICA}\d+", run.name) for run in runs):
        return []
    return sorted(runs, key=lambda run: int(run.name.removeprefix(REPLICA)))


def list_members(folder: Path) -> list[Path]:
    """What a folder of runs holds, by name: run folders, folders of replicas and files of reduced means; none if it is
    a run folder or a folder of replicas itself."""
    if not folder.is_dir() or (folder / "case.toml").is_file() or list_replicas(folder):
        return []
    runs = [path for path in folder.iterdir() if (path / "case.toml").is_file() or list_replicas(path)]
    return sorted([*runs, *folder.glob("*.nc")])


def expand_replicas(paths: Iterable[Path]) -> list[Path]:
    """`paths` with the run folders in a folder of replicas in its place."""
    return [one for path in paths for one in list_replicas(path) or [path]]


def find_home(run: Path) -> Path:
    """The folder that what is made of `run` goes into: itself, of a file NAME.nc the folder NAME beside it, of a file
    with another name that and "-made".

    Raises: CaseError if that is a folder of a run of its own.
    """
    if not run.is_file():
        return run
    home = run.with_suffix("") if run.suffix == ".nc" else run.with_name(f"{run.name}-made")
    if (home / "case.toml").is_file():
        text = f"what is made of it goes into {home}, and that is a run folder"
        raise CaseError([f"{run}: {text}; give another place with -o."])
    return home


def cache_folder() -> Path:
    """Return the folder of built things: `FBCOUPLE_CACHE`, else `fbcouple` in the user's XDG cache folder.

    Raises: SolverError if neither is there.
    """
    if given := os.environ.get("FBCOUPLE_CACHE"):
        return Path(given).expanduser().resolve()
    folder = find_user_folder("XDG_CACHE_HOME", "~/.cache")
    if folder is None:
        raise SolverError("there is no home folder for the cache of built things; name a folder in FBCOUPLE_CACHE")
    return folder


def find_user_folder(variable: str, default: str) -> Path | None:
    """The folder `fbcouple` in the one that the XDG variable names or, where it names none from the root, in `default`;
    None without a home folder."""
    above = Path(os.environ.get(variable, ""))
    if not above.is_absolute():  # as the XDG specification says
        above = Path(os.path.expanduser(default)) if os.environ.get("HOME", "~") else Path("~")
    return above / "fbcouple" if above.is_absolute() else None


def require_usable(run: Path) -> None:
    """Raise CaseError if the solvers and libraries cannot write into `run` for the letters of its path.

    Blanks, quotes and letters of any language are fine. The netCDF library takes a backslash for the separator of
    another system and reads paths as UTF-8; a line break cuts what is said about the run.
    """
    path = str(run.resolve())
    wrong = {letter for letter in path if letter == "\\" or not letter.isprintable()}
    if wrong:
        shown = ", ".join(f"U+{ord(letter):04X}" for letter in sorted(wrong))
        raise CaseError(
            [
                f"{str(run)!a}: the path of a run folder has characters ({shown}) that the netCDF library cannot "
                "write to; all printable ones but the backslash are allowed, in UTF-8; move it, or give another "
                "folder with -o."
            ]
        )
