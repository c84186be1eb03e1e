"""Builds the C++ adapter for the OpenFOAM that is installed: `python -m fbcouple.solvers.openfoam.build`.

Two ways: a site's own OpenFOAM (openfoam.com v1912 or later, its bashrc sourced) brings headers and flags; Debian's
package brings only libraries, so the headers come from its source package. The library lies in a cache folder
(`FBCOUPLE_CACHE`, else `~/.cache/fbcouple`) under a name that changes with OpenFOAM, sources, compiler and flags.
"""

import fcntl
import hashlib
import os
import re
import sys
import tempfile
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from fbcouple.errors import FbcoupleError, SolverError
from fbcouple.machine.cache import make_folder, require_trusted
from fbcouple.paths import cache_folder
from fbcouple.run_folder.lock import NO_LOCKS
from fbcouple.solvers.openfoam.commands import run_command
from fbcouple.solvers.openfoam.headers import debian_headers, include_folders
from fbcouple.solvers.openfoam.versions import ABOUT, ALLOWED, choose_standard, is_supported, require_supported

SOURCES = Path(__file__).resolve().parent / "adapter"
"""Folder of the adapter's C++ files."""
LIBRARIES = (
    "finiteVolume",
    "meshTools",
    "incompressibleTransportModels",
    "turbulenceModels",
    "incompressibleTurbulenceModels",
    "OpenFOAM",
    "Pstream",
)
_COMPILER = "install a C++ compiler (sudo apt-get install g++) or name yours in CXX"
_ABSENT = f"no OpenFOAM found: sudo apt-get install openfoam, or source the etc/bashrc of {ALLOWED}"


@dataclass(frozen=True)
class Installation:
    """One OpenFOAM to build for: its version, compile and link flags, and its source tree if the site has one."""

    version: str
    compile_flags: tuple[str, ...]
    link_flags: tuple[str, ...]
    project: Path | None


def find_installation() -> Installation:
    """Find the OpenFOAM to build for: the one whose bashrc was sourced, else Debian's package.

    Raises
    ------
    SolverError : there is none, or it is one that the adapter is not written for
    """
    if named := os.environ.get("WM_PROJECT_DIR"):
        project = Path(named)
        if (project / "src" / "OpenFOAM").is_dir():
            return _site_installation(project)
        if (project / ABOUT).is_file():  # its programs and libraries alone, which would be taken beside Debian's
            require_supported(project)
    return _debian_installation()


def _site_installation(project: Path) -> Installation:
    """Read a full OpenFOAM's version and flags from its tree and the variables that its bashrc set."""
    api = require_supported(project)
    if not (project / "src" / "OpenFOAM" / "lnInclude").is_dir():
        raise SolverError(f"{project}/src/OpenFOAM has no lnInclude: run wmakeLnIncludeAll in {project}")
    rules = [project / "wmake" / "rules" / rules_of / "c++" for rules_of in ("General/Gcc", "linux64Gcc")]
    words = " ".join(path.read_text(encoding="utf-8", errors="replace") for path in rules if path.is_file())
    standard = re.search(r"-std=\S+", words)
    settings = os.environ
    options = settings.get("WM_OPTIONS", "linux64GccDPInt32Opt")
    binaries = settings.get("FOAM_LIBBIN", str(project / "platforms" / options / "lib"))
    folders = (f"{binaries}/{settings.get('FOAM_MPI', 'sys-openmpi')}", binaries)
    return Installation(
        version=f"{api}-{options}",
        compile_flags=_compile_flags(
            standard[0] if standard else choose_standard(api),
            api,
            settings.get("WM_PRECISION_OPTION", "DP"),
            settings.get("WM_LABEL_SIZE", "32"),
        ),
        link_flags=_link_flags(folders),
        project=project,
    )


def _debian_installation() -> Installation:
    """Ask dpkg for the version of Debian's package, which has double precision and 32-bit labels."""
    query = ["dpkg-query", "-W", "-f", "${db:Status-Status} ${source:Version}", "libopenfoam"]
    try:
        status, version = run_command(query, mend=_ABSENT).split()
    except (SolverError, ValueError) as error:
        raise SolverError(_ABSENT) from error
    api = version.split(".")[0]
    if status != "installed" or not is_supported(api):
        raise SolverError(f"Debian package libopenfoam: {status}, version {version}; allowed: {ALLOWED}; {_ABSENT}")
    return Installation(version, _compile_flags(choose_standard(api), api, "DP", "32"), _link_flags(()), None)


def _compile_flags(standard: str, api: str, precision: str, label_size: str) -> tuple[str, ...]:
    """Return the flags that wmake gives: the same sizes as the libraries have, or the adapter reads garbage."""
    defines = (f"OPENFOAM={api}", f"WM_{precision}", f"WM_LABEL_SIZE={label_size}", "WM_ARCH_OPTION=64", "NoRepository")
    return (standard, "-O3", "-fPIC", "-pthread", "-ftemplate-depth-100", *(f"-D{define}" for define in defines))


