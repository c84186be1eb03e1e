"""Parts of the reference that are read from the code when the pages are built.

`<!-- generated: NAME -->` in a page becomes what `PARTS[NAME]()` returns, Markdown. What the code has and a table here
does not name is a KeyError: the build fails, and the page is completed.
"""

from __future__ import annotations

import ast
import inspect
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click
from sphinx.application import Sphinx

from fbcouple.case.base import read_case
from fbcouple.case.plan.measured_errors import MEASURED
from fbcouple.case.presets import PRESETS
from fbcouple.case.schema.option import Section
from fbcouple.case.schema.reference import Option, list_options, list_sections, list_tables
from fbcouple.case.schema.sections import Case
from fbcouple.case.source import list_sets, list_shipped
from fbcouple.cli.main import cli
from fbcouple.coupling.box.mapping import VOIDAGE_METHODS
from fbcouple.coupling.forces import FORCES
from fbcouple.coupling.kernels import DRAG_SCHEMES
from fbcouple.physics.drag.laws import DRAG_LAWS
from fbcouple.postproc import COMPARISONS, FIGURES
from fbcouple.postproc.papers.hamidouche2019.claims import STATEMENTS
from fbcouple.postproc.papers.hamidouche2019.registry import CLAIMS
from fbcouple.results.variables import (
    EXITS,
    HISTORIES,
    HISTORIES_OF_OUTLETS,
    HISTORIES_OF_SPECIES,
    HISTORY_VECTORS,
    MEANS,
    STAGES,
)
from fbcouple.validate.comparisons import COMPARISONS as WAYS
from fbcouple.validate.comparisons import UNITS
from fbcouple.validate.schema import Validation
from fbcouple.validate.source import list_beds, read_bed
from fbcouple.verify.registry import load_checks

ROOT = Path(__file__).resolve().parents[2]
MARK = re.compile(r"^<!-- generated: ([a-z-]+) -->$", re.MULTILINE)
PARTS: dict[str, Callable[[], str]] = {}

STAGE_TEXTS = {
    "dem": "LIGGGHTS: the DEM steps of the particles",
    "cfd": "OpenFOAM: the step of the gas",
    "map": "solids volume to the cells: the voidage",
    "drag": "drag of each particle, its sums to the cells",
    "react": "forces of the new gas back to the particles, and the check of momentum",
    "average": "samples for the time means",
    "record": "rows of the history, snapshots, frames, checkpoints, results.nc",
    "wait": "waiting for the slowest rank, before the gas and after the particles",
}


def part(function: Callable[[], str]) -> Callable[[], str]:
    """Register a generated part under the name of its function, with hyphens."""
    PARTS[function.__name__.replace("_", "-")] = function
    return function


def escape(text: str) -> str:
    """`text` with the characters that Markdown would take for its own, outside of backticks."""
    pieces = text.split("`")
    pieces[::2] = [re.sub(r"([\\*_<>|$\[\]])", r"\\\1", piece) for piece in pieces[::2]]
    return "`".join(pieces)


