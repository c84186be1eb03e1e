"""What of a run's texts and of the environment may leave the machine: what is known to be harmless, nothing else.

A word of a text stays if it is a number, or if fbcouple's own sources and templates or the solvers' own messages have
it. Whatever else, a name, a password or a key of any form, is replaced; a line that speaks of a secret is left out.
"""

from __future__ import annotations

import builtins
import calendar
import errno
import os
import platform
import re
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from pathlib import Path

from fbcouple.paths import PACKAGE, TEMPLATES

MASK = "***"
LEFT_OUT = "[a line that may hold a secret is left out]"
_NAMES = """
CONDA_PREFIX CXX FBCOUPLE_BIND FBCOUPLE_CACHE FBCOUPLE_LAUNCHER FBCOUPLE_LIGGGHTS FBCOUPLE_OPENFOAM_SOURCE
FOAM_API FOAM_LIBBIN FOAM_MPI FOAM_SETNAN FOAM_SIGFPE LANG LC_ALL LC_CTYPE
LC_NUMERIC LD_LIBRARY_PATH LSB_DJOB_NUMPROC LSB_JOBID NCPUS NUMBA_CACHE_DIR NUMBA_DISABLE_JIT NUMBA_NUM_THREADS
OMPI_COMM_WORLD_RANK OMPI_COMM_WORLD_SIZE OMPI_MCA_btl OMPI_MCA_mtl OMPI_MCA_pml OMPI_MCA_rmaps_base_oversubscribe
OMP_NUM_THREADS PATH PBS_JOBID PBS_NP PYTHONCOERCECLOCALE PYTHONIOENCODING PYTHONPATH PYTHONSAFEPATH PYTHONUTF8
SHELL SLURM_CPUS_ON_NODE SLURM_JOB_ID SLURM_JOB_NUM_NODES SLURM_MEM_PER_CPU SLURM_MEM_PER_NODE SLURM_NTASKS
SLURM_RESTART_COUNT SLURM_TASKS_PER_NODE TMPDIR UCX_TLS VIRTUAL_ENV WM_ARCH WM_COMPILER WM_LABEL_SIZE WM_MPLIB
WM_OPTIONS WM_PRECISION_OPTION WM_PROJECT_DIR WM_PROJECT_VERSION XDG_CACHE_HOME
"""
VARIABLES = frozenset(_NAMES.split())
"""Environment variables that say what solvers, MPI and batch systems do, by their whole names."""
_READ_BY_SOLVERS = re.compile(r"(OMPI|PMIX|PRTE|FOAM|WM|SLURM|PBS|LSB|OMP|NUMBA|FBCOUPLE|LC|UCX|PYTHON)_?\w+")
_HARMLESS_VALUE = re.compile(r"[\w./:+,=~ -]*")
_OF_A_SECRET = re.compile(r"(?i)key|token|secret|pass|pwd|\bpw|_pw|credential|cookie|auth|jwt|_pat\b|cert")
_SHORTEST_SECRET = 6
_SPEAKS_OF_A_SECRET = re.compile(
    r"""(?ix) passw | passphrase | passcode | secret | credential | bearer | \bjwt | cookie | \bpin\b
    | authoriz | (?:api|access|private|ssh|rsa)[\s_-]?key | ssh- | ://[^\s/]*@ | _pat\b
    | (?:token|key|auth|pwd)\w*["']?\s*[=:] | --?[\w-]*(?:token|key|auth)"""
)
_PEM_BEGINS, _PEM_ENDS = re.compile(r"-----\s*BEGIN"), re.compile(r"-----\s*END")
_GOES_ON = re.compile(r"[=:|>\\]\s*$")
_NUMBER = re.compile(
    r"[v+-]?\d{1,12}(?:\.\d{0,25})?(?:[eE][+-]?\d{1,3})?|\d{1,4}[TZ]\d{0,2}|0x|(?:a|b|rc|post|dev)\d{1,3}"
)
_WORD = re.compile(r"\w+")
_TOKEN = re.compile(r"\S+")
_PIECE = re.compile(r"[v+-]?\d+(?:\.\d+)?(?:[eE][+-]?\d+)?(?![\w])|\w+")
_MESSAGE = re.compile(rb"[\x20-\x7e]{8,}")
_SOLVERS_WORDS = "consistency Disallowing Histogram region0 xplane yplane zplane"
_LARGEST_LIBRARY = 100_000_000


