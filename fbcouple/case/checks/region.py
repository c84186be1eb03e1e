"""Whether a region that is no box is described well, and asks for nothing that only a box has."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from fbcouple.case.bed.region import read_imported_mesh, read_mesh
from fbcouple.case.bed.streams import has_openings
from fbcouple.case.checks.registry import check
from fbcouple.case.problems import Problem, show
from fbcouple.case.schema.gas import Domain
from fbcouple.case.schema.sections import Case
from fbcouple.errors import CaseError

AGREES = 0.01
"""Relative difference that the size of a mesh may have from the size that the case says: round walls are meshed by
flat faces between points on them. Only this check and the pre-flight numbers look at the size that the case says."""
MOST_ACROSS = 2000


@check("domain.shape", "domain.elements", "domain.mesh", "domain.scale", "domain.inlet", "domain.outlet")
def check_shape_words(case: Case, folder: Path) -> Iterator[Problem]:
    """Options of one shape are not given with another."""
    domain = case.domain
    owners = {"elements": ("box", "cylinder"), **dict.fromkeys(("mesh", "scale", "inlet", "outlet"), ("file",))}
    for key, shapes in owners.items():
        if (value := getattr(domain, key)) is not None and domain.shape not in shapes:
            text = f"{show(value)} is given and domain.shape is {show(domain.shape)}"
            others = " or ".join(map(show, shapes))
            yield Problem(f"domain.{key}", f"{text}; remove it or give domain.shape = {others}.")
    if domain.shape == "file" and domain.mesh is None:
        yield Problem("domain.mesh", 'nothing is given and domain.shape is "file"; give the mesh beside the case.')


@check("domain.shape", "domain.size", "domain.cells")
def check_cylinder(case: Case, folder: Path) -> Iterator[Problem]:
    """A cylinder has one diameter, and an even number of cells along it."""
    if case.domain.shape != "cylinder":
        return
    (width, depth, _), (across, other, _) = case.domain.size, case.domain.cells
    if width != depth:
        yield Problem("domain.size", f"{width:g} and {depth:g} m are given; a cylinder has the same diameter twice.")
    if across != other or across % 2 or not 4 <= across <= MOST_ACROSS:
        text = f"{across} and {other} are given; a cylinder has an even number of cells across it, 4 to {MOST_ACROSS}"
        yield Problem("domain.cells", f"{text}, twice.")


@check("domain", "gas", "exchange")
def check_box_only(case: Case, folder: Path) -> Iterator[Problem]:
    """What only a box has is not asked for."""
    domain, exchange = case.domain, case.exchange
    if domain.is_plain_box:
        return
    region = f"domain.shape is {show(domain.shape)}"
    if domain.elements:
        region = f"{region} of {domain.elements}"
    if case.gas is None:
        text = f"the case has none and {region}, no box of hexahedra"
        yield Problem("gas", f"{text}; add [gas] (its solver holds the mesh).")
    given = {
        "domain.periodic": domain.periodic or None,
        "gas.closed_nozzle": case.gas.closed_nozzle if case.gas else None,
        "exchange.diffusion_width": exchange.diffusion_width if exchange else None,
        "gas.top": case.gas.top if case.gas and case.gas.top != "open" else None,
    }
    for key, value in given.items():
        if value is not None:
            yield Problem(key, f"{show(value)} is given and {region}; only a box of hexahedra has it: remove it.")
    if exchange is not None and exchange.voidage not in ("trilinear", "centre"):
        text = f'{show(exchange.voidage)} is given, on such a mesh "trilinear" and "centre" are allowed'
        yield Problem("exchange.voidage", f"{text}; give one of them.")


@check("domain", "domain.shape", "domain.mesh", "domain.scale", "domain.size", "domain.inlet", "domain.outlet")
def check_mesh(case: Case, folder: Path) -> Iterator[Problem]:
    """The mesh lies beside the case, can be read, has an inlet and an outlet, and the size that the case says."""
    if case.domain.shape != "file" or case.domain.mesh is None:
        return
    try:
        mesh = read_imported_mesh(case, folder) if has_openings(case) else read_mesh(case, folder)
    except CaseError as error:
        yield from (Problem("domain.mesh", problem) for problem in error.problems)
        return
    yield from _compare_size(case.domain, mesh.high - mesh.low)


def _compare_size(domain: Domain, size: np.ndarray) -> Iterator[Problem]:
    ratios = np.array(domain.size) / size
    if np.all(np.abs(ratios - 1.0) <= AGREES):
        return
    given, found = (", ".join(f"{edge:.7g}" for edge in edges) for edges in (domain.size, size))
    text = f"[{given}] is given and the box around {domain.mesh} is [{found}] m, within {AGREES:.0%} is allowed"
    if np.ptp(ratios) <= AGREES * ratios.mean():
        scale = (domain.scale or 1.0) * float(ratios.mean())
        mend = f"give domain.scale = {scale:.3g} if the mesh is in another unit (1e-3: mm), or the size of the mesh"
        yield Problem("domain.size", f"{text}; {mend}.")
    else:
        yield Problem("domain.size", f"{text}; give that, in m.")
