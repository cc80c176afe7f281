# SPDX-License-Identifier: GPL-3.0-or-later
"""Mouse, keys, waiting, claims and screenshots, for the sessions: scripts that drive a Blender with a window.

A session has parts. Each is a generator that begins with Blender's startup file; each ``yield`` gives Blender
the time that a person would take. ``with claim("what holds"):`` notes whether the assertions inside hold, and
``test_window.py`` makes a test of each claim. Outcomes and screenshots go to the folder named after ``--``.
"""

import json
import os
import sys
import threading
import time
import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import addon_utils
import bmesh
import bpy
import numpy as np
from bpy_extras.view3d_utils import location_3d_to_region_2d
from mathutils import Vector

MODULE = os.environ.get("SINEW_ADDON_MODULE", "sinew")
MODELS = Path(__file__).resolve().parents[2] / "blend_samples" / "models"
OUTPUT = Path(sys.argv[sys.argv.index("--") + 1])

FRONT = (0.7071068, 0.7071068, 0.0, 0.0)  # the rotation of a view

seen: dict[str, object] = {"claims": {}}  # what the tests read; of each claim, what went wrong each time
mouse = [0, 0]
pace = [0.1]  # seconds from one step to the next
pictures = [OUTPUT]  # the folder of the screenshots of this part

Place = tuple[int, int]  # pixels of the window, from its lower left corner


@contextmanager
def claim(text: str) -> Iterator[None]:
    """Note whether the assertions inside hold. The session goes on, whether they do or not."""
    outcomes = seen["claims"].setdefault(text, [])
    try:
        yield
    except AssertionError as error:
        told = traceback.TracebackException.from_exception(error, capture_locals=True)
        outcomes.append("".join(told.format()))
    else:
        outcomes.append("")


def enable() -> None:
    """Switch the add-on on."""
    if addon_utils.enable(MODULE, default_set=True) is None:
        raise RuntimeError("Sinew is not installed")


def sessions():
    return sys.modules[f"{MODULE}.session.state.sessions"]


def settled() -> Iterator[None]:
    """Wait until every shape is final."""
    yield from rest()
    yield from until(lambda: not sessions().unsettled() and not binding().busy(), 120.0)
    yield from rest()


def window() -> bpy.types.Window:
    return bpy.context.window_manager.windows[0]


def viewport() -> bpy.types.Area:
    """The largest 3D viewport."""
    areas = (area for area in window().screen.areas if area.type == "VIEW_3D")
    return max(areas, key=lambda area: area.width)


def region(kind: str = "WINDOW") -> bpy.types.Region:
    return next(region for region in viewport().regions if region.type == kind)


def in_view() -> object:
    """For operators that ask where the mouse is."""
    return bpy.context.temp_override(window=window(), area=viewport(), region=region())


def middle() -> Place:
    """The middle of what the sidebar leaves of the viewport."""
    view, sidebar = region(), region("UI")
    covered = sidebar.width if viewport().spaces.active.show_region_ui else 0
    return view.x + (view.width - covered) // 2, view.y + view.height // 2


def look_from_front(distance: float = 9.0, height: float = 0.0, sidebar: bool = False) -> Iterator[None]:
    """Without perspective; with the panel of Sinew beside it, if wanted."""
    space = viewport().spaces.active
    space.region_3d.view_perspective, space.region_3d.view_rotation = "ORTHO", FRONT
    space.region_3d.view_location, space.region_3d.view_distance = (0.0, 0.0, height), distance
    space.show_region_ui = sidebar
    yield from rest()
    if sidebar:
        yield from open_tab()
        yield from rest()


def on_screen(point: Sequence[float]) -> Place:
    """Where a point of the world is in the window."""
    pixel = location_3d_to_region_2d(region(), viewport().spaces.active.region_3d, Vector(point))
    return int(region().x + pixel.x), int(region().y + pixel.y)


_NUMBERS = ("ZERO", "ONE", "TWO", "THREE", "FOUR", "FIVE", "SIX", "SEVEN", "EIGHT", "NINE")
_KEYS = {" ": "SPACE", ".": "PERIOD", "-": "MINUS", **{str(n): key for n, key in enumerate(_NUMBERS)}}
_CHARACTERS = {key: character for character, key in _KEYS.items()}


def binding():
    return sys.modules[f"{MODULE}.session.evaluation.binding"]


