# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs inside a Blender with a window: an artist's first pose, by mouse and keyboard.

Steps are a generator; each ``yield`` gives Blender the time a person would take. Observations and screenshots
go to the folder named after ``--``.
"""

import json
import os
import sys
import traceback
from pathlib import Path

import addon_utils
import bpy
import numpy as np

OUTPUT = Path(sys.argv[sys.argv.index("--") + 1])
PAUSE = 0.5  # seconds; a software renderer needs about half of it to draw a window of this size

seen: dict[str, object] = {}


def window():
    return bpy.context.window_manager.windows[0]


def viewport():
    return next(area for area in window().screen.areas if area.type == "VIEW_3D")


def view_region():
    return next(region for region in viewport().regions if region.type == "WINDOW")


def in_view():
    return bpy.context.temp_override(window=window(), area=viewport(), region=view_region())


def press(key: str, **modifiers: bool) -> None:
    for value in ("PRESS", "RELEASE"):
        window().event_simulate(key, value, x=mouse[0], y=mouse[1], **modifiers)


def move(x: int, y: int) -> None:
    mouse[:] = x, y
    window().event_simulate("MOUSEMOVE", "NOTHING", x=x, y=y)


def click(x: int, y: int) -> None:
    move(x, y)
    press("LEFTMOUSE")


def screenshot(name: str) -> None:
    with in_view():
        bpy.ops.screen.screenshot(filepath=str(OUTPUT / f"{name}.png"))


def centre() -> tuple[int, int]:
    region = view_region()
    return region.x + region.width // 3, region.y + region.height // 2


def shown_points() -> np.ndarray:
    obj = bpy.data.objects["Statue"]
    evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
    flat = np.empty(len(evaluated.data.vertices) * 3, dtype=np.float32)
    evaluated.data.vertices.foreach_get("co", flat)
    return flat.reshape(-1, 3)


def control() -> bpy.types.Object:
    return bpy.data.objects["Statue"].sinew.deformers[0].handles[0].control


def select(where) -> None:
    import bmesh

    mesh = bpy.data.objects["Statue"].data
    edit = bmesh.from_edit_mesh(mesh)
    for vertex in edit.verts:
        vertex.select = bool(where(vertex.co))
    edit.select_flush_mode()
    bmesh.update_edit_mesh(mesh)


mouse = [0, 0]


def prepare() -> None:
    """A head of 7,958 vertices, seen from the front, the Sinew tab open."""
    if addon_utils.enable(os.environ.get("SINEW_ADDON_MODULE", "sinew"), default_set=True) is None:
        raise RuntimeError("Sinew is not installed")
    for obj in list(bpy.data.objects):
        bpy.data.objects.remove(obj)
    bpy.ops.mesh.primitive_monkey_add(size=3.0)
    obj = bpy.context.object
    obj.name = "Statue"
    obj.modifiers.new("Subdivision", "SUBSURF").levels = 2
    bpy.ops.object.modifier_apply(modifier="Subdivision")
    bpy.ops.object.shade_smooth()
    space = viewport().spaces.active
    space.show_region_ui = True
    space.overlay.show_extras = True
    space.region_3d.view_perspective = "ORTHO"
    space.region_3d.view_rotation = (0.7071, 0.7071, 0.0, 0.0)
    space.region_3d.view_location = (0.3, 0.0, 0.4)
    space.region_3d.view_distance = 7.0


def open_tab() -> None:
    """Click the last tab of the sidebar."""
    sidebar = next(region for region in viewport().regions if region.type == "UI")
    if hasattr(sidebar, "active_panel_category"):
        sidebar.active_panel_category = "Sinew"
        return
    scale = bpy.context.preferences.system.ui_scale
    click(sidebar.x + sidebar.width - int(9 * scale), sidebar.y + sidebar.height - int(TAB * scale))


TAB = 160  # from the top of the sidebar to the middle of the fourth tab, in pixels at scale 1


def journey():
    prepare()
    yield
    open_tab()
    yield
    move(*centre())
    press("TAB")
    yield
    select(lambda point: point.z > 1.05 and abs(point.x) < 1.0)
    bpy.ops.ed.undo_push(message="Select")
    screenshot("1-selected")
    yield
    with in_view():
        bpy.ops.wm.call_menu(name="SINEW_MT_edit_mesh")
    yield
    move(mouse[0] + 2, mouse[1])
    yield
    screenshot("2-menu")
    press("RET")
    yield
    yield
    deformers = bpy.data.objects["Statue"].sinew.deformers
    seen["handles_after_menu"] = [handle.vertex_group for handle in deformers[0].handles] if deformers else []
    select(lambda point: point.z < -0.6)
    with in_view():
        bpy.ops.sinew.handle_add("INVOKE_DEFAULT", kind="FIXED")
    yield
    move(*centre())
    press("TAB")
    yield
    seen["mode"] = bpy.data.objects["Statue"].mode
    seen["selected"] = [obj.name for obj in bpy.context.view_layer.objects if obj.select_get()]
    seen["status"] = deformers_status()
    yield
    screenshot("3-ready")
    before = shown_points()
    press("G")
    yield
    for step in range(1, 7):
        move(centre()[0] + 12 * step, centre()[1] + 14 * step)
        yield
    seen["during"] = float(np.abs(shown_points() - before).max())
    press("LEFTMOUSE")
    yield
    yield
    yield
    after = shown_points()
    seen["moved"] = float(np.abs(after - before).max())
    seen["base_moved"] = float(np.abs((after - before)[before[:, 2] < -0.6]).max())
    seen["control"] = list(control().matrix_world.translation)
    seen["settled"] = not session().unsettled()
    screenshot("4-posed")
    yield
    press("R")
    yield
    move(mouse[0] - 60, mouse[1] + 100)
    yield
    press("LEFTMOUSE")
    yield
    yield
    yield
    screenshot("5-turned")
    turned = shown_points()
    seen["turned"] = float(np.abs(turned - after).max())
    press("Z", ctrl=True)
    yield
    yield
    seen["first_undo"] = float(np.abs(shown_points() - after).max())
    press("Z", ctrl=True)
    yield
    yield
    seen["second_undo"] = float(np.abs(shown_points() - before).max())
    screenshot("6-undone")
    yield
    yield from heavy_bind()


def heavy_bind():
    """A mesh that binds in a thread: the window lives on, Esc cancels, Bind starts again."""
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=400, y_subdivisions=400)
    obj = bpy.context.object
    for name, side in (("Left", -1.0), ("Right", 1.0)):
        members = [vertex.index for vertex in obj.data.vertices if vertex.co.x * side > 0.8]
        obj.vertex_groups.new(name=name).add(members, 1.0, "REPLACE")
    with in_view():
        bpy.ops.sinew.deformer_add(method="thin_shell")
        bpy.ops.sinew.handle_add(kind="FIXED", vertex_group="Right")
        bpy.ops.sinew.handle_add("INVOKE_DEFAULT", kind="HANDLE", vertex_group="Left")
    deformer = obj.sinew.active
    seen["heavy_in_thread"] = session().job(deformer.uid) is not None
    yield from until(lambda: session().job(deformer.uid) is None)
    seen["heavy_status"] = deformer.status
    yield
    with in_view():
        bpy.context.view_layer.objects.active = obj
        bpy.ops.sinew.bind("INVOKE_DEFAULT")
    press("ESC")
    yield
    yield
    seen["cancelled"] = deformer.status
    screenshot("7-cancelled")
    with in_view():
        bpy.ops.sinew.bind("INVOKE_DEFAULT")
    yield from until(lambda: session().job(deformer.uid) is None)
    yield
    seen["bound_again"] = deformer.status
    handle = deformer.handles[1]
    bpy.data.objects.remove(handle.control)
    yield
    yield
    screenshot("8-control-missing")
    yield


def until(condition, steps: int = 60):
    """Wait, as a person would, until ``condition()``."""
    for _ in range(steps):
        if condition():
            return
        yield


def deformers_status() -> str:
    deformers = bpy.data.objects["Statue"].sinew.deformers
    return deformers[0].status if deformers else ""


def session():
    return sys.modules[os.environ.get("SINEW_ADDON_MODULE", "sinew") + ".session"]


def pixels(name: str) -> np.ndarray:
    """The part of a screenshot that shows the mesh, (rows, columns, 3)."""
    image = bpy.data.images.load(str(OUTPUT / f"{name}.png"))
    width, height = image.size
    rows = np.array(image.pixels[:]).reshape(height, width, -1)
    region = view_region()
    return rows[region.y : region.y + region.height, region.x : region.x + region.width * 2 // 3, :3]


def finish() -> None:
    if "error" not in seen:
        ready, posed, undone = (pixels(name) for name in ("3-ready", "4-posed", "6-undone"))
        seen["pixels_moved"] = float((np.abs(posed - ready).max(axis=2) > 0.05).mean())
        seen["pixels_not_undone"] = float((np.abs(undone - ready).max(axis=2) > 0.05).mean())
    (OUTPUT / "seen.json").write_text(json.dumps(seen, indent=1))
    sys.stdout.flush()
    os._exit(0)


def tick() -> float | None:
    going_on = False
    try:
        next(steps)
        going_on = True
    except StopIteration:
        pass
    finally:  # Blender must end whatever happened, and the test reads the reason
        if not going_on:
            if sys.exc_info()[0] is not None:
                seen["error"] = traceback.format_exc()
            finish()
    return PAUSE


bpy.context.preferences.view.show_splash = False
bpy.context.preferences.view.show_tooltips = False
steps = journey()
bpy.app.timers.register(tick, first_interval=1.5)
