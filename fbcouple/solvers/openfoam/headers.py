"""OpenFOAM's headers for Debian's binary package, which ships none: taken from Debian's source package.

The system's apt set-up stays as it is: its source lists are copied, with `deb-src` for `deb`, into a private folder.
"""

import os
import re
import shutil
import tempfile
from pathlib import Path

from fbcouple.errors import SolverError
from fbcouple.solvers.openfoam.commands import run_command
from fbcouple.solvers.site_files import OPENFOAM_SOURCE, find_openfoam_source

_LIBRARIES = (
    "OpenFOAM",
    "OSspecific/POSIX",
    "finiteVolume",
    "meshTools",
    "fileFormats",
    "surfMesh",
    "transportModels/incompressible",
    "TurbulenceModels/turbulenceModels",
    "TurbulenceModels/incompressible",
)
_TREES = ("transportModels",)
_NO_SOURCE = (
    "source package openfoam={version}, which belongs to the installed libopenfoam, was not got: {error}\n"
    "if the mirror has a newer version: sudo apt-get update && sudo apt-get install openfoam, then build again; "
    f"without a mirror unpack that version's source (develop.openfoam.com) and name its folder in {OPENFOAM_SOURCE}"
)
_NETWORK = "check that this machine reaches its Debian mirror (sudo apt-get update), then build again"


def include_folders(source: Path) -> list[Path]:
    """Return the folders to give to the compiler, in order.

    Parameters
    ----------
    source : OpenFOAM's `src` folder, or one laid out like it
    """
    return [source / library / "lnInclude" for library in _LIBRARIES] + [source / tree for tree in _TREES]


def debian_headers(version: str, cache: Path) -> Path:
    """Return a folder laid out like OpenFOAM's `src`, put into the cache the first time: from the source tree that
    FBCOUPLE_OPENFOAM_SOURCE names, else from Debian's source package.

    Parameters
    ----------
    version : version of Debian's source package, such as `1912.200626-1`
    cache : folder that keeps the headers; the caller holds its lock

    Raises
    ------
    SolverError : the source package cannot be fetched or unpacked, or the variable names another source
    """
    own = find_openfoam_source(version.split(".", maxsplit=1)[0])
    kept = cache / f"openfoam-{version}-headers"
    if not kept.is_dir():
        with tempfile.TemporaryDirectory(prefix="openfoam-source-", dir=cache) as name:
            scratch = Path(name)
            source = _copy_source(own, scratch) if own else _fetch_source(version, scratch)
            _collect(source, scratch / "headers")
            (scratch / "headers").rename(kept)
    return kept


def _fetch_source(version: str, scratch: Path) -> Path:
    """Fetch and unpack Debian's source package in a private folder; return the unpacked tree."""
    options = _private_apt(scratch)
    run_command(["apt-get", *options, "update"], mend=_NETWORK, folder=scratch)
    command = ["apt-get", *options, "source", "--only-source"]
    mend = "needs dpkg-dev (sudo apt-get install dpkg-dev) and the source package on this machine's mirror"
    try:
        run_command([*command, f"openfoam={version}"], mend=mend, folder=scratch)
    except SolverError as error:
        # A mirror may lack the description of a source package, and the patches, and have OpenFOAM's own archive.
        try:
            run_command([*command, "--tar-only", "--download-only", f"openfoam={version}"], mend=mend, folder=scratch)
            archives = [str(path) for path in scratch.glob("openfoam_*.orig.tar.*") if path.suffix != ".asc"]
            run_command(["tar", "-xf", *archives], mend="fetch it again", folder=scratch)
        except SolverError:
            raise SolverError(_NO_SOURCE.format(version=version, error=error)) from error
    trees = [path for path in scratch.glob("*") if (path / "wmake" / "wmakeLnInclude").is_file()]
    if len(trees) != 1:
        raise SolverError(f"source package openfoam={version} unpacked to {len(trees)} trees with wmake; 1 is allowed")
    return trees[0]


def _copy_source(source: Path, scratch: Path) -> Path:
    """Copy of a source tree what headers are collected from: that leaves links in the tree, which is another's."""
    copy = scratch / "source"
    for part in ("wmake", *(f"src/{library}" for library in (*_LIBRARIES, *_TREES))):
        shutil.copytree(source / part, copy / part, symlinks=True, dirs_exist_ok=True)
    return copy


def _private_apt(scratch: Path) -> list[str]:
    """Copy the system's source lists as `deb-src` and return the apt options that use nothing else of the system's."""
    parts = scratch / "sources.list.d"
    for folder in (parts, scratch / "lists" / "partial", scratch / "cache" / "archives" / "partial"):
        folder.mkdir(parents=True)
    etc = Path("/etc/apt")
    for path in [etc / "sources.list", *sorted((etc / "sources.list.d").glob("*"))]:
        if path.is_file() and path.suffix in (".list", ".sources"):
            (parts / path.name).write_text(
                as_source_list(path.read_text(encoding="utf-8", errors="surrogateescape"), path.suffix),
                encoding="utf-8",
                errors="surrogateescape",
            )
    folders = {
        "Dir::Etc::sourcelist": "/dev/null",
        "Dir::Etc::sourceparts": parts,
        "Dir::State::Lists": scratch / "lists",
        "Dir::Cache": scratch / "cache",
    }
    if os.geteuid() == 0:
        folders["APT::Sandbox::User"] = "root"
    return [word for key, value in folders.items() for word in ("-o", f"{key}={value}")]


def as_source_list(text: str, suffix: str) -> str:
    """Turn a list of binary packages into the list of their source packages.

    Parameters
    ----------
    text : contents of a file of /etc/apt/sources.list.d
    suffix : `.sources` (stanzas) or `.list` (one line an archive)
    """
    if suffix == ".sources":
        return re.sub(r"(?mi)^Types:.*$", "Types: deb-src", text)
    lines = (line.strip() for line in text.splitlines())
    archives = (re.sub(r"^deb(-src)?\s", "deb-src ", line) for line in lines)
    return "".join(f"{line}\n" for line in dict.fromkeys(archives) if line.startswith("deb-src "))


def _collect(source: Path, complete: Path) -> None:
    """Copy the headers alone: each library's gathered flat, as wmake does, and the trees that are included by path."""
    for tree in _TREES:
        shutil.copytree(source / "src" / tree, complete / tree)
    for library in _LIBRARIES:
        run_command(
            [str(source / "wmake" / "wmakeLnInclude"), "-s", str(source / "src" / library)],
            mend="the source package looks incomplete: build again",
            folder=source,
        )
        shutil.copytree(source / "src" / library / "lnInclude", complete / library / "lnInclude")