def works() -> bool:
    """Whether a thread of Sinew is at work, or what it did is not taken in yet."""
    return any(thread.name == "sinew" for thread in threading.enumerate()) or binding().busy()


def only_head(size: float = 2.0) -> bpy.types.Object:
    """A head alone in the scene."""
    for obj in list(bpy.data.objects):
        bpy.data.objects.remove(obj)
    bpy.ops.mesh.primitive_monkey_add(size=size)
    bpy.context.object.name = "Head"
    return bpy.context.object


def head() -> bpy.types.Object:
    return bpy.data.objects["Head"]


def deformer():
    """That of the head which the panel shows."""
    return head().sinew.active


def new_head(levels: int, regions: dict) -> None:
    """A smooth head alone in the scene, subdivided, with ``regions`` by name: kind, and which points."""
    obj = only_head(3.0)
    obj.modifiers.new("Subdivision", "SUBSURF").levels = levels
    bpy.ops.object.modifier_apply(modifier="Subdivision")
    bpy.ops.object.shade_smooth()
    for name, (kind, where) in regions.items():
        members = [vertex.index for vertex in obj.data.vertices if where(vertex.co)]
        obj.vertex_groups.new(name=name).add(members, 1.0, "REPLACE")
        bpy.context.view_layer.objects.active = obj
        bpy.ops.sinew.handle_add(kind=kind, vertex_group=name)
    bpy.context.view_layer.objects.active = obj


def press(key: str, character: str = "", **modifiers: bool) -> None:
    """A key or button, where the mouse is; ``character`` is what a letter writes."""
    written = character or _CHARACTERS.get(key, "")
    for value in ("PRESS", "RELEASE"):
        typed = {"unicode": written} if written and value == "PRESS" else {}
        window().event_simulate(key, value, x=mouse[0], y=mouse[1], **typed, **modifiers)


def write(text: str) -> None:
    """Type it."""
    for character in text:
        press(_KEYS.get(character, character.upper()), character)


def move(x: int, y: int, **modifiers: bool) -> None:
    mouse[:] = x, y
    window().event_simulate("MOUSEMOVE", "NOTHING", x=x, y=y, **modifiers)


def click(x: int, y: int, **modifiers: bool) -> Iterator[None]:
    """A button has to see the mouse above it first."""
    move(x, y)
    yield
    press("LEFTMOUSE", **modifiers)
    yield


def choose(menu: Place, owner: bpy.types.bpy_struct, name: str, value: str) -> Iterator[None]:
    """Open the menu of a property, and go to an entry by arrow keys: letters change as entries are added."""
    entries = [item.identifier for item in owner.bl_rna.properties[name].enum_items if item.identifier]
    yield from click(*menu)
    yield from rest()
    press("HOME")
    yield
    for _ in range(entries.index(value)):
        press("DOWN_ARROW")
        yield
    press("RET")
    yield from rest(3)


