"""The OpenFOAM that the adapter is written for: which line, from which version, and why another one is refused.

What differs between versions is dealt with here and in `adapter/averaged_turbulence.hpp`, nowhere else.
"""

from __future__ import annotations

import re
from pathlib import Path

from fbcouple.errors import SolverError

OLDEST = 1912
"""First version of openfoam.com that the adapter compiles with."""
NEWEST_COMPILED = 2512
"""Newest version that it was compiled with; a later one is taken, too, and its compiler says whether it fits."""
ABOUT = "META-INFO/api-info"
"""File of an OpenFOAM of openfoam.com that holds its version."""
ALLOWED = f"openfoam.com v{OLDEST} or later"
_TAKE = f"take {ALLOWED}: source its etc/bashrc, or unset WM_PROJECT_DIR to use Debian's package (openfoam)"
_FOUNDATION = (
    "its classes of turbulence, transport and boundary conditions and the files of its cases are others, so that it "
    "would need another adapter and other decks"
)
_STANDARDS = {1912: "-std=c++11", 2312: "-std=c++14", 2412: "-std=c++17"}
"""C++ standard from each version on, as its own rules have it."""


def require_supported(project: Path) -> str:
    """Version that the OpenFOAM in `project` says it has.

    Raises
    ------
    SolverError : it is older than v1912, or of another line: the OpenFOAM Foundation's, or foam-extend
    """
    about = project / ABOUT
    text = about.read_text(encoding="utf-8", errors="replace") if about.is_file() else ""
    if (api := re.search(r"^api=(\d+)", text, re.MULTILINE)) is None:
        raise SolverError(f"WM_PROJECT_DIR={project}: {_name_line(project)}; {_TAKE}")
    if not is_supported(api[1]):
        raise SolverError(f"WM_PROJECT_DIR={project}: v{api[1]}, which the adapter does not compile with; {_TAKE}")
    return api[1]


def is_supported(api: str) -> bool:
    """Is `api`, a version such as 2312, one that the adapter is written for?"""
    return api.isdecimal() and len(api) == len(str(OLDEST)) and int(api) >= OLDEST


def choose_standard(api: str) -> str:
    """The compiler's option for the C++ standard that the headers of version `api` are written in."""
    return _STANDARDS[max(first for first in _STANDARDS if first <= int(api))]


def _name_line(project: Path) -> str:
    """Of which line and version an OpenFOAM is that has no file of its version, and why it will not do."""
    bashrc = project / "etc" / "bashrc"
    text = bashrc.read_text(encoding="utf-8", errors="replace") if bashrc.is_file() else ""
    settings = dict(re.findall(r"^\s*(?:export )?(WM_PROJECT(?:_VERSION)?)=([\w.+-]+)", text, re.MULTILINE))
    version = settings.get("WM_PROJECT_VERSION", "")
    if settings.get("WM_PROJECT") == "foam":
        return f"foam-extend {version}: it has no model of a volume-averaged gas that this adapter knows"
    if re.fullmatch(r"\d{1,2}(\.[\dx]+)*|dev", version):
        return f"OpenFOAM {version} of the OpenFOAM Foundation (openfoam.org): {_FOUNDATION}"
    return f"no {ABOUT} in it, so it is not of openfoam.com, or not a whole one"
