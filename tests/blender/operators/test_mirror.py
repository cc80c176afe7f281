# SPDX-License-Identifier: GPL-3.0-or-later
"""Mirror of handles: names by Blender's rules, weights by place, controls and poses by reflection."""

import bpy
import numpy as np
import pytest
from editing import edit, select
from inside import inner
from mathutils import Matrix
from rigs import rig as scenes

FLIP = np.array((-1.0, 1.0, 1.0))


def paint(obj: bpy.types.Object, name: str, weight) -> None:
    """A vertex group with ``weight(point)`` where that is above 0."""
    group = obj.vertex_groups.new(name=name)
    for vertex in obj.data.vertices:
        if (value := weight(vertex.co)) > 0.0:
            group.add([vertex.index], value, "REPLACE")


def weights(obj: bpy.types.Object, name: str) -> dict[tuple[float, ...], float]:
    found = scenes.painted(obj.data, obj.vertex_groups[name].index)
    places = map(tuple, np.round(scenes.base_points(obj), 4) + 0.0)
    return {place: weight for place, weight in zip(places, found, strict=True) if weight}


def reflected(found: dict[tuple[float, ...], float]) -> dict[tuple[float, ...], float]:
    return {(-x + 0.0, y, z): weight for (x, y, z), weight in found.items()}


def soft_left(point) -> float:
    """1 near the left edge, falling off towards the centre, uneven along y."""
    return min(1.0, max(0.0, (point[0] - 0.35) * 2.5)) if point[1] > -0.5 else 0.0


@pytest.fixture
def hand() -> scenes.Rig:
    """A plate, posed: soft Hand.L on the left, the centre column fixed. The deformer is bound."""
    plate = scenes.Rig(scenes.grid_object())
    bpy.ops.sinew.deformer_add(method="thin_shell")
    add_region(plate, "Hand.L", soft_left, "HANDLE")
    add_region(plate, "Spine", lambda point: abs(point[0]) < 0.1)
    plate.deformer.active_handle = 0
    return plate


def by_name(plate: scenes.Rig, name: str):
    return plate.deformer.handles[name]


def handle_names(plate: scenes.Rig) -> list[str]:
    return plate.deformer.handles.keys()


def mirror(**options) -> None:
    assert bpy.ops.sinew.handle_mirror(**options) == {"FINISHED"}
    scenes.update()


def add_region(plate: scenes.Rig, name: str, where, kind: str = "FIXED") -> None:
    """A vertex group of the vertices for which ``where(point)``, and its region, active."""
    paint(plate.obj, name, lambda point: float(where(point)))
    scenes.press(plate.obj, "handle_add", kind=kind, vertex_group=name)
    scenes.make_active(plate.obj)


def assert_weights_are_mirrored(plate: scenes.Rig, left: str = "Hand.L", right: str = "Hand.R") -> None:
    assert weights(plate.obj, right) == pytest.approx(reflected(weights(plate.obj, left)))


def assert_is_its_own_mirror_image(plate: scenes.Rig) -> None:
    points = plate.points()
    assert np.abs(points - mirror_image(plate.obj, points)).max() < 2e-5


def low_corner(sign: float):
    """Where the left (1.0) or right (-1.0) corner nearest to the viewer is."""
    return lambda point: point[0] * sign > 0.7 and point[1] < -0.7


def on_the_right(plate: scenes.Rig) -> list[int]:
    return [i for i, p in enumerate(plate.rest()) if p[0] < -0.76 and p[1] > -0.5]


def mirror_image(obj: bpy.types.Object, points: np.ndarray) -> np.ndarray:
    """What a symmetrical grid would show if its left were its right."""
    rest = np.round([vertex.co for vertex in obj.data.vertices], 4) + 0.0
    where = {tuple(place): index for index, place in enumerate(rest)}
    return points[[where[tuple(place * FLIP + 0.0)] for place in rest]] * FLIP


