# SPDX-License-Identifier: GPL-3.0-or-later
"""Every method is complete: pair of files, test, binding with its types, row, sample, all under one name.

A method room's own files are methods, and what all of them share: ``cage`` and ``cage_coordinates`` in the
room ``cage``. Parts of a method stand in a folder of their own, or in another room.
"""

import ast
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from .tree import files

METHOD_ROOMS = {
    "SURFACE_LINEAR": ("methods/surface/linear",),
    "SURFACE_NONLINEAR": ("methods/surface/nonlinear",),
    "MULTIRESOLUTION": ("methods/multiresolution",),
    "SPACE_LINEAR": ("methods/space/lattice", "methods/space/cage", "methods/space/points"),
    "SPACE_NONLINEAR": ("methods/space/nonlinear",),
}


@dataclass(frozen=True)
class Row:
    id: str
    family: str
    place: str


def rows(root: Path) -> list[Row]:
    """The calls of Method(...) in the registry, read without importing it."""
    found = []
    for path in files(root, "addon/core/methods", ".py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "Method":
                words = {keyword.arg: keyword.value for keyword in node.keywords}
                place = f"{path.relative_to(root).as_posix()}:{node.lineno}"
                found.append(Row(words["id"].value, words["family"].attr, place))
    return found


def registry_offences(root: Path) -> list[str]:
    found = rows(root)
    return [*_doubled(found), *(o for row in found for o in _row_offences(root, row)), *_strays(root, found)]


def _doubled(found: list[Row]) -> Iterator[str]:
    ids = [row.id for row in found]
    yield from (f"addon/core/methods: two rows are called {name}" for name in set(ids) if ids.count(name) > 1)


def _row_offences(root: Path, row: Row) -> Iterator[str]:
    place = f"{row.place}: {row.id}"
    if row.family not in METHOD_ROOMS:
        yield f"{place}: no room is known for {row.family}"
        return
    rooms = [room for room in METHOD_ROOMS[row.family] if (root / f"native/{room}/{row.id}.h").is_file()]
    if len(rooms) != 1:
        yield f"{place}: no {row.id}.h in native/{' or native/'.join(METHOD_ROOMS[row.family])}"
        return
    source, test = f"native/{rooms[0]}/{row.id}.cpp", f"tests/native/{rooms[0]}/test_{row.id}.cpp"
    for name in (source, test):
        if not (root / name).is_file():
            yield f"{place}: {name} is missing"
    suites = ["SpaceContract"] if row.family.startswith("SPACE") else ["SurfaceContract"]
    if row.family == "MULTIRESOLUTION":  # around surface methods, or around space methods
        suites.append("SpaceContract")
    text = (root / test).read_text(encoding="utf-8") if (root / test).is_file() else ""
    if text and not any(f", {suite}," in text for suite in suites):
        yield f"{place}: {test} does not run {' or '.join(suites)}"
    bindings = "".join(path.read_text(encoding="utf-8") for path in files(root, "native/bindings", ".cpp"))
    native = "".join(word.capitalize() for word in row.id.split("_"))
    if not re.search(rf'([a-z_]*[Cc]lass_?|bind_[a-z]+_method)<[^;]*?"{native}"', bindings):
        yield f"{place}: native/bindings binds no class {native}"
    if not any(_shows(path, row.id) for path in files(root, "blend_samples", ".py")):
        yield f'{place}: no sample in blend_samples is named after it or uses "{row.id}"'


def _shows(sample: Path, method: str) -> bool:
    named = sample.stem == method or sample.stem.startswith(method + "_")
    return named or bool(re.search(rf"[\"']{method}[\"']", sample.read_text(encoding="utf-8")))


def _strays(root: Path, found: list[Row]) -> Iterator[str]:
    ids = {row.id for row in found}
    for room in sorted({room for rooms in METHOD_ROOMS.values() for room in rooms}):
        shared = Path(room).name
        for header in files(root, f"native/{room}", ".h"):
            own = header.parent == root / "native" / room
            if own and header.stem not in ids and not f"{header.stem}_".startswith(f"{shared}_"):
                yield f"native/{room}/{header.name}: neither a row of the registry nor shared by the room"
        for source in files(root, f"native/{room}", ".cpp"):
            if not source.with_suffix(".h").is_file():
                yield f"{source.relative_to(root).as_posix()}: has no header beside it"
