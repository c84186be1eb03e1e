"""More than 200 broken case files, made by mutation of a good one: told in words, at once, with nothing written."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from click.testing import CliRunner

import fbcouple
from fbcouple.case.load import load_case, write_case
from fbcouple.case.schema.reference import list_options
from fbcouple.cli.main import cli

LONGEST = 2.0
"""Processor time [s] that a broken case may take; wall time where nothing else runs."""
LONG = 4_900_000


def read_good(folder: Path) -> bytes:
    """The effective case of patil/c2: every option on a line of its own."""
    write_case(load_case("patil/c2"), folder / "good.toml")
    text = (folder / "good.toml").read_bytes()
    (folder / "good.toml").unlink()
    return text


def replace_value(text: bytes, key: str, value: bytes) -> bytes:
    """The case with `value` in place of what `key` has there."""
    section, _, name = key.rpartition(".")
    lines = text.split(b"\n")
    start = lines.index(f"[{section}]".encode()) if section else -1
    number = next(n for n in range(start + 1, len(lines)) if lines[n].startswith(f"{name} = ".encode()))
    return b"\n".join([*lines[:number], f"{name} = ".encode() + value, *lines[number + 1 :]])


def mutate_values(text: bytes) -> Iterator[tuple[str, bytes]]:
    """Each option with values of a wrong type, out of range, too large, with a unit, or in letters that look right."""
    numbers = {"text": b'"1.0"', "unit": b"1 mm", "list": b"[1.0]", "infinite": b"inf", "not a number": b"nan"}
    numbers |= {"minus": b"-1", "overflow": b"1e999", "many digits": b"9" * 5000, "flag": b"true"}
    words = {
        "number": b"1",
        "Cyrillic": '"slip\u0430"'.encode(),
        "empty": b'""',
        "control": b'"a\\u0007b"',
        "list": b'["a"]',
    }
    others = {"number": b"3", "text": b'"yes"', "table": b"{ a = 1 }", "date": b"2026-01-01"}
    for key, option in list_options().items():
        section, _, name = key.rpartition(".")
        _, _, rest = text.partition(f"[{section}]".encode()) if section else (b"", b"", text)
        if f"\n{name} = ".encode() not in b"\n" + rest.split(b"\n[")[0]:
            continue
        kind = "number" if "number" in option.allowed and "list" not in option.allowed else option.allowed
        wrong = numbers if kind == "number" else words if '"' in kind or kind.startswith("a text") else others
        for what, value in wrong.items():
            if not (key == "title" and what == "Cyrillic"):
                yield f"{key}: {what}", replace_value(text, key, value)


def mutate_structure(text: bytes) -> Iterator[tuple[str, bytes]]:
    """The file as a whole: torn, doubled, nested, enormous, not text, not TOML."""
    needed = text.index(b"inlet_velocity")  # cut behind it, the gas alone is a case
    yield from ((f"cut at {n}", text[:n]) for n in range(1, needed, needed // 12))
    for key in (b"title", b"end_time", b"[gas]", b"[domain]", b"density", b"cells"):
        line = next(line for line in text.split(b"\n") if line.startswith(key))
        yield f"{key.decode()} twice", text.replace(line, line + b"\n" + line, 1)
    for section in (b"domain", b"gas", b"particles", b"contact", b"exchange"):
        yield f"{section.decode()} misspelt", text.replace(b"[" + section, b"[" + section[:-1])
        yield f"{section.decode()} as an array", text.replace(b"[" + section + b"]", b"[[" + section + b"]]")
    yield "brackets", b"end_time = " + b"[" * 100_000
    yield "closed brackets", b"end_time = " + b"[" * 500 + b"]" * 500 + b"\n" + text
    yield "braces", b"gas = " + b"{a=" * 5000 + b"1" + b"}" * 5000
    deep = b".".join([b"a"] * 5000)
    yield "dotted key", deep + b" = 1\n" + text
    yield "dotted section", text + b"\n[" + deep + b"]\nb = 1\n"
    yield (
        "many keys of a dotted section",
        text + b"\n[" + deep + b"]\n" + b"".join(b"b%d = 1\n" % n for n in range(5000)),
    )
    yield "quoted dotted key", b"gas = { " + b" . ".join([b'"a b"', b"'c'"] * 2500) + b" = 1 }\n"
    yield "long title", replace_value(text, "title", b'"' + b"x" * LONG + b'"')
    yield "long word", replace_value(text, "gas.walls", b'"' + b"y" * LONG + b'"')
    yield "long key", b"k" * LONG + b" = 1\n" + text
    yield "long quoted key", b'"' + "\u202e".encode() * (LONG // 3) + b'" = 1\n' + text
    yield "long list", replace_value(text, "domain.cells", b"[" + b"1," * (LONG // 40) + b"1]")
    yield "long file name", text.replace(b"mass =", b'positions = "' + b"p" * LONG + b'.csv"\nmass =')
    yield "larger than a case file may be", text + b"#" * 5_000_000
    yield "many keys", b"".join(b"k%d = 1\n" % n for n in range(20_000)) + text
    yield "many sections", text + b"".join(b"\n[s%d]\n" % n for n in range(5000))
    yield "hexadecimal", replace_value(text, "particles.diameter", b"0x" + b"f" * 100_000)
    yield "exponent", replace_value(text, "particles.diameter", b"1e" + b"9" * 100_000)
    yield "UTF-16", text.decode().encode("utf-16")
    yield "Latin-1", text.replace(b'title = "', b'title = "\xfc')
    yield "zero bytes", text.replace(b"\n", b"\0\n")
    yield "surrogate", text.replace(b'title = "', b'title = "\\ud800')
    yield "right-to-left", text.replace(b'title = "', 'title = "\u202e'.encode())
    yield "full-width digits", replace_value(text, "end_time", "２０".encode())
    yield "decimal comma", replace_value(text, "end_time", b"20,0")
    yield "thousands", replace_value(text, "end_time", b"1'000")
    yield "nothing", b""
    yield "noise", bytes(range(256)) * 50
    yield "YAML", text.replace(b" = ", b": ")
    yield "JSON", b'{"title": "x", "end_time": 20}'
    yield "words without an end", b"a" * (LONG // 2) + b"." + b"a" * (LONG // 2)
    yield "quotes and dots", (b'"' + b"a" * 1000 + b'".') * 40 + b"=\n" + b"'a'." * 1_000_000
    yield "binary", b"\x7fELF" + bytes(1000)


@pytest.fixture(scope="module")
def mutants(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    text = read_good(tmp_path_factory.mktemp("good"))
    return dict(mutate_values(text)) | dict(mutate_structure(text))


def test_there_are_enough_and_the_good_one_is_good(mutants, tmp_path):
    assert len(mutants) >= 200
    (tmp_path / "case.toml").write_bytes(read_good(tmp_path))
    assert load_case(str(tmp_path)).particles.mass == 0.075


def test_every_broken_case_is_told_and_nothing_is_written(mutants, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    wrong = []
    for number, (name, text) in enumerate(mutants.items()):
        Path("case.toml").write_bytes(text)
        start = time.process_time()
        result = CliRunner().invoke(cli, [("check", "setup")[number % 2], "case.toml"])
        seconds = time.process_time() - start
        lines = result.stderr.splitlines()
        told = result.exit_code == 1 and isinstance(result.exception, SystemExit) and result.stdout == ""
        readable = lines and all(line.startswith("case.toml: ") and len(line) < 1000 for line in lines)
        printable = all(line.isprintable() for line in lines)
        alone = [path.name for path in tmp_path.iterdir()] == ["case.toml"]
        if not (told and readable and printable and alone and seconds < LONGEST):
            wrong.append((name, result.exit_code, f"{seconds:.1f} s", repr(result.exception), result.output[:200]))
    assert wrong == []


@pytest.mark.parametrize("name", ["brackets", "long key", "UTF-16", "many keys", "gas.density: text"])
def test_broken_case_in_a_process_of_its_own(mutants, tmp_path, name):
    (tmp_path / "case.toml").write_bytes(mutants[name])
    root = str(Path(fbcouple.__file__).parents[1])
    command = [sys.executable, "-m", "fbcouple.cli.main", "setup", "case.toml"]
    done = subprocess.run(
        command,
        cwd=tmp_path,
        env={"PYTHONPATH": root, "PATH": ""},
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert done.returncode == 1 and done.stdout == "" and "Traceback" not in done.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["case.toml"]
