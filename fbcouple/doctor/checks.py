"""What is installed, what fits together and what to do about the rest; libraries are only loaded in other processes."""

import importlib.metadata
import importlib.util
import os
import platform
import re
import shlex
import shutil
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from fbcouple.doctor.abilities import rate_abilities
from fbcouple.doctor.room import list_room
from fbcouple.doctor.row import Row
from fbcouple.doctor.variables import CAPABILITIES, VARIABLES, list_wrong_variables
from fbcouple.errors import SolverError
from fbcouple.machine.cache import require_trusted
from fbcouple.machine.environment import child_environment
from fbcouple.machine.launchers import LAUNCHER
from fbcouple.machine.programs import run_program
from fbcouple.paths import ABOVE, cache_folder
from fbcouple.solvers.c_library import MPI_LIBRARY
from fbcouple.solvers.openfoam.build import adapter_path, build_adapter, compiler_version
from fbcouple.solvers.site_files import FUNCTIONS, LIGGGHTS, LIGGGHTS_NAMES, find_liggghts

if TYPE_CHECKING:
    from packaging.requirements import Requirement

_FIX = "fbcouple doctor --fix"
_INSTALL = "sudo apt-get install"
_SYSTEM_PROJECT = "/usr/share/openfoam"
_FOAM_LIBRARIES = ("libOpenFOAM.so", "libfiniteVolume.so", "libincompressibleTurbulenceModels.so")
_FOAM_PROGRAMS = ("blockMesh", "topoSet", "createPatch", "decomposePar")
_PROBE = """
import ctypes, pathlib, sys
sys.stdout.reconfigure(encoding="utf-8", errors="surrogateescape")
name = sys.argv[1]
if name == "mpi4py":
    import mpi4py
    mpi4py.rc.initialize = False
    from mpi4py import MPI
    print(MPI.Get_library_version().split(",")[0].strip().splitlines()[0])
else:
    ctypes.CDLL(name, ctypes.RTLD_GLOBAL)
    print(name)
maps = pathlib.Path("/proc/self/maps").read_text(encoding="utf-8", errors="surrogateescape").splitlines()
print("\\n".join(sorted({line.split(None, 5)[5] for line in maps if ".so" in line})))
"""
_PICTURE = """
import pyvista
plotter = pyvista.Plotter(off_screen=True, window_size=(64, 64))
plotter.add_mesh(pyvista.Sphere())
plotter.screenshot(None, return_img=True)
print(plotter.render_window.GetClassName())
"""


@dataclass(frozen=True)
class _Loaded:
    """What a process said that loaded a library: its words, the files then in memory, or why it failed."""

    words: str
    files: tuple[str, ...]
    failed: bool

    @property
    def mpi(self) -> tuple[str, ...]:
        """Every MPI library in that process; more than one, or another one than mpi4py's, breaks a run."""
        return tuple(file for file in self.files if re.match(MPI_LIBRARY, Path(file).name))


def examine() -> list[Row]:
    """Return a row for everything that a run needs; a run can work if all are ok."""
    mpi = _load("mpi4py")
    return [
        _python(),
        _variables(),
        *_dependencies(),
        _mpi(mpi),
        _launcher(mpi),
        _liggghts(mpi),
        rate_abilities(),
        *(_library(name, mpi, f"{_INSTALL} openfoam") for name in _FOAM_LIBRARIES),
        *(_program(name) for name in _FOAM_PROGRAMS),
        _control_dict(),
        _compiler(),
        _cache(),
        _adapter(mpi),
        _pictures(),
        *list_room(),
    ]


def fix() -> None:
    """Fix what can be fixed without the system's package manager: build the adapter.

    Raises
    ------
    SolverError : OpenFOAM or the compiler is missing, or the build failed
    """
    build_adapter()


def _python() -> Row:
    return Row(
        "python", platform.python_version(), ">=3.11", sys.version_info >= (3, 11), f"{_INSTALL} python3 python3-venv"
    )


