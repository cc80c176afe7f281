# SPDX-License-Identifier: GPL-3.0-or-later
"""The ranks of the rooms of native/, and of the sub-rooms inside them.

A line sees its own place and places of lower rank, never another one of its own rank.
"""

import re
from collections.abc import Iterator
from pathlib import Path, PurePosixPath

from .layers import step
from .tree import files, lines

NATIVE_RANKS = {
    "core": 0,
    "mesh": 1,
    "solvers": 1,
    "methods/space": 1,
    "splines": 1,
    "caging": 2,
    "operators": 2,
    "subdivision": 2,
    "methods/space/weights": 2,
    "methods/space/handle_points": 2,
    "local_global/graph": 3,
    "handles": 3,
    "attachments": 3,
    "skeleton": 3,
    "local_global": 4,
    "methods/surface": 4,
    "methods/surface/linear": 5,
    "methods/surface/sketch": 5,
    "methods/space/lattice": 5,
    "methods/space/cage": 5,
    "methods/space/points": 5,
    "methods/surface/nonlinear": 6,
    "methods/space/nonlinear": 6,
    "methods/multiresolution": 7,
    "bindings": 8,
}
# Room -> rank of each of its sub-rooms, of a pair of its files (with a dot) and of all other files ("").
SUB_RANKS = {
    "attachments": {"part.": 0, "sampling.": 0, "host_surface.": 1, "find_hosts.": 2, "frames": 3, "": 4},
    "bindings": {"": 0, "shapes": 1, "space": 1, "surface": 1},
    "local_global": {"arap": 0, "bodies": 1, "reduced": 1, "rows": 1, "": 2},
    "mesh": {"": 0, "frames": 1, "trees": 1},
    "operators": {"fits": 0, "": 1},
    "core": {"": 0, "simd": 1, "system": 1},
    "solvers": {"dense": 0, "optimization": 0, "supernodal": 0, "engines": 1, "": 2},
    "methods/space/lattice": {"grid": 0, "": 1},
    "methods/space/points": {"rbf": 0, "wires": 0, "": 1},
    "methods/space/cage": {"cage.": 0, "closed_forms": 1, "harmonic": 1, "inside": 2, "visibility": 2, "": 3},
    "methods/surface/linear": {"pyramid": 0, "responses": 0, "volume": 0, "semi_regular": 1, "": 2},
    "methods/surface/nonlinear": {"primo": 0, "pyramids": 0, "sequence": 0, "subspace": 0, "": 1},
    "methods/space/nonlinear": {"handles": 0, "fields": 0, "mls": 0, "cells": 1, "graph": 1, "": 2},
    "methods/multiresolution": {"details": 0, "transfer": 1, "": 1},
}
# Sub-rooms that nobody outside their room may see.
INTERNAL = {
    "solvers/engines",
    "solvers/supernodal",
    "methods/space/cage/closed_forms",
    "methods/space/lattice/grid",
    "methods/space/cage/harmonic",
    "methods/space/cage/inside",
    "methods/space/cage/visibility",
    "methods/space/nonlinear/fields",
    "methods/space/nonlinear/cells",
    "methods/space/nonlinear/graph",
    "methods/space/nonlinear/mls",
    "methods/space/points/rbf",
    "methods/space/points/wires",
    "methods/surface/linear/pyramid",
    "methods/surface/linear/semi_regular",
    "methods/surface/linear/volume",
    "methods/surface/nonlinear/primo",
    "methods/surface/nonlinear/pyramids",
    "methods/surface/nonlinear/subspace",
    "methods/multiresolution/details",
}
# A header that only one room may include -> that room.
RESERVED_HEADERS = {
    r"pybind11/|Python\.h": "bindings",
    r"opensubdiv/": "subdivision",
    r"tbb/|oneapi/": "core",
}
SUFFIXES = (".h", ".cpp", ".inl")
INCLUDE = re.compile(r'\s*#\s*include\s*(["<])([^">]+)[">]')


def native_offences(root: Path) -> list[str]:
    return [f"{place}: {what}" for place, what in _offences(root)]


def room_of(path: str) -> str | None:
    """The room of a path below native/, by the longest name that fits."""
    fitting = [room for room in NATIVE_RANKS if path.startswith(room + "/")]
    return max(fitting, key=len, default=None)


def sub_room_of(path: str, room: str) -> str | None:
    """The key of SUB_RANKS that a path below native/ belongs to; None where its folder is named nowhere."""
    inside = PurePosixPath(path).relative_to(room)
    if len(inside.parts) > 1:
        return inside.parts[0] if inside.parts[0] in SUB_RANKS.get(room, {}) else None
    pair = inside.stem + "."
    return pair if pair in SUB_RANKS.get(room, {}) else ""


def _offences(root: Path) -> Iterator[tuple[str, str]]:
    for path in files(root, "native", *SUFFIXES):
        name = path.relative_to(root).as_posix()
        below = name.removeprefix("native/")
        room = room_of(below)
        if room is None or sub_room_of(below, room) is None:
            yield name, "belongs to no room that has a rank"
            continue
        for number, line in lines(path):
            place = f"{name}:{number}"
            if re.match(r"\s*#\s*pragma\s+omp\b", line):
                yield place, f"parallel loops go through core/parallel.h, never OpenMP: {line.strip()}"
            include = INCLUDE.match(line)
            if include is None:
                continue
            quote, target = include.groups()
            for header, owner in RESERVED_HEADERS.items():
                if re.match(header, target) and room != owner:
                    yield place, f"only {owner} may include {target}: {line.strip()}"
            if quote == '"' and not target.startswith("native/"):
                yield place, f"includes run from the repository root: {line.strip()}"
            elif quote == '"':
                yield from _include(place, line, below, room, target.removeprefix("native/"))


def _include(place: str, line: str, below: str, room: str, target: str) -> Iterator[tuple[str, str]]:
    """Nothing where the file `below` native/ may include `target`."""
    other = room_of(target)
    yield from step(place, line, room, other, NATIVE_RANKS)
    if other is None:
        return
    inner = sub_room_of(target, other)
    if other == room:
        yield from step(place, line, sub_room_of(below, room) or "", inner, SUB_RANKS.get(room, {"": 0}))
    elif inner is None:
        yield place, f"names no room that has a rank: {line.strip()}"
    elif f"{other}/{inner}" in INTERNAL:
        yield place, f"native/{other}/{inner} may not be seen from outside native/{other}: {line.strip()}"