def list_environment(variables: Mapping[str, str]) -> str:
    """The variables of VARIABLES, a line each; of others that solvers read the names alone."""
    lines = []
    for name, value in sorted(variables.items()):
        if name in VARIABLES and _HARMLESS_VALUE.fullmatch(value) and "://" not in value:
            lines.append(f"{name}={value}\n")
        elif name in VARIABLES or (_READ_BY_SOLVERS.fullmatch(name) and name.isascii()):
            lines.append(f"{name}: set, its value is left out\n")
    return mask_values("".join(lines), variables)


def mask_values(text: str, variables: Mapping[str, str]) -> str:
    """`text` without the values of variables that are called secrets."""
    for name, value in variables.items():
        if _OF_A_SECRET.search(name) and len(value) >= _SHORTEST_SECRET and name not in VARIABLES:
            text = text.replace(value, MASK)
    return text


class Vocabulary:
    """The words that a text may keep: those of fbcouple's own files, of Python's errors and of `messages`."""

    def __init__(self, messages: Iterable[Path] = ()) -> None:
        """`messages`: libraries, programs and texts of the solvers and MPI, whose own messages are known."""
        self._known = {word.lower() for text in _read_own() for word in _WORD.findall(text)}
        for path in messages:
            self._known |= _read_messages(path)
        self._keep = cache(self._filter_token)

    def filter(self, text: str) -> str:
        """`text` with each unknown word replaced, and without the lines that speak of secrets."""
        return "".join(f"{line}\n" for line in self._filter_lines(text))

    def filter_name(self, name: str) -> str:
        """A file's name if all words of it are known, else its ending."""
        if _SPEAKS_OF_A_SECRET.search(name) or not self._is_known(name):
            ending = Path(name).suffix
            return MASK + (ending if self._is_known(ending) else "")
        return name

    def _filter_lines(self, text: str) -> Iterator[str]:
        is_key = goes_on = False
        for line in text.splitlines():
            is_key = is_key or bool(_PEM_BEGINS.search(line))
            speaks = bool(_SPEAKS_OF_A_SECRET.search(line))
            if is_key or speaks or goes_on:
                yield LEFT_OUT
            else:
                yield _TOKEN.sub(lambda found: self._keep(found[0]), line)
            is_key = is_key and not _PEM_ENDS.search(line)
            goes_on = speaks and bool(_GOES_ON.search(line))

    def _filter_token(self, token: str) -> str:
        """A path keeps the parts of it that are known; of anything else all is kept or nothing."""
        if "/" in token and "://" not in token:
            return "/".join(part if self._is_known(part) else MASK for part in token.split("/"))
        return token if self._is_known(token) else MASK

    def _is_known(self, token: str) -> bool:
        return all(piece.lower() in self._known or _NUMBER.fullmatch(piece) for piece in _PIECE.findall(token))


def _read_own() -> Iterator[str]:
    for folder in (PACKAGE, PACKAGE / "postproc", TEMPLATES):
        for path in folder.rglob("*"):
            if path.is_file() and path.suffix != ".pyc":
                yield path.read_text(encoding="utf-8", errors="ignore")
    yield " ".join(
        [*dir(builtins), *calendar.day_abbr, *calendar.month_abbr, platform.machine(), "consistency Histogram"]
    )
    yield " ".join(map(os.strerror, errno.errorcode))


def _read_messages(path: Path) -> set[str]:
    """Words of the readable texts in a file, which have a blank between them; empty if it cannot be read."""
    try:
        if path.stat().st_size > _LARGEST_LIBRARY:
            return set()
        content = path.read_bytes()
    except OSError:
        return set()
    texts = (found.decode("ascii") for found in _MESSAGE.findall(content) if b" " in found)
    return {word.lower() for text in texts for word in _WORD.findall(text)}
