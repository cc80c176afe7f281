# SPDX-License-Identifier: GPL-3.0-or-later
"""Mirrored posing by mouse and keys, a rig that rides on another, Sinew Drag: Bones, Draw Outline, popups,
remeshing.
"""

import sys
from collections.abc import Callable, Iterator

import bpy
import numpy as np
from driving import above, apart, claim, near, rest, run, settled, until, works
from hand import click, hold, keys, move, open_sidebar, redo, release, stroke, undo
from rigs.rig import base_points, curves_of, make_active
from scenes import MODELS, deformer, empty_scene, head, shown, smooth_head
from window import Place, button, differing, look_from_front, middle, on_screen, screenshot, viewport

sys.path.insert(0, str(MODELS.parents[1]))

FLOAT32 = 4e-6  # of a head 4 units wide
FLIP = np.array((-1.0, 1.0, 1.0))
REGIONS = {
    "Ear": ("HANDLE", lambda point: point[0] > 1.6),
    "Back": ("FIXED", lambda point: point[1] > 0.35 and abs(point[0]) < 1.2),
}


def ear(side: str) -> bpy.types.Object:
    return next(handle.control for handle in deformer().handles if handle.name == f"Ear.{side}")


def places() -> np.ndarray:
    """Of the left and the right control."""
    return np.array([ear(side).location for side in "LR"])


def assert_mirrored() -> None:
    """The controls, and the ears that are shown."""
    left, right = places()
    near(left * FLIP, right, FLOAT32)
    base = np.round(base_points(head()), 4) + 0.0
    where = {tuple(place): index for index, place in enumerate(base)}
    images = np.array([where.get(tuple(place * FLIP + 0.0), -1) for place in base])
    paired = (images >= 0) & (np.abs(base[:, 0]) > 1.65)
    near(shown()[paired], shown()[images[paired]] * FLIP, FLOAT32)


def grab(up: int = 12, check: Callable[[], object] = lambda: None) -> Iterator[None]:
    """G, and the mouse goes up and aside, with a check after each of four steps."""
    x, y = middle()
    yield from keys("G", at=(x, y))
    for step in range(1, 5):
        move(x + 6 * step, y + up * step)
        yield from rest()
        check()


def mirror() -> Iterator[None]:
    """A head whose left ear is a handle without a side in its name; Mirror makes the right one."""
    viewport().spaces.active.show_region_hud = False
    smooth_head(1, REGIONS)
    deformer().active_handle = 0
    bpy.ops.sinew.handle_mirror(tolerance=0.01)
    with claim("Mirror names the ears"):
        assert [handle.name for handle in deformer().handles] == ["Ear.L", "Back", "Ear.R"]
    look_from_front()
    yield from open_sidebar()
    deformer().use_mirror_x = True
    make_active(ear("L"))
    bpy.ops.ed.undo_push(message="Mirror")
    yield from rest()
    for step in (mirrored_drag, mirrored_clear, mirrored_cancel):
        yield from step()
    with claim("the other ear follows typed numbers"):
        yield from keys("G", "Z", "1", "RET", at=middle())
        assert_mirrored()


def mirrored_drag() -> Iterator[None]:
    heights = []

    def check() -> None:
        heights.append(places()[0, 1])
        above(np.abs(places()[0]).max(), 0.01)
        assert_mirrored()

    with claim("the other ear follows each step of a drag"):
        yield from grab(check=check)
        yield from keys("LEFTMOUSE")
        assert_mirrored()
        assert len(set(heights)) == len(heights) == 4
    dragged = places()
    with claim("one step of undo takes both ears back, and redo brings both"):
        yield from undo()
        assert np.abs(places()).max() < 1e-12
        assert_mirrored()
        yield from redo()
        near(places(), dragged, 1e-6)


def mirrored_clear() -> Iterator[None]:
    """Alt+G, for which Blender takes its step of undo before the other side follows; another step; undo."""
    dragged = places()
    make_active(ear("L"))
    bpy.ops.ed.undo_push(message="Select")
    with claim("clearing one ear clears both at every step of undo"):
        yield from keys("alt G", at=middle())
        assert np.abs(places()).max() < 1e-12
        make_active(ear("R"))
        ear("R").rotation_euler.x = ear("L").rotation_euler.x = 0.25
        yield from rest()
        bpy.ops.ed.undo_push(message="Turn")
        yield from rest()
        yield from undo()
        assert np.abs(places()).max() < 1e-12
        yield from undo()
        near(places(), dragged, 1e-6)


