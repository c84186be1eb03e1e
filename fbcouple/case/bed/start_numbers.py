"""What `check` tells of a start that is not as it usually is: sizes from its file, columns unread, layers."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from fbcouple.case.bed.lattice import find_start_box, is_layered, lattice_height, mixed_height
from fbcouple.case.bed.particle_types import find_ratio
from fbcouple.case.bed.positions import find_start_file
from fbcouple.case.schema.sections import Case
from fbcouple.errors import CaseError

Told = tuple[str, float, str, str, bool, str]
"""Name, value, unit, what is wanted, whether that is so, and meaning of a pre-flight number."""


def describe_start(case: Case, folder: Path) -> Iterator[Told]:
    """Numbers of the start of a case whose own files lie in `folder`; none of a usual one."""
    particles = case.particles
    assert particles is not None
    on_lattice = case.start is not None and not case.start.is_made
    if on_lattice and case.domain.shape == "box" and is_layered(case):
        meaning = f"Each layer holds one kind; a lattice that mixes them would be {mixed_height(case):.4g} m high."
        yield "start height", lattice_height(case), "m", f"below {find_start_box(case)[1][2]:g}", True, meaning
    if particles.sizes:
        ratio = find_ratio(particles)
        small, large = particles.sizes[0][0] / ratio, max(diameter for diameter, *_ in particles.sizes) / ratio
        sizes = len({diameter for diameter, *_ in particles.sizes})
        meaning = f"{particles.positions} gives each particle its own ({sizes} diameters); that of the case counts for "
        meaning += "the widths of kernels only."
        limit = f"at most {particles.diameter:g} (particles.diameter)"
        yield "smallest diameter", small, "m", limit, small <= particles.diameter, meaning
        limit = f"at least {particles.diameter:g} (particles.diameter)"
        yield "largest diameter", large, "m", limit, large >= particles.diameter, meaning
    try:
        start = find_start_file(case, folder)
    except CaseError:
        return  # told by check_positions
    if start is None:
        return
    idle = ("temperature",) if start.temperatures is not None and case.heat is None else ()
    if unread := (*start.unread, *idle):
        meaning = f"Columns of {particles.positions} that nothing is read from: {', '.join(unread)[:200]}."
        yield "unread columns", len(unread), "1", "0", False, meaning
