# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the links of Markdown pages lead: to files of the tree, and to headings that are there."""

import re
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import unquote

from .tree import files, lines

MANUAL = "docs/manual"  # its pages, *.md, are packed with those about methods, without the rest of the tree
PACKED = (MANUAL, f"{MANUAL}/images", "docs/methods")
LINK = re.compile(r"\]\(\s*<?([^)\s>]+)|^\s*\[[^\]]+\]:\s+(\S+)|\b(?:href|src)=\"([^\"]+)\"")


def link_offences(root: Path) -> list[str]:
    """Relative links to what is not there; links of the manual to what is not packed with it."""
    return [
        f"{page.relative_to(root)}:{number}: {link} {problem}"
        for page in files(root, ".", ".md")
        for number, link in links(page)
        if (problem := broken(root, page, link))
    ]


def links(page: Path) -> Iterator[tuple[int, str]]:
    """The links that lead nowhere else, each with its line."""
    for number, line in prose(page):
        for groups in LINK.findall(re.sub(r"`[^`]*`", "", line)):
            link = next(filter(None, groups))
            if not re.match(r"[a-z]+:", link):
                yield number, link


def broken(root: Path, page: Path, link: str) -> str:
    """What is wrong with a link, or nothing."""
    name, _, anchor = unquote(link).partition("#")
    target = (page.parent / name).resolve() if name else page.resolve()
    if not target.is_relative_to(root.resolve()) or not target.exists():
        return "does not exist"
    place = target.relative_to(root.resolve())
    of_manual = page.parent == root / MANUAL
    if of_manual and place.parent.as_posix() not in PACKED:
        return "leads out of the manual"
    if anchor and (place.suffix != ".md" or anchor not in anchors(target)):
        return "is no heading there"
    return ""


def anchors(page: Path) -> set[str]:
    """What the headings of a page are called in links: the second of a name gets ``-1``."""
    found: Counter = Counter()
    names = set()
    for _number, line in prose(page):
        heading = re.match(r"#{1,6}\s+(.*?)\s*#*$", line)
        if heading:
            text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading[1]).lower()
            name = re.sub(r"[^\w\s-]", "", text).replace(" ", "-")
            names.add(f"{name}-{found[name]}" if found[name] else name)
            found[name] += 1
    return names


def prose(page: Path) -> Iterator[tuple[int, str]]:
    """The lines outside of fenced code."""
    fenced = False
    for number, line in lines(page):
        if line.lstrip().startswith("```"):
            fenced = not fenced
        elif not fenced:
            yield number, line