def between(start: Place, end: Place, steps: int) -> list[Place]:
    """The places on the way, with its end."""
    (x, y), (right, up) = start, end
    return [(x + (right - x) * step // steps, y + (up - y) * step // steps) for step in range(1, steps + 1)]


def hold(way: Sequence[Place]) -> Iterator[None]:
    """Press the left button at the first place, and move to the others without releasing it."""
    move(*way[0])
    yield
    window().event_simulate("LEFTMOUSE", "PRESS", x=mouse[0], y=mouse[1])
    yield
    for place in way[1:]:
        move(*place)
        yield


def release() -> None:
    """Release the left button, where the mouse is."""
    window().event_simulate("LEFTMOUSE", "RELEASE", x=mouse[0], y=mouse[1])


def drag(start: Place, end: Place, steps: int = 4) -> Iterator[None]:
    """Hold the left button on the way."""
    yield from hold([start, *between(start, end, steps)])
    release()
    yield


def undo(redo: bool = False) -> Iterator[None]:
    """One step back by the keyboard."""
    press("Z", ctrl=True, shift=redo)
    yield from rest(3)


def redo() -> Iterator[None]:
    yield from undo(redo=True)


def until(condition: Callable[[], bool], seconds: float = 60.0) -> Iterator[None]:
    """Wait, as a person would, until ``condition()``."""
    begin = time.monotonic()
    while not condition() and time.monotonic() - begin < seconds:
        yield


def rest(steps: int = 2) -> Iterator[None]:
    """Let Blender draw."""
    for _ in range(steps):
        yield


def screenshot(name: str) -> None:
    with bpy.context.temp_override(window=window()):
        bpy.ops.screen.screenshot(filepath=str(pictures[0] / f"{name}.png"))


def pixels(name: str) -> np.ndarray:
    """A screenshot, (rows, columns, 3) in 0..1, from below."""
    image = bpy.data.images.load(str(pictures[0] / f"{name}.png"))
    width, height = image.size
    rows = np.array(image.pixels[:], dtype=np.float32).reshape(height, width, -1)[:, :, :3]
    bpy.data.images.remove(image)
    return rows


def view_pixels(name: str) -> np.ndarray:
    """The part of a screenshot that shows the mesh, left of the sidebar."""
    view = region()
    return pixels(name)[view.y : view.y + view.height, view.x : view.x + view.width * 2 // 3]


def differing(one: str, other: str, limit: float = 0.05) -> float:
    """The share of the pixels that show the mesh in which two screenshots differ."""
    return float((np.abs(view_pixels(one) - view_pixels(other)).max(axis=2) > limit).mean())


_TAB = 160  # from the top of the sidebar to the middle of the fourth tab, in pixels at scale 1


def open_tab() -> Iterator[None]:
    """Click the Sinew tab, the last one of the sidebar."""
    sidebar = region("UI")
    if hasattr(sidebar, "active_panel_category"):
        sidebar.active_panel_category = "Sinew"
        return
    scale = bpy.context.preferences.system.ui_scale
    yield from click(
        sidebar.x + sidebar.width - int(9 * scale), sidebar.y + sidebar.height - int(_TAB * scale)
    )


def shown_points(obj: bpy.types.Object) -> np.ndarray:
    """What the window shows of a mesh, (n, 3), in its own space, without asking for another evaluation."""
    evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
    flat = np.empty(len(evaluated.data.vertices) * 3, dtype=np.float32)
    evaluated.data.vertices.foreach_get("co", flat)
    return flat.reshape(-1, 3)


def apart(one: np.ndarray, other: np.ndarray) -> float:
    """The largest difference of two shapes."""
    return float(np.abs(one - other).max())


def near(one: np.ndarray, other: np.ndarray, limit: float) -> None:
    """Assert that two shapes differ by less; the other one may be the same vector for all points."""
    assert other.shape in (one.shape, one.shape[1:])
    off = apart(one, other)
    assert off < limit, off


def above(value: float, limit: float) -> None:
    """Assert it, and tell the value."""
    assert value > limit, value


def select(obj: bpy.types.Object, where: Callable[[object], bool]) -> None:
    """Select the vertices at the points for which ``where(point)``, in Edit Mode."""
    edit = bmesh.from_edit_mesh(obj.data)
    for vertex in edit.verts:
        vertex.select = bool(where(vertex.co))
    edit.select_flush_mode()
    bmesh.update_edit_mesh(obj.data)


def run(*parts: Callable[[], Iterator[None]]) -> None:
    """The parts of a session, one after the other."""

    def journey() -> Iterator[None]:
        for part in parts:
            enable()
            bpy.ops.wm.read_homefile(use_factory_startup=True)
            pictures[0] = OUTPUT / part.__name__
            pictures[0].mkdir(parents=True, exist_ok=True)
            print("part:", part.__name__, time.strftime("%X"), flush=True)
            yield from rest()
            yield from part()

    play(journey())


def play(journey: Iterator[None]) -> None:
    """Take the steps of a journey, then end Blender, whatever happened."""

    def tick() -> float | None:
        going_on = False
        try:
            next(journey)
            going_on = True
        except StopIteration:
            pass
        finally:  # the test reads the reason
            if not going_on:
                if sys.exc_info()[0] is not None:
                    seen["error"] = traceback.format_exc()
                _finish()
        return pace[0]

    preferences = bpy.context.preferences
    preferences.view.show_splash = preferences.view.show_tooltips = False
    # Without a GPU, smooth edges take half of the time; by default each picture is drawn eight times.
    smooth = "SINEW_SMOOTH_PICTURES" in os.environ
    preferences.system.viewport_aa = "FXAA" if smooth else "OFF"
    preferences.system.use_overlay_smooth_wire = preferences.system.use_edit_mode_smooth_wire = smooth
    bpy.app.timers.register(tick, first_interval=1.5, persistent=True)


def _finish() -> None:
    (OUTPUT / "seen.json").write_text(json.dumps(seen, indent=1), encoding="utf-8")
    sys.stdout.flush()
    os._exit(0)
