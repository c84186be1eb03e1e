"""Files and the words of programs are UTF-8, whatever the locale says: every place names its encoding."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
FILES = sorted([*ROOT.glob("fbcouple/**/*.py"), *ROOT.glob("postproc/**/*.py")])
OTHER_OPEN = {"os", "tarfile", "gzip", "Image", "mapping"}
"""What has an `open` that opens no text file."""


def find_unnamed(source: str) -> Iterator[str]:
    """Calls in `source` that read or write text in the encoding of the locale; programs in texts are looked at too."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and "read_text(" in node.value:
            yield from find_unnamed(node.value)
        if isinstance(node, ast.Call) and _is_text(node) and "encoding" not in {key.arg for key in node.keywords}:
            yield ast.unparse(node)


def _is_text(call: ast.Call) -> bool:
    function = call.func
    name = function.attr if isinstance(function, ast.Attribute) else getattr(function, "id", "")
    if name in ("read_text", "write_text"):
        return isinstance(function, ast.Attribute) and not (name == "read_text" and call.args)
    if name in ("open", "fdopen", "NamedTemporaryFile"):
        owner = ast.unparse(function.value) if isinstance(function, ast.Attribute) else ""
        if name == "open" and owner.rpartition(".")[2] in OTHER_OPEN:
            return False
        words = [ast.unparse(value) for value in (*call.args[:2], *(key.value for key in call.keywords))]
        is_binary = any("'" in word and "b" in word.partition("'")[2].partition("'")[0] for word in words)
        return not is_binary
    return any(key.arg in ("text", "universal_newlines") for key in call.keywords)


@pytest.mark.parametrize(
    ("source", "found"),
    [
        ("path.read_text()", 1),
        ("path.read_text(errors='replace')", 1),
        ("path.read_text('ascii')", 0),
        ("path.write_text(text, encoding='utf-8')", 0),
        ("open(path)", 1),
        ("path.open('a')", 1),
        ("path.open('rb')", 0),
        ("open(path, 'w', encoding='utf-8')", 0),
        ("os.fdopen(number, 'rb')", 0),
        ("os.open(path, os.O_RDONLY)", 0),
        ("subprocess.run(command, text=True)", 1),
        ("subprocess.run(command, text=True, encoding='utf-8')", 0),
        ("subprocess.run(command, capture_output=True)", 0),
        ("PROGRAM = 'import pathlib; print(pathlib.Path(name).read_text())'", 1),
    ],
)
def test_what_is_looked_for(source, found):
    assert len(list(find_unnamed(source))) == found


def test_every_file_and_program_has_its_encoding_named():
    assert len(FILES) > 150
    unnamed = {str(path.relative_to(ROOT)): list(find_unnamed(path.read_text(encoding="utf-8"))) for path in FILES}
    assert {name: calls for name, calls in unnamed.items() if calls} == {}