NAMES = (
    *("Hand.L", "hand_r.003", "L Hand", "r-x", "LeftHand", "HandRIGHT.001", "leftover", "xleft", "Bright"),
    *("RIGHT", "Head", "", "L", ".L", "L.", "L.001", "left", "Hand.Lx", "rightleft", "xleftleft", "LEft_x"),
    *("a.L.b.R", "Hand.L.1a", "Hand.L.a1", "Größe.r", "ö.L", "éleft", "LEFTright", "riGHTy", "Hand.L."),
    *("L.1", "Left"),
)


@pytest.mark.parametrize("name", NAMES)
def test_names_flip_as_blender_flips_them(name: str):
    theirs = bpy.utils.flip_name(name)
    assert inner.sides.flip(name) == ("" if theirs == name else theirs)


def test_a_handle_is_made_for_the_other_side(hand: scenes.Rig):
    source = by_name(hand, "Hand.L")
    source.weight, source.continuity, source.colour = 0.9, 1.0, (0.1, 0.2, 0.3)
    mirror()
    assert handle_names(hand) == ["Hand.L", "Spine", "Hand.R"]
    source, target = by_name(hand, "Hand.L"), by_name(hand, "Hand.R")
    assert_weights_are_mirrored(hand)
    assert len({round(weight, 3) for weight in weights(hand.obj, "Hand.R").values()}) > 2  # soft ones too
    assert target.vertex_group == "Hand.R"
    for name in ("kind", "weight", "continuity", "colour"):
        assert getattr(target, name) == getattr(source, name)
    assert target.control not in (None, source.control)
    places = [np.array(handle.control.matrix_world.translation) for handle in (source, target)]
    assert np.allclose(places[0] * FLIP, places[1], atol=1e-6)
    assert hand.deformer.status_level == "INFO"
    assert np.abs(hand.points() - hand.rest()).max() < scenes.FLOAT32  # nothing moved


@pytest.mark.parametrize("turned", [False, True])
def test_the_pose_is_mirrored_with_it(hand: scenes.Rig, turned: bool):
    """The posed shape becomes its own mirror image, wherever the mesh object stands.

    The numbers are those with x, and the turns about y and z, reversed: what Paste Pose Flipped does.
    """
    if turned:
        hand.obj.matrix_world = scenes.some_motion() @ Matrix.Diagonal((1.0, 2.0, 0.5, 1.0))
        bpy.ops.sinew.unbind()
        bpy.ops.sinew.bind()
    control = hand.control
    control.location, control.rotation_euler = (0.1, 0.2, 0.4), (0.3, 0.5, -0.2)
    before = hand.points()
    assert np.abs(before - hand.rest()).max() > 0.3
    scenes.press(hand.obj, "handle_mirror")
    assert_is_its_own_mirror_image(hand)
    assert np.abs(hand.points() - hand.rest()).max() > 0.3
    other = by_name(hand, "Hand.R").control
    if not turned:
        assert np.allclose(other.location, (-0.1, 0.2, 0.4), atol=1e-6)
        assert np.allclose(other.rotation_euler, (0.3, -0.5, 0.2), atol=1e-6)
    other.matrix_basis = control.matrix_basis = Matrix.Identity(4)
    assert np.abs(hand.points() - hand.rest()).max() < 2e-5  # Alt+G, Alt+R bring both back


def test_the_support_around_a_dragged_handle_is_mirrored_with_it():
    plate = scenes.Rig(scenes.grid_object(cells=20))
    bpy.ops.sinew.drag(origin=(0.5, 0.1, 5.0), value=(0.1, 0.05, 0.3), radius=0.15, reach=2.5)
    scenes.press(plate.obj, "handle_mirror")
    scenes.update()
    assert handle_names(plate) == ["Free Area.L", "Handle L", "Handle R", "Free Area.R"]
    assert_is_its_own_mirror_image(plate)
    assert_weights_are_mirrored(plate, "Free Area.L", "Free Area.R")


