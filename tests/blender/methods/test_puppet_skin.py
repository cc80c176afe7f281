# SPDX-License-Identifier: GPL-3.0-or-later
"""The skin of a puppet: bones as handles of a mesh, from vertex groups or by distance."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from inside import calls_of
from rigs import rig as scenes
from rigs.puppets import pose

LOOKS = ("rest_mesh", "rest_meshes", "_new_meshes", "group_weights")


def tube() -> bpy.types.Object:
    """Around the bones of ``arm``."""
    angles, heights = np.meshgrid(np.arange(12) * np.pi / 6.0, np.linspace(0.0, 2.0, 41))
    points = np.stack((0.08 * np.cos(angles), 0.08 * np.sin(angles), heights), -1)
    index = np.arange(angles.size).reshape(angles.shape)
    right = np.roll(index, -1, axis=1)
    faces = np.stack((index[:-1], right[:-1], right[1:], index[1:]), -1)
    obj = scenes.new_object("Sleeve", points.reshape(-1, 3).tolist(), faces.reshape(-1, 4).tolist())
    scenes.make_active(obj)
    return obj


def arm() -> bpy.types.Object:
    places = [(0.0, 0.0, float(k)) for k in range(3)]
    return scenes.armature_object("Arm", {"first": places[:2], "second": (*places[1:], "first")})


def rig(armature: bpy.types.Object, **keywords) -> None:
    assert bpy.ops.sinew.puppet_rig(armature=armature.name, **keywords) == {"FINISHED"}
    scenes.update()


def bones_of(obj: bpy.types.Object) -> list[str]:
    assert obj.sinew.active.status_level == "INFO", obj.sinew.active.status
    return [row.bone for row in obj.sinew.active.handles]


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


def test_bones_become_handles_and_the_skin_follows_also_keyed():
    armature, obj = arm(), tube()
    rig(armature)
    deformer, rest = obj.sinew.active, scenes.base_points(obj)
    assert deformer.method == "mesh_puppetry"
    assert [(row.bone, row.control) for row in deformer.handles] == [
        (name, armature) for name in ("first", "second")
    ]
    pose(armature, "second", (0.0, 0.0, 0.0), key=True)
    assert scenes.close(scenes.evaluated_points(obj), rest)
    bpy.context.scene.frame_set(20)
    pose(armature, "second", (0.9, 0.0, -0.8), key=True)
    shown = scenes.evaluated_points(obj)
    for name, here in (("first", rest[:, 2] <= 0.75 + 1e-6), ("second", rest[:, 2] >= 1.25 - 1e-6)):
        bone = armature.pose.bones[name]
        moved = scenes.apply_matrix(bone.matrix @ bone.bone.matrix_local.inverted(), rest[here])
        assert scenes.close(shown[here], moved, 2e-5), name
    assert np.abs(shown - rest).max() > 0.5
    for frame, shape in ((1, rest), (20, shown)):
        bpy.context.scene.frame_set(frame)
        assert scenes.close(scenes.evaluated_points(obj), shape, 2e-5)


def test_painted_groups_with_the_names_of_bones_are_used():
    armature, obj = arm(), tube()
    scenes.add_group(obj, "first", lambda point: point[2] < 0.8)
    scenes.add_group(obj, "second", lambda point: point[2] > 1.2)
    rig(armature)
    assert [row.vertex_group for row in obj.sinew.active.handles] == ["first", "second"]
    assert len(obj.vertex_groups) == 2
    rig(armature, automatic=True, margin=0.4)
    assert len(obj.vertex_groups) == 4


@pytest.mark.parametrize("active", ["Arm", "Sleeve"])
@pytest.mark.parametrize("mode", ["OBJECT", "POSE"])
def test_the_mesh_and_its_armature_are_selected_in_any_order(active: str, mode: str):
    """Another mesh that the armature moves already is not taken for the selected one."""
    armature, other = arm(), tube()
    other.name = "Other"
    rig(armature)
    obj = tube()
    scenes.make_active(bpy.data.objects[active], armature, obj)
    if mode == "POSE" and active == "Arm":
        bpy.ops.object.mode_set(mode="POSE")
    assert bpy.ops.sinew.puppet_rig() == {"FINISHED"}
    assert bones_of(obj) == ["first", "second"]
    assert len(other.sinew.deformers) == 1
    assert bpy.context.object.name == active
    armature.pose.bones["first"].location.y = 0.5
    assert scenes.close(scenes.evaluated_points(obj), scenes.base_points(obj) + (0.0, 0.0, 0.5), 2e-5)


def test_bones_with_empty_groups_are_left_out_and_counted(capfd: pytest.CaptureFixture):
    """Importers leave such groups behind. If all are empty, limbs are found by distance."""
    armature, obj = arm(), tube()
    scenes.add_group(obj, "first", lambda point: point[2] < 0.8)
    obj.vertex_groups.new(name="second").add([0, 1, 2], 0.0, "REPLACE")
    rig(armature)
    assert bones_of(obj) == ["first"]
    assert "1 bone, without 1 whose vertex group is empty" in capfd.readouterr().out
    obj.vertex_groups["first"].remove(range(len(obj.data.vertices)))
    rig(armature)
    assert bones_of(obj) == ["first", "second"]


def test_rigging_is_refused_without_a_trace():
    """Far away, no bone lies inside."""
    armature, obj = arm(), tube()
    armature.location.x = 10.0
    scenes.update()
    scenes.refused("No bone of Arm lies inside of Sleeve", "puppet_rig", armature=armature.name)
    assert not obj.sinew.deformers
    assert not obj.vertex_groups
    scenes.refused("There is no object 'Nobody'", "puppet_rig", armature="Nobody")
    scenes.refused("Select the mesh and one armature", "puppet_rig")