def table(heads: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    """A table in Markdown; cells are Markdown already."""
    lines = [heads, ("---",) * len(heads), *rows]
    return "\n".join("| " + " | ".join(row) + " |" for row in lines) + "\n"


def read_doc(thing: Any) -> str:
    """The docstring of `thing`, escaped, its paragraphs as they are."""
    return escape(inspect.getdoc(thing) or "")


@part
def options() -> str:
    """Every option of a case file, by section."""
    return describe_options(Case, "##")


def describe_options(root: type[Section], mark: str) -> str:
    """Every option of a kind of file, by section, under headings that begin with `mark`."""
    lines = []
    for section in [*list_sections(root), *list_tables(root)]:
        head = f"`[[{section}]]`" if section in list_tables(root) else f"`[{section}]`"
        lines.append(f"{mark} {head}\n" if section else f"{mark} Top of the file\n")
        for option in list_options(root).values():
            if option.key.rpartition(".")[0] == section:
                lines.append(f"`{option.key}`\n: {describe_option(option)}\n\n  {escape(option.sentence)}\n")
    return "\n".join(lines)


def describe_option(option: Option) -> str:
    """Type and range, unit and default of an option, in a line."""
    default = f"default `{write_value(option.default)}`" if option.default is not None else "no default"
    facts = [escape(option.allowed), "required" if option.required else default]
    if option.unit != "1":
        facts.insert(1, f"[{option.unit}]".replace("[", "\\[").replace("]", "\\]"))
    return " · ".join(facts)


def write_value(value: Any) -> str:
    """A default as it would stand in a case file."""
    if isinstance(value, tuple):
        return f"[{', '.join(map(write_value, value))}]"
    if isinstance(value, bool):
        return str(value).lower()
    return f'"{value}"' if isinstance(value, str) else f"{value:.10g}"


@part
def presets() -> str:
    """What each preset of `accuracy` sets."""
    keys = list(dict.fromkeys(key for values in PRESETS.values() for key in values))
    rows = [(f"`{key}`", *(f"{values[key]:g}" for values in PRESETS.values())) for key in keys]
    return table(("option", *(f"`{name}`" for name in PRESETS)), rows)


@part
def measured_errors() -> str:
    """What numerics err, as plans have it: the numbers of the studies."""
    rows = []
    for knob in dict.fromkeys(row.knob for row in MEASURED):
        found = [row for row in MEASURED if row.knob == knob]
        for value in dict.fromkeys(row.value for row in found):
            one = [row for row in found if row.value == value]
            source = "; ".join(f"{row.bed} {row.over_map:.2g} (`{row.study}`, `{row.measure}`)" for row in one)
            rows.append((knob, value, f"{max(row.over_map for row in one):.2g}", source))
    return table(("knob", "value", "the larger", "bed (study, measure)"), rows)


@part
def drag_laws() -> str:
    """Every drag law with formula, range and source."""
    return "\n".join(f"### `{name}`\n\n{read_doc(law)}\n" for name, law in DRAG_LAWS.items())


@part
def drag_schemes() -> str:
    """How the drag is averaged over a step."""
    return "\n".join(f"`{name}`\n: {read_doc(scheme)}\n" for name, scheme in DRAG_SCHEMES.items())


@part
def forces() -> str:
    """Forces beside drag and pressure gradient."""
    return "\n".join(f"`exchange.{name}`\n: {read_doc(force.kernel)}\n" for name, force in FORCES.items())


@part
def voidage_methods() -> str:
    """How a particle is shared among cells."""
    return "\n".join(
        f"`{name}`\n: {read_doc(method)}\n".replace("\n\n", "\n\n  ") for name, method in VOIDAGE_METHODS.items()
    )


@part
def variables() -> str:
    """Means and histories of results.nc."""
    blocks = []
    exits = {f"exit_{name}": about for name, about in EXITS.items()}
    histories = HISTORIES | HISTORIES_OF_OUTLETS | HISTORIES_OF_SPECIES | HISTORY_VECTORS
    titled = ("Time means", MEANS), ("Histories", histories), ("Particles that left", exits)
    for title, entries in titled:
        rows = [(f"`{name}`", escape(unit), escape(text)) for name, (unit, text) in entries.items()]
        blocks.append(f"### {title}\n\n{table(('variable', 'unit', 'what it is'), rows)}")
    return "\n".join(blocks)


@part
def stages() -> str:
    """Stages of a coupling step, as the clock tells them apart."""
    return table(("stage", "what it is"), [(f"`{name}`", STAGE_TEXTS[name]) for name in STAGES])


@part
def figures() -> str:
    """Figures of one run, and those of several."""
    blocks = []
    for title, registry in (("Of one run", FIGURES), ("Of several runs, in a report", COMPARISONS)):
        rows = [(f"`{name}`", " ".join(read_doc(draw).split("\n\n")[0].split())) for name, draw in registry.items()]
        blocks.append(f"## {title}\n\n{table(('figure', 'what it shows'), rows)}")
    return "\n".join(blocks)


@part
def checks() -> str:
    """Checks of `fbcouple verify`."""
    rows = []
    for name, check in load_checks().items():
        text = inspect.getdoc(check.function) or inspect.getdoc(inspect.getmodule(check.function)) or ""
        ranks = ", ".join(map(str, check.ranks))
        rows.append((f"`{name}`", "yes" if check.fast else "", ranks, " ".join(escape(text).split("\n\n")[0].split())))
    return table(("check", "fast", "ranks", "what it compares"), rows)


@part
def cases() -> str:
    """Shipped cases and sets."""
    rows = [(f"`{name}`", escape(str(read_case(path, name)[0]["title"]))) for name, path in list_shipped().items()]
    sets = [(f"`{name}`", ", ".join(f"`{member}`" for member in members)) for name, members in list_sets().items()]
    return table(("case", "title"), rows) + "\n## Sets\n\n" + table(("set", "cases"), sets)


@part
def claims() -> str:
    """The claims of the paper: what each needs, its margin and why."""
    assert STATEMENTS, "the modules that register the claims are read"
    rows = [
        (
            f"`{name}`",
            escape(f"{claim.statement} ({claim.place})"),
            escape("; ".join(", ".join(beds) for beds in (claim.needs, *claim.also) if beds)),
            escape(f"{claim.wanted}: {claim.reason}"),
        )
        for name, claim in CLAIMS.items()
    ]
    return table(("claim", "what the paper says, and where", "runs; in place of them also", "margin: why"), rows)


@part
def beds() -> str:
    """Shipped measured beds."""
    rows = []
    for bed in map(read_bed, list_beds()):
        measured = "; ".join(task.measurement.name for task in bed.tasks)
        rows.append((f"`{bed.name}`", *map(escape, (bed.about.source, measured, bed.about.cost))))
    return table(("bed", "by", "measured", "a run takes"), rows)


@part
def comparisons() -> str:
    """Comparisons of measured beds."""
    rows = []
    for way in WAYS.values():
        of = way.of if isinstance(way.of, str) else "a history" if way.of is UNITS else ", ".join(way.of)
        keys = [*(f"`{key}`" for key in way.needs), *(f"`{key}` if wanted" for key in way.takes)]
        text = " ".join((inspect.getdoc(way.function) or "").split())
        rows.append((f"`{way.name}`", escape(of), ", ".join(keys), escape(text)))
    return table(("compare", "of", "keys", "what it compares"), rows)


@part
def validation() -> str:
    """Every key of a validation.toml."""
    return describe_options(Validation, "###")


@part
def floors() -> str:
    """The floors of the imports, as the test of the layers holds them."""
    tree = ast.parse((ROOT / "tests/test_layers.py").read_text(encoding="utf-8"))
    found = next(node.value for node in tree.body if isinstance(node, ast.Assign) and node.targets[0].id == "FLOORS")
    rows = []
    for number, floor in reversed(list(enumerate(ast.literal_eval(found)))):
        rows.append((str(number), ", ".join(f"`{room}`" for room in floor), "; ".join(map(describe_room, floor))))
    return table(("floor", "packages", "what they hold"), rows)


def describe_room(name: str) -> str:
    """First sentence of the docstring of a package, or of a module."""
    package = ROOT / ("postproc" if name == "postproc" else f"fbcouple/{name}")
    path = package / "__init__.py" if package.is_dir() else package.with_suffix(".py")
    text = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or ""
    return escape(" ".join(text.split("\n\n")[0].split()).rstrip("."))


@part
def commands() -> str:
    """Every command with its arguments and options."""
    return "\n".join(write_command(name, command, ()) for name, command in sorted(cli.commands.items()))


def write_command(name: str, command: click.Command, above: tuple[str, ...]) -> str:
    """A command, and those below it."""
    path = (*above, name)
    context = click.Context(command, info_name=" ".join(("fbcouple", *path)))
    pieces = command.collect_usage_pieces(context)
    lines = [
        f"{'#' * (len(path) + 1)} `fbcouple {' '.join(path)}`\n",
        f"{escape(inspect.cleandoc(command.help or ''))}\n",
    ]
    if isinstance(command, click.Group):
        return "\n".join(lines + [write_command(sub, entry, path) for sub, entry in sorted(command.commands.items())])
    lines.append(f"```text\n{context.command_path} {' '.join(pieces)}\n```\n")
    for parameter in command.get_params(context):
        record = parameter.get_help_record(context)
        if record and record[1]:  # the line of usage has the arguments
            lines.append(f"`{record[0]}`\n: {escape(record[1])}\n")
    return "\n".join(lines)


def fill(app: Sphinx, page: str, source: list[str]) -> None:
    """Replace the marks of a page."""
    source[0] = MARK.sub(lambda found: PARTS[found[1]](), source[0])


def list_outdated(app: Sphinx, env: Any, added: set[str], changed: set[str], removed: set[str]) -> list[str]:
    """Pages with marks are read again in every build: the code may have changed."""
    return [page for page in env.found_docs if MARK.search(Path(env.doc2path(page)).read_text(encoding="utf-8"))]


def setup(app: Sphinx) -> dict[str, bool]:
    """Connect to Sphinx."""
    app.connect("source-read", fill)
    app.connect("env-get-outdated", list_outdated)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
