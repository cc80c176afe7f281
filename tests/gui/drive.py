# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs inside a Blender with a window: from a blank file to a rendered pose, by mouse and keyboard.

Then the same way back by undo, Grab Region, and a bind and a transfer that are cancelled.
"""

import bmesh
import bpy
import numpy as np
from bpy_extras.object_utils import world_to_camera_view
from driving import (
    MODELS,
    OUTPUT,
    apart,
    binding,
    choose,
    click,
    differing,
    drag,
    enable,
    in_view,
    middle,
    move,
    open_tab,
    play,
    press,
    rest,
    screenshot,
    seen,
    select,
    sessions,
    shown_points,
    until,
    viewport,
    write,
)
from mathutils import Vector

# Where things are in a window of 1280 x 800 pixels, from its lower left corner.
HEAD = (370, 626), (600, 456)
HOOVES = (100, 200), (470, 126)
MENU = (600, 760)
MENU_ADD_HANDLE = (640, 736)
METHOD = (930, 585)
FACTOR = (975, 232), (940, 232)
LAST = 12  # frame


def cow() -> bpy.types.Object:
    return bpy.data.objects["spot"]


def deformer():
    return cow().sinew.active


def control() -> bpy.types.Object:
    return deformer().handles[0].control


def shown() -> np.ndarray:
    return shown_points(cow())


def blank_file():
    """A new file, the model of a cow in place of the cube, seen from the side."""
    enable()
    move(*middle())
    press("N", ctrl=True)
    yield from rest()
    press("RET")
    yield from rest(3)
    press("X")
    yield from rest()
    press("RET")
    yield from rest()
    seen["blank"] = [obj.name for obj in bpy.data.objects if obj.type == "MESH"]
    bpy.ops.wm.obj_import(filepath=str(MODELS / "spot.obj"))
    with in_view():
        bpy.ops.object.shade_smooth()
    bpy.ops.ed.undo_push(message="Import")
    press("NUMPAD_3")
    yield from rest()
    press("N")
    yield from rest()
    yield from open_tab()
    yield from rest()
    view = viewport().spaces.active.region_3d
    view.view_location, view.view_distance = (0.0, 0.51, 0.25), 2.65
    yield from rest()


def mark_regions():
    """The head by the header's menu, the hooves by the pie."""
    move(*middle())
    press("TAB")
    yield from rest()
    press("Z", alt=True)
    yield
    press("A", alt=True)
    yield
    press("B")
    yield from drag(*HEAD)
    yield
    yield from click(*MENU)
    yield from rest()
    move(*MENU_ADD_HANDLE)
    yield from rest()
    screenshot("1-menu")
    press("LEFTMOUSE")
    yield from rest()
    seen["after_menu"] = [(handle.kind, handle.vertex_group) for handle in deformer().handles]
    press("A", alt=True)
    yield
    press("B")
    yield from drag(*HOOVES)
    yield
    move(300, 330)
    press("Y", shift=True)
    yield from rest()
    move(400, 330)
    yield from rest()
    screenshot("2-pie")
    press("LEFTMOUSE")
    yield from rest()
    seen["after_pie"] = [(handle.kind, handle.vertex_group) for handle in deformer().handles]
    press("Z", alt=True)
    yield
    press("TAB")
    yield from rest(3)
    seen["mode"] = cow().mode
    seen["selected"] = [obj.name for obj in bpy.context.view_layer.objects if obj.select_get()]
    seen["status"] = deformer().status
    screenshot("3-ready")


def hooves(points: np.ndarray) -> np.ndarray:
    """Those of the fixed region."""
    group = cow().vertex_groups["Fixed"].index
    members = [v.index for v in cow().data.vertices if any(entry.group == group for entry in v.groups)]
    return points[members]


def pose():
    """Move, turn and scale the head; undo and redo."""
    ready = shown()
    here = (480, 300)
    move(*here)
    press("G")
    yield
    for step in range(1, 5):
        move(here[0] + 8 * step, here[1] + 20 * step)
        yield
    seen["during"] = apart(shown(), ready)
    press("LEFTMOUSE")
    yield from rest()
    yield from until(lambda: not sessions().unsettled())
    moved = shown()
    seen["moved"] = apart(moved, ready)
    seen["hooves_moved"] = apart(hooves(moved), hooves(ready))
    seen["settled"] = not sessions().unsettled()
    screenshot("4-moved")
    yield
    move(600, 420)
    press("R")
    yield
    move(610, 330)
    yield
    move(590, 250)
    yield
    press("LEFTMOUSE")
    yield from rest()
    yield from until(lambda: not sessions().unsettled())
    turned = shown()
    seen["turned"] = apart(turned, moved)
    press("Z", ctrl=True)
    yield from rest(3)
    yield from until(lambda: not sessions().unsettled())
    seen["first_undo"] = apart(shown(), moved)
    press("Z", ctrl=True)
    yield from rest(3)
    seen["second_undo"] = apart(shown(), ready)
    screenshot("5-undone")
    for _ in range(2):
        press("Z", ctrl=True, shift=True)
        yield from rest(3)
    yield from until(lambda: not sessions().unsettled())
    seen["redone"] = apart(shown(), turned)
    move(*middle())
    press("S")
    yield
    write("1.25")
    yield
    press("RET")
    yield from rest()
    yield from until(lambda: not sessions().unsettled())
    seen["scaled"] = apart(shown(), turned)
    seen["control_scale"] = list(control().scale)
    screenshot("6-posed")


