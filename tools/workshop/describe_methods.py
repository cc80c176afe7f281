# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes the parts of the documents about methods, from rows of the registry and C++ headers.

Only the text between two marks is written. The rest of a page belongs to its author.
"""

import argparse
import importlib.util
import re
import sys
import tomllib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cache
from itertools import groupby, takewhile
from pathlib import Path
from types import ModuleType

from .blenders import HEADLESS, INSIDE, install_legacy
from .places import ROOT
from .programs import program
from .shell import must

PAGES = "docs/methods"
CATALOGUE = f"{PAGES}/catalogue.toml"
BEGIN = "<!-- methods: written by tools/describe_methods -->"
END = "<!-- end of methods -->"
COST = "repeat it when"  # the second heading of a cost table in a header
INCLUDED = re.compile(r'#include "(native/[^"]+)"')
SPEEDS = {1: "quick", 2: "medium", 3: "slow"}
CONTROLS = {
    "HANDLES": "handles",
    "CAGE": "a cage",
    "LATTICE": "a lattice",
    "POINTS": "points",
    "CURVES": "curves",
    "TOOLS": "tools",
}


@dataclass(frozen=True)
class Entry:
    """A line of the tables. ``link`` is its page or, without one, its header, relative to the root; empty if
    it is planned. ``known_as`` is its name in the literature, empty where that is the label."""

    id: str
    label: str
    group: str
    section: str
    paper: str
    summary: str
    link: str = ""
    known_as: str = ""

    @property
    def both_names(self) -> str:
        return f"{self.label} ({self.known_as})" if self.known_as else self.label


@cache
def registry(root: Path) -> ModuleType:
    """The registry, imported without Blender."""
    init = root / "addon/core/methods/__init__.py"  # beside which Python finds the other modules
    spec = importlib.util.spec_from_file_location("described_methods", init)
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


def entries(root: Path) -> list[Entry]:
    """All methods, in the order of the registry's families and of the tutorial's sections."""
    found = []
    for row in registry(root).METHODS:
        names = {name: getattr(row, name) for name in ("id", "label", "section", "paper", "summary")}
        known_as = "" if row.known_as == row.label else row.known_as
        page = f"{PAGES}/{row.id}.md"
        found.append(Entry(**names, group=row.family.value, link=page, known_as=known_as))
    for words in tomllib.loads((root / CATALOGUE).read_text(encoding="utf-8"))["method"]:
        name = words.pop("header", "")
        page = f"{PAGES}/{words['id']}.md"
        header = _header(root, name).relative_to(root).as_posix() if name else ""
        found.append(Entry(**words, link=page if (root / page).is_file() else header))
    groups = [family.value for family in registry(root).Family]
    groups += [entry.group for entry in found if entry.group not in groups]
    return sorted(found, key=lambda entry: (groups.index(entry.group), entry.section))


def documents(root: Path) -> dict[Path, str]:
    """The pages that have a part from here, each with the text that it should have."""
    found = entries(root)
    parts = {
        root / "README.md": overview(found),
        root / PAGES / "README.md": tables(found),
        **{root / PAGES / f"{row.id}.md": head(root, row) for row in registry(root).METHODS},
    }
    return {page: _with(page, part) for page, part in parts.items()}


def overview(found: Iterable[Entry]) -> str:
    """One line per group, with the methods that are available."""
    lines = ["| | available |", "|---|---|"]
    for group, members in _grouped(found):
        there = ", ".join(f"[{entry.both_names}]({entry.link})" for entry in members if entry.link)
        lines.append(f"| {group} | {there} |")
    return "\n".join(lines)


def tables(found: Iterable[Entry]) -> str:
    lines = []
    for group, members in _grouped(found):
        columns = "| id | name | section | what it does | paper | state |"
        lines += ["", f"## {group}", "", columns, "|---|---|---|---|---|---|"]
        for entry in members:
            link = Path(entry.link).name if entry.link.startswith(PAGES) else f"../../{entry.link}"
            state = f"[available]({link})" if entry.link else "planned"
            words = (f"`{entry.id}`", entry.both_names, entry.section, entry.summary, entry.paper, state)
            lines.append(f"| {' | '.join(words)} |")
    return "\n".join(lines[1:])


def head(root: Path, row) -> str:
    header = _header(root, f"{row.id}.h")
    moved = ", and of ".join(target.value for target in registry(root).Moved if target in row.moves)
    steps = "step by step, so that a drag shows an early step" if row.iterative else "in one step"
    around = "a method of " + " or ".join(family.value for family in row.wraps)
    kernels = nearest_kernels(root, header)
    facts = [
        ("known as", row.known_as),
        ("fails", f"{row.fails}."),
        ("needs", row.needs or "nothing: it takes anything"),
        ("bind", SPEEDS[row.cost]),
        ("id", f"`{row.id}`, in Python `sinew_native.{row.native}`"),
        ("library", _links(root, [header, header.with_suffix(".cpp")])),
        ("kernels", _links(root, kernels)),
        ("tests", _links(root, sorted((root / "tests/native").rglob(f"test_{row.id}.cpp")))),
        ("tutorial", f"section {row.section}"),
        ("paper", row.paper),
        ("moved by", CONTROLS[row.control.name]),
        ("moves", f"points of {moved}"),
        ("around", around if row.wraps else ""),
        ("solves", steps),
    ]
    lines = [f"# {row.label}", "", f"{row.summary}.", "", "| | |", "|---|---|"]
    lines += [f"| {name} | {value} |" for name, value in facts if value]
    titles = ("parameter", "of each handle", "of each control")
    for title, rows in zip(titles, (row.parameters, row.handle_parameters, row.control_parameters)):
        if rows:
            lines += ["", f"| {title} | default | unit | what it does |", "|---|---|---|---|"]
            lines += map(_parameter, rows)
    costs = ["", "What a call costs:", "", "```text", *_costs(root, header, row.native), "```"]
    lines += [
        *costs,
        "",
        "A program in Python, which runs as it stands here:",
        "",
        "```python",
        *program(row).splitlines(),
        "```",
    ]
    return "\n".join(lines)


def nearest_kernels(root: Path, header: Path) -> list[Path]:
    """The vectorised code nearest to a method: what it includes, or what that includes, or a step further."""
    seen = level = {header, header.with_suffix(".cpp")}
    for _step in range(3):
        included = {root / name for path in level for name in INCLUDED.findall(path.read_text("utf-8"))}
        found = sorted(file for path in included if (file := path.with_suffix(".inl")).is_file())
        if found:
            return found
        both = {file for path in included for file in (path, path.with_suffix(".cpp"))}
        level = {file for file in both if file.is_file()} - seen
        seen = seen | level
    return []


def _links(root: Path, files: Iterable[Path]) -> str:
    return ", ".join(f"[{file.relative_to(root)}](../../{file.relative_to(root)})" for file in files)


def _parameter(parameter) -> str:
    notes = [f"{parameter.description}."]
    if getattr(parameter, "items", ()):
        notes += [f"*{label}*: {about}." for _identifier, label, about in parameter.items]
    if parameter.paintable:
        notes.append("A vertex group may scale it.")
    name = f"{parameter.label} (`{parameter.id}`)"
    words = " ".join(notes).replace("|", "\\|")
    return f"| {name} | {_default(parameter)} | {parameter.unit} | {words} |"


def _default(parameter) -> str:
    for identifier, label, _about in getattr(parameter, "items", ()):
        if identifier == parameter.default:
            return label
    if isinstance(parameter.default, bool):
        return "on" if parameter.default else "off"
    return str(parameter.default)


def _costs(root: Path, header: Path, native: str) -> list[str]:
    """The cost table of a class, or of the class that it is derived from."""
    text = header.read_text(encoding="utf-8")
    lines = [line.strip() for line in text.splitlines()]
    at = next((number for number, line in enumerate(lines) if COST in line), None)
    if at is None:
        base = re.search(rf"^class {native}\b[^:{{;]*:\s*public (\w+)", text, re.MULTILINE)
        if base is None:
            raise SystemExit(f"{header.relative_to(root)} has no cost table, and {native} no base class")
        return _costs(root, _declaring(root, base[1]), base[1])
    table = takewhile(lambda line: line.startswith("///") and line != "///", lines[at:])
    return [line.removeprefix("///").removeprefix("   ") for line in table]


def _header(root: Path, name: str) -> Path:
    return _only(list((root / "native").rglob(name)), f"headers called {name}")


def _declaring(root: Path, native: str) -> Path:
    pattern = re.compile(rf"^class {native}\b[^;]*$", re.MULTILINE)
    headers = (root / "native").rglob("*.h")
    found = [path for path in headers if pattern.search(path.read_text("utf-8"))]
    return _only(found, f"headers that declare {native}")


def _only(found: list[Path], what: str) -> Path:
    if len(found) != 1:
        raise SystemExit(f"native/ has {len(found)} {what}, not one")
    return found[0]


def _grouped(found: Iterable[Entry]) -> Iterator[tuple[str, Iterator[Entry]]]:
    """The entries are in the order of their groups."""
    return groupby(found, key=lambda entry: entry.group)


def _with(page: Path, part: str) -> str:
    """The text of a page with a new part between the marks. A new page has no other text."""
    text = page.read_text(encoding="utf-8") if page.is_file() else f"{BEGIN}\n{END}\n"
    before, begin, rest = text.partition(BEGIN)
    _old, end, after = rest.partition(END)
    if not begin or not end:
        raise SystemExit(f"{page} has no marks {BEGIN} and {END}")
    return f"{before}{BEGIN}\n{part}\n{END}{after}"


def outdated(root: Path) -> list[Path]:
    """The pages that differ from the rows and headers."""
    wanted = documents(root).items()
    return [page for page, text in wanted if not page.is_file() or page.read_text("utf-8") != text]


def main() -> None:
    parser = argparse.ArgumentParser(prog="tools/describe_methods", description=__doc__)
    about = "change nothing, and fail if a page is out of date"
    parser.add_argument("--check", action="store_true", help=about)
    about = "build the module, and let Debian's Blender write the reference of LLM.md, too"
    parser.add_argument("--scripts", action="store_true", help=about)
    arguments = parser.parse_args()
    if arguments.check:
        pages = outdated(ROOT)
        for page in pages:
            print(f"{page.relative_to(ROOT)} is out of date: run tools/describe_methods")
        raise SystemExit(bool(pages))
    for page, text in documents(ROOT).items():
        page.parent.mkdir(parents=True, exist_ok=True)
        page.write_text(text, encoding="utf-8")
    if arguments.scripts:
        must([*HEADLESS, INSIDE / "script_page.py"], env=install_legacy("script-page", from_wheel=False))
