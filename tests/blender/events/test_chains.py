# SPDX-License-Identifier: GPL-3.0-or-later
"""Rigs that follow rigs: each is solved after those that it reads, in the same frame, wherever that is shown.

The oracle: whatever is evaluated again changes nothing, and a frame looks the same from wherever it is
reached. Where a control is followed, a solve by the library for where Blender has put that control.
"""

from collections.abc import Callable
from typing import NamedTuple

import bpy
import numpy as np
import pytest
from inside import calls_of
from mathutils import Matrix
from probe import render
from rigs import rig as scenes
from rigs.cages import ball, box, fine_box, surround
from rigs.kinds import HandleRig
from rigs.rig_of_lattice import lattice_object
from rigs.sheet import draw_panel

EXACT = 1e-6
MOVES = 0.05  # at least so far from the first frame to the last


class Chain(NamedTuple):
    """The control of one rig moves another one, ``follower``, through the shape of the first."""

    control: bpy.types.Object
    base: bpy.types.Object
    follower: bpy.types.Object


def new_base() -> HandleRig:
    return HandleRig.new("Middle").start("thin_shell")


def on_vertex(obj: bpy.types.Object, base: scenes.Rig, *vertices: int) -> bpy.types.Object:
    obj.parent, obj.parent_type = base.obj, "VERTEX" if len(vertices) == 1 else "VERTEX_3"
    obj.parent_vertices = [int(vertex) for vertex in (*vertices, 0, 0)[:3]]
    scenes.update()
    return obj


def constrain(owner: bpy.types.Object | bpy.types.PoseBone, kind: str, **settings: object) -> None:
    constraint = owner.constraints.new(kind)
    for name, value in settings.items():
        setattr(constraint, name, value)
    scenes.update()


def free(control: bpy.types.Object) -> bpy.types.Object:
    place = control.matrix_world.copy()
    control.parent = None
    control.matrix_world = place
    return control


# --- what a follower may hang on

CHAINS: dict[str, Callable[[str], Chain]] = {}


def hangs(bound: str = "before") -> Callable:
    """The decorated function hangs a follower on the base; it is bound before that, after it, or by it."""

    def add(hang: Callable[[HandleRig, HandleRig], None]) -> Callable:
        def make(name: str) -> Chain:
            base, follower = new_base(), HandleRig.new(name)
            if bound == "before":
                follower.start("thin_shell")
            hang(base, follower)
            if bound == "after":
                follower.bind("thin_shell")
            return Chain(base.control, base.obj, follower.obj)

        CHAINS[hang.__name__] = make
        return hang

    return add


def chain_of_its_own(make: Callable[[str], Chain]) -> Callable[[str], Chain]:
    CHAINS[make.__name__] = make
    return make


@hangs()
def its_control_on_a_vertex(base: HandleRig, follower: HandleRig) -> None:
    on_vertex(follower.control, base, base.top[0])


@hangs()
def its_control_on_three_vertices(base: HandleRig, follower: HandleRig) -> None:
    on_vertex(follower.control, base, 0, 60, 115)


@hangs()
def its_control_on_a_child_of_a_vertex(base: HandleRig, follower: HandleRig) -> None:
    free(follower.control).parent = on_vertex(scenes.new_empty("Between"), base, base.top[3])


@hangs()
def its_control_is_carried_by_a_control_that_rides(base: HandleRig, follower: HandleRig) -> None:
    """On a second deformer of the first rig, whose shape the first one moves."""
    scenes.add_group(base.obj, "Spot", lambda point: point[1] > 0.75 and abs(point[0]) < 0.5)
    base.press("deformer_add", method="thin_shell")
    base.press("handle_add", kind="HANDLE", vertex_group="Spot")
    control = base.obj.sinew.deformers[1].handles[0].control
    base.obj.sinew.active_deformer = 0
    free(follower.control).parent = control
    scenes.update()


@hangs()
def its_control_copies_a_group(base: HandleRig, follower: HandleRig) -> None:
    constrain(free(follower.control), "COPY_LOCATION", target=base.obj, subtarget="Top")


@hangs()
def its_control_sticks_to_the_surface(base: HandleRig, follower: HandleRig) -> None:
    constrain(free(follower.control), "SHRINKWRAP", target=base.obj)


