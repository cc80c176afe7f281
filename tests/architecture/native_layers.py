# SPDX-License-Identifier: GPL-3.0-or-later
"""The ranks of the rooms of native/, and of the sub-rooms inside them.

A line sees its own place and places of lower rank, never another one of its own rank.
"""

import re
from collections.abc import Iterator
from pathlib import Path, PurePosixPath

from .layers import step
from .tree import files, lines, ranked

NATIVE_RANKS = ranked(
    "core",
    "mesh solvers methods/space splines",
    "caging operators subdivision methods/space/weights methods/space/handle_points",
    "local_global/graph handles attachments skeleton",
    "local_global methods/surface",
    "methods/surface/linear methods/surface/sketch methods/space/lattice "
    "methods/space/cage methods/space/points",
    "methods/surface/nonlinear methods/space/nonlinear",
    "methods/multiresolution",
    "bindings",
)
# Room -> rank of each of its sub-rooms, of a pair of its files (with a dot) and of all other files ("").
SUB_RANKS = {
    "attachments": {"part.": 0, "sampling.": 0, "host_surface.": 1, "find_hosts.": 2, "frames": 3, "": 4},
    "bindings": {"": 0, "shapes": 1, "space": 1, "surface": 1},
    "local_global": {"arap": 0, "bodies": 1, "reduced": 1, "rows": 1, "": 2},
    "mesh": {"": 0, "frames": 1, "trees": 1, "remeshing": 2},
    "operators": {"fits": 0, "": 1},
    "core": {"": 0, "simd": 1, "space": 1, "system": 1},
    "solvers": {
        "dense": 0,
        "dissection": 0,
        "optimization": 0,
        "supernodal": 0,
        "engines": 1,
        "": 2,
        "multigrid": 3,
        "systems": 4,
    },
    "methods/space/lattice": {"grid": 0, "": 1},
    "methods/space/points": {"rbf": 0, "wires": 0, "": 1},
    "methods/space/cage": {
        "smooth": 0,
        "cage.": 1,
        "closed_forms": 2,
        "harmonic": 2,
        "inside": 3,
        "visibility": 3,
        "": 4,
    },
    "methods/surface/linear": {"pyramid": 0, "responses": 0, "volume": 0, "semi_regular": 1, "": 2},
    "methods/surface/nonlinear": {"primo": 0, "pyramids": 0, "sequence": 0, "subspace": 0, "": 1},
    "methods/space/nonlinear": {"handles": 0, "fields": 0, "mls": 0, "cells": 1, "graph": 1, "": 2},
    "methods/multiresolution": {"details": 0, "transfer": 1, "": 1},
}
# Room -> its sub-rooms that nobody outside may see.
HIDDEN = {
    "solvers": "dissection engines multigrid supernodal",
    "methods/space/cage": "closed_forms harmonic inside smooth visibility",
    "methods/space/lattice": "grid",
    "methods/space/nonlinear": "fields cells graph mls",
    "methods/space/points": "rbf wires",
    "methods/surface/linear": "pyramid semi_regular volume",
    "methods/surface/nonlinear": "primo pyramids subspace",
    "methods/multiresolution": "details",
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
    elif inner in HIDDEN.get(other, "").split():
        yield place, f"native/{other}/{inner} may not be seen from outside native/{other}: {line.strip()}"
