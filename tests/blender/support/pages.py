# SPDX-License-Identifier: GPL-3.0-or-later
"""What the pages for artists set in bold and in italics, which are names; " > " joins the steps of a path."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[3]
MANUAL = tuple(sorted((ROOT / "docs" / "manual").glob("*.md")))
PAGES = (ROOT / "README.md", *MANUAL, *sorted((ROOT / "docs" / "methods").glob("*.md")))


@dataclass(frozen=True)
class Name:
    """A name on a page, the marks around it, and the paragraph, list item or table row that it stands in."""

    page: str
    marks: str
    text: str
    around: str

    @property
    def steps(self) -> list[str]:
        return [step.strip() for step in self.text.split(" > ")]

    def __str__(self) -> str:
        return f"{self.page}: {self.marks}{self.text}{self.marks}"


def blocks(page: Path) -> Iterator[str]:
    """Paragraphs, items, rows of tables and headings, each in one line, without code and pictures."""
    text = page.read_text(encoding="utf-8")
    text = re.sub(r"```.*?```|<!--.*?-->|!\[[^\]]*\]\([^)]*\)", "", text, flags=re.DOTALL)
    text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", text)
    for block in re.split(r"\n\s*\n|\n(?=\s*(?:[-*] |\d+\. |\||#))", text):
        if block.strip():
            yield " ".join(block.split())


def names(page: Path) -> Iterator[Name]:
    """All that a page sets in bold or italics, in order."""
    for block in blocks(page):
        plain = re.sub(r"`[^`]*`", "", block.removeprefix("* "))
        for marks, text in re.findall(r"(?<!\*)(\*\*?)(?![\s*])(.+?)(?<![\s*])\1(?!\*)", plain):
            if re.search(r"[A-Za-z+]", text):
                yield Name(page.name, marks, text, block)


def keys(page: Path) -> set[str]:
    """The keys with modifiers in code marks, such as ``Shift D``."""
    found = re.findall(r"`((?:(?:Shift|Ctrl|Alt) )+[A-Z])`", " ".join(blocks(page)))
    return {" ".join(sorted(key.split())) for key in found}
