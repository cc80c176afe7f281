# SPDX-License-Identifier: GPL-3.0-or-later
"""The picture on the page about the architecture, drawn from the ranks that the other tests enforce."""

from collections import defaultdict
from collections.abc import Iterable
from html import escape
from pathlib import Path

from .layers import ADDON_RANKS, INNER_RANKS
from .native_layers import NATIVE_RANKS, SUB_RANKS

PICTURE = Path("docs/developer/images/architecture.svg")
COLUMN, GAP, LEFT, TOP = 470, 80, 30, 66  # pixels
LINE, SPACE = 18, 8
TITLES = {"addon": "addon/: the Blender add-on, Python", "native": "native/: the library, C++"}

Box = tuple[float, float, float, float]  # left, top, width, height
Rows = list[list[str]]


def by_rank(ranks: dict[str, int]) -> Rows:
    """Rooms of each rank, the highest rank first."""
    found = defaultdict(list)
    for room, rank in ranks.items():
        found[rank].append(room)
    return [sorted(found[rank]) for rank in sorted(found, reverse=True)]


def inner_rows(side: str, room: str) -> Rows:
    """The rooms inside a room, the highest rank first; a pair of files or a face has no box."""
    ranks = (INNER_RANKS if side == "addon" else SUB_RANKS).get(room, {})
    return by_rank({name: rank for name, rank in ranks.items() if name and not name.endswith(".")})


def breadth(side: str, room: str) -> float:
    """How wide a room has to be beside others, in letters."""
    return max(len(room) + 8, *(sum(len(name) + 5 for name in names) for names in inner_rows(side, room)), 0)


def height(side: str, rooms: Iterable[str]) -> float:
    return max(LINE + 2 * SPACE + (LINE + SPACE) * len(inner_rows(side, room)) for room in rooms)


def text(
    x: float, y: float, words: str, size: int = 13, weight: str = "normal", anchor: str = "middle"
) -> str:
    look = f'font-size="{size}" font-weight="{weight}" text-anchor="{anchor}"'
    return f'<text x="{x:g}" y="{y:g}" {look}>{escape(words)}</text>'


def box(place: Box, fill: str) -> str:
    x, y, width, tall = place
    return (
        f'<rect x="{x:g}" y="{y:g}" width="{width:g}" height="{tall:g}" rx="4" fill="{fill}" stroke="#667"/>'
    )


def room_box(side: str, room: str, place: Box) -> list[str]:
    """One room with those inside it."""
    x, y, width, _ = place
    parts = [box(place, "#e6eef8"), text(x + width / 2, y + LINE, room, weight="bold")]
    for index, names in enumerate(inner_rows(side, room)):
        wide = (width - SPACE) / len(names)
        top = y + LINE + SPACE + index * (LINE + SPACE)
        for number, name in enumerate(names):
            left = x + SPACE + number * wide
            parts.append(box((left, top, wide - SPACE, LINE + 2), "#fff"))
            parts.append(text(left + (wide - SPACE) / 2, top + LINE - 4, name, size=11))
    return parts


def column(side: str, ranks: dict[str, int], left: float) -> tuple[list[str], dict[str, Box]]:
    """The rooms of one side from the highest rank down, and where each stands."""
    parts = [text(left, TOP - 18, TITLES[side], size=15, weight="bold", anchor="start")]
    places: dict[str, Box] = {}
    y = float(TOP)
    for rooms in by_rank(ranks):
        tall = height(side, rooms)
        parts.append(text(left - 12, y + LINE, str(ranks[rooms[0]]), size=11))
        x, share = left, (COLUMN + SPACE) / sum(breadth(side, room) for room in rooms)
        for room in rooms:
            wide = share * breadth(side, room)
            places[room] = (x, y, wide - SPACE, tall)
            parts += room_box(side, room, places[room])
            x += wide
        y += tall + SPACE
    return parts, places


def draw() -> str:
    addon, addon_places = column("addon", ADDON_RANKS, LEFT)
    native, native_places = column("native", NATIVE_RANKS, LEFT + COLUMN + GAP)
    x, y, width, tall = addon_places["backend"]
    to_x, to_y, _, to_tall = native_places["bindings"]
    middle = LEFT + COLUMN + 24
    door = (
        f'<path d="M{x + width:g} {y + tall / 2:g} H{middle} V{to_y + to_tall - SPACE:g} H{to_x - 4:g}" '
        'fill="none" stroke="#c50" stroke-width="2" marker-end="url(#head)"/>'
    )
    bottom = max(top + tall for _, top, _, tall in (*addon_places.values(), *native_places.values()))
    wide = LEFT + 2 * COLUMN + GAP + SPACE
    caption = "A room sees the rooms below it and itself. Some wait for their first method."
    head = (
        '<marker id="head" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="7" markerHeight="7" '
        'orient="auto"><path d="M0 0 L8 4 L0 8 z" fill="#c50"/></marker>'
    )
    lines = [
        "<!-- SPDX-License-Identifier: GPL-3.0-or-later -->",
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {wide:g} {bottom + 34:g}" '
        'font-family="sans-serif">',
        f"<defs>{head}</defs>",
        '<rect width="100%" height="100%" fill="#fff"/>',
        text(LEFT, 24, "Rooms by rank", size=18, weight="bold", anchor="start"),
        *addon,
        *native,
        door,
        text(LEFT + COLUMN + GAP / 2 - 4, y + tall / 2 + 18, "sinew_native", size=10),
        text(LEFT, bottom + 22, caption, size=12, anchor="start"),
        "</svg>",
    ]
    return "\n".join(lines) + "\n"