def _dependencies() -> list[Row]:
    """Compare each package's version with what fbcouple's metadata asks for; extras are not needed for a run."""
    try:
        wanted = importlib.metadata.requires("fbcouple") or []
    except importlib.metadata.PackageNotFoundError:
        mend = shlex.join([sys.executable, "-m", "pip", "install", "-e", str(ABOVE)])
        return [Row("fbcouple", "not installed", "installed", False, mend)]
    try:
        from packaging.requirements import Requirement  # noqa: PLC0415  (it is one of what may be missing)
    except ModuleNotFoundError:
        mend = shlex.join([sys.executable, "-m", "pip", "install", "packaging"])
        return [Row("packaging", "not installed", "installed", False, mend)]
    needed = [Requirement(text) for text in wanted]
    return [_dependency(one) for one in needed if one.marker is None or one.marker.evaluate({"extra": ""})]


def _dependency(wanted: "Requirement") -> Row:
    name, bound = wanted.name, str(wanted.specifier)
    mend = shlex.join([sys.executable, "-m", "pip", "install", f"{name}{bound}"])
    try:
        found = importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return Row(name, "not installed", bound, False, mend)
    return Row(name, found, bound, wanted.specifier.contains(found, prereleases=True), mend)


def _load(name: str) -> _Loaded:
    """Load mpi4py or a shared library in a process of its own."""
    return _try_out(_PROBE, name)


def _try_out(program: str, *words: str) -> _Loaded:
    """Run a small Python program whose first line says what it got, whose others are the files it loaded."""
    command = [sys.executable, "-c", program, *words]
    environment = {"WM_PROJECT_DIR": _SYSTEM_PROJECT} | child_environment()
    done = run_program(command, environment, "/")  # a library's settings file in the current folder is not for it
    lines = done.stdout.splitlines()
    if done.returncode != 0 or not lines:
        last = next((line.strip() for line in reversed(done.stderr.splitlines()) if line.strip()), "no words")
        return _Loaded(f"exit code {done.returncode}: {last}", (), True)
    return _Loaded(lines[0], tuple(lines[1:]), False)


def _variables() -> Row:
    """What the site names by environment variables must be there."""
    named = [f"{name}={os.environ[name]}" for name in VARIABLES if os.environ.get(name)]
    wrong = list_wrong_variables()
    found = "; ".join(wrong or named) or "none set"
    return Row("variables", found, "what they name is there", not wrong, "set them right, or unset them")


def _mpi(mpi: _Loaded) -> Row:
    found = mpi.words if mpi.failed else f"{mpi.words}, {' and '.join(mpi.mpi) or 'no libmpi'}"
    mend = f"{_INSTALL} openmpi-bin && {shlex.join([sys.executable, '-m', 'pip', 'install', 'mpi4py>=4.0'])}"
    return Row("mpi4py's MPI", found, "one MPI", not mpi.failed and len(mpi.mpi) == 1, mend)


def _launcher(mpi: _Loaded) -> Row:
    """The launcher must be of the MPI that mpi4py loads, or each rank believes that it is alone.

    Of Open MPI the release is the same, too; of a batch system's launcher only a run can say it.
    """
    name = os.environ.get(LAUNCHER) or "mpirun"
    found = _first_line([name, "--version"])
    wanted = re.search(r"\bv(\d+\.\d+\.\d+)", mpi.words)
    release = re.search(r"\((?:Open MPI|OpenRTE)\) (\d+\.\d+\.\d+)", found)
    mend = f"{_INSTALL} openmpi-bin"
    if name not in ("mpirun", "mpiexec"):
        mend = f"load the batch system's module, or unset {LAUNCHER}"
        return Row(name, found, "on PATH", found != "not on PATH", mend)
    if not mpi.words.startswith("Open MPI"):
        ok = found != "not on PATH" and release is None
        return Row(name, found, f"{name} of {mpi.words.split(' Version')[0]}", ok, "load the module of mpi4py's MPI")
    ok = release is not None and (wanted is None or release[1] == wanted[1])
    return Row(name, found, f"{name} (Open MPI) {wanted[1] if wanted else ''}".rstrip(), ok, mend)