@hangs()
def its_control_is_armature_constrained_to_a_bone(base: HandleRig, follower: HandleRig) -> None:
    armature = scenes.new_armature(button=((0.0, 1.0, 0.0), (0.0, 1.5, 0.0)))
    constrain(armature.pose.bones["button"], "COPY_LOCATION", target=base.obj, subtarget="Top")
    control = free(follower.control)
    constraint = control.constraints.new("ARMATURE")
    target = constraint.targets.new()
    target.target, target.subtarget = armature, "button"


@hangs(bound="by it")
def its_control_is_such_a_bone(base: HandleRig, follower: HandleRig) -> None:
    """A child of one that copies a group."""
    armature = scenes.new_armature(
        button=((0.0, 1.0, 0.0), (0.0, 1.5, 0.0)), tip=((0.0, 1.5, 0.0), (0.0, 2.0, 0.0), "button")
    )
    follower.bind("thin_shell")
    follower.deformer.handles[0].control, follower.deformer.handles[0].bone = armature, "tip"
    scenes.press(follower.obj, "bind")
    constrain(armature.pose.bones["button"], "COPY_LOCATION", target=base.obj, subtarget="Top")


@hangs()
def its_control_is_driven(base: HandleRig, follower: HandleRig) -> None:
    empty = on_vertex(scenes.new_empty("Between"), base, base.top[3])
    driver = follower.control.driver_add("location", 2).driver
    driver.type = "SUM"
    variable = driver.variables.new()
    variable.type = "TRANSFORMS"
    variable.targets[0].id, variable.targets[0].transform_type = empty, "LOC_Z"
    scenes.update()


@hangs()
def it_is_itself_on_a_vertex(base: HandleRig, follower: HandleRig) -> None:
    free(follower.control)
    on_vertex(follower.obj, base, base.top[3])


@hangs(bound="after")
def it_is_hooked_to_a_child_of_a_vertex(base: HandleRig, follower: HandleRig) -> None:
    scenes.add_group(follower.obj, "Hooked", lambda point: abs(point[1]) < 0.5)
    hook = follower.obj.modifiers.new("Hook", "HOOK")
    hook.object, hook.vertex_group = on_vertex(scenes.new_empty("Between"), base, base.top[3]), "Hooked"


@hangs(bound="after")
def it_is_wrapped_onto_the_base(base: HandleRig, follower: HandleRig) -> None:
    follower.obj.modifiers.new("Shrinkwrap", "SHRINKWRAP").target = base.obj


@hangs(bound="after")
def it_takes_weights_from_the_base(base: HandleRig, follower: HandleRig) -> None:
    """From what is nearest, for a displacement below us."""
    transfer = follower.obj.modifiers.new("Weights", "DATA_TRANSFER")
    transfer.object = base.obj
    transfer.use_vert_data, transfer.data_types_verts = True, {"VGROUP_WEIGHTS"}
    transfer.vert_mapping, transfer.layers_vgroup_select_src = "NEAREST", "ALL"
    displace = follower.obj.modifiers.new("Displace", "DISPLACE")
    displace.vertex_group, displace.mid_level, displace.strength = "Top", 0.0, 0.5


@hangs(bound="after")
def it_is_moved_by_nodes_that_ask_for_the_base(base: HandleRig, follower: HandleRig) -> None:
    """Below us: by the height of the first vertex of the base."""
    group, entry, leave = scenes.new_nodes("Follow")
    asked, box = group.nodes.new("GeometryNodeObjectInfo"), group.nodes.new("GeometryNodeBoundBox")
    moved = group.nodes.new("GeometryNodeSetPosition")
    asked.inputs["Object"].default_value = base.obj
    for start, end in (
        (entry, moved.inputs["Geometry"]),
        (asked.outputs["Geometry"], box.inputs["Geometry"]),
        (box.outputs["Max"], moved.inputs["Offset"]),
        (moved.outputs[0], leave),
    ):
        group.links.new(start, end)
    follower.obj.modifiers.new("Follow", "NODES").node_group = group


@chain_of_its_own
def its_cage_has_a_deformer(name: str) -> Chain:
    follower, cage = ball(name, 2), fine_box(2)
    base = scenes.Rig(cage).bind("thin_shell")
    surround(follower, cage)
    return Chain(base.control, base.obj, follower)


