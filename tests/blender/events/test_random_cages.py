# SPDX-License-Identifier: GPL-3.0-or-later
"""Random sequences of what an artist does with cages: always the warp that the properties ask for.

The oracle binds double weights anew after each step, from the rest cage stored in the file, and places the
cage by Blender's matrices.
"""

from __future__ import annotations

import bmesh
import bpy
import numpy as np
import pytest
from expected import faces_of
from hypothesis import strategies as st
from hypothesis.stateful import initialize, precondition, rule
from inside import native
from mathutils import Matrix
from rigs.rig import (
    apply_matrix,
    base_points,
    coordinates,
    evaluated_points,
    make_active,
    press,
    reopen,
)
from sequences import SEQUENCES, Sequence, run_sequences

STEPS = 30
TOLERANCE = 2e-5  # float32 weights and positions, of shapes of a few units

SMALL = st.integers(-4, 4).map(lambda number: number / 8)
VECTOR = st.tuples(SMALL, SMALL, SMALL)
PICK = st.integers(0, 5)
CLASSES = {"mean_value": "MeanValue", "green": "Green"}  # these take points anywhere


class Artist(Sequence):
    """Balls, and boxes around them. Picks are taken modulo what there is."""

    @property
    def targets(self) -> list[bpy.types.Object]:
        return [obj for obj in bpy.context.scene.objects if obj.name.startswith("Ball")]

    def caged(self, pick: int) -> tuple[bpy.types.Object, object] | None:
        found = [
            (obj, deformer)
            for obj in self.targets
            for deformer in obj.sinew.deformers
            if not deformer.cage_missing
        ]
        return found[pick % len(found)] if found else None

    def compare(self) -> None:
        for obj in self.targets:
            if obj.mode == "OBJECT":
                self.compare_one(obj)

    def compare_one(self, obj: bpy.types.Object) -> None:
        """Every deformer of the stack adds the motion of its cage to what enters it."""
        expected = base_points(obj).astype(np.float64)
        for deformer in obj.sinew.deformers:
            if deformer.cage_missing:
                return  # the last pose stays, whatever it was
            now = self.in_frame(deformer.cage, obj)
            held = deformer.cage_rest
            if len(now) != len(held.vertices):
                assert deformer.status_level == "ERROR"
                assert "vertices, at bind it had" in deformer.status
                continue
            assert deformer.status_level in ("INFO", "WARNING"), deformer.status
            rest = coordinates(deformer.rest.vertices)
            expected = expected + deformer.factor * (self.warp(deformer, rest, held, now) - rest)
        off = np.abs(evaluated_points(obj) - expected).max()
        assert off <= TOLERANCE * max(1.0, np.abs(expected).max()), f"{obj.name} is off by {off:.3g}"
        Artist.checked += 1

    def warp(self, deformer, points, held: bpy.types.Mesh, now: np.ndarray) -> np.ndarray:
        before = coordinates(held.vertices)
        weights = getattr(native(), CLASSES[deformer.method])(
            native().SurfaceMesh(before, faces_of(held)), precision="double"
        )
        weights.bind(points)
        return weights.warp(now)

    def in_frame(self, cage: bpy.types.Object, obj: bpy.types.Object) -> np.ndarray:
        return apply_matrix(obj.matrix_world.inverted() @ cage.matrix_world, evaluated_points(cage))

    # What an artist does

    @initialize()
    def begin(self):
        self.new_ball()
        self.put_box("mean_value", 1.8)
        self.start_over()

    def new_ball(self) -> None:
        bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=2, radius=0.6)
        bpy.context.object.name = "Ball"

    def put_box(self, method: str, size: float) -> None:
        target = bpy.context.object
        bpy.ops.mesh.primitive_cube_add(size=size, location=target.location)
        cage = bpy.context.object
        press(target, "cage_add", source="OBJECT", cage=cage.name, method=method)

    @precondition(lambda self: self.in_object_mode and self.targets)
    @rule(pick=PICK, method=st.sampled_from(sorted(CLASSES)), size=st.sampled_from((1.0, 1.5, 2.0)))
    def add_cage(self, pick, method, size):
        obj = self.targets[pick % len(self.targets)]
        if len(obj.sinew.deformers) < 2:
            make_active(obj)
            self.put_box(method, size)
            self.done()

    @precondition(lambda self: self.in_object_mode and len(self.targets) < 3)
    @rule(linked=st.booleans(), pick=PICK)
    def duplicate(self, linked, pick):
        """Both follow the cage."""
        make_active(self.targets[pick % len(self.targets)])
        bpy.ops.object.duplicate(linked=linked)
        self.done()

    @precondition(lambda self: self.caged(0))
    @rule(pick=PICK, by=VECTOR, turn=VECTOR, scale=st.sampled_from((0.5, 1.0, 1.5)))
    def move_cage(self, pick, by, turn, scale):
        cage = self.caged(pick)[1].cage
        cage.location, cage.rotation_euler, cage.scale = by, turn, (scale, 1.0, scale)
        self.done()

    @precondition(lambda self: self.targets)
    @rule(pick=PICK, by=VECTOR, turn=VECTOR, scale=st.sampled_from((0.5, 1.0, 1.5)))
    def move_target(self, pick, by, turn, scale):
        obj = self.targets[pick % len(self.targets)]
        obj.location, obj.rotation_euler, obj.scale = by, turn, (1.0, scale, 1.0)
        self.done()

    @precondition(lambda self: self.caged(0))
    @rule(pick=PICK, vertex=st.integers(0, 40), by=VECTOR)
    def move_vertex(self, pick, vertex, by):
        cage = self.caged(pick)[1].cage
        if cage.mode == "EDIT":
            edit = bmesh.from_edit_mesh(cage.data)
            edit.verts.ensure_lookup_table()
            edit.verts[vertex % len(edit.verts)].co += Matrix.Translation(by).translation
            bmesh.update_edit_mesh(cage.data)
        else:
            cage.data.vertices[vertex % len(cage.data.vertices)].co += Matrix.Translation(by).translation
            cage.data.update()
        self.done()

    @precondition(lambda self: self.caged(0) and self.in_object_mode)
    @rule(pick=PICK)
    def edit_cage(self, pick):
        cage = self.caged(pick)[1].cage
        make_active(cage)
        bpy.ops.object.mode_set(mode="EDIT")
        self.done()

    @precondition(lambda self: bpy.context.mode == "EDIT_MESH")
    @rule(subdivide=st.booleans())
    def leave_edit_mode(self, subdivide):
        if subdivide and len(bpy.context.object.data.vertices) < 30:
            bpy.ops.mesh.select_all(action="SELECT")
            bpy.ops.mesh.subdivide()
        bpy.ops.object.mode_set(mode="OBJECT")
        self.done()

    @precondition(lambda self: self.caged(0) and self.in_object_mode)
    @rule(pick=PICK)
    def set_rest(self, pick):
        obj, deformer = self.caged(pick)
        index = next(k for k, other in enumerate(obj.sinew.deformers) if other.uid == deformer.uid)
        obj.sinew.active_deformer = index
        press(obj, "cage_set_rest")
        deformer = obj.sinew.deformers[index]
        held = coordinates(deformer.cage_rest.vertices)
        assert np.abs(held - self.in_frame(deformer.cage, obj)).max() < TOLERANCE
        self.done()

    @precondition(lambda self: self.caged(0))
    @rule(pick=PICK, method=st.sampled_from(sorted(CLASSES)), factor=st.sampled_from((0.0, 0.5, 1.0)))
    def change_settings(self, pick, method, factor):
        _obj, deformer = self.caged(pick)
        deformer.method, deformer.factor = method, factor
        self.done()

    @precondition(lambda self: self.now > 8 and self.caged(0) and self.in_object_mode)
    @rule(pick=PICK)
    def delete_cage(self, pick):
        make_active(self.caged(pick)[1].cage)
        bpy.ops.object.delete()
        self.done()

    @precondition(lambda self: self.in_object_mode)
    @rule()
    def save_and_load(self):
        reopen(self.folder / "cages.blend")
        self.start_over()


@pytest.mark.slow
def test_random_sequences_with_cages():
    sequences = max(20, SEQUENCES // 5)  # the first ones are short
    run_sequences(Artist, sequences, STEPS)
    assert Artist.checked > 5 * sequences
