"""From the name or path of a study file to a checked study; all mistakes at once, in the words of case files."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from pydantic import ValidationError

from fbcouple import paths
from fbcouple.case.alternatives import list_displaced
from fbcouple.case.load import load_case, write_value
from fbcouple.case.problems import Problem, format_errors, show, suggest, write_hint
from fbcouple.case.schema.option import Section
from fbcouple.case.schema.reference import list_options
from fbcouple.case.source import STUDIES, list_shipped, read_toml
from fbcouple.errors import CaseError

FILE_NAME = "study.toml"
Kind = TypeVar("Kind", bound=Section)
Settings = dict[str, Any]
"""Case keys and their values, on top of a base case."""
MOST = 1000
"""Members of a study, or scenes of one of its tables."""


@dataclass(frozen=True)
class Source:
    """Where a study came from: what messages call it, and its folder."""

    label: str
    folder: Path

    def find_base(self, base: str) -> str:
        """The name by which `load_case` finds `base`: a shipped case, or a path that starts beside the study."""
        return base if base in list_shipped() else str(self.folder / base)


def list_studies() -> dict[str, Path]:
    """Return the study files that come with fbcouple, by name."""
    return {path.parent.name: path for path in sorted((paths.CASES / STUDIES).glob(f"*/{FILE_NAME}"))}


def read_study(name: str, kind: type[Kind]) -> tuple[Kind, Source]:
    """Read and validate the study `name`: a shipped one (`single-particle`), a file, or a folder with a study.toml.

    Raises: CaseError with every mistake of the file's own keys; its case keys are for `require_members` to judge.
    """
    path = _find_study(name)
    label = path.name if path.parent == Path() else str(path)
    raw = read_toml(path, label)
    try:
        return kind.model_validate(raw), Source(label, path.parent)
    except ValidationError as error:
        problems, _ = format_errors(error, raw, kind)
        raise CaseError([f"{label}: {problem}" for problem in problems]) from None


def _find_study(name: str) -> Path:
    shipped = list_studies()
    if name in shipped:
        return shipped[name]
    path = Path(name)
    candidate = path / FILE_NAME if path.is_dir() else path
    if candidate.is_file():
        return candidate
    hint = write_hint(name, shipped)
    raise CaseError([f"{show(name)}: no study file; shipped studies are: {', '.join(shipped)}{hint}."])


def flatten(table: Settings, above: str = "") -> Settings:
    """Dotted keys of nested tables: `gas.max_courant` may be written with quotes or without."""
    flat: Settings = {}
    for key, value in table.items():
        dotted = f"{above}{key}"
        flat |= flatten(value, f"{dotted}.") if isinstance(value, dict) else {dotted: value}
    return flat


def check_number(key: str, lists: Mapping[str, Sequence[Any]], mend: str) -> Iterator[Problem]:
    """Count the combinations of the values in `lists` before they are made: they grow as a power."""
    sizes = [len(values) for values in lists.values()]
    if (number := math.prod(sizes)) > MOST:
        shown = " x ".join(map(str, sizes[:8])) + (" x ..." if len(sizes) > 8 else "")
        text = f"{shown} = {show(number)} combinations are given, at most {MOST} are allowed"
        yield Problem(key, f"{text}; {mend}.")


def check_keys(keys: Sequence[str], where: str, also: Sequence[str] = ()) -> Iterator[Problem]:
    """Every key is one of the case file, or one of `also`."""
    known = [*also, *list_options()]
    for key in keys:
        if key not in known:
            close = suggest(key, known) or next((k for k in known if k.split(".")[-1] == key.split(".")[-1]), None)
            hint = f"did you mean `{close}`" if close else "`fbcouple cases` and the schema list the keys"
            yield Problem(f"{where}.{key}", f"a case has no such key; {hint}.")


def format_settings(settings: Settings) -> list[str]:
    """The `key=value` texts that `load_case` takes."""
    return [f"{key}={write_value(value)}" for key, value in settings.items()]


def put_on_top(common: Settings, own: Settings) -> Settings:
    """`common` with `own` on top: an option of `own` takes the place of one that says the same in another way, too, as
    a setting takes that of a case file's."""
    replaced = {other for _, other in list_displaced(own)}
    return {key: value for key, value in common.items() if key not in replaced} | own


def find_mistakes(base: str, settings: Settings, label: str) -> list[str]:
    """What is wrong with the case `base` under `settings`, each text with `label` before it."""
    try:
        load_case(base, format_settings(settings))
    except CaseError as error:
        return [f"{label}: {problem.removeprefix('--set: ')}" for problem in error.problems]
    return []
