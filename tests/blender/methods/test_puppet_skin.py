# SPDX-License-Identifier: GPL-3.0-or-later
"""The skin of a puppet: bones as handles of a mesh, from vertex groups or by distance."""

from __future__ import annotations

import math

import bpy
import numpy as np
import pytest
from inside import calls_of
from rigs.puppets import pose
from rigs.rig import (
    armature_object,
    base_points,
    close,
    evaluated_points,
    make_active,
    new_object,
    refused,
    update,
)

LOOKS = ("rest_mesh", "rest_meshes", "_new_meshes", "group_weights")


def tube(radius: float = 0.08, rings: int = 40, sides: int = 12) -> bpy.types.Object:
    """A tube around the bones of ``arm``."""
    points, faces = [], []
    for ring in range(rings + 1):
        for side in range(sides):
            angle = 2 * math.pi * side / sides
            points.append((radius * math.cos(angle), radius * math.sin(angle), 2.0 * ring / rings))
    for ring in range(rings):
        for side in range(sides):
            a, b = ring * sides + side, ring * sides + (side + 1) % sides
            faces.append((a, b, b + sides, a + sides))
    obj = new_object("Sleeve", points, faces)
    make_active(obj)
    return obj


def arm() -> bpy.types.Object:
    places = [(0.0, 0.0, float(k)) for k in range(3)]
    return armature_object("Arm", {"first": places[:2], "second": (*places[1:], "first")})


def rigged(**keywords) -> tuple[bpy.types.Object, bpy.types.Object]:
    armature, obj = arm(), tube()
    assert bpy.ops.sinew.puppet_rig(armature=armature.name, **keywords) == {"FINISHED"}
    update()
    return obj, armature


def test_the_mesh_is_looked_at_as_often_for_two_bones_as_for_one():
    """Each look evaluates the scene, which took most of the time."""
    counts = []
    for deforming in ("first", "second"), ("first",):
        armature, obj = arm(), tube()
        for bone in armature.data.bones:
            bone.use_deform = bone.name in deforming
            obj.vertex_groups.new(name=bone.name).add([0, 1], 1.0, "REPLACE")
        found = calls_of(lambda name=armature.name: bpy.ops.sinew.puppet_rig(armature=name))
        assert len(obj.sinew.active.handles) == len(deforming)
        counts.append([found[name] for name in LOOKS])
    assert counts[0] == counts[1]
    assert any(counts[0])


def test_bones_become_handles_and_the_skin_follows():
    obj, armature = rigged()
    deformer = obj.sinew.active
    assert deformer.method == "mesh_puppetry"
    assert [(row.bone, row.control) for row in deformer.handles] == [
        ("first", armature),
        ("second", armature),
    ]
    rest = base_points(obj)
    assert close(evaluated_points(obj), rest)
    pose(armature, "second", (0.9, 0.0, -0.8))
    shown = evaluated_points(obj)
    for name, here in (("first", rest[:, 2] <= 0.75 + 1e-6), ("second", rest[:, 2] >= 1.25 - 1e-6)):
        bone = armature.pose.bones[name]
        matrix = np.array(bone.matrix @ bone.bone.matrix_local.inverted())
        moved = rest[here] @ matrix[:3, :3].T + matrix[:3, 3]
        assert close(shown[here], moved, 2e-5), name
    assert np.abs(shown - rest).max() > 0.5


def test_painted_groups_with_the_names_of_bones_are_used():
    armature, obj = arm(), tube()
    for name, inside in (("first", lambda z: z < 0.8), ("second", lambda z: z > 1.2)):
        group = obj.vertex_groups.new(name=name)
        group.add([vertex.index for vertex in obj.data.vertices if inside(vertex.co.z)], 1.0, "REPLACE")
    bpy.ops.sinew.puppet_rig(armature=armature.name)
    assert [row.vertex_group for row in obj.sinew.active.handles] == ["first", "second"]
    assert len(obj.vertex_groups) == 2
    bpy.ops.sinew.puppet_rig(armature=armature.name, automatic=True, margin=0.4)
    assert len(obj.vertex_groups) == 4


def group_with(obj: bpy.types.Object, name: str, inside) -> None:
    group = obj.vertex_groups.new(name=name)
    group.add([vertex.index for vertex in obj.data.vertices if inside(vertex.co.z)], 1.0, "REPLACE")


@pytest.mark.parametrize("active", ["Arm", "Sleeve"])
@pytest.mark.parametrize("mode", ["OBJECT", "POSE"])
def test_the_mesh_and_its_armature_are_selected_in_any_order(active: str, mode: str):
    """Another mesh that the armature moves already is not taken for the selected one."""
    armature, other = arm(), tube()
    other.name = "Other"
    bpy.ops.sinew.puppet_rig(armature=armature.name)
    obj = tube()
    make_active(bpy.data.objects[active], armature, obj)
    if mode == "POSE" and active == "Arm":
        bpy.ops.object.mode_set(mode="POSE")
    assert bpy.ops.sinew.puppet_rig() == {"FINISHED"}
    assert [row.bone for row in obj.sinew.active.handles] == ["first", "second"]
    assert len(other.sinew.deformers) == 1
    assert bpy.context.object.name == active
    rest = base_points(obj)
    armature.pose.bones["first"].location.y = 0.5
    assert close(evaluated_points(obj), rest + (0.0, 0.0, 0.5), 2e-5)


def test_bones_with_empty_groups_are_left_out_and_counted(capfd: pytest.CaptureFixture):
    """Importers leave such groups behind. If all are empty, limbs are found by distance."""
    armature, obj = arm(), tube()
    group_with(obj, "first", lambda z: z < 0.8)
    obj.vertex_groups.new(name="second")
    weightless = obj.vertex_groups["second"]
    weightless.add([0, 1, 2], 0.0, "REPLACE")
    assert bpy.ops.sinew.puppet_rig(armature=armature.name) == {"FINISHED"}
    assert [row.bone for row in obj.sinew.active.handles] == ["first"]
    assert obj.sinew.active.status_level == "INFO", obj.sinew.active.status
    assert "1 bone, without 1 whose vertex group is empty" in capfd.readouterr().out
    obj.vertex_groups["first"].remove(range(len(obj.data.vertices)))
    assert bpy.ops.sinew.puppet_rig(armature=armature.name) == {"FINISHED"}
    assert [row.bone for row in obj.sinew.active.handles] == ["first", "second"]
    assert obj.sinew.active.status_level == "INFO", obj.sinew.active.status


def test_a_keyed_pose_plays_with_its_skin():
    obj, armature = rigged()
    pose(armature, "second", (0.0, 0.0, 0.0), key=True)
    straight = evaluated_points(obj)
    bpy.context.scene.frame_set(20)
    pose(armature, "second", (0.9, 0.0, -0.8), key=True)
    bent_shape = evaluated_points(obj)
    for frame, shape in ((1, straight), (20, bent_shape), (1, straight)):
        bpy.context.scene.frame_set(frame)
        assert close(evaluated_points(obj), shape, 2e-5)


def test_rigging_is_refused_without_a_trace():
    armature, obj = arm(), tube()
    armature.location.x = 10.0
    update()
    # Far away, no bone lies inside.
    refused("No bone of Arm lies inside of Sleeve", "puppet_rig", armature=armature.name)
    assert not obj.sinew.deformers
    assert not obj.vertex_groups
    refused("There is no object 'Nobody'", "puppet_rig", armature="Nobody")
    refused("Select the mesh and one armature", "puppet_rig")