def _link_flags(folders: tuple[str, ...]) -> tuple[str, ...]:
    """Return link flags; DT_RPATH, unlike DT_RUNPATH, also serves the libraries that OpenFOAM's libraries need."""
    search = [flag for folder in folders for flag in (f"-L{folder}", f"-Wl,-rpath,{folder}")]
    libraries = [f"-l{library}" for library in LIBRARIES]
    return ("-shared", "-Wl,--no-as-needed,--disable-new-dtags,-z,defs", *search, *libraries)


def adapter_path() -> Path:
    """Return where the adapter for this OpenFOAM, source, compiler and flags is, or would be once built.

    On a machine without a compiler (a cluster's compute node) an adapter that any compiler built for the same
    OpenFOAM, source and flags serves.

    Raises
    ------
    SolverError : no OpenFOAM, neither a compiler nor a built adapter, or a cache that others can write
    """
    installation = find_installation()
    flags = (*installation.compile_flags, *installation.link_flags)
    texts = [path.read_bytes() for pattern in ("*.cpp", "*.hpp") for path in sorted(SOURCES.glob(pattern))]
    sources = _short_hash(*texts, *(flag.encode() for flag in flags))
    stem = f"adapter-{installation.version}-{sources}"
    try:
        compiler = compiler_version()
    except SolverError:
        built = sorted(cache_folder().glob(f"{stem}-*.so"))
        if built:
            require_trusted(cache_folder(), built[:1])
            return built[0]
        raise
    library = cache_folder() / f"{stem}-{_short_hash(compiler.encode())}.so"
    if os.path.lexists(library.parent):
        require_trusted(library.parent, [library] if os.path.exists(library) else [])
    return library


def build_adapter(force: bool = False) -> Path:
    """Build the adapter if it is not there yet; two builds at once wait for each other.

    Parameters
    ----------
    force : build it even if it is there

    Returns
    -------
    Path of the shared library

    Raises
    ------
    SolverError : no OpenFOAM or compiler, headers not to be had, or the compiler's words
    """
    target = adapter_path()
    if os.path.isfile(target) and not force:
        return target
    make_folder(target.parent)
    with _lock(target.parent):
        if force or not target.is_file():
            _compile(target)
    return target


def _compile(target: Path) -> None:
    """Compile the adapter, its sources side by side, under a temporary name, then rename it."""
    installation = find_installation()
    if installation.project is None:
        headers = debian_headers(installation.version, target.parent)
        require_trusted(target.parent, [headers])
    else:
        headers = installation.project / "src"
    unfinished = target.with_name(f".{target.name}.{os.getpid()}")
    includes = [f"-I{folder}" for folder in include_folders(headers)]
    command = [_compiler(), *installation.compile_flags]
    mend = f"fix the sources in {SOURCES}, or {_COMPILER}"

    def translate(source: Path) -> str:
        part = Path(scratch, source.stem).with_suffix(".o")
        run_command([*command, "-c", *includes, str(source), "-o", str(part)], mend=mend)
        return str(part)

    try:
        with tempfile.TemporaryDirectory(dir=target.parent) as scratch, ThreadPoolExecutor(os.cpu_count()) as pool:
            parts = list(pool.map(translate, sorted(SOURCES.glob("*.cpp"))))
            run_command([*command, *parts, "-o", str(unfinished), *installation.link_flags], mend=mend)
        unfinished.rename(target)
    finally:
        unfinished.unlink(missing_ok=True)


def compiler_version() -> str:
    """Return the first line of what the C++ compiler says of itself.

    Raises
    ------
    SolverError : there is no compiler
    """
    return run_command([_compiler(), "--version"], mend=_COMPILER).splitlines()[0]


def _compiler() -> str:
    return os.environ.get("CXX") or "g++"


def _short_hash(*parts: bytes) -> str:
    return hashlib.sha256(b"\0".join(parts)).hexdigest()[:16]


@contextmanager
def _lock(folder: Path) -> Iterator[None]:
    """Hold the folder's lock file; the system frees it even if this process is killed.

    Where the file system has no locks two builds may do the same work; each names its library when it is whole.
    """
    try:
        file = (folder / "build.lock").open("w", encoding="utf-8")
    except OSError as error:
        text = f"{folder}: the cache cannot be written ({error.strerror}), and there is no adapter for this OpenFOAM"
        mend = "build where it can be written (fbcouple doctor --fix), or name a folder of your own in FBCOUPLE_CACHE"
        raise SolverError(f"{text} in it; {mend}") from error
    with file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX)
        except OSError as error:
            if error.errno not in NO_LOCKS:
                raise
        yield


if __name__ == "__main__":
    try:
        print(build_adapter(force="--force" in sys.argv[1:]))
    except FbcoupleError as error:
        print(error, file=sys.stderr)
        sys.exit(error.exit_code)
