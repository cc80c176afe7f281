# SPDX-License-Identifier: GPL-3.0-or-later
"""Random sequences of what an artist does: the shape is always the one that the properties ask for.

A failure ends with the shortest sequence found, as Python: the calls of ``Artist``.
"""

from __future__ import annotations

import os

import bmesh
import bpy
import numpy as np
from expected import in_frame
from hypothesis import strategies as st
from hypothesis.stateful import initialize, precondition, rule
from inside import catch_up, native
from mathutils import Euler, Matrix, Vector
from oracle import Oracle, Unsure
from registry import WITH_HANDLES
from rigs.rig import (
    apply_matrix,
    close,
    coordinates,
    evaluated_points,
    load,
    make_active,
    new_empty,
    press,
    save,
    update,
)
from rigs.targets import GROUPS, SETTINGS, SHAPES, new_target
from sequences import SEQUENCES, Sequence, run_sequences

STEPS = int(os.environ.get("SINEW_RANDOM_STEPS", "50"))

PICK = st.integers(0, 5)
METHODS = st.sampled_from(WITH_HANDLES)
SMALL = st.integers(-4, 4).map(lambda number: number / 4)
VECTOR = st.tuples(SMALL, SMALL, SMALL)
SHARE = st.sampled_from((0.0, 0.25, 0.5, 1.0))
CAGED = ("green", "mean_value")  # these take points anywhere
SIZE = st.sampled_from((0.5, 1.0, 1.5))
FOUND = {"deformer": 1, "handle": 2}  # which of the answers of a look-up


def setting(of: str, name: str, values: st.SearchStrategy, solved: bool = True):
    """The rule by which a property of a deformer or of a handle takes one of these values."""

    def change(self, pick, value):
        setattr(getattr(self, of)(pick)[FOUND[of]], name, value)
        self.done(solved=solved)

    change.__name__ = f"set_{name}"
    return precondition(lambda self: getattr(self, of)(0))(rule(pick=PICK, value=values)(change))