@chain_of_its_own
def its_cage_is_wrapped_onto_the_base(name: str) -> Chain:
    base, follower, cage = new_base(), ball(name, 2), fine_box(2)
    surround(follower, cage)
    cage.modifiers.new("Shrinkwrap", "SHRINKWRAP").target = base.obj
    scenes.update()
    return Chain(base.control, base.obj, follower)


@chain_of_its_own
def it_follows_a_follower(name: str) -> Chain:
    base, between, follower = new_base(), HandleRig.new("Kept between"), HandleRig.new(name)
    between.start("thin_shell")
    follower.start("thin_shell")
    on_vertex(between.control, base, base.top[0])
    on_vertex(follower.control, between, between.top[3])
    return Chain(base.control, base.obj, follower.obj)


def moved_lattice() -> tuple[bpy.types.Object, bpy.types.Object]:
    """A lattice with a deformer, around all that it carries, and the cage that moves it."""
    lattice, cage = lattice_object((3, 3, 3), "Middle"), box("Cage", 3.0)
    lattice.scale = 1.2, 1.2, 1.2
    scenes.update()
    surround(lattice, cage)
    return lattice, cage


@chain_of_its_own
def it_is_below_a_lattice_that_a_cage_moves(name: str) -> Chain:
    base, cage = moved_lattice()
    follower = HandleRig.new(name)
    follower.obj.modifiers.new("Lattice", "LATTICE").object = base
    follower.bind("thin_shell")
    return Chain(cage, base, follower.obj)


@chain_of_its_own
def its_lattice_has_a_deformer(name: str) -> Chain:
    base, cage = moved_lattice()
    follower = ball(name, 2)
    scenes.press(follower, "lattice_add", source="OBJECT", lattice=base.name)
    return Chain(cage, base, follower)


def owners() -> list[bpy.types.Object]:
    return [obj for obj in bpy.context.scene.objects if obj.is_property_set("sinew") and obj.sinew.deformers]


def again(obj: bpy.types.Object) -> np.ndarray:
    """What it shows once everything was evaluated again and again."""
    for _ in range(4):
        for other in owners():
            other.update_tag()
        scenes.update()
    return scenes.evaluated_points(obj)


def difference(one: np.ndarray, other: np.ndarray) -> float:
    return float(np.abs(one - other).max())


@pytest.fixture(params=["Before", "Zuletzt"])
def name(request: pytest.FixtureRequest) -> str:
    """The follower comes before the base in Blender's lists, or after it."""
    return request.param


@pytest.fixture(params=CHAINS)
def chain(request: pytest.FixtureRequest, name: str) -> Chain:
    """Its control rises by one from frame 1 to frame 11."""
    chain = CHAINS[request.param](name)
    scenes.key_heights(chain.control, {1: 0.0, 11: 1.0})
    return chain


def at(frame: float, obj: bpy.types.Object) -> np.ndarray:
    whole = int(frame)
    bpy.context.scene.frame_set(whole, subframe=frame - whole)
    return scenes.evaluated_points(obj)


def moves(chain: Chain, one: np.ndarray, other: np.ndarray) -> bool:
    """Its shape, or in the world, where the object itself goes along."""
    return max(difference(one, other), difference(np.array(chain.follower.matrix_world), np.eye(4))) > MOVES


def test_a_frame_is_right_from_wherever_it_is_reached(chain: Chain):
    """And a drag moves both at once."""
    at(11, chain.follower)
    shown = at(7, chain.follower)
    at(6, chain.follower)
    assert difference(at(7, chain.follower), shown) < EXACT
    assert difference(again(chain.follower), shown) < EXACT
    assert moves(chain, at(11, chain.follower), at(1, chain.follower))
    for height in (0.9, -0.3):
        before = scenes.evaluated_points(chain.follower)
        scenes.move_world(chain.control, Matrix.Translation((0.0, 0.0, height)))
        seen = scenes.evaluated_points(chain.follower)
        assert difference(again(chain.follower), seen) < EXACT
        assert height < 0.0 or moves(chain, seen, before)


