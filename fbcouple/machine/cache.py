"""The cache of built things: used only where nobody but its owner can write, and copied where nobody can.

What lies in it is run: the adapter is a library, and what Numba keeps is loaded by pickle.
"""

from __future__ import annotations

import atexit
import grp
import hashlib
import os
import pwd
import shutil
import stat
import tempfile
from collections.abc import Iterable
from itertools import chain
from pathlib import Path

from fbcouple.errors import SolverError
from fbcouple.paths import PACKAGE, cache_folder

_OTHERS_WRITE = stat.S_IWGRP | stat.S_IWOTH
_OTHERS_REACH = stat.S_IXGRP | stat.S_IXOTH
_NUMBA = "NUMBA_CACHE_DIR"
_LOOPS = "loops-"
_LOOPS_IN = "physics", "geometry", "coupling"
"""Folders whose loops are compiled into one another."""


def make_folder(folder: Path) -> None:
    """Make `folder` where it is not there yet, so that its owner alone can write into it.

    Raises: SolverError if it cannot be made or written.
    """
    try:
        # What Numba and the linker make inside follows the umask: where that lets others write, nobody else gets in.
        kept = os.umask(0o077)
        os.umask(kept)
        folder.mkdir(mode=0o755 if kept & _OTHERS_WRITE == _OTHERS_WRITE else 0o700, parents=True, exist_ok=True)
    except OSError as error:
        raise SolverError(
            f"{folder}: the cache cannot be written ({error.strerror}); name a folder of your own in FBCOUPLE_CACHE, "
            "or build on a machine where it can be (fbcouple doctor --fix)"
        ) from error


def require_trusted(folder: Path, files: Iterable[Path] = (), variable: str = "FBCOUPLE_CACHE") -> None:
    """Raise SolverError if somebody else could have put `folder`, a cache, or `files` in it there.

    Trusted are this user, root, and whoever owns a folder that only root or he could have made (a site's). variable:
    the environment variable that names the folder.
    """
    folder = folder.resolve()
    try:
        about = folder.stat()
        trusted = {0, os.geteuid()}
        is_foreign = about.st_uid not in trusted
        loose = _find_loose(folder, is_foreign)
        if is_foreign and not loose:
            trusted.add(about.st_uid)
        loose = loose or _find_foreign(files, trusted, bool(about.st_mode & _OTHERS_REACH))
    except OSError as error:
        raise SolverError(f"{folder}: the cache cannot be read ({error.strerror}); {_format_mend(variable)}") from error
    if loose:
        found = loose.stat()
        raise SolverError(
            f"{folder}: what lies in this cache is run, and somebody else may have put it there: {loose} belongs to "
            f"{_format_owner(found.st_uid)} and has mode {stat.S_IMODE(found.st_mode):04o}; allowed is what belongs to "
            f"you or root and only its owner writes; {_format_mend(variable)}"
        )


def _find_loose(folder: Path, is_foreign: bool) -> Path | None:
    """The folder itself or one above it that others could exchange or fill."""
    if _others_write(folder.stat()):
        return folder
    for above in folder.parents:
        about = above.stat()
        if is_foreign and _others_write(about):
            return folder
        if about.st_mode & stat.S_IWOTH and not about.st_mode & stat.S_ISVTX:
            return above
    return None


def _find_foreign(files: Iterable[Path], trusted: set[int], is_reached: bool) -> Path | None:
    """The first of `files` that is not of a trusted owner, or that others write in a folder that they reach."""
    for path in files:
        try:
            about = path.stat()
            owners = {path.lstat().st_uid, about.st_uid}
        except FileNotFoundError:  # another process has put it under its final name
            continue
        if owners - trusted or (is_reached and _others_write(about)):
            return path
    return None


def _others_write(about: os.stat_result) -> bool:
    """Can another user write? A group that has its owner alone, as many systems make one for each user, is none."""
    writers = about.st_mode & _OTHERS_WRITE
    return bool(writers & stat.S_IWOTH) or (bool(writers) and not _is_private_group(about.st_gid, about.st_uid))


def _is_private_group(group: int, owner: int) -> bool:
    try:
        name, members = pwd.getpwuid(owner).pw_name, grp.getgrgid(group)
    except KeyError:
        return False
    return members.gr_name == name and set(members.gr_mem) <= {name}


def _format_owner(owner: int) -> str:
    try:
        return pwd.getpwuid(owner).pw_name
    except KeyError:
        return f"user {owner}"


def _format_mend(variable: str) -> str:
    return f"name a folder of your own in {variable}, or remove this one and build again (fbcouple doctor --fix)"


def prepare_compiled() -> Path:
    """Return the folder for what Numba compiles: in the cache, or `NUMBA_CACHE_DIR` if the user has set it.

    Where it cannot be written, as on many compute nodes, a copy that can, which goes with this process; the processes
    that this one starts find the folder in their environment. Its name changes with the sources: Numba itself looks at
    the file of a loop alone, and after an update of a function that is compiled into others it would go on with those
    of before.

    Raises: SolverError if somebody else could have filled it, or Numba is told not to compile.
    """
    if os.environ.get("NUMBA_DISABLE_JIT", "0").strip() not in ("", "0"):
        raise SolverError(
            "NUMBA_DISABLE_JIT is set: the loops over particles and cells call each other as machine code, and cannot "
            "run without the compiler; unset it"
        )
    given = os.environ.get(_NUMBA, "")
    # A folder of the user's own stands; that of an fbcouple that started this one does not.
    is_own = not given or Path(given).name.startswith(_LOOPS)
    folder = cache_folder() / _name_loops() if is_own else Path(given)
    base, variable = (folder.parent, "FBCOUPLE_CACHE") if is_own else (folder, _NUMBA)
    if os.path.lexists(base):
        require_trusted(base, variable=variable)
    if os.path.isdir(folder):
        require_trusted(base, [folder, *folder.rglob("*")], variable)
    folder = folder if _can_be_written(folder) else _copy(folder)
    os.environ[_NUMBA] = str(folder)
    return folder


def list_compiled() -> list[Path]:
    """The files of compiled loops, once `prepare_compiled` has said where they are."""
    folder = os.environ.get(_NUMBA)
    return list(Path(folder).rglob("*.nb?")) if folder else []


def _name_loops() -> str:
    files = [sorted((PACKAGE / name).rglob("*.py")) for name in _LOOPS_IN]
    assert all(files), "every folder of _LOOPS_IN is there"
    return _LOOPS + hashlib.sha256(b"".join(path.read_bytes() for path in chain(*files))).hexdigest()[:16]


def _can_be_written(folder: Path) -> bool:
    """Make the folder, and try it out."""
    try:
        make_folder(folder)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except (OSError, SolverError):
        return False


def _copy(folder: Path) -> Path:
    try:
        copy = Path(tempfile.mkdtemp(prefix="fbcouple-compiled-"))
        atexit.register(_remove, copy, os.getpid())
        for path in sorted(folder.rglob("*")):
            target = copy / path.relative_to(folder)
            if path.is_dir():
                target.mkdir()
            else:
                shutil.copyfile(path, target)
    except OSError as error:
        text = f"{folder}: cannot be written, nor copied into the folder of temporary files ({error})"
        raise SolverError(f"{text}; name a folder that can be written in TMPDIR or FBCOUPLE_CACHE") from error
    return copy


def _remove(copy: Path, owner: int) -> None:
    if os.getpid() == owner:  # and not a process that was forked from it
        shutil.rmtree(copy, ignore_errors=True)
