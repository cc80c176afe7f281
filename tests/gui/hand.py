# SPDX-License-Identifier: GPL-3.0-or-later
"""Mouse and keys of a session."""

from collections.abc import Iterator, Sequence
from itertools import pairwise

import bpy
import numpy as np
from driving import rest
from window import Place, on_screen, region, screenshot, viewport, window

_NUMBERS = ("ZERO", "ONE", "TWO", "THREE", "FOUR", "FIVE", "SIX", "SEVEN", "EIGHT", "NINE")
_KEYS = {".": "PERIOD", "-": "MINUS", **{str(n): key for n, key in enumerate(_NUMBERS)}}

mouse = [0, 0]


def press(key: str, character: str = "", **modifiers: bool) -> None:
    """A key or button, where the mouse is; ``character`` is what it writes."""
    typed = {"unicode": character} if character else {}
    window().event_simulate(key, "PRESS", x=mouse[0], y=mouse[1], **typed, **modifiers)
    window().event_simulate(key, "RELEASE", x=mouse[0], y=mouse[1], **modifiers)


def write(text: str) -> None:
    for character in text:
        press(_KEYS.get(character, character.upper()), character)


def keys(*presses: str, at: Place | None = None) -> Iterator[None]:
    """Keys or buttons, as "RET" or "ctrl Z", and numbers; ``at`` a place. Blender draws after each."""
    if at is not None:
        move(*at)
        yield from rest()
    for each in presses:
        *modifiers, key = each.split()
        if key[0] in _KEYS:
            write(key)
        else:
            press(key, **dict.fromkeys(modifiers, True))
        yield from rest()


def undo() -> Iterator[None]:
    yield from keys("ctrl Z")
    yield


def redo() -> Iterator[None]:
    yield from keys("ctrl shift Z")
    yield


def move(x: int, y: int) -> None:
    mouse[:] = x, y
    window().event_simulate("MOUSEMOVE", "NOTHING", x=x, y=y)


def click(x: int, y: int, **modifiers: bool) -> Iterator[None]:
    """A button has to see the mouse above it first."""
    move(x, y)
    yield
    press("LEFTMOUSE", **modifiers)
    yield from rest()


def between(start: Place, end: Place, steps: int = 4) -> list[Place]:
    """The places on the way, with its end."""
    (x, y), (right, up) = start, end
    return [(x + (right - x) * step // steps, y + (up - y) * step // steps) for step in range(1, steps + 1)]


def polyline(corners: Sequence[tuple[float, float]]) -> list[Place]:
    """The places on the way along points of the world, as seen from the front."""
    ways = [np.linspace(start, end, 8, endpoint=False) for start, end in pairwise(corners)]
    return [on_screen((x, 0.0, z)) for x, z in np.concatenate([*ways, corners[-1:]])]


def glide(way: Sequence[Place]) -> Iterator[None]:
    for place in way:
        move(*place)
        yield


def hold(way: Sequence[Place]) -> Iterator[None]:
    """Press the left button at the first place, and move to the others without releasing it."""
    move(*way[0])
    yield from rest()
    window().event_simulate("LEFTMOUSE", "PRESS", x=mouse[0], y=mouse[1])
    yield
    yield from glide(way[1:])


def release() -> Iterator[None]:
    window().event_simulate("LEFTMOUSE", "RELEASE", x=mouse[0], y=mouse[1])
    yield from rest(3)


def drag(start: Place, end: Place, steps: int = 4) -> Iterator[None]:
    yield from hold([start, *between(start, end, steps)])
    yield from release()


def stroke(corners: Sequence[tuple[float, float]], picture: str = "") -> Iterator[None]:
    """Hold the left button along a polyline, of which a picture may be taken."""
    yield from hold(polyline(corners))
    if picture:
        screenshot(picture)
        yield
    yield from release()


_TAB = 160  # from the top of the sidebar to the middle of the fourth tab, in pixels at scale 1


def open_sidebar() -> Iterator[None]:
    """With the Sinew tab, the last one."""
    viewport().spaces.active.show_region_ui = True
    yield from rest()
    sidebar = region("UI")
    if hasattr(sidebar, "active_panel_category"):
        sidebar.active_panel_category = "Sinew"
    else:
        scale = bpy.context.preferences.system.ui_scale
        right, top = sidebar.x + sidebar.width, sidebar.y + sidebar.height
        yield from click(right - int(9 * scale), top - int(_TAB * scale))
    yield from rest()
