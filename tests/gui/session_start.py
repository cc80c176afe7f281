# SPDX-License-Identifier: GPL-3.0-or-later
"""From a blank file to a rendered pose and back; the preferences; the panel."""

from collections.abc import Iterator
from pathlib import Path

import addon_utils
import bpy
import installed
import numpy as np
import window
from driving import above, apart, claim, near, rest, run, settled, until
from editing import edited, select, selection
from expected import members_of
from hand import between, click, drag, glide, keys, move, open_sidebar, press, redo, undo
from inside import inner
from mathutils import Vector
from rigs.rig import base_points, curves_of
from scenes import MODELS, empty_scene, shown

# Where things are in a window of 1280 x 800 pixels, from its lower left corner.
HEAD = (370, 626), (600, 456)
HOOVES = (100, 200), (470, 126)
HERE = (480, 300)
MENU = (600, 760)
MENU_ADD_HANDLE = (640, 736)
METHOD, SOFT_SHEET = (955, 650), (518, 374)  # the button, and a picture in its popup
FACTOR = (975, 432), (940, 432)
FAR = (100, 300)
LAST = 12  # frame
REGIONS = [("HANDLE", "Handle"), ("FIXED", "Still")]
FLOAT32 = 2e-6  # of a model 2 units long


def cow() -> bpy.types.Object:
    return bpy.data.objects["spot"]


def deformer():
    return cow().sinew.active


def control() -> bpy.types.Object:
    return deformer().handles[0].control


def regions() -> list[tuple[str, str]]:
    return [(handle.kind, handle.vertex_group) for handle in deformer().handles]


def blank_file() -> Iterator[None]:
    """A new file, the model of a cow in place of the cube, seen from the side."""
    yield from keys("ctrl N", "RET", at=window.middle())
    yield from keys("X", "RET")
    with claim("the new file has a cube, which X deletes"):
        assert [obj.name for obj in bpy.data.objects if obj.type == "MESH"] == []
    bpy.ops.wm.obj_import(filepath=str(MODELS / "spot.obj"))
    with window.in_view():
        bpy.ops.object.shade_smooth()
    bpy.ops.ed.undo_push(message="Import")
    yield from keys("NUMPAD_3")
    yield from open_sidebar()
    window.view().view_location, window.view().view_distance = (0.0, 0.51, 0.25), 2.65
    yield from rest()


def mark_regions() -> Iterator[None]:
    """The head by the header's menu, the hooves by the pie."""
    yield from keys("TAB", "alt Z", "alt A", "B", at=window.middle())
    yield from drag(*HEAD)
    yield from rest()
    window.screenshot("1-selected")
    yield from click(*MENU)
    move(*MENU_ADD_HANDLE)
    yield from rest()
    yield from keys("LEFTMOUSE")
    with claim("the menu makes a handle of the selection"):
        assert regions() == REGIONS[:1]
    yield from keys("alt A", "B")
    yield from drag(*HOOVES)
    yield from keys("shift Y", at=(300, 330))
    yield from keys("LEFTMOUSE", at=(400, 330))
    with claim("the pie menu adds what stays"):
        assert regions() == REGIONS
    yield from keys("alt Z", "TAB")
    with claim("back in Object Mode the control alone is selected"):
        assert cow().mode == "OBJECT"
        assert [obj.name for obj in bpy.context.view_layer.objects if obj.select_get()] == ["spot Handle"]
        assert "2,930 vertices, 1 handle, 1 still, " in deformer().status
        assert "bound in" in deformer().status
    window.screenshot("3-ready")


def pose() -> Iterator[None]:
    ready = shown(cow())
    hooves, _weights = members_of(cow(), "Still")
    with claim("the surface follows the drag, and the final answer the preview"):
        yield from keys("G", at=HERE)
        yield from glide(between(HERE, (512, 380)))
        above(apart(shown(cow()), ready), 0.2)
        press("LEFTMOUSE")
        yield from settled()
        assert not inner.sessions.unsettled()
        above(apart(shown(cow()), ready), 0.2)
        assert (shown(cow())[hooves] == ready[hooves]).all()
    moved = shown(cow())
    window.screenshot("4-moved")
    yield from keys("R", at=(600, 420))
    yield from glide([(610, 330), (590, 250)])
    press("LEFTMOUSE")
    yield from settled()
    turned = shown(cow())
    with claim("undo takes turn and drag back, and redo brings them"):
        above(apart(turned, moved), 0.05)
        yield from undo()
        yield from settled()
        near(shown(cow()), moved, FLOAT32)
        yield from undo()
        near(shown(cow()), ready, FLOAT32)
        window.screenshot("5-undone")
        yield from redo()
        yield from redo()
        yield from settled()
        near(shown(cow()), turned, FLOAT32)
    with claim("the picture changes, and comes back"):
        above(window.differing("4-moved", "3-ready"), 0.03)
        assert window.differing("5-undone", "3-ready") < 0.002
    with claim("the surface follows when the control is scaled"):
        yield from keys("S", "1.25", "RET", at=window.middle())
        yield from settled()
        above(apart(shown(cow()), turned), 0.05)
        assert np.allclose(control().scale, 1.25, rtol=1e-6)
    window.screenshot("6-posed")