def test_the_next_mirror_updates_the_counterpart(hand: scenes.Rig):
    """Its weights only, or its settings and its pose as well."""
    mirror()
    first = by_name(hand, "Hand.R").control
    by_name(hand, "Hand.L").control.location.z = 0.5
    by_name(hand, "Hand.L").weight = 0.5
    hand.obj.vertex_groups["Hand.L"].add([30, 60], 0.25, "REPLACE")
    for weights_only in (True, False):
        mirror(weights_only=weights_only)
        assert handle_names(hand) == ["Hand.L", "Spine", "Hand.R"]
        target = by_name(hand, "Hand.R")
        assert target.control == first
        assert target.weight == (1.0 if weights_only else 0.5)
        assert np.allclose(first.matrix_basis, Matrix.Identity(4)) == weights_only
        assert_weights_are_mirrored(hand)
    assert_is_its_own_mirror_image(hand)


@pytest.mark.parametrize("name", ["Foot.R", "Foot"])
def test_all_of_one_side(hand: scenes.Rig, name: str):
    """A handle without a side in its name gets one when its side is mirrored; what is fixed, no control."""
    add_region(hand, name, low_corner(-1.0), "HANDLE")
    add_region(hand, "Pin.L", lambda point: point[0] > 0.9 and point[1] < -0.7)
    mirror(side="LEFT_TO_RIGHT")
    assert handle_names(hand) == ["Hand.L", "Spine", name, "Pin.L", "Hand.R", "Pin.R"]
    assert (by_name(hand, "Pin.R").kind, by_name(hand, "Pin.R").control) == ("FIXED", None)
    mirror(side="RIGHT_TO_LEFT")
    assert handle_names(hand) == ["Hand.L", "Spine", "Foot.R", "Pin.L", "Hand.R", "Pin.R", "Foot.L"]
    assert_weights_are_mirrored(hand, "Foot.R", "Foot.L")


def test_vertices_on_the_centre_stay_with_the_source(capfd):
    """Both sides would hold them exactly, which no vertex can obey."""
    plate = scenes.Rig(scenes.grid_object())
    bpy.ops.sinew.deformer_add(method="thin_shell")
    add_region(plate, "Half.L", lambda point: point[0] > -0.01, "HANDLE")
    mirror()
    assert "11 vertices on the centre line belong" in capfd.readouterr().out
    assert plate.deformer.status_level == "INFO"
    left, right = weights(plate.obj, "Half.L"), weights(plate.obj, "Half.R")
    assert len(left) == 66
    assert right == {place: weight for place, weight in reflected(left).items() if place[0] < 0.0}


def test_an_even_handle_takes_one_half_from_the_other(hand: scenes.Rig):
    def aside_and_centre() -> tuple[set, dict]:
        head = weights(hand.obj, "Head")
        aside = {weight for place, weight in head.items() if place[0]}
        return aside, {place: weight for place, weight in head.items() if not place[0]}

    add_region(hand, "Head", lambda point: (0.8 if point[0] > 0.0 else 0.3) * (abs(point[0]) < 0.5))
    centre = aside_and_centre()[1]
    mirror()  # the active one
    assert aside_and_centre() == ({np.float32(0.8)}, centre)
    assert_weights_are_mirrored(hand, "Head", "Head")
    assert len(hand.deformer.handles) == 3
    right = [i for i, p in enumerate(hand.rest()) if -0.5 < p[0] < -0.1]
    hand.obj.vertex_groups["Head"].add(right, 0.4, "REPLACE")
    mirror(side="RIGHT_TO_LEFT")
    assert aside_and_centre()[0] == {np.float32(0.4)}