def _liggghts(mpi: _Loaded) -> Row:
    """The library that a rank would load, by whatever name, must have what is called; its own words are only shown."""
    mend = f"{_INSTALL} liggghts, or name a library of LIGGGHTS 3.8 in {LIGGGHTS}"
    try:
        name = find_liggghts(_require_loadable)
    except SolverError as error:
        return Row(LIGGGHTS_NAMES[0], str(error), "loads", False, mend)
    row = _library(name, mpi, mend)
    if not row.ok:
        return row
    told = _try_out(CAPABILITIES, name, *FUNCTIONS)
    wanted = f"{row.wanted}; all functions that are called"
    return Row(row.name, f"{row.found}; {told.words}", wanted, not told.failed, mend)


def _require_loadable(name: str) -> None:
    """Raise OSError with the loader's words if library `name` does not load."""
    if (loaded := _load(name)).failed:
        raise OSError(loaded.words)


def _library(name: str, mpi: _Loaded, mend: str) -> Row:
    """A library must load, and bring no other MPI than mpi4py's."""
    loaded = _load(name)
    wanted = f"loads, with {mpi.mpi[0]}" if mpi.mpi else "loads, with mpi4py's MPI"
    matches = [file for file in loaded.files if Path(file).name.startswith(Path(name).name)]
    found = loaded.words if loaded.failed else matches[0] if matches else name
    same = loaded.mpi == mpi.mpi and bool(mpi.mpi)
    if not loaded.failed and not same:
        found += f", with {' and '.join(loaded.mpi) or 'no MPI'}"
    return Row(Path(name).name, found, wanted, not loaded.failed and same, mend)


def _program(name: str) -> Row:
    found = shutil.which(name, path=child_environment().get("PATH", os.defpath))
    return Row(name, found or "not on PATH", "on PATH", found is not None, f"{_INSTALL} openfoam")


def _control_dict() -> Row:
    path = Path(os.environ.get("WM_PROJECT_DIR", _SYSTEM_PROJECT)) / "etc" / "controlDict"
    found = str(path) if path.is_file() else f"no {path}"
    return Row("OpenFOAM's controlDict", found, "a file", path.is_file(), f"{_INSTALL} openfoam")


def _compiler() -> Row:
    """The compiler is only needed until the adapter is built."""
    try:
        return Row("C++ compiler", compiler_version(), "any g++", True, f"{_INSTALL} g++")
    except SolverError as error:
        return Row("C++ compiler", str(error), "any g++, or a built adapter", _built(), f"{_INSTALL} g++")


def _built() -> bool:
    try:
        return os.path.isfile(adapter_path())
    except SolverError:
        return False


def _cache() -> Row:
    wanted = "a folder that you or root own and nobody else writes"
    try:
        folder = cache_folder()
        if os.path.lexists(folder):
            require_trusted(folder)
    except SolverError as error:
        return Row("cache", str(error), wanted, False, "name a folder of your own in FBCOUPLE_CACHE")
    return Row("cache", str(folder), wanted, True, "name a folder of your own in FBCOUPLE_CACHE")


def _adapter(mpi: _Loaded) -> Row:
    wanted = "built for this OpenFOAM, source and compiler"
    try:
        path = adapter_path()
    except SolverError as error:
        return Row("adapter", str(error), wanted, False, f"fix the rows above, then {_FIX}")
    if not os.path.isfile(path):
        return Row("adapter", f"no {path}", wanted, False, _FIX)
    row = _library(str(path), mpi, f"rm {shlex.quote(str(path))} && {_FIX}")
    return Row("adapter", row.found, f"{wanted}; {row.wanted}", row.ok, row.mend)


def _pictures() -> Row:
    """Without EGL or OSMesa the 3-D library ends its process, so it is tried in another one.

    EGL finds nothing to draw with where Mesa's drivers are not there, which libegl1 does not bring along.
    """
    if importlib.util.find_spec("pyvista") is None:
        return Row("3-D pictures", "left out (pyvista is not installed)", "not needed for a run", True, "")
    tried = _try_out(_PICTURE)
    mend = f"{_INSTALL} libegl1 libgl1-mesa-dri"
    return Row("3-D pictures", tried.words, "drawn without a screen", not tried.failed, mend)


def _first_line(command: list[str]) -> str:
    try:
        done = run_program(command, child_environment())
    except FileNotFoundError:
        return "not on PATH"
    lines = (done.stdout or done.stderr).splitlines()
    return lines[0] if lines else f"exit code {done.returncode}"
