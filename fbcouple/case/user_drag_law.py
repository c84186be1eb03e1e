"""The drag law that a case names: one of the registry, or its own, a Python file beside the case."""

from __future__ import annotations

import runpy
from pathlib import Path

import numpy as np
from numba.core.errors import NumbaError

from fbcouple.case.schema.sections import Exchange
from fbcouple.case.user_code import FUNCTION, OWN
from fbcouple.errors import CaseError
from fbcouple.physics.compiler import njit
from fbcouple.physics.drag.laws import DRAG_LAWS
from fbcouple.physics.drag.registry import DragLaw

_TRIED = np.linspace(0.36, 1.0, 9), np.array([[0.0], [1e-3], [1.0], [30.0]])
"""Voidages and slips [m/s] at which an own law must be finite and not negative, with 1 mm in air."""
_LONGEST = 300


def choose_law(options: Exchange, folder: Path) -> DragLaw:
    """The law of `options`; its own file, if it has one, lies in `folder` and is run.

    Raises CaseError, as `read_law`.
    """
    if options.drag != OWN:
        return DRAG_LAWS[options.drag]
    assert options.drag_file is not None, "the checks of the case ask for it"
    return read_law(folder / options.drag_file)


def read_law(path: Path) -> DragLaw:
    """Run the Python file `path` and compile its function `beta(voidage, slip, diameter, density, viscosity)`.

    The function gives beta [kg/s] of one particle from numbers, F_D = beta (u - v) without the pressure gradient's
    force (model A); u is the gas velocity between the particles. It is compiled as the shipped laws are.

    Raises CaseError if the file cannot be run or compiled, or beta is negative or not finite.
    """
    key = f"exchange.drag_file: {path.name}"
    try:
        beta = njit(error_model="numpy")(runpy.run_path(str(path))[FUNCTION])
        law = DragLaw(_loop_over(beta), cache=False)
        tried = law(*_TRIED, 1e-3, 1.2, 1.8e-5)
    except NumbaError as error:
        words = " ".join(str(error).split())[:_LONGEST]
        text = f"cannot be compiled by numba ({words}); use numbers, `math` and NumPy's scalar functions only."
        raise CaseError([f"{key}: {text}"]) from error
    except Exception as error:  # whatever the user's file raises is the user's to read
        raise CaseError([f"{key}: fails ({type(error).__name__}: {error}); fix the file."]) from error
    if not (np.isfinite(tried).all() and (tried >= 0.0).all()):
        text = "beta is negative or not finite within voidage 0.36-1 and slip 0-30 m/s (1 mm in air); fix it."
        raise CaseError([f"{key}: {text}"])
    return law


def _loop_over(function):
    """The loop over particles around a compiled function of one."""

    def own(voidage, slip, diameter, density, viscosity, beta):
        """The case's own drag law."""
        for p in range(len(beta)):
            beta[p] = function(voidage[p], slip[p], diameter[p], density, viscosity)

    return own