def test_painted_parameters_are_evened_out_on_request(hand: scenes.Rig):
    paint(hand.obj, "Stiff", lambda point: 0.5 + 0.4 * point[0])
    hand.deformer.method = "arap"
    hand.deformer.arap.rigidity_group = "Stiff"
    before = weights(hand.obj, "Stiff")
    mirror()
    assert weights(hand.obj, "Stiff") == before
    mirror(painted_groups=True)
    after = weights(hand.obj, "Stiff")
    assert after == pytest.approx(reflected(after))
    assert all(after[place] == weight for place, weight in before.items() if place[0] >= 0.0)


def test_the_bone_of_the_other_side_becomes_the_control(hand: scenes.Rig):
    places = {f"arm.{side}": ((0.5 * x, 0, 0), (x, 0.2, 0.3)) for side, x in (("L", 1.0), ("R", -1.0))}
    armature = scenes.new_armature(**places)
    armature.location = (0.0, 0.3, 0.1)
    with scenes.in_mode(armature):
        for bone, roll in zip(armature.data.edit_bones, (0.3, 1.1), strict=True):  # they do not match
            bone.roll = roll
    handle = by_name(hand, "Hand.L")
    handle.control, handle.bone = armature, "arm.L"
    scenes.press(hand.obj, "bind")
    bone = armature.pose.bones["arm.R"]
    bone.location = (0.0, 0.0, 0.2)  # posed before it becomes a control
    mirror()
    target = by_name(hand, "Hand.R")
    assert (target.control, target.bone, target.owns_control) == (armature, "arm.R", False)
    moved = armature.matrix_world @ bone.matrix @ bone.bone.matrix_local.inverted()
    hard = on_the_right(hand)
    expected = scenes.apply_matrix(moved @ armature.matrix_world.inverted(), hand.rest()[hard])
    assert np.abs(expected - hand.rest()[hard]).max() > 0.1
    assert np.abs(hand.points()[hard] - expected).max() < 1e-5


def test_the_object_of_the_other_side_becomes_the_control(hand: scenes.Rig):
    left, right = scenes.new_empty("Ctrl.L", (0.9, 0.1, 0.0)), scenes.new_empty("Ctrl.R", (-0.9, 0.1, 0.0))
    by_name(hand, "Hand.L").control = left
    scenes.press(hand.obj, "bind")
    left.location.z = 0.4  # posed, while the other one rests
    scenes.update()
    mirror()
    assert by_name(hand, "Hand.R").control == right
    assert np.abs(hand.points()[on_the_right(hand), 2]).max() < scenes.FLOAT32
    right.location.z = 0.4
    assert_is_its_own_mirror_image(hand)


def test_a_mirror_modifier_fills_the_other_side():
    """The base mesh is one half: the modifier hands the weights on to the flipped group."""
    obj = scenes.grid_object()
    edit(obj, lambda point: point.x < -0.01)
    bpy.ops.mesh.delete(type="VERT")
    bpy.ops.object.mode_set(mode="OBJECT")
    obj.modifiers.new("Mirror", "MIRROR").use_clip = True
    plate = scenes.Rig(obj)
    paint(obj, "Hand.R", lambda point: 0.0)
    bpy.ops.sinew.deformer_add(method="thin_shell")
    add_region(plate, "Hand.L", soft_left, "HANDLE")
    bpy.ops.sinew.handle_add(kind="FIXED", vertex_group="Base")
    plate.deformer.active_handle = 0
    rest = scenes.evaluated_points(obj)
    plate.control.location.z = 0.5
    mirror()
    assert plate.deformer.status_level == "INFO"
    for sign in (1, -1):
        ends = (rest[:, 0] * sign > 0.9) & (rest[:, 1] > 0.0)
        assert np.abs(plate.points()[ends, 2] - 0.5).max() < scenes.FLOAT32