def settings() -> Iterator[None]:
    arap = shown(cow())
    with claim("another method from the pictures keeps the regions and shows at once"):
        yield from click(*METHOD)
        yield from rest(5)
        window.screenshot("7-methods")
        yield from click(*SOFT_SHEET)
        yield from settled()
        move(*FAR)  # which closes the popup
        yield from rest()
        assert deformer().method == "thin_shell"
        assert regions() == REGIONS
        above(apart(shown(cow()), arap), 0.01)
    full = shown(cow())
    with claim("the slider blends between rest and pose"):
        yield from drag(*FACTOR)
        assert 0.0 < deformer().factor < 1.0
        base = base_points(cow())
        near(shown(cow()), base + deformer().factor * (full - base), FLOAT32)
    with claim("undo takes the settings back"):
        yield from undo()
        yield from undo()
        yield from settled()
        assert (deformer().method, deformer().factor) == ("arap", 1.0)
        near(shown(cow()), arap, FLOAT32)


def animate() -> Iterator[None]:
    """Home at the first frame, posed at the last."""
    scene = bpy.context.scene
    posed, far, base = control().matrix_world.copy(), shown(cow()), base_points(cow())
    with claim("clearing the transform of a control brings the mesh to rest"):
        yield from keys("alt G", "alt R", "alt S", at=window.middle())
        yield from settled()
        near(shown(cow()), base, FLOAT32)
    with claim("keyed controls animate the surface"):
        # The fifth entry of the menu is Location, Rotation and Scale; then Blender remembers.
        yield from keys("I", *["DOWN_ARROW"] * 4, "RET")
        scene.frame_end = LAST
        yield from keys("shift RIGHT_ARROW")
        control().matrix_world = posed
        yield from keys("I", "RET", at=window.middle())
        keyed = {curve.data_path for curve in curves_of(control())}
        assert keyed == {"location", "rotation_euler", "scale"}
        assert scene.frame_current == LAST
        near(shown(cow()), far, FLOAT32)
        yield from keys("shift LEFT_ARROW")
        assert scene.frame_current == 1
        near(shown(cow()), base, FLOAT32)
        yield from keys(*["RIGHT_ARROW"] * (LAST // 2))
        stepped, frame = shown(cow()), scene.frame_current
        above(min(apart(stepped, base), apart(stepped, far)), 0.05)
        yield from keys("shift RIGHT_ARROW")
        scene.frame_set(frame)
        assert (shown(cow()) == stepped).all()


def look() -> None:
    """A camera, a colour, and few samples."""
    scene = bpy.context.scene
    camera = scene.camera
    camera.data.type, camera.data.ortho_scale = "ORTHO", 2.35
    toward = Vector((-0.86, -0.44, -0.24))
    camera.rotation_euler = toward.to_track_quat("-Z", "Y").to_euler()
    camera.location = Vector((0.0, 0.0, 0.26)) - 6.0 * toward.normalized()
    light = bpy.data.objects["Light"]
    light.data.energy, light.location, light.data.shadow_soft_size = 1700.0, (3.5, 4.5, 5.0), 1.0
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.12, 0.13, 0.15, 1.0)
    colour = bpy.data.materials.new("Hide")
    colour.use_nodes = True
    colour.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (0.5, 0.29, 0.16, 1.0)
    cow().data.materials.clear()
    cow().data.materials.append(colour)
    scene.render.engine, scene.cycles.samples, scene.cycles.use_denoising = "CYCLES", 16, False
    scene.render.resolution_x, scene.render.resolution_y, scene.render.film_transparent = 380, 380, True


def render() -> Iterator[None]:
    look()
    ended: list[int] = []
    bpy.app.handlers.render_complete.append(lambda scene, *_: ended.append(scene.frame_current))
    with claim("renders come to their end and leave what the window shows"):
        for frame in (1, LAST // 2, LAST):
            bpy.context.scene.frame_set(frame)
            yield
            before = shown(cow())
            yield from keys("F12", at=window.middle())
            yield from until(lambda frame=frame: frame in ended)
            yield from rest()
            path = str(window.pictures[0] / f"rendered-{frame}.png")
            bpy.data.images["Render Result"].save_render(path)
            assert (shown(cow()) == before).all()


def undo_all() -> Iterator[None]:
    """Back to the imported mesh, step by step."""
    steps = 0
    while cow().sinew.deformers and steps < 60:
        press("Z", ctrl=True)
        yield
        steps += 1
    yield from rest()
    if cow().mode == "EDIT":
        yield from keys("TAB", at=window.middle())
    with claim("undo leads back to the bare mesh"):
        assert not [*cow().sinew.deformers, *cow().modifiers, *cow().vertex_groups]
        assert not [obj for obj in bpy.data.objects if obj.type == "EMPTY"]
        assert (shown(cow()) == base_points(cow())).all()


def grab_region() -> Iterator[None]:
    """A pose of the moment by key and number, undone; another one given up."""
    yield from keys("TAB", at=window.middle())
    select(cow(), lambda point: point.y > 0.75)
    bpy.ops.ed.undo_push(message="Select")
    before, chosen = edited(cow()), selection(cow())
    way = [(520, 330), (560, 360)]
    with claim("Grab Once starts by its key, and the surface follows"):
        yield from keys("alt Y", at=HERE)
        yield from glide(way)
        above(apart(edited(cow()), before), 0.1)
    window.screenshot("8-grab")
    with claim("one undo takes a typed grab back, and Esc restores every bit"):
        yield from keys("X", "0.5", "RET")
        last = bpy.context.window_manager.operators[-1]
        assert (last.bl_idname, last.mode) == ("SINEW_OT_grab_region", "TRANSLATE")
        assert [round(number, 5) for number in last.value] == [0.5, 0.0, 0.0]
        yield from undo()
        assert (edited(cow()) == before).all()
        yield from keys("alt Y", at=HERE)
        yield from glide(way)
        yield from keys("X", "0.5", "ESC")
        assert edited(cow()).tobytes() == before.tobytes()
        assert selection(cow()) == chosen


def journey() -> Iterator[None]:
    for step in (blank_file, mark_regions, pose, settings, animate, render, undo_all, grab_region):
        yield from step()


def preferences() -> Iterator[None]:
    """*Check This Installation* in the preferences of the add-on."""
    area, name = window.viewport(), installed.name()
    area.type = "PREFERENCES"
    bpy.context.preferences.active_section = "ADDONS"
    bpy.context.window_manager.addon_search = "Sinew"
    addon = next(module for module in addon_utils.modules() if module.__name__ == name)
    addon_utils.module_bl_info(addon)["show_expanded"] = True
    yield from rest(8)
    check = inner.backend.last_check
    yield from click(area.x + 610, area.y + area.height - 330)
    yield from until(lambda: check().report != "")
    move(area.x + 20, area.y + 20)
    yield from rest(4)
    window.screenshot("checked")
    with claim("the button checks the installation and tells where the report lies"):
        found, report = check(), Path(check().report)
        text = report.read_text(encoding="utf-8")
        report.unlink()
        above(found.asked, 100)
        assert found.wrong == 0
        assert found.summary == f"All {found.asked} known answers are right"
        assert "with a window" in text
        assert text.count("  right  ") == found.asked


def sidebar(name: str) -> np.ndarray:
    """A screenshot of the sidebar."""
    place = window.region("UI")
    window.screenshot(name)
    return window.pixels(name)[place.y : place.y + place.height, place.x : place.x + place.width]


def panel() -> Iterator[None]:
    """In a sidebar as wide as Blender makes it, the picture of a list changes with the frames of its keys."""
    empty_scene()
    bpy.ops.mesh.primitive_monkey_add()
    yield from open_sidebar()
    with window.in_view():
        bpy.ops.screen.screen_full_area()
    yield from rest(4)
    with window.in_view():
        bpy.ops.sinew.deformer_add(method="mesh_sequence")
    rows = bpy.context.object.sinew.active.keys
    for frame in (1, 8, 128, 1024):  # frame 1 is the current one, so its row has another icon
        rows.add().frame = frame
    place = window.region("UI")
    inside = place.x + place.width // 3, place.y + place.height // 3
    yield from keys(*["WHEELDOWNMOUSE"] * 15, at=inside)  # down to the end of the panel
    before = sidebar("1-keys")
    with claim("each key shows its frame: the lines of pixels that change are digits of one row"):
        width = place.width / bpy.context.preferences.system.ui_scale
        assert abs(width - 220.0) < 1.0, width
        for row in rows[1:]:
            row.frame += 5
            place.tag_redraw()
            yield from rest(4)
            after = sidebar(f"2-key-{row.frame}")
            lines = int((np.abs(after - before).max(axis=2) > 0.1).any(axis=1).sum())
            assert 4 <= lines <= 20, (row.frame, lines)
            before = after
        assert [row.frame for row in rows] == [1, 13, 133, 1029]


def try_it() -> Iterator[None]:
    """A rig in a scene of its own, and back."""
    yield from open_sidebar()
    looked = window.view().view_rotation.copy(), window.viewport().spaces.active.shading.color_type
    window.button("try_it", rig="limb")
    yield from settled()
    with claim("a rig stands in the middle of the view, and a drag on its tip ticks its first step"):
        tip = window.on_screen((0.0, -0.2, 1.85))
        yield from drag(tip, (tip[0] + 80, tip[1] - 30))
        yield from settled()
        window.screenshot("try-it")
        assert inner.try_it.steps_done(bpy.context.window.scene) == 1
    window.button("try_back")
    yield from settled()
    with claim("Back to My Scene brings the view back, and the tool"):
        assert looked == (window.view().view_rotation, window.viewport().spaces.active.shading.color_type)
        tool = bpy.context.workspace.tools.from_space_view3d_mode("OBJECT")
        assert (tool.idname, bpy.context.window.scene.name) == ("builtin.select_box", "Scene")


run(journey, preferences, panel, try_it)