def settings():
    """Method and Factor in the panel."""
    arap = shown()
    yield from choose(METHOD, deformer(), "method", "thin_shell")
    seen["method"] = deformer().method
    seen["method_changed"] = apart(shown(), arap)
    seen["method_keeps"] = [(handle.kind, handle.vertex_group) for handle in deformer().handles]
    screenshot("7-thin-shell")
    yield
    full = shown()
    yield from drag(*FACTOR)
    yield from rest()
    base = np.array([vertex.co for vertex in cow().data.vertices])
    seen["factor"] = deformer().factor
    seen["factor_error"] = apart(shown(), base + deformer().factor * (full - base))
    screenshot("8-factor")
    for _ in range(2):
        press("Z", ctrl=True)
        yield from rest(3)
    yield from until(lambda: not sessions().unsettled())
    seen["settings_undone"] = [deformer().method, deformer().factor, apart(shown(), arap)]


def key(entry: int):
    """Insert Keyframe; the fifth entry is Location, Rotation and Scale, then Blender remembers."""
    move(*middle())
    press("I")
    yield from rest()
    for _ in range(entry - 1):
        press("DOWN_ARROW")
    yield
    press("RET")
    yield from rest()


def animate():
    """Home at the first frame, posed at the last."""
    posed = control().matrix_world.copy()
    far = shown()
    for reset in ("G", "R", "S"):
        move(*middle())
        press(reset, alt=True)
        yield from rest()
    yield from until(lambda: not sessions().unsettled())
    base = np.array([vertex.co for vertex in cow().data.vertices])
    seen["home"] = apart(shown(), base)
    yield from key(5)
    bpy.context.scene.frame_end = LAST
    press("RIGHT_ARROW", shift=True)
    yield from rest()
    control().matrix_world = posed
    yield from rest()
    yield from key(1)
    seen["keyed"] = sorted({curve.data_path for curve in control().animation_data.action.fcurves})
    seen["last_frame"] = [bpy.context.scene.frame_current, apart(shown(), far)]
    press("LEFT_ARROW", shift=True)
    yield from rest()
    seen["first_frame"] = [bpy.context.scene.frame_current, apart(shown(), base)]
    for _ in range(LAST // 2):
        press("RIGHT_ARROW")
        yield
    yield from rest()
    stepped = shown()
    seen["middle_frame"] = bpy.context.scene.frame_current
    press("RIGHT_ARROW", shift=True)
    yield from rest()
    bpy.context.scene.frame_set(seen["middle_frame"])
    seen["scrubbed"] = apart(shown(), stepped)
    seen["between"] = min(apart(stepped, base), apart(stepped, far))
    screenshot("9-animated")


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
    render = scene.render
    render.engine, scene.cycles.samples, scene.cycles.use_denoising = "CYCLES", 16, False
    render.resolution_x, render.resolution_y, render.film_transparent = 380, 380, True


def outline() -> list[float]:
    """The shape that the window shows, where the camera sees it: left, lowest, right, highest pixel."""
    scene, matrix = bpy.context.scene, cow().matrix_world
    places = [world_to_camera_view(scene, scene.camera, matrix @ Vector(point)) for point in shown()]
    across = [place.x * scene.render.resolution_x for place in places]
    up = [place.y * scene.render.resolution_y for place in places]
    return [min(across), min(up), max(across), max(up)]


def silhouette(path: str) -> list[float]:
    """The same of a picture with a transparent background."""
    image = bpy.data.images.load(path)
    width, height = image.size
    covered = np.array(image.pixels[:]).reshape(height, width, 4)[:, :, 3] > 0.5
    across, up = np.flatnonzero(covered.any(axis=0)), np.flatnonzero(covered.any(axis=1))
    return [float(edge) for edge in (across[0], up[0], across[-1] + 1, up[-1] + 1)]


def render():
    """F12 at three frames."""
    look()
    ended: list[int] = []
    bpy.app.handlers.render_complete.append(lambda scene, *_: ended.append(scene.frame_current))
    seen["rendered"] = []
    for frame in (1, LAST // 2, LAST):
        bpy.context.scene.frame_set(frame)
        yield
        before = shown()
        move(*middle())
        press("F12")
        yield from until(lambda frame=frame: frame in ended)
        yield from rest()
        path = str(OUTPUT / f"rendered-{frame}.png")
        bpy.data.images["Render Result"].save_render(path)
        seen["rendered"].append([silhouette(path), outline(), apart(shown(), before)])


def undo_all():
    """Back to the imported mesh, step by step."""
    steps = 0  # of undo
    while cow().sinew.deformers and steps < 60:
        press("Z", ctrl=True)
        yield
        steps += 1
    yield from rest()
    if cow().mode == "EDIT":
        move(*middle())
        press("TAB")
        yield from rest()
    base = np.array([vertex.co for vertex in cow().data.vertices])
    seen["undo_steps"] = steps
    seen["all_undone"] = {
        "deformers": len(cow().sinew.deformers),
        "modifiers": len(cow().modifiers),
        "groups": len(cow().vertex_groups),
        "empties": len([obj for obj in bpy.data.objects if obj.type == "EMPTY"]),
        "moved": apart(shown(), base),
    }


def edited() -> np.ndarray:
    """What Edit Mode shows, float32 (n, 3), in the mesh's own space."""
    return np.array([vertex.co for vertex in bmesh.from_edit_mesh(cow().data).verts], dtype=np.float32)


def chosen() -> list[bool]:
    mesh = bmesh.from_edit_mesh(cow().data)
    return [element.select for kind in (mesh.verts, mesh.faces) for element in kind]


def grab_region():
    """A pose of the moment by key and number, undone; another one given up."""
    move(*middle())
    press("TAB")
    yield from rest()
    select(cow(), lambda point: point.y > 0.75)
    bpy.ops.ed.undo_push(message="Select")
    before, flags, here = edited(), chosen(), (480, 300)
    members = np.flatnonzero(flags[: len(before)])
    world = np.array(cow().matrix_world)[:3, :3]
    for end in ("RET", "ESC"):
        move(*here)
        press("Y", alt=True)
        yield
        for step in (1, 2):
            move(here[0] + 40 * step, here[1] + 30 * step)
            yield
        seen["grab_dragged"] = apart(edited(), before)
        press("X")
        write("0.5")
        yield from rest()
        press(end)
        yield from rest()
        if end == "RET":
            moved = (edited() - before).astype(float) @ world.T
            seen["grab_typed"] = apart(moved[members], np.array((0.5, 0.0, 0.0)))
            seen["grab_followed"] = int(moved.any(axis=1).sum()) - len(members)
            last = bpy.context.window_manager.operators[-1]
            seen["grab_last"] = [last.bl_idname, last.mode, [round(number, 5) for number in last.value]]
            press("Z", ctrl=True)
            yield from rest()
            seen["grab_undone"] = apart(edited(), before)
    seen["grab_restored"] = edited().tobytes() == before.tobytes() and chosen() == flags
    press("TAB")
    yield from rest()


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
    heavy = obj.sinew.active
    seen["heavy_in_thread"] = binding().job(heavy.uid) is not None
    yield
    screenshot("10-binding")
    yield from until(lambda: binding().job(heavy.uid) is None)
    seen["heavy_status"] = heavy.status
    yield
    bpy.context.view_layer.objects.active = obj
    obj.data.vertices[0].co.z += 0.5  # else the factor stays, and nothing is left to cancel
    with in_view():
        bpy.ops.sinew.bind("INVOKE_DEFAULT")
    press("ESC")
    yield from rest()
    seen["cancelled"] = heavy.status
    screenshot("11-cancelled")
    with in_view():
        bpy.ops.sinew.bind("INVOKE_DEFAULT")
    yield from until(lambda: binding().job(heavy.uid) is None)
    yield
    seen["bound_again"] = heavy.status


def cancelled_transfer():
    """Esc in the middle of a transfer of five thousand frames leaves neither a file nor a modifier."""
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=40, y_subdivisions=40)
    source = bpy.context.object
    target = bpy.data.objects.new("Target", source.data.copy())
    bpy.context.collection.objects.link(target)
    bpy.context.view_layer.objects.active = target
    bpy.context.scene.frame_set(3)
    folder = OUTPUT / "transfer"
    folder.mkdir(exist_ok=True)
    with in_view():
        bpy.ops.sinew.transfer_deformation(
            "INVOKE_DEFAULT",
            source=source.name,
            filepath=str(folder / "stout"),
            frame_start=1,
            frame_end=5000,
        )
    yield from rest()
    seen["transfer_files"] = len(list(folder.iterdir()))
    seen["transfer_frame"] = bpy.context.scene.frame_current
    press("ESC")
    yield from rest()
    seen["transfer_left"] = [
        *(path.name for path in folder.iterdir()),
        *(modifier.name for modifier in target.modifiers),
    ]
    seen["transfer_frame_after"] = bpy.context.scene.frame_current


def journey():
    yield from blank_file()
    yield from mark_regions()
    yield from pose()
    yield from settings()
    yield from animate()
    yield from render()
    yield from undo_all()
    yield from grab_region()
    yield from heavy_bind()
    yield from cancelled_transfer()
    seen["pixels_moved"] = differing("4-moved", "3-ready")
    seen["pixels_not_undone"] = differing("5-undone", "3-ready")


play(journey())