def test_renders_show_what_the_viewport_shows(chain: Chain):
    """A picture, an animation, and the frames that motion blur asks for."""
    scene = bpy.context.scene
    expected = {frame: at(frame, chain.follower) for frame in (3, 6, 9, 9.25, 9.75)}
    at(6, chain.follower)
    assert difference(render()[-1][chain.follower.name], expected[6]) < EXACT
    scene.frame_start, scene.frame_end, scene.frame_step = 3, 9, 3
    for frame, seen in zip((3, 6, 9), render(animation=True), strict=True):
        assert difference(seen[chain.follower.name], expected[frame]) < EXACT
    at(9, chain.follower)
    for subframe, seen in zip((0.75, 0.25), render(subframes=(0.75, 0.25)), strict=True):
        assert difference(seen[chain.follower.name], expected[9 + subframe]) < EXACT


FOLLOWED = ("on_a_vertex", "copies_a_group", "sticks_to_the_surface")


@pytest.mark.parametrize("row", [*(f"its_control_{how}" for how in FOLLOWED), "it_follows_a_follower"])
def test_a_follower_is_solved_for_where_its_control_is(row: str, name: str):
    """By the library, on Blender's own mesh, vertex groups and matrices."""
    follower = HandleRig.new("Model").start("thin_shell")
    poses, obj = follower.poses, follower.obj
    bpy.data.objects.remove(follower.control)
    bpy.data.objects.remove(obj)
    chain = CHAINS[row](name)
    scenes.key_heights(chain.control, {1: 0.0, 11: 1.0})
    for frame in (11, 7, 2):
        shown = at(frame, chain.follower)
        control = HandleRig.control_of(chain.follower)
        assert scenes.close(shown, poses.now(chain.follower, control), scenes.MATRIX)
        assert difference(scenes.evaluated_points(chain.follower), shown) == 0.0


def test_a_parent_given_by_a_script_counts_in_the_next_frame():
    """Nothing is evaluated between."""
    base, follower = new_base(), HandleRig.new("Before").start("thin_shell")
    scenes.key_heights(base.control, {1: 0.0, 11: 1.0})
    at(11, follower.obj)
    follower.control.parent_vertices = (int(base.top[0]), 0, 0)
    for frame, parent, kind in ((7, base.obj, "VERTEX"), (5, None, "OBJECT")):
        follower.control.parent, follower.control.parent_type = parent, kind
        shown = at(frame, follower.obj)
        assert difference(again(follower.obj), shown) < EXACT


def test_relations_that_name_nothing_are_followed_nowhere(posed_plate: HandleRig):
    """Objects, bones, groups and nodes that do not exist, or no longer."""
    follower = HandleRig.new("Before").start("thin_shell")
    armature = scenes.new_armature(only=((0.0, 0.0, 0.0), (0.0, 1.0, 0.0)))
    scenes.make_active(follower.obj)
    for kind in ("HOOK", "SHRINKWRAP", "ARMATURE", "NODES", "BOOLEAN"):
        follower.obj.modifiers.new(kind, kind)
        bpy.ops.object.modifier_move_to_index(modifier=kind, index=0)
    hook = follower.obj.modifiers["HOOK"]
    hook.object, hook.subtarget = armature, "gone"
    for kind in ("COPY_LOCATION", "ARMATURE", "SHRINKWRAP", "CHILD_OF"):
        follower.control.constraints.new(kind)
    constrain(follower.control, "COPY_LOCATION", target=armature, subtarget="gone")
    driver = follower.control.driver_add("scale", 0).driver
    driver.type = "SUM"
    driver.variables.new().type = "TRANSFORMS"
    for hooked in (armature, None):
        hook.object = hooked
        posed_plate.lift(0.1)
        assert posed_plate.is_right()
        assert "follow" not in told(follower)


# --- what it costs


def frame_cost(frame: int) -> dict[str, int]:
    for warm in (1, 11, 3):
        bpy.context.scene.frame_set(warm)
    return calls_of(lambda: bpy.context.scene.frame_set(frame))