def test_vertices_without_an_image_are_counted(hand: scenes.Rig, capfd):
    lifted = [i for i, p in enumerate(hand.rest()) if p[0] < -0.95 and p[1] > 0.3]
    for index in lifted:
        hand.obj.data.vertices[index].co.z = 0.02
    for tolerance, without in ((1e-4, len(lifted)), (0.05, 0)):
        capfd.readouterr()
        mirror(tolerance=tolerance)
        assert (f"{without} vertices have no mirror image" in capfd.readouterr().out) == bool(without)
        assert len(weights(hand.obj, "Hand.R")) == len(weights(hand.obj, "Hand.L")) - without


def test_mirror_in_edit_and_weight_paint_mode(hand: scenes.Rig):
    for mode in ("EDIT", "WEIGHT_PAINT"):
        hand.deformer.active_handle = 0
        with scenes.in_mode(hand.obj, mode):
            mirror()
            assert hand.obj.mode == mode
    assert_weights_are_mirrored(hand)


@pytest.mark.parametrize(("sign", "ending", "other"), [(1.0, ".L", ".R"), (-1.0, ".R", ".L")])
def test_a_handle_is_named_by_the_side_that_it_lies_on(hand: scenes.Rig, capfd, sign, ending, other):
    """With the group and the control that carried its name, and is mirrored with its pose."""
    add_region(hand, "Foot", low_corner(sign), "HANDLE")
    control = by_name(hand, "Foot").control
    assert control.name == "Plate Foot"
    control.location.z, control.rotation_euler.y = 0.4, 0.3
    before = hand.points()
    scenes.make_active(hand.obj)
    mirror()
    said = capfd.readouterr().out
    assert f"Foot is now Foot{ending}, after the side that it lies on" in said
    assert f"Mirrored Foot{ending} to Foot{other}" in said
    assert handle_names(hand) == ["Hand.L", "Spine", f"Foot{ending}", f"Foot{other}"]
    for end in (ending, other):
        handle = by_name(hand, f"Foot{end}")
        assert (handle.vertex_group, handle.control.name) == (f"Foot{end}", f"Plate Foot{end}")
    assert by_name(hand, f"Foot{ending}").control == control
    assert "Foot" not in hand.obj.vertex_groups
    assert_weights_are_mirrored(hand, f"Foot{ending}", f"Foot{other}")
    corner = [i for i, p in enumerate(hand.rest()) if low_corner(sign)(p)]
    after = hand.points()
    assert np.abs(after - before)[corner].max() < scenes.FLOAT32
    assert np.abs(after - mirror_image(hand.obj, after))[corner].max() < 2e-5
    assert hand.deformer.status_level == "INFO"


def test_what_names_the_group_of_a_handle_follows_its_new_name(hand: scenes.Rig, tmp_path):
    """Shape keys, masks, modifiers, constraints, painted parameters, and the regions of other deformers."""
    add_region(hand, "Foot", low_corner(1.0), "HANDLE")
    obj = hand.obj
    key = scenes.add_key(obj, "Up", Matrix())
    key.data[0].co.z, key.value, key.vertex_group = 1.0, 0.5, "Foot"
    obj.modifiers.new("Smooth", "SMOOTH").vertex_group = "Foot"
    cloth = obj.modifiers.new("Cloth", "CLOTH")
    cloth.show_viewport = cloth.show_render = False
    cloth.settings.vertex_group_mass = "Foot"
    follower = scenes.new_empty("Follower")
    constraint = follower.constraints.new("COPY_LOCATION")
    constraint.target, constraint.subtarget = obj, "Foot"
    hand.deformer.mask_group = "Foot"
    scenes.press(obj, "deformer_add", method="arap")
    bpy.ops.sinew.handle_add(kind="HANDLE", vertex_group="Foot", handle_name="Other")
    bpy.ops.sinew.handle_add(kind="FIXED", vertex_group="Spine")
    hand.deformer.arap.rigidity_group = "Foot"
    hand.control.location.z = 0.3
    before, carried = hand.points(), np.array(follower.matrix_world.translation)
    obj.sinew.active_deformer, obj.sinew.deformers[0].active_handle = 0, 2
    mirror()
    first, second = obj.sinew.deformers
    assert handle_names(hand) == ["Hand.L", "Spine", "Foot.L", "Foot.R"]
    assert second.handles[0].vertex_group == second.arap.rigidity_group == first.mask_group == "Foot.L"
    assert key.vertex_group == obj.modifiers["Smooth"].vertex_group == constraint.subtarget == "Foot.L"
    assert cloth.settings.vertex_group_mass == "Foot.L"
    assert np.allclose(follower.matrix_world.translation, carried, atol=1e-5)
    for _ in range(2):
        assert np.abs(hand.points() - before).max() < 2e-5
        assert {deformer.status_level for deformer in hand.obj.sinew.deformers} == {"INFO"}
        scenes.reopen(tmp_path / "renamed.blend")


