# SPDX-License-Identifier: GPL-3.0-or-later
"""The ranks of the rooms of addon/: a room sees itself and rooms of lower rank, never one of its own rank."""

import ast
from collections.abc import Iterator
from pathlib import Path

from .tree import files, ranked

ADDON_RANKS = ranked(
    "ids core compat",
    "backend",
    "properties preferences mesh_io",
    "session",
    "bake",
    "operators farm",
    "handlers ui",
)
# Large rooms have ranks inside; their __init__.py is the face, which only other rooms see.
INNER_RANKS = {
    "core": ranked(
        "elements field memory point_types sides traits",
        "names status",
        "errors",
        "methods geometry transform",
        "labels tasks templates",
        "rigs",
    ),
    "session": ranked(
        "state", "targets", "datablocks", "controls", "results evaluation", "actions edit_mode"
    ),
}
# Folders whose sub-folders may not see each other: adding one kind must not need another.
APART = ("session/controls",)
FARM = "native/python/sinew_farm"
FARM_RANKS = ranked("atom", "errors job", "clusters", "shot sweep", "command", "__main__")
BLENDER_MODULES = {"bpy", "bpy_extras", "bmesh", "mathutils", "gpu", "blf", "addon_utils", "bl_math", "aud"}
ROOMS_WITHOUT_BLENDER = {"core", "backend"}


def addon_offences(root: Path) -> list[str]:
    return [f"{place}: {what}" for place, what in _addon_offences(root)]


def farm_offences(root: Path) -> list[str]:
    found: list[tuple[str, str]] = []
    for path in files(root, FARM, ".py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and node.level:
                for target in [node.module] if node.module else [alias.name for alias in node.names]:
                    place = f"{FARM}/{path.name}:{node.lineno}"
                    found += step(place, ast.unparse(node), path.stem, target, FARM_RANKS)
    return [f"{place}: {what}" for place, what in found]


def step(
    place: str, line: str, room: str, target: str | None, ranks: dict[str, int]
) -> Iterator[tuple[str, str]]:
    """Nothing where `room` may see `target`."""
    if target is None:
        yield place, f"names no room that has a rank: {line.strip()}"
    elif target != room and ranks[target] >= ranks[room]:
        above = "of the same rank" if ranks[target] == ranks[room] else "of higher rank"
        yield place, f"{room} (rank {ranks[room]}) may not see {target}, {above}: {line.strip()}"


def _addon_offences(root: Path) -> Iterator[tuple[str, str]]:
    for path in files(root, "addon", ".py"):
        inside = path.relative_to(root / "addon")
        room = inside.parts[0].removesuffix(".py")
        is_root = inside.as_posix() == "__init__.py"
        if not is_root and room not in ADDON_RANKS:
            yield f"addon/{inside.as_posix()}", "belongs to no room that has a rank"
            continue
        source = path.read_text(encoding="utf-8")
        module = ast.parse(source, filename=str(path))
        at_top = set(_top_level(module.body))
        text = source.splitlines()
        for node in ast.walk(module):
            if not isinstance(node, ast.Import | ast.ImportFrom | ast.Call):
                continue
            place, line = f"addon/{inside.as_posix()}:{node.lineno}", text[node.lineno - 1]
            modules, targets = _seen(node, inside)
            for name in modules:
                yield from _absolute(place, line, name, room)
            for target in targets:
                if node not in at_top:
                    yield place, f"relative imports stand at the top of the file: {line.strip()}"
                if target[0] == "_native":
                    if room != "backend":
                        yield place, f"only backend may import sinew_native: {line.strip()}"
                elif not is_root:
                    yield from _addon_step(root, place, line, inside, target)


def _addon_step(
    root: Path, place: str, line: str, inside: Path, target: tuple[str, ...]
) -> Iterator[tuple[str, str]]:
    """Nothing where the file may see the target, a path below addon/."""
    own, room = inside.with_suffix("").parts, target[0]
    yield from step(place, line, own[0], room if room in ADDON_RANKS else None, ADDON_RANKS)
    ranks = INNER_RANKS.get(room, {})
    if own[0] == room and own[1:] != ("__init__",) and ranks:
        inner = target[1] if len(target) > 1 and target[1] in ranks else None
        if own[1] not in ranks:
            yield place, f"{own[1]} is no room of {room} that has a rank: {line.strip()}"
        else:
            yield from step(place, line, own[1], inner, ranks)
    for folder in APART:
        above = tuple(folder.split("/"))
        parts = [path[len(above)] for path in (own, target) if path[: len(above)] == above != path]
        if len(set(parts)) == 2 and all((root / "addon" / folder / part).is_dir() for part in parts):
            yield place, f"{parts[0]} and {parts[1]} stand apart: {line.strip()}"


def _absolute(place: str, line: str, name: str, room: str) -> Iterator[tuple[str, str]]:
    first = name.split(".")[0]
    if first in BLENDER_MODULES and room in ROOMS_WITHOUT_BLENDER:
        yield place, f"{room} does without Blender: {line.strip()}"
    if first == "sinew_native" and room != "backend":
        yield place, f"only backend may import sinew_native: {line.strip()}"
    if first in ("addon", "sinew", "bl_ext"):
        yield place, f"the add-on imports itself relatively: {line.strip()}"


def _top_level(body: list[ast.stmt]) -> Iterator[ast.stmt]:
    """Statements that run with the module, those under a module's if or try included."""
    for statement in body:
        yield statement
        for part in ("body", "orelse", "finalbody"):
            if isinstance(statement, ast.If | ast.Try):
                yield from _top_level(getattr(statement, part, []))
        for handler in getattr(statement, "handlers", []):
            yield from _top_level(handler.body)


def _seen(
    node: ast.Import | ast.ImportFrom | ast.Call, inside: Path
) -> tuple[list[str], list[tuple[str, ...]]]:
    """Absolute module names, and paths below addon/, that an import names."""
    if isinstance(node, ast.Import):
        return [alias.name for alias in node.names], []
    if isinstance(node, ast.Call):
        called = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
        if called in ("import_module", "__import__") and node.args and isinstance(node.args[0], ast.Constant):
            return [str(node.args[0].value).lstrip(".")], []
        return [], []
    if node.level == 0:
        return [node.module or ""], []
    package = list(inside.parts[:-1])
    kept = package[: len(package) - (node.level - 1)]
    target = kept + (node.module.split(".") if node.module else [])
    if node.level - 1 > len(package):
        return [], [("(outside the add-on)",)]
    return [], [(*target, alias.name) for alias in node.names]
