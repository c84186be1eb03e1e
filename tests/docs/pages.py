"""Blocks of README and documentation, with the marks in the comments before them."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
MARKS = ("syntax", "file", "needs", "later")
_BLOCK = re.compile(r"^(?:<!-- (\w+)(?:: ([^\n]*?))? -->\n)?```(\S+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)

_INLINE = re.compile(r"(?<!`)`(fbcouple [^`]+)`(?!`)")


@dataclass(frozen=True)
class Block:
    """A fenced block: its language, text, and the mark before it with its word ("" where there is none)."""

    language: str
    text: str
    mark: str
    word: str

    @property
    def commands(self) -> list[str]:
        """What a console block types, a line each."""
        lines = self.text.splitlines()
        assert all(line.startswith("$ ") for line in lines), f"a console block has lines without `$ `: {lines}"
        return [line.removeprefix("$ ") for line in lines]


def list_pages() -> list[Path]:
    """README and every page of the documentation, but for the reports of results."""
    pages = [page for page in sorted(DOCS.rglob("*.md")) if not {"_build", "results"} & set(page.parts)]
    return [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *pages]


def read_blocks(text: str) -> Iterator[Block]:
    """The blocks of a page in their order."""
    for mark, word, language, content in _BLOCK.findall(text):
        yield Block(language, content, mark, word)


def list_inline(text: str) -> list[str]:
    """Commands of fbcouple in the running text of a page, as `fbcouple run RUN`."""
    return [" ".join(words.split()) for words in _INLINE.findall(_BLOCK.sub("", text))]


def name_page(page: Path) -> str:
    """How a test calls a page."""
    return str(page.relative_to(ROOT))
