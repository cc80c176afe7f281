# SPDX-License-Identifier: GPL-3.0-or-later
"""The sentences in the source of the add-on and of the library, with gaps for what differs."""

import ast
import functools
import re
from collections.abc import Iterator
from pathlib import Path

from pages import ROOT

GAP = "\0"
ADDON, LIBRARY = ROOT / "addon", ROOT / "native"
# Rooms whose sentences the status box shows as they are; the other rooms refuse what a button asks for.
STATUS_ROOMS = (
    "bake/sequences.py",
    "core/geometry/frames.py",
    "session/targets",
    "session/datablocks",
    "session/controls",
    "session/actions/keys.py",
    "session/evaluation",
    "ui/status_box.py",
)


@functools.cache
def sentences(path: Path) -> tuple[str, ...]:
    """The strings of a Python source, but for docstrings and parts of other strings."""
    nodes = list(ast.walk(ast.parse(path.read_text(encoding="utf-8"))))
    inner = {id(part) for node in nodes if isinstance(node, ast.JoinedStr) for part in node.values}
    inner |= {id(node.value) for node in nodes if isinstance(node, ast.Expr)}
    return tuple(text for node in nodes if id(node) not in inner for text in _text(node))


def _text(node: ast.AST) -> Iterator[str]:
    if isinstance(node, ast.JoinedStr):
        yield "".join(part.value if isinstance(part, ast.Constant) else GAP for part in node.values)
    elif isinstance(node, ast.Constant) and isinstance(node.value, str):
        yield re.sub(r"\{\w*\}|%[ds]|%\.\d+f", GAP, node.value)


@functools.cache
def of_the_addon() -> list[str]:
    return [text for path in sorted(ADDON.rglob("*.py")) for text in sentences(path)]


@functools.cache
def of_the_library() -> list[str]:
    """The clauses of literals in C++ that are long enough to be known again."""
    found = []
    for path in sorted(LIBRARY.rglob("*.cpp")):
        text = re.sub(r'"\s*\n\s*"', "", path.read_text(encoding="utf-8"))
        for literal in re.findall(r'"((?:[^"\\\n]|\\.)+)"', text):
            found += [clause.strip() for clause in re.split(r"[,:]", literal) if len(clause.strip()) >= 12]
    return found


def of_the_status_box() -> list[str]:
    """Sentences of four words and more: the panel shows them when a rig is bound and evaluated."""
    found = []
    for name in STATUS_ROOMS:
        room = ADDON / name
        for path in [room] if room.is_file() else sorted(room.rglob("*.py")):
            found += [text for text in sentences(path) if re.match(r"[A-Z\0]\S*( \S+){3}", text)]
    return list(dict.fromkeys(found))


def says(sentence: str, entry: str) -> bool:
    """Whether an entry of a page is a sentence, or what stands before its remedy; a gap stands for anything.

    The number before a noun counts for nothing, and three words are enough of a beginning.
    """
    return any(pattern.match(entry) for pattern in _patterns(sentence))


@functools.cache
def _patterns(sentence: str) -> tuple[re.Pattern, ...]:
    found = []
    for text in {sentence, *(sentence.partition(end)[0] for end in (" - ", ". ", ", so ", ": "))}:
        words = text.replace(GAP, "").split()
        if len("".join(words)) > 3 and len(words) > (GAP in text):
            pattern = ".+?".join(re.escape(part) for part in text.split(GAP))
            found.append(re.compile(rf"(\d+ )?{pattern}{'' if len(words) >= 3 else '$'}"))
    return tuple(found)