class Artist(Sequence):
    """Picks are taken modulo what there is."""

    unsure = warped = 0  # shapes that nobody can tell, and those that a cage moves

    def __init__(self) -> None:
        super().__init__()
        self.oracle = Oracle(native())
        self.memory = self.oracle.last
        self.saved: list[str] = []
        self.posed: set[str] = set()  # targets that show a solution, and were compared

    # What there is

    @property
    def targets(self) -> list[bpy.types.Object]:
        """But no cages."""
        return [obj for obj in bpy.context.scene.objects if obj.type == "MESH" and "cage" not in obj]

    def target(self, pick: int) -> bpy.types.Object | None:
        return self.targets[pick % len(self.targets)] if self.targets else None

    def deformer(self, pick: int) -> tuple[bpy.types.Object, object] | None:
        found = [(obj, index) for obj in self.targets for index in range(len(obj.sinew.deformers))]
        if not found:
            return None
        obj, index = found[pick % len(found)]
        obj.sinew.active_deformer = index
        return obj, obj.sinew.deformers[index]

    def handle(self, pick: int, kind: str = "") -> tuple | None:
        found = [
            (obj, deformer, handle, number)
            for obj in self.targets
            for deformer in obj.sinew.deformers
            for number, handle in enumerate(deformer.handles)
            if kind in ("", handle.kind)
        ]
        return found[pick % len(found)] if found else None

    def control(self, pick: int) -> bpy.types.Object | None:
        """A cage, or what a handle follows."""
        controls = {
            control.name
            for obj in self.targets
            for deformer in obj.sinew.deformers
            for control in (deformer.cage, *(handle.control for handle in deformer.handles))
            if control is not None and control.users_scene
        }
        return bpy.data.objects[sorted(controls)[pick % len(controls)]] if controls else None

    def caged(self, pick: int) -> tuple[bpy.types.Object, object] | None:
        found = [(obj, row) for obj in self.targets for row in obj.sinew.deformers if not row.cage_missing]
        found = [(obj, row) for obj, row in found if row.cage is not None]
        return found[pick % len(found)] if found else None

    @property
    def edits_a_target(self) -> bool:
        return bpy.context.mode == "EDIT_MESH" and bpy.context.object in self.targets

    # How a step ends

    def call(self, operator, **keywords) -> bool:
        """An operator, as a button: it may refuse in words, never with a traceback."""
        try:
            return operator(**keywords) == {"FINISHED"}
        except RuntimeError as refusal:
            words = str(refusal)
        assert "Traceback" not in words, words
        return False

    def compare(self) -> None:
        depsgraph = bpy.context.evaluated_depsgraph_get()
        self.posed = set()
        for obj in self.targets:
            if obj.mode == "SCULPT" or obj.data.is_editmode:
                self.oracle.skip_poses(obj)  # there Blender shows other meshes, or omits some modifiers
                continue
            if not obj.sinew.deformers:
                continue
            try:
                expected = self.oracle.expected(obj, depsgraph)
            except Unsure:
                Artist.unsure += 1
                continue
            Artist.checked += 1
            if expected.shown:
                self.posed.add(obj.name)
            shown = evaluated_points(obj)
            assert shown.shape == expected.points.shape, f"{obj.name}: {len(shown)} vertices"
            off = np.abs(shown - expected.points).max()
            assert off <= expected.tolerance, (
                f"{obj.name} is off by {off:.3g}, more than {expected.tolerance:.3g}; "
                f"refused {expected.refused}, shown {expected.shown}, "
                f"status {[deformer.status for deformer in obj.sinew.deformers]}"
            )
            for deformer in obj.sinew.deformers:
                if deformer.uid in expected.refused:
                    assert deformer.status_level == "ERROR", (expected.refused, deformer.status)
                elif deformer.uid in expected.shown:
                    Artist.warped += deformer.cage is not None
                    allowed = {"INFO"} if deformer.cage is None else {"INFO", "WARNING"}
                    assert deformer.status_level in allowed, deformer.status

    # What an artist does

    @initialize(shape=st.sampled_from(sorted(SHAPES)), method=METHODS, caged=st.sampled_from(("", *CAGED)))
    def begin(self, shape, method, caged):
        new_target(shape)
        bpy.ops.sinew.deformer_add(method=method)
        bpy.ops.sinew.handle_add(kind="HANDLE", vertex_group="Far")
        press(bpy.data.objects[shape], "handle_add", kind="FIXED", vertex_group="Near")
        if caged:
            self.put_into_a_cage(bpy.data.objects[shape], caged, 2.3)
        self.start_over()

    @precondition(lambda self: self.in_object_mode and len(self.targets) < 3)
    @rule(shape=st.sampled_from(sorted(SHAPES)))
    def add_target(self, shape):
        new_target(shape)
        self.done()

    @precondition(lambda self: self.in_object_mode and self.targets)
    @rule(pick=PICK, method=METHODS)
    def add_deformer(self, pick, method):
        obj = self.target(pick)
        if len(obj.sinew.deformers) < 3:
            make_active(obj)
            self.call(bpy.ops.sinew.deformer_add, method=method)
            self.done()

    @precondition(lambda self: self.deformer(0))
    @rule(pick=PICK)
    def remove_deformer(self, pick):
        obj, _deformer = self.deformer(pick)
        self.activate(obj)
        self.oracle.forget_missing([obj])  # if this is undone
        self.call(bpy.ops.sinew.deformer_remove)
        self.done()

    def activate(self, obj: bpy.types.Object) -> None:
        if self.in_object_mode:
            make_active(obj)

    @precondition(lambda self: self.deformer(0))
    @rule(pick=PICK, kind=st.sampled_from(("HANDLE", "FIXED", "SUPPORT")), group=st.sampled_from(GROUPS))
    def add_handle(self, pick, kind, group):
        obj, deformer = self.deformer(pick)
        if len(deformer.handles) < 5 and deformer.cage_rest is None:
            self.activate(obj)
            self.call(bpy.ops.sinew.handle_add, kind=kind, vertex_group=group)
            self.done()

    @precondition(lambda self: self.edits_a_target)
    @rule(vertex=st.integers(0, 40), kind=st.sampled_from(("HANDLE", "FIXED", "SUPPORT")))
    def add_handle_of_a_selection(self, vertex, kind):
        edit = bmesh.from_edit_mesh(bpy.context.object.data)
        edit.verts.ensure_lookup_table()
        for other in edit.verts:
            other.select = False
        if edit.verts:
            edit.verts[vertex % len(edit.verts)].select = True
        edit.select_flush(True)
        self.call(bpy.ops.sinew.handle_add, kind=kind)
        self.done()

    @precondition(lambda self: self.deformer(0))
    @rule(pick=PICK, index=st.integers(0, 3))
    def remove_handle(self, pick, index):
        obj, _deformer = self.deformer(pick)
        self.activate(obj)
        self.call(bpy.ops.sinew.handle_remove, index=index)
        self.done()

    @precondition(lambda self: self.control(0))
    @rule(pick=PICK, by=VECTOR)
    def move_control(self, pick, by):
        control = self.control(pick)
        control.matrix_world = Matrix.Translation(by) @ control.matrix_world
        self.done(solved=False)

    @precondition(lambda self: self.control(0))
    @rule(pick=PICK, by=VECTOR, size=st.tuples(SIZE, SIZE, SIZE))
    def turn_control(self, pick, by, size):
        control = self.control(pick)
        control.matrix_basis = control.matrix_basis @ Euler(by).to_matrix().to_4x4()
        control.scale = size
        self.done(solved=False)

    @precondition(lambda self: self.in_object_mode and self.targets)
    @rule(pick=PICK, method=st.sampled_from(CAGED), size=st.sampled_from((1.1, 1.7, 2.3)))
    def add_cage(self, pick, method, size):
        if len(self.target(pick).sinew.deformers) < 3:
            self.put_into_a_cage(self.target(pick), method, size)
            self.done()

    def put_into_a_cage(self, obj: bpy.types.Object, method: str, size: float) -> None:
        bpy.ops.mesh.primitive_cube_add(size=size, location=obj.location)
        cage = bpy.context.object
        cage["cage"] = True
        press(obj, "cage_add", source="OBJECT", cage=cage.name, method=method)

    @precondition(lambda self: self.caged(0) and self.in_object_mode)
    @rule(pick=PICK, vertex=st.integers(0, 40), by=VECTOR, subdivide=st.booleans(), leave=st.booleans())
    def edit_cage(self, pick, vertex, by, subdivide, leave):
        """In Edit Mode, which may stay."""
        cage = self.caged(pick)[1].cage
        if cage.hide_viewport:
            return
        make_active(cage)
        bpy.ops.object.mode_set(mode="EDIT")
        edit = bmesh.from_edit_mesh(cage.data)
        edit.verts.ensure_lookup_table()
        edit.verts[vertex % len(edit.verts)].co += 0.5 * Vector(by)
        if subdivide and len(edit.verts) < 30:
            bmesh.ops.subdivide_edges(edit, edges=edit.edges, cuts=1, use_grid_fill=True)
        bmesh.update_edit_mesh(cage.data)
        if leave:
            bpy.ops.object.mode_set(mode="OBJECT")
        self.done()

    @precondition(lambda self: bpy.context.mode == "EDIT_MESH")
    @rule()
    def leave_edit_mode(self):
        bpy.ops.object.mode_set(mode="OBJECT")
        self.done()

    @precondition(lambda self: self.caged(0) and self.in_object_mode)
    @rule(pick=PICK)
    def set_rest(self, pick):
        obj, deformer = self.caged(pick)
        obj.sinew.active_deformer = obj.sinew.deformers.values().index(deformer)
        press(obj, "cage_set_rest")
        deformer = obj.sinew.active
        now = apply_matrix(in_frame(obj, deformer.cage), evaluated_points(deformer.cage))
        assert close(coordinates(deformer.cage_rest.vertices), now, 2e-5)
        self.done()

    @precondition(lambda self: self.targets)
    @rule(pick=PICK, by=VECTOR, turn=VECTOR, scale=st.sampled_from((0.5, 1.0, 2.0)))
    def move_target(self, pick, by, turn, scale):
        obj = self.target(pick)
        obj.location, obj.rotation_euler, obj.scale = by, turn, (scale, 1.0, scale)
        self.done()

    @precondition(lambda self: self.in_object_mode and self.control(0))
    @rule(pick=PICK)
    def delete_control(self, pick):
        make_active(self.control(pick))
        self.call(bpy.ops.object.delete)
        self.done()

    @precondition(lambda self: self.control(0))
    @rule(pick=PICK)
    def purge_control(self, pick):
        bpy.data.objects.remove(self.control(pick))
        self.done()

    @precondition(lambda self: self.in_object_mode and len(self.targets) > 1)
    @rule(pick=PICK)
    def delete_target(self, pick):
        make_active(self.target(pick))
        self.call(bpy.ops.object.delete)
        self.done()

    @precondition(lambda self: self.in_object_mode and self.targets and len(self.targets) < 3)
    @rule(pick=PICK, linked=st.booleans())
    def duplicate(self, pick, linked):
        """Original and copy go on from the same shape, each by a key of its own."""
        name = self.target(pick).name
        before = evaluated_points(bpy.data.objects[name])
        make_active(bpy.data.objects[name])
        if not self.call(bpy.ops.object.duplicate, linked=linked):
            return
        twins = (bpy.data.objects[name], bpy.context.object)
        catch_up()
        if not self.oracle.forget_missing(twins):
            for twin in twins:
                assert np.abs(evaluated_points(twin) - before).max() <= 1e-4 * max(1.0, np.abs(before).max())
        used = [deformer.uid for twin in twins for deformer in twin.sinew.deformers]
        assert len(set(used)) == len(used)
        self.done()

    @precondition(lambda self: self.handle(0, "HANDLE"))
    @rule(pick=PICK, other=PICK)
    def exchange_control(self, pick, other):
        """Nothing jumps."""
        obj, _deformer, handle, _number = self.handle(pick, "HANDLE")
        new = self.control(other)
        if new is None:
            new = new_empty("New")
            new.location = (1.0, 2.0, 3.0)
            update()
        before = evaluated_points(obj)
        handle.control = new
        self.done()
        if obj.name in self.posed:
            assert np.abs(evaluated_points(obj) - before).max() <= 1e-3 * max(1.0, np.abs(before).max())

    @precondition(lambda self: self.targets)
    @rule(pick=PICK, what=st.sampled_from(("object", "control", "modifier", "deformer", "group")))
    def rename(self, pick, what):
        obj = self.target(pick)
        if what == "object":
            obj.name = "Renamed"
        elif what == "control" and self.control(pick):
            self.control(pick).name = "Renamed Control"
        elif what == "modifier" and obj.modifiers:
            obj.modifiers[pick % len(obj.modifiers)].name = "Renamed Modifier"
        elif what == "deformer" and obj.sinew.deformers:
            obj.sinew.deformers[0].name = "Renamed Deformer"
        self.done()

    @precondition(lambda self: self.deformer(0))
    @rule(pick=PICK, method=METHODS, caged=st.sampled_from(CAGED))
    def set_method(self, pick, method, caged):
        deformer = self.deformer(pick)[1]
        deformer.method = method if deformer.cage_rest is None else caged
        self.done()

    @precondition(lambda self: self.deformer(0))
    @rule(pick=PICK, setting=st.sampled_from(SETTINGS))
    def set_parameter(self, pick, setting):
        group, name, value = setting
        setattr(getattr(self.deformer(pick)[1], group), name, value)
        self.done()

    set_factor = setting("deformer", "factor", SHARE, solved=False)
    set_mask = setting("deformer", "mask_group", st.sampled_from((*GROUPS, "", "Nowhere")))
    set_automatic_rebind = setting("deformer", "auto_rebind", st.booleans())
    set_weight = setting("handle", "weight", SHARE)
    set_continuity = setting("handle", "continuity", st.sampled_from((0.0, 0.5, 1.0, 1.5, 2.0)))
    set_group = setting("handle", "vertex_group", st.sampled_from((*GROUPS, "Nowhere")))

    @precondition(lambda self: self.handle(0))
    @rule(pick=PICK, name=st.sampled_from(("enabled", "from_rest")))
    def toggle(self, pick, name):
        handle = self.handle(pick)[2]
        setattr(handle, name, not getattr(handle, name))
        self.done()

    @precondition(lambda self: self.deformer(0))
    @rule(pick=PICK)
    def bind(self, pick):
        self.activate(self.deformer(pick)[0])
        self.call(bpy.ops.sinew.bind)
        self.done()

    @precondition(lambda self: self.deformer(0))
    @rule(pick=PICK)
    def unbind(self, pick):
        obj, deformer = self.deformer(pick)
        key = deformer.uid
        self.activate(obj)
        if self.call(bpy.ops.sinew.unbind):
            self.oracle.forget_missing([obj])
            for pair in [pair for pair in self.oracle.last if pair[0] == key]:
                del self.oracle.last[pair]
        self.done()

    @precondition(lambda self: len(self.saved) < 3)
    @rule()
    def save(self):
        path = self.folder / f"{len(self.saved)}.blend"
        self.saved.append(save(path, check_existing=False))
        self.done()

    @precondition(lambda self: self.saved)
    @rule(pick=PICK)
    def load(self, pick):
        load(self.saved[pick % len(self.saved)])
        self.oracle.last.clear()
        self.oracle.forget_missing(bpy.data.objects)
        self.start_over()

    @precondition(lambda self: self.control(0))
    @rule(pick=PICK, frame=st.integers(1, 5), to=VECTOR)
    def key_control(self, pick, frame, to):
        control = self.control(pick)
        control.location = to
        control.keyframe_insert("location", frame=frame)
        self.done()

    @rule(frame=st.integers(1, 5))
    def go_to_frame(self, frame):
        bpy.context.scene.frame_set(frame)
        self.done()

    @precondition(lambda self: self.targets)
    @rule(pick=PICK, mode=st.sampled_from(("OBJECT", "EDIT", "WEIGHT_PAINT", "SCULPT")))
    def set_mode(self, pick, mode):
        self.activate(self.target(pick))
        self.call(bpy.ops.object.mode_set, mode=mode)
        self.done()

    @precondition(lambda self: self.edits_a_target)
    @rule(index=st.integers(0, 60), how=st.sampled_from(("poke", "delete", "move")))
    def edit_topology(self, index, how):
        mesh = bpy.context.object.data
        edit = bmesh.from_edit_mesh(mesh)
        edit.faces.ensure_lookup_table()
        edit.verts.ensure_lookup_table()
        if len(edit.faces) > 8:
            if how == "poke" and len(edit.verts) < 70:
                bmesh.ops.poke(edit, faces=[edit.faces[index % len(edit.faces)]])
            elif how == "delete":
                bmesh.ops.delete(edit, geom=[edit.verts[index % len(edit.verts)]], context="VERTS")
            else:
                edit.verts[index % len(edit.verts)].co.z += 0.1
            bmesh.update_edit_mesh(mesh)
        self.done()

    @precondition(lambda self: self.in_object_mode and self.targets)
    @rule(pick=PICK, kind=st.sampled_from(("DISPLACE", "ARRAY")), group=st.sampled_from(("", "Far", "Soft")))
    def add_modifier(self, pick, kind, group):
        obj = self.target(pick)
        if len(obj.modifiers) < 5 and not (kind == "ARRAY" and any(m.type == "ARRAY" for m in obj.modifiers)):
            modifier = obj.modifiers.new(kind.title(), kind)
            if kind == "DISPLACE":
                modifier.direction, modifier.strength, modifier.mid_level = "XYZ"[pick % 3], 0.4, 0.0
                modifier.vertex_group = group
            else:
                modifier.count, modifier.use_relative_offset, modifier.use_constant_offset = 2, False, True
                modifier.constant_offset_displace = (2.0, 0.5, 0.0)
        self.done()

    def modifier(self, pick: int, ours: bool):
        found = [
            (obj, modifier)
            for obj in self.targets
            for modifier in obj.modifiers
            if ours or modifier.type != "NODES"
        ]
        return found[pick % len(found)] if found else None

    @precondition(lambda self: self.in_object_mode and self.modifier(0, False))
    @rule(pick=PICK)
    def remove_modifier(self, pick):
        obj, modifier = self.modifier(pick, False)
        obj.modifiers.remove(modifier)
        self.done()

    @precondition(lambda self: self.in_object_mode and self.modifier(0, True))
    @rule(pick=PICK, index=st.integers(0, 4))
    def move_modifier(self, pick, index):
        obj, modifier = self.modifier(pick, True)
        make_active(obj)
        index %= len(obj.modifiers)
        self.call(bpy.ops.object.modifier_move_to_index, modifier=modifier.name, index=index)
        self.done()

    @precondition(lambda self: self.modifier(0, True))
    @rule(pick=PICK)
    def mute_modifier(self, pick):
        modifier = self.modifier(pick, True)[1]
        modifier.show_viewport = not modifier.show_viewport
        self.done()

    @precondition(lambda self: bpy.context.mode in ("OBJECT", "PAINT_WEIGHT") and self.targets)
    @rule(pick=PICK, group=st.sampled_from(GROUPS), vertex=st.integers(0, 60), weight=SHARE)
    def paint_weight(self, pick, group, vertex, weight):
        obj = self.target(pick)
        if group in obj.vertex_groups:
            obj.vertex_groups[group].add([vertex % len(obj.data.vertices)], weight, "REPLACE")
        self.done()

    @precondition(lambda self: self.in_object_mode and self.targets)
    @rule(pick=PICK, group=st.sampled_from(GROUPS))
    def remove_group(self, pick, group):
        """By the button: from Python, Blender evaluates nothing."""
        obj = self.target(pick)
        if group in obj.vertex_groups:
            make_active(obj)
            obj.vertex_groups.active_index = obj.vertex_groups[group].index
            self.call(bpy.ops.object.vertex_group_remove)
        self.done()

    @precondition(lambda self: self.control(0))
    @rule(pick=PICK)
    def hide_control(self, pick):
        control = self.control(pick)
        control.hide_viewport = not control.hide_viewport
        self.done()


def test_any_sequence_of_operations_shows_what_the_properties_ask_for():
    Artist.unsure = Artist.warped = 0
    run_sequences(Artist, SEQUENCES, STEPS)
    if SEQUENCES >= 50:  # the first dozens are short
        assert Artist.checked > 0.4 * STEPS * SEQUENCES  # the test looks
        assert Artist.warped > 0.1 * STEPS * SEQUENCES
    assert Artist.unsure < 0.2 * Artist.checked