def test_each_rig_of_a_chain_is_solved_once_per_frame():
    """Blender evaluates once more in between, and once at the end, as ever."""
    chain = CHAINS["it_follows_a_follower"]("Before")
    scenes.key_heights(chain.control, {1: 0.0, 11: 1.0})
    found = frame_cost(8)
    assert found["_answer"] == found["write_shape"] == 3, found
    assert found["evaluate"] == 3, found  # the first one finds nothing to do
    found = calls_of(lambda: bpy.context.scene.frame_set(8))
    assert not found["_answer"] + found["write_shape"], found
    assert found["evaluate"] <= 1, found  # from Blender 4.2 on, the same frame is evaluated anew


def test_rigs_that_read_no_other_are_evaluated_as_before():
    """Each control is read once, and Blender is asked for nothing."""
    rigs = [HandleRig.new(name).start("thin_shell") for name in ("One", "Two", "Three")]
    for rig in rigs:
        scenes.key_heights(rig.control, {1: 0.0, 11: 1.0})
    found = frame_cost(8)
    assert found["write_shape"] == len(rigs), found
    assert found["read_place"] == len(rigs) * found["on_frame_change"], found
    assert "evaluate" not in found, found
    other = scenes.new_empty("Other")
    found = [calls_of(lambda: scenes.move_world(other, Matrix.Translation((0.1, 0, 0)))) for _ in range(2)]
    assert "reads" not in found[1]


def test_a_single_rig_follows_no_relations(posed_plate: HandleRig):
    for action in (lambda: posed_plate.lift(0.1), lambda: bpy.context.scene.frame_set(3)):
        assert not {"steps", "reads", "evaluate"} & calls_of(action).keys()


def test_each_constraint_and_driver_of_an_armature_is_read_once_per_evaluation():
    """However many handles hang on its bones."""
    count = 24
    rigs = [HandleRig.new(name).start("thin_shell") for name in ("One", "Two")]
    armature = scenes.new_armature(**{f"b{i}": ((0.0, i, 0.0), (0.0, i + 1.0, 0.0)) for i in range(count)})
    for bone in armature.pose.bones:
        bone.constraints.new("COPY_LOCATION").target = rigs[1].control
        variable = bone.driver_add("scale", 0).driver.variables.new()
        variable.type = "TRANSFORMS"
        variable.targets[0].id = rigs[1].control
    for number in range(6):
        handle = rigs[0].deformer.handles.add()
        handle.control, handle.bone = armature, f"b{number * 3}"
    scenes.update()
    found = calls_of(lambda: rigs[1].lift(0.1))
    rounds = found["steps"]
    assert found["_constraint"] // count == found["_variables"] // count == 2 * rounds, found


# --- circles


def told(rig: scenes.Rig) -> str:
    scenes.make_active(rig.obj)
    return draw_panel().texts()


def one_and_two() -> tuple[HandleRig, HandleRig]:
    return HandleRig.new("One").start("thin_shell"), HandleRig.new("Two").start("thin_shell")


def test_rigs_in_a_circle_are_named_and_end(capfd: pytest.CaptureFixture):
    """Each follows the other: there is no right shape, and none of them hangs."""
    one, two = one_and_two()
    on_vertex(two.control, one, one.top[0])
    assert "follow each other" not in told(two)
    on_vertex(one.control, two, 60)
    found = calls_of(lambda: bpy.context.scene.frame_set(3))
    assert found["_answer"] <= 2 * 8, found
    for rig in (one, two):
        assert "One and Two follow each other in a circle" in told(rig)
    one.control.parent = None
    assert "follow each other" not in told(two)
    shown = at(4, two.obj)
    assert difference(again(two.obj), shown) < EXACT
    capfd.readouterr()  # Blender may name the circle, too


def test_a_rig_that_follows_itself_is_named(capfd: pytest.CaptureFixture):
    plate = HandleRig.new().start("thin_shell")
    assert "follows its own shape" not in told(plate)
    on_vertex(plate.control, plate, 60)
    assert "Plate follows its own shape" in told(plate)
    capfd.readouterr()


def test_a_control_that_rides_along_with_its_own_target_is_no_circle():
    """Nor are two rigs of which each carries the other's control as an object, not by its shape."""
    one, two = one_and_two()
    one.control.parent, two.control.parent = two.obj, one.obj
    assert not any("follow" in told(rig) for rig in (one, two))
    assert "evaluate" not in calls_of(lambda: two.lift(0.2))