def mirrored_cancel() -> Iterator[None]:
    """The right ear is posed by itself; a drag of the left one takes it along, and Esc gives both back."""
    deformer().use_mirror_x = False
    yield from rest()
    ear("R").location.z += 0.5
    yield from rest()
    deformer().use_mirror_x = True
    make_active(ear("L"))
    bpy.ops.ed.undo_push(message="Pose")
    yield from rest()
    before = places()
    yield from grab()
    with claim("Esc gives both ears back"):
        above(apart(before[0] * FLIP, before[1]), FLOAT32)
        near(places()[0] * FLIP, places()[1], FLOAT32)
        yield from keys("ESC")
        assert (places() == before).all()


HAND, HIP = "hand.L", "hip"
THROUGH_BONES = 1e-5  # float32 of a figure 1.8 units high, through the matrices of a chain of bones
REACHED = 0.02  # of a drag of half a unit: a pixel is a two-hundredth, and joints resist a little
STANDS = 1e-3  # what pinned feet give way: they count a thousand times as much as what is dragged


def figure() -> bpy.types.Object:
    return bpy.data.objects["Mannequin Rig"]


def skin() -> bpy.types.Object:
    return bpy.data.objects["Mannequin Skin"]


def tail(name: str) -> np.ndarray:
    return np.array(figure().matrix_world @ figure().pose.bones[name].tail)


def feet() -> np.ndarray:
    return np.array([tail("foot.L"), tail("foot.R")])


def lengths() -> np.ndarray:
    return np.array([(bone.tail - bone.head).length for bone in figure().pose.bones])


def middle_of(name: str) -> np.ndarray:
    bone = figure().pose.bones[name]
    return np.array(figure().matrix_world @ (0.5 * (bone.head + bone.tail)))


def pull(name: str, by: tuple[float, float, float]) -> Iterator[None]:
    """Press on a bone and drag it; the button is still held where the mouse ends."""
    start = middle_of(name)
    yield from hold([on_screen(start + share * np.array(by)) for share in np.linspace(0.0, 1.0, 5)])
    yield from rest()


def puppet() -> Iterator[None]:
    """An animator drags a hand and the hip of a mannequin in Pose Mode."""
    empty_scene()
    from blend_samples.models import mannequin

    mannequin.build("Mannequin")
    bpy.context.view_layer.objects.active = skin()
    bpy.ops.sinew.puppet_rig(armature=figure().name)
    yield from until(lambda: skin().sinew.active.is_bound)
    figure().show_in_front = True
    bpy.context.view_layer.objects.active = figure()
    bpy.ops.object.mode_set(mode="POSE")
    look_from_front(distance=4.2, height=0.95)
    bpy.ops.ed.undo_push(message="Mannequin")
    yield from rest(3)
    still, stood, long = shown(skin()), feet(), lengths()
    button("drag_start", mode="AUTO")
    with claim("a click with the tool pins a bone, and a disc marks it"):
        screenshot("puppet-1-free")
        for name in ("foot.L", "foot.R"):
            yield from click(*on_screen(middle_of(name)))
            yield from rest(3)
        assert sorted(bone.name for bone in figure().pose.bones if bone.sinew.pin) == ["foot.L", "foot.R"]
        near(feet(), stood, THROUGH_BONES)
        screenshot("puppet-2-pinned")
        above(differing("puppet-1-free", "puppet-2-pinned"), 1e-4)
    bpy.context.scene.tool_settings.use_keyframe_insert_auto = True
    shapes = []
    for name, by in ((HAND, (-0.3, 0.0, 0.4)), (HIP, (0.0, 0.0, -0.3))):
        before = tail(name)
        yield from pull(name, by)
        screenshot(f"puppet-3-{name.partition('.')[0]}")
        yield from release()
        with claim("a dragged bone follows the mouse, and the feet stay"):
            near(tail(name), before + by, REACHED)
            near(feet(), stood, STANDS)
            near(lengths(), long, THROUGH_BONES)
        shapes.append(shown(skin()))
        if name == HAND:
            with claim("the skin follows, and Auto Keying keys the bones that follow"):
                above(apart(shapes[0], still), 0.3)
                keyed = {curve.data_path.split('"')[1] for curve in curves_of(figure())}
                assert {HAND, "lower.L", "upper.L"} <= keyed
    with claim("a drag of a puppet is one step of undo"):
        for step, shape in ((undo, shapes[0]), (redo, shapes[1])):
            yield from step()
            near(shown(skin()), shape, THROUGH_BONES)
        assert bpy.context.mode == "POSE"


# From below the ear around it to above, as seen from the front: an ear that is larger and ends in a point.
STROKE = ((1.3, -0.25), (1.75, -0.1), (2.2, 0.2), (2.65, 0.75), (2.1, 0.85), (1.6, 0.85), (1.2, 0.75))
ONE_KEY = ["Basis", "Silhouette"]


def shape_keys() -> list[str]:
    found = head().data.shape_keys
    return [] if found is None else [key.name for key in found.key_blocks]


