"""Whether what [output] asks for can be had from this case."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from fbcouple.case.bed.particle_types import particle_count, word_one
from fbcouple.case.checks.bed import try_region
from fbcouple.case.checks.registry import BED, check, has_bed
from fbcouple.case.companions import find_companion
from fbcouple.case.problems import Problem, show
from fbcouple.case.schema.output import AUTO, OF_GAS, OF_SOLIDS
from fbcouple.case.schema.sections import Case
from fbcouple.case.user_code import examine_task_file
from fbcouple.errors import CaseError
from fbcouple.input_files.measured_lines import parse_reference, read_line

MOST_SNAPSHOTS = 100_000
MOST_FRAMES = 10_000
MOST_TRACKED = 100
MOST_RECORDS = 10_000_000
"""Rows of the history that a rank can hold."""
FEWEST_BLOCKS = 8
"""Blocks that an error which ends a run is made of, at least."""


@check("output.record_every", "end_time")
def check_records(case: Case, folder: Path) -> Iterator[Problem]:
    """The history has not more rows than fit into memory."""
    if case.end_time / case.output.record_every > MOST_RECORDS:
        text = f"{case.output.record_every:g} s is given, at least {case.end_time / MOST_RECORDS:.3g} s is allowed"
        yield Problem("output.record_every", f"{text} ({MOST_RECORDS} rows); record more seldom.")


@check("output.task_file")
def check_task_file(case: Case, folder: Path) -> Iterator[Problem]:
    """A file of tasks is a Python file beside the case with a class of Task."""
    name = case.output.task_file
    if name is None:
        return
    try:
        examine_task_file(find_companion(case.find_folder(folder, name), name, ".py"))
    except CaseError as error:
        yield from (Problem("output.task_file", problem) for problem in error.problems)


@check("output.snapshots_every", "gas", "particles", "end_time")
def check_snapshots(case: Case, folder: Path) -> Iterator[Problem]:
    """Snapshots of the voidage need both phases, and there are not more of them than a file should hold."""
    every = case.output.snapshots_every
    if every is None:
        return
    if case.gas is None or case.particles is None:
        missing = "gas" if case.gas is None else "particles"
        text = f"{every:g} s is given and the case has no [{missing}], so no voidage"
        yield Problem("output.snapshots_every", f"{text}; remove it or add [{missing}].")
    elif case.end_time / every > MOST_SNAPSHOTS:
        text = f"{every:g} s is given, at least {case.end_time / MOST_SNAPSHOTS:.3g} s is allowed"
        yield Problem("output.snapshots_every", f"{text} ({MOST_SNAPSHOTS} snapshots); take them more seldom.")


@check("output.particles_every", "particles", "end_time")
def check_frames(case: Case, folder: Path) -> Iterator[Problem]:
    """Frames need particles, and there are not more of them than a folder should hold."""
    every = case.output.particles_every
    if every is None:
        return
    if case.particles is None:
        text = f"{every:g} s is given and the case has no [particles]; remove it or add [particles]."
        yield Problem("output.particles_every", text)
    elif case.end_time / every > MOST_FRAMES:
        text = f"{every:g} s is given, at least {case.end_time / MOST_FRAMES:.3g} s is allowed"
        yield Problem("output.particles_every", f"{text} ({MOST_FRAMES} frames); take them more seldom.")


@check("output.tracked", *BED)
def check_tracked(case: Case, folder: Path) -> Iterator[Problem]:
    """Tracked particles are there, each is named once, and they are few."""
    key, numbers = "output.tracked", case.output.tracked
    if not numbers:
        return
    if case.particles is None:
        yield Problem(key, f"{show(numbers)} is given and the case has no [particles]; remove it or add [particles].")
        return
    if len(numbers) > MOST_TRACKED:
        text = f"{len(numbers)} particles are given, at most {MOST_TRACKED} are allowed"
        yield Problem(key, f"{text}; output.particles_every keeps them all.")
    if len(set(numbers)) < len(numbers):
        yield Problem(key, f"{show(numbers)} is given; name each particle once.")
    fed = bool(case.particles.feeds)
    if has_bed(case) and not fed and max(numbers) > (count := particle_count(case.particles)):
        what = word_one(case.particles)
        yield Problem(key, f"{what} {max(numbers)} is given and there are {count} {what}s; number them from 1.")


@check("output.references", "domain", "domain.size", "domain.shape")
def check_references(case: Case, folder: Path) -> Iterator[Problem]:
    """Each reference can be read, its file lies beside the case, and its line lies in the box."""
    key = "output.references"
    region = try_region(case, folder) if case.output.references else None
    for text in case.output.references:
        try:
            reference = parse_reference(text)
            if reference.is_radial and case.domain.shape == "box":
                given = f'{show(text)} is given and domain.shape is "box", which has no radius'
                yield Problem(
                    key, f"{given}; give {reference.quantity}@{reference.height:g}=file, x from the left wall."
                )
                continue
            file = find_companion(case.find_folder(folder, reference.file), reference.file, ".csv")
            read_line(reference, file, case.domain.size, region.corner if region else (0.0, 0.0, 0.0))
        except CaseError as error:
            yield from (Problem(key, problem) for problem in error.problems)


@check("output.profile_heights", "output.radial_heights", "domain.size", "domain.shape")
def check_heights(case: Case, folder: Path) -> Iterator[Problem]:
    """Profiles are taken inside of the box, and over the radius of what may be round."""
    for key in ("profile_heights", "radial_heights"):
        for height in getattr(case.output, key):
            if height >= case.domain.size[2]:
                text = f"{height:g} m is given and the box is {case.domain.size[2]:g} m high; give heights in it, in m."
                yield Problem(f"output.{key}", text)
    if case.output.radial_heights and case.domain.shape == "box":
        text = f'{show(case.output.radial_heights)} is given and domain.shape is "box", which has no radius'
        yield Problem("output.radial_heights", f"{text}; remove it, or give profile_heights.")


@check("averages.start", "averages.until_error", "averages.blocks")
def check_start(case: Case, folder: Path) -> Iterator[Problem]:
    """A start-up is found by blocks enough."""
    if case.averages is None or case.averages.start != AUTO or case.averages.until_error is not None:
        return
    if case.averages.blocks < FEWEST_BLOCKS:
        text = f'{case.averages.blocks} is given, at least {FEWEST_BLOCKS} are allowed with averages.start = "auto"'
        yield Problem("averages.blocks", f"{text}: fewer tell no start-up; give more.")


@check("averages.until_error", "averages.earliest_end", "averages.error_of", "averages.blocks", "gas", "particles")
def check_until_error(case: Case, folder: Path) -> Iterator[Problem]:
    """What ends a run by its error has blocks enough, and a map or history that the case has."""
    if case.averages is None:
        return
    chosen, blocks = case.averages.error_of, case.averages.blocks
    if case.averages.until_error is None:
        if chosen is not None:
            yield Problem("averages.error_of", f'"{chosen}" is given without averages.until_error; give both or none.')
        if (earliest := case.averages.earliest_end) is not None:
            text = f"{earliest:g} s is given without averages.until_error, which alone ends a run early"
            yield Problem("averages.earliest_end", f"{text}; give both or none.")
        return
    if blocks < FEWEST_BLOCKS:
        text = f"{blocks} is given, at least {FEWEST_BLOCKS} are allowed with averages.until_error"
        yield Problem("averages.blocks", f"{text}: fewer tell no error; give more.")
    lacking = "particles" if case.particles is None and chosen in OF_SOLIDS else ""
    lacking = "gas" if case.gas is None and chosen in OF_GAS else lacking
    if lacking:
        yield Problem("averages.error_of", f'"{chosen}" is given and the case has no [{lacking}]; name what it has.')
