"""The laws that a case names: those of the registries, or its own, Python files beside the case."""

from __future__ import annotations

import runpy
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numba.core.errors import NumbaError

from fbcouple.case.schema.heat import Heat
from fbcouple.case.schema.sections import Exchange
from fbcouple.case.user_code import DRAG_FILE, LAW_FILES, NUSSELT_FILE, OWN
from fbcouple.errors import CaseError
from fbcouple.physics.compiler import njit
from fbcouple.physics.drag.laws import DRAG_LAWS
from fbcouple.physics.drag.registry import DragLaw
from fbcouple.physics.heat.nusselt import NUSSELT_LAWS, NusseltLaw

_VOIDAGES = np.linspace(0.36, 1.0, 9)
_DRAG_TRIED = _VOIDAGES, np.array([[0.0], [1e-3], [1.0], [30.0]]), 1e-3, 1.2, 1.8e-5
"""Voidages and slips [m/s] at which an own drag law must be finite and not negative, with 1 mm in air."""
_NUSSELT_TRIED = _VOIDAGES, np.array([[0.0], [1e-3], [1.0], [100.0], [1e4]]), 0.7
"""Voidages and Reynolds numbers at which an own law of heat transfer must be, with the Prandtl number of air."""
_LONGEST = 300
Law = TypeVar("Law", DragLaw, NusseltLaw)


def choose_drag(options: Exchange, folder: Path) -> DragLaw:
    """The drag law of `options`; its own file, if it has one, lies in `folder` and is run.

    Raises CaseError, as `read_drag`.
    """
    if options.drag != OWN:
        return DRAG_LAWS[options.drag]
    assert options.drag_file is not None, "the checks of the case ask for it"
    return read_drag(folder / options.drag_file)


def choose_nusselt(options: Heat, folder: Path) -> NusseltLaw:
    """The law of heat transfer of `options`; its own file, if it has one, lies in `folder` and is run.

    Raises CaseError, as `read_nusselt`.
    """
    if options.nusselt != OWN:
        return NUSSELT_LAWS[options.nusselt]
    assert options.nusselt_file is not None, "the checks of the case ask for it"
    return read_nusselt(folder / options.nusselt_file)


def read_drag(path: Path) -> DragLaw:
    """Run the Python file `path` and compile its function `beta(voidage, slip, diameter, density, viscosity)`.

    The function gives beta [kg/s] of one particle from numbers, F_D = beta (u - v) without the pressure gradient's
    force (model A); u is the gas velocity between the particles. It is compiled as the shipped laws are.

    Raises CaseError if the file cannot be run or compiled, or beta is negative or not finite.
    """
    limits = "voidage 0.36-1 and slip 0-30 m/s (1 mm in air)"
    return _read(path, DRAG_FILE, lambda beta: DragLaw(_loop_over_slips(beta), cache=False), _DRAG_TRIED, limits)


def read_nusselt(path: Path) -> NusseltLaw:
    """Run the Python file `path` and compile its function `nusselt(voidage, reynolds, prandtl)`.

    The function gives Nu = h d/k [1] of one particle from numbers; Re by the superficial slip, eps rho |u - v| d/mu. It
    is compiled as the shipped laws are.

    Raises CaseError if the file cannot be run or compiled, or Nu is negative or not finite.
    """
    limits = "voidage 0.36-1 and Re 0-1e4 (Pr 0.7)"
    return _read(path, NUSSELT_FILE, lambda nu: NusseltLaw(_loop_over_numbers(nu), cache=False), _NUSSELT_TRIED, limits)


def _read(path: Path, option: str, make: Callable[[Any], Law], tried: tuple[Any, ...], limits: str) -> Law:
    key, function = f"{option}: {path.name}", LAW_FILES[option][0]
    try:
        law = make(njit(error_model="numpy")(runpy.run_path(str(path))[function]))
        found = law(*tried)
    except NumbaError as error:
        words = " ".join(str(error).split())[:_LONGEST]
        text = f"cannot be compiled by numba ({words}); use numbers, `math` and NumPy's scalar functions only."
        raise CaseError([f"{key}: {text}"]) from error
    except Exception as error:  # whatever the user's file raises is the user's to read
        raise CaseError([f"{key}: fails ({type(error).__name__}: {error}); fix the file."]) from error
    if not (np.isfinite(found).all() and (found >= 0.0).all()):
        raise CaseError([f"{key}: {function} is negative or not finite within {limits}; fix it."])
    return law


def _loop_over_slips(function):
    """The loop over particles around a compiled drag law of one."""

    def own(voidage, slip, diameter, density, viscosity, beta):
        """The case's own drag law."""
        for p in range(len(beta)):
            beta[p] = function(voidage[p], slip[p], diameter[p], density, viscosity)

    return own


def _loop_over_numbers(function):
    """The loop over particles around a compiled law of heat transfer of one."""

    def own(voidage, reynolds, prandtl, nusselt):
        """The case's own law of heat transfer."""
        for p in range(len(nusselt)):
            nusselt[p] = function(voidage[p], reynolds[p], prandtl)

    return own