def silhouette() -> Iterator[None]:
    smooth_head(2)
    look_from_front()
    yield from rest()
    before = shown()
    screenshot("1-before")
    move(*on_screen((0.0, 0.0, 0.0)))
    yield from rest()
    button("silhouette_sketch")
    yield from rest()
    yield from stroke(STROKE, "2-drawn")
    with claim("the surface follows a sketch when the button is released"):
        assert shape_keys() == ONE_KEY
        above(apart(shown(), before), 0.3)

    def changed() -> np.ndarray:
        return np.abs(shown() - before).max(axis=1) > 1e-6

    with claim("the wheel changes how much follows a sketch, and confirming keeps what is shown"):
        narrow = changed().sum()
        yield from keys("WHEELDOWNMOUSE")
        above(changed().sum(), narrow)
        wider = shown()
        yield from keys("RET")
        yield
        screenshot("4-kept")
        kept = shown()
        assert shape_keys() == ONE_KEY
        near(kept, wider, FLOAT32)
        assert before[:, 0].max() < 2.2 < kept[:, 0].max() < 2.75
        assert not changed()[before[:, 0] < 0.0].any()
        assert bpy.context.window_manager.operators[-1].bl_idname == "SINEW_OT_silhouette_sketch"
    with claim("a sketch is one step of undo"):
        for step, names, shape in ((undo, [], before), (redo, ONE_KEY, kept), (undo, [], before)):
            yield from step()
            assert shape_keys() == names
            near(shown(), shape, FLOAT32)


# Buttons in a window of 1280 x 800 pixels, from its lower left corner: of tasks in a popup that was opened
# with the mouse HERE, of methods with the mouse ABOVE.
HERE, PUT_IN_A_BOX, LIFT_BROWS = (640, 500), (934, 355), (535, 223)
ABOVE, SMOOTH_BEND, RIGID_POINTS = (1000, 760), (718, 617), (518, 351)
FAR = (100, 100)
BROW = ((-0.5, 0.4), (0.0, 0.6), (0.5, 0.4))


def popup(name: str, at: Place) -> Iterator[None]:
    """Open it where the mouse is."""
    move(*at)
    yield
    button(name)
    yield from rest(5)


def methods() -> list[str]:
    return [row.method for row in head().sinew.deformers]


def browser() -> Iterator[None]:
    smooth_head(1)
    look_from_front()
    yield from rest()
    yield from popup("all_tasks", HERE)
    screenshot("1-tasks")
    with claim("a task is pressed in the browser, which is one step of undo"):
        yield from click(*PUT_IN_A_BOX)
        yield from settled()
        assert methods() == ["ffd"]
        assert bpy.context.window_manager.operators[-1].bl_idname == "SINEW_OT_lattice_add"
        yield from undo()
        assert methods() == []
    with claim("the popup closes, so that a task that waits for the mouse gets it"):
        yield from popup("all_tasks", HERE)
        yield from click(*LIFT_BROWS)
        yield from rest(4)
        yield from stroke(BROW)
        yield from settled()
        assert methods() == ["wires"]
    smooth_head(1, REGIONS)
    ear = deformer().handles[0].control
    ear.location.z += 1.0
    bpy.ops.ed.undo_push(message="Pose")
    yield from settled()
    first, shape = methods(), shown()
    yield from popup("choose_method", ABOVE)
    with claim("a method that is pressed changes the shape at once, and the popup stays"):
        for place, method in ((SMOOTH_BEND, "laplacian_editing"), (RIGID_POINTS, "mls")):
            yield from click(*place)
            yield from settled()
            assert methods() == [method]
            above(apart(shown(), shape), 0.01)
        screenshot("2-methods")
    move(*FAR)
    yield from rest(4)
    with claim("each method is one step of undo"):
        for wanted in (["laplacian_editing"], first):
            yield from undo()
            yield from settled()
            assert methods() == wanted
        near(shown(), shape, FLOAT32)


def remeshing() -> Iterator[None]:
    """Of 63,000 triangles, in a thread."""
    smooth_head(3)
    before = base_points(head())
    with claim("Esc while a mesh is remeshed leaves it as it was"):
        assert button("remesh") == {"RUNNING_MODAL"}
        yield from rest(4)
        assert works()
        yield from keys("ESC", at=middle())
        yield from until(lambda: not works())
        assert np.array_equal(base_points(head()), before)
    with claim("one step of undo takes a remesh back whole, and redo brings it"):
        button("remesh", share=2.0)
        yield from until(lambda: len(head().data.vertices) != len(before))
        made = base_points(head())
        above(len(before) / len(made), 3.0)
        yield from undo()
        assert np.array_equal(base_points(head()), before)
        yield from redo()
        assert np.array_equal(base_points(head()), made)


run(mirror, puppet, silhouette, browser, remeshing)