def test_a_group_that_a_bone_needs_keeps_its_name(hand: scenes.Rig):
    armature = scenes.new_armature(Foot=((0.8, -0.8, 0.0), (0.8, -0.8, 0.5)))
    add_region(hand, "Foot", low_corner(1.0), "HANDLE")
    hand.obj.modifiers.new("Armature", "ARMATURE").object = armature
    scenes.press(hand.obj, "handle_mirror")
    groups = {handle.name: handle.vertex_group for handle in hand.deformer.handles[2:]}
    assert groups == {"Foot.L": "Foot", "Foot.R": "Foot.R"}


def test_a_name_that_is_taken_gets_a_number(hand: scenes.Rig):
    hand.obj.vertex_groups.new(name="Foot.R")
    add_region(hand, "Foot", low_corner(1.0), "HANDLE")
    mirror()
    assert handle_names(hand)[2:] == ["Foot.001.L", "Foot.001.R"]
    assert "Foot.001.L" in hand.obj.vertex_groups
    assert not weights(hand.obj, "Foot.R")


def test_a_region_on_the_centre_line_stays_one_handle_and_is_said_to(hand: scenes.Rig, capfd):
    hand.deformer.active_handle = 1
    mirror()
    assert "Spine lies on the centre line: it stays one handle, made symmetric" in capfd.readouterr().out
    assert handle_names(hand) == ["Hand.L", "Spine"]


def test_two_nameless_handles_that_mirror_each_other_become_a_pair(hand: scenes.Rig):
    add_region(hand, "Foot", low_corner(-1.0), "HANDLE")
    add_region(hand, "Toes", low_corner(1.0), "HANDLE")
    controls = [by_name(hand, name).control for name in ("Foot", "Toes")]
    controls[1].location.z = 0.4
    scenes.press(hand.obj, "handle_mirror")
    assert handle_names(hand)[2:] == ["Toes.R", "Toes.L"]
    assert [by_name(hand, name).control for name in ("Toes.R", "Toes.L")] == controls
    assert controls[0].name == "Plate Toes.R"
    assert controls[0].location.z == pytest.approx(0.4, abs=1e-6)
    assert hand.deformer.status_level == "INFO"


def test_a_selection_that_became_a_handle_gets_the_names_of_both_sides(hand: scenes.Rig):
    """It is mirrored and not what was held still last: the control is active after Edit Mode, and its row."""
    with scenes.in_mode(hand.obj):
        for kind, chosen in (("HANDLE", low_corner(1.0)), ("FIXED", lambda point: point[1] > 0.9)):
            select(hand.obj, chosen)
            assert bpy.ops.sinew.handle_add(kind=kind) == {"FINISHED"}
    scenes.update()
    assert bpy.context.object == hand.deformer.handles[2].control
    mirror()
    assert handle_names(hand) == ["Hand.L", "Spine", "Handle L", "Still", "Handle R"]
    for index in (4, 3, 2):
        bpy.ops.sinew.handle_remove(index=index)
    assert set(hand.obj.vertex_groups.keys()) == {"Top", "Base", "Hand.L", "Spine"}
