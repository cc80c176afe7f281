# SPDX-License-Identifier: GPL-3.0-or-later
"""Random sequences of what an artist does: the shape is always the one that the properties ask for.

A failure ends with the shortest sequence found, as Python: the calls of ``Artist``.
"""

from __future__ import annotations

import os
from collections.abc import Callable

import bmesh
import bpy
import numpy as np
from expected import in_frame
from hypothesis import strategies as st
from hypothesis.stateful import initialize, precondition, rule
from inside import catch_up, native
from mathutils import Euler, Matrix, Vector
from oracle import Expected, Oracle, Unsure
from registry import WITH_HANDLES
from rigs import rig as scenes
from rigs.targets import GROUPS, SETTINGS, SHAPES, new_target
from sequences import SEQUENCES, Sequence, run_sequences

STEPS = int(os.environ.get("SINEW_RANDOM_STEPS", "50"))

PICK = st.integers(0, 5)
METHODS = st.sampled_from(WITH_HANDLES)
SMALL = st.integers(-4, 4).map(lambda number: number / 4)
VECTOR = st.tuples(SMALL, SMALL, SMALL)
SHARE = st.sampled_from((0.0, 0.25, 0.5, 1.0))
SIZE = st.sampled_from((0.5, 1.0, 1.5))
ROLE = st.sampled_from(("HANDLE", "FIXED", "SUPPORT"))
SHAPE = st.sampled_from(sorted(SHAPES))
CAGED = ("green", "mean_value")  # these take points anywhere


def step(of: str = "", when: Callable = lambda self: True, solved: bool = True, **given: st.SearchStrategy):
    """A rule with one of what ``self.<of>`` finds, if any; one that has ended by itself returns True."""
    picks = {"pick": PICK} if of else {}

    def make(act: Callable) -> Callable:
        def taken(self, pick: int = 0, **chosen: object) -> None:
            found = (getattr(self, of)(pick),) if of else ()
            if not act(self, *found, **chosen):
                self.done(solved=solved)

        taken.__name__ = act.__name__  # so that a failure names it
        is_there = precondition(lambda self: bool(when(self) and (not of or getattr(self, of)(0))))
        return is_there(rule(**picks, **given)(taken))

    return make


def setting(of: str, name: str, values: st.SearchStrategy, solved: bool = True) -> Callable:
    """The rule by which a property of a deformer or of a handle takes one of these values."""

    def act(self, owner, value: object) -> None:
        setattr(owner, name, value)

    act.__name__ = f"set_{name}"
    return step(of, solved=solved, value=values)(act)


def pick_among(found: list, pick: int):
    return found[pick % len(found)] if found else None


def in_object_mode(artist: Artist) -> bool:
    return artist.in_object_mode


def edits_a_target(artist: Artist) -> bool:
    return bpy.context.mode == "EDIT_MESH" and bpy.context.object in artist.targets


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

    def rows(self) -> list:
        return [row for obj in self.targets for row in obj.sinew.deformers]

    def target(self, pick: int) -> bpy.types.Object | None:
        return pick_among(self.targets, pick)

    def deformer(self, pick: int):
        """It is the active one of its object."""
        found = pick_among(self.rows(), pick)
        if found is not None:
            found.id_data.sinew.active_deformer = found.id_data.sinew.deformers.values().index(found)
        return found

    def handle(self, pick: int, kind: str = ""):
        handles = [handle for row in self.rows() for handle in row.handles]
        return pick_among([handle for handle in handles if kind in ("", handle.kind)], pick)

    def mover(self, pick: int):
        return self.handle(pick, "HANDLE")

    def control(self, pick: int) -> bpy.types.Object | None:
        """A cage, or what a handle follows."""
        owners = [
            owner for row in self.rows() for owner in (row.cage, *(each.control for each in row.handles))
        ]
        names = {owner.name for owner in owners if owner is not None and owner.users_scene}
        return bpy.data.objects.get(pick_among(sorted(names), pick) or "")

    def caged(self, pick: int):
        """A deformer with a cage that can be seen."""
        rows = [row for row in self.rows() if row.cage is not None and not row.cage_missing]
        return pick_among([row for row in rows if not row.cage.hide_viewport], pick)

    def modifier(self, pick: int) -> bpy.types.Modifier | None:
        return pick_among([modifier for obj in self.targets for modifier in obj.modifiers], pick)

    def other_modifier(self, pick: int) -> bpy.types.Modifier | None:
        found = [modifier for obj in self.targets for modifier in obj.modifiers if modifier.type != "NODES"]
        return pick_among(found, pick)

    def saved_file(self, pick: int) -> str | None:
        return pick_among(self.saved, pick)

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
            elif obj.sinew.deformers:
                try:
                    self.compare_one(obj, self.oracle.expected(obj, depsgraph))
                except Unsure:
                    Artist.unsure += 1

    def compare_one(self, obj: bpy.types.Object, expected: Expected) -> None:
        Artist.checked += 1
        if expected.shown:
            self.posed.add(obj.name)
        shown = scenes.evaluated_points(obj)
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

    @initialize(shape=SHAPE, method=METHODS, caged=st.sampled_from(("", *CAGED)))
    def begin(self, shape, method, caged):
        new_target(shape)
        bpy.ops.sinew.deformer_add(method=method)
        bpy.ops.sinew.handle_add(kind="HANDLE", vertex_group="Far")
        scenes.press(bpy.data.objects[shape], "handle_add", kind="FIXED", vertex_group="Near")
        if caged:
            self.put_into_a_cage(bpy.data.objects[shape], caged, 2.3)
        self.start_over()

    def activate(self, obj: bpy.types.Object) -> None:
        if self.in_object_mode:
            scenes.make_active(obj)

    @step(when=lambda self: self.in_object_mode and len(self.targets) < 3, shape=SHAPE)
    def add_target(self, shape):
        new_target(shape)

    @step("target", in_object_mode, method=METHODS)
    def add_deformer(self, obj, method):
        if len(obj.sinew.deformers) < 3:
            scenes.make_active(obj)
            self.call(bpy.ops.sinew.deformer_add, method=method)

    @step("deformer")
    def remove_deformer(self, deformer):
        self.activate(deformer.id_data)
        self.oracle.forget_missing([deformer.id_data])  # if this is undone
        self.call(bpy.ops.sinew.deformer_remove)

    @step("deformer", kind=ROLE, group=st.sampled_from(GROUPS))
    def add_handle(self, deformer, kind, group):
        if len(deformer.handles) < 5 and deformer.cage_rest is None:
            self.activate(deformer.id_data)
            self.call(bpy.ops.sinew.handle_add, kind=kind, vertex_group=group)

    @step(when=edits_a_target, vertex=st.integers(0, 40), kind=ROLE)
    def add_handle_of_a_selection(self, vertex, kind):
        edit = bmesh.from_edit_mesh(bpy.context.object.data)
        edit.verts.ensure_lookup_table()
        for other in edit.verts:
            other.select = other.index == vertex % len(edit.verts)
        edit.select_flush(True)
        self.call(bpy.ops.sinew.handle_add, kind=kind)

    @step("deformer", index=st.integers(0, 3))
    def remove_handle(self, deformer, index):
        self.activate(deformer.id_data)
        self.call(bpy.ops.sinew.handle_remove, index=index)

    @step("control", solved=False, by=VECTOR)
    def move_control(self, control, by):
        control.matrix_world = Matrix.Translation(by) @ control.matrix_world

    @step("control", solved=False, by=VECTOR)
    def rotate_control(self, control, by):
        control.matrix_basis = control.matrix_basis @ Euler(by).to_matrix().to_4x4()

    @step("control", solved=False, by=st.tuples(SIZE, SIZE, SIZE))
    def scale_control(self, control, by):
        control.scale = by

    @step("target", in_object_mode, method=st.sampled_from(CAGED), size=st.sampled_from((1.1, 1.7, 2.3)))
    def add_cage(self, obj, method, size):
        if len(obj.sinew.deformers) < 3:
            self.put_into_a_cage(obj, method, size)

    def put_into_a_cage(self, obj: bpy.types.Object, method: str, size: float) -> None:
        bpy.ops.mesh.primitive_cube_add(size=size, location=obj.location)
        cage = bpy.context.object
        cage["cage"] = True
        scenes.press(obj, "cage_add", source="OBJECT", cage=cage.name, method=method)

    @step(
        "caged",
        in_object_mode,
        vertex=st.integers(0, 40),
        by=VECTOR,
        subdivide=st.booleans(),
        leave=st.booleans(),
    )
    def edit_cage(self, deformer, vertex, by, subdivide, leave):
        """In Edit Mode, which may stay."""
        cage = deformer.cage
        scenes.make_active(cage)
        bpy.ops.object.mode_set(mode="EDIT")
        edit = bmesh.from_edit_mesh(cage.data)
        edit.verts.ensure_lookup_table()
        edit.verts[vertex % len(edit.verts)].co += 0.5 * Vector(by)
        if subdivide and len(edit.verts) < 30:
            bmesh.ops.subdivide_edges(edit, edges=edit.edges, cuts=1, use_grid_fill=True)
        bmesh.update_edit_mesh(cage.data)
        if leave:
            bpy.ops.object.mode_set(mode="OBJECT")

    @step(when=lambda _self: bpy.context.mode == "EDIT_MESH")
    def leave_edit_mode(self):
        bpy.ops.object.mode_set(mode="OBJECT")

    @step("caged", in_object_mode)
    def set_rest(self, deformer):
        obj = deformer.id_data
        obj.sinew.active_deformer = obj.sinew.deformers.values().index(deformer)
        scenes.press(obj, "cage_set_rest")
        deformer = obj.sinew.active
        now = scenes.apply_matrix(in_frame(obj, deformer.cage), scenes.evaluated_points(deformer.cage))
        assert scenes.close(scenes.coordinates(deformer.cage_rest.vertices), now, 2e-5)

    @step("target", by=VECTOR, turn=VECTOR, scale=st.sampled_from((0.5, 1.0, 2.0)))
    def move_target(self, obj, by, turn, scale):
        obj.location, obj.rotation_euler, obj.scale = by, turn, (scale, 1.0, scale)

    @step("control", in_object_mode)
    def delete_control(self, control):
        scenes.make_active(control)
        self.call(bpy.ops.object.delete)

    @step("control")
    def purge_control(self, control):
        bpy.data.objects.remove(control)

    @step("target", lambda self: self.in_object_mode and len(self.targets) > 1)
    def delete_target(self, obj):
        scenes.make_active(obj)
        self.call(bpy.ops.object.delete)

    @step("target", lambda self: self.in_object_mode and len(self.targets) < 3, linked=st.booleans())
    def duplicate(self, obj, linked):
        """Original and copy go on from the same shape, each by a key of its own."""
        name, before = obj.name, scenes.evaluated_points(obj)
        scenes.make_active(obj)
        assert self.call(bpy.ops.object.duplicate, linked=linked)
        twins = (bpy.data.objects[name], bpy.context.object)
        catch_up()
        if not self.oracle.forget_missing(twins):
            for twin in twins:
                assert np.abs(scenes.evaluated_points(twin) - before).max() <= 1e-4 * max(
                    1.0, np.abs(before).max()
                )
        used = [deformer.uid for twin in twins for deformer in twin.sinew.deformers]
        assert len(set(used)) == len(used)

    @step("mover", other=PICK)
    def exchange_control(self, handle, other):
        """Nothing jumps."""
        new, name = self.control(other), handle.id_data.name
        if new is None:
            new = scenes.new_empty("New", (1.0, 2.0, 3.0))
        before = scenes.evaluated_points(handle.id_data)
        handle.control = new
        self.done()
        if name in self.posed:
            after = scenes.evaluated_points(bpy.data.objects[name])
            assert np.abs(after - before).max() <= 1e-3 * max(1.0, np.abs(before).max())
        return True

    @step(
        "target",
        what=st.sampled_from(("object", "control", "modifier", "deformer", "group")),
        pick_control=PICK,
    )
    def rename(self, obj, what, pick_control):
        if what == "object":
            obj.name = "Renamed"
        elif what == "control" and self.control(pick_control):
            self.control(pick_control).name = "Renamed Control"
        elif what == "modifier" and obj.modifiers:
            obj.modifiers[pick_control % len(obj.modifiers)].name = "Renamed Modifier"
        elif what == "deformer" and obj.sinew.deformers:
            obj.sinew.deformers[0].name = "Renamed Deformer"

    @step("deformer", method=METHODS, caged=st.sampled_from(CAGED))
    def set_method(self, deformer, method, caged):
        deformer.method = method if deformer.cage_rest is None else caged

    @step("deformer", setting=st.sampled_from(SETTINGS))
    def set_parameter(self, deformer, setting):
        group, name, value = setting
        setattr(getattr(deformer, group), name, value)

    set_factor = setting("deformer", "factor", SHARE, solved=False)
    set_mask_group = setting("deformer", "mask_group", st.sampled_from((*GROUPS, "", "Nowhere")))
    set_auto_rebind = setting("deformer", "auto_rebind", st.booleans())
    set_weight = setting("handle", "weight", SHARE)
    set_continuity = setting("handle", "continuity", st.sampled_from((0.0, 0.5, 1.0, 1.5, 2.0)))
    set_vertex_group = setting("handle", "vertex_group", st.sampled_from((*GROUPS, "Nowhere")))
    set_enabled = setting("handle", "enabled", st.booleans())
    set_from_rest = setting("handle", "from_rest", st.booleans())

    @step("deformer")
    def bind(self, deformer):
        self.activate(deformer.id_data)
        self.call(bpy.ops.sinew.bind)

    @step("deformer")
    def unbind(self, deformer):
        key, obj = deformer.uid, deformer.id_data
        self.activate(obj)
        if self.call(bpy.ops.sinew.unbind):
            self.oracle.forget_missing([obj])
            for pair in [pair for pair in self.oracle.last if pair[0] == key]:
                del self.oracle.last[pair]

    @step(when=lambda self: len(self.saved) < 3)
    def save(self):
        self.saved.append(scenes.save(self.folder / f"{len(self.saved)}.blend", check_existing=False))

    @step("saved_file")
    def load(self, path):
        scenes.load(path)
        self.oracle.last.clear()
        self.oracle.forget_missing(bpy.data.objects)
        self.start_over()
        return True

    @step("control", frame=st.integers(1, 5), to=VECTOR)
    def key_control(self, control, frame, to):
        control.location = to
        control.keyframe_insert("location", frame=frame)

    @step(frame=st.integers(1, 5))
    def go_to_frame(self, frame):
        bpy.context.scene.frame_set(frame)

    @step("target", mode=st.sampled_from(("OBJECT", "EDIT", "WEIGHT_PAINT", "SCULPT")))
    def set_mode(self, obj, mode):
        self.activate(obj)
        self.call(bpy.ops.object.mode_set, mode=mode)

    @step(when=edits_a_target, index=st.integers(0, 60), how=st.sampled_from(("poke", "delete", "move")))
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

    @step("target", in_object_mode, axis=st.sampled_from("XYZ"), group=st.sampled_from(("", "Far", "Soft")))
    def add_displacement(self, obj, axis, group):
        if len(obj.modifiers) < 5:
            modifier = obj.modifiers.new("Displace", "DISPLACE")
            modifier.direction, modifier.strength, modifier.mid_level = axis, 0.4, 0.0
            modifier.vertex_group = group

    @step("target", in_object_mode)
    def add_array(self, obj):
        if len(obj.modifiers) < 5 and "ARRAY" not in {modifier.type for modifier in obj.modifiers}:
            modifier = obj.modifiers.new("Array", "ARRAY")
            modifier.count, modifier.use_relative_offset, modifier.use_constant_offset = 2, False, True
            modifier.constant_offset_displace = (2.0, 0.5, 0.0)

    @step("other_modifier", in_object_mode)
    def remove_modifier(self, modifier):
        modifier.id_data.modifiers.remove(modifier)

    @step("modifier", in_object_mode, index=st.integers(0, 4))
    def move_modifier(self, modifier, index):
        scenes.make_active(modifier.id_data)
        index %= len(modifier.id_data.modifiers)
        self.call(bpy.ops.object.modifier_move_to_index, modifier=modifier.name, index=index)

    @step("modifier")
    def mute_modifier(self, modifier):
        modifier.show_viewport = not modifier.show_viewport

    @step(
        "target",
        lambda _self: bpy.context.mode in ("OBJECT", "PAINT_WEIGHT"),
        group=st.sampled_from(GROUPS),
        vertex=st.integers(0, 60),
        weight=SHARE,
    )
    def paint_weight(self, obj, group, vertex, weight):
        if group in obj.vertex_groups:
            obj.vertex_groups[group].add([vertex % len(obj.data.vertices)], weight, "REPLACE")

    @step("target", in_object_mode, group=st.sampled_from(GROUPS))
    def remove_group(self, obj, group):
        """By the button: from Python, Blender evaluates nothing."""
        if group in obj.vertex_groups:
            scenes.make_active(obj)
            obj.vertex_groups.active_index = obj.vertex_groups[group].index
            self.call(bpy.ops.object.vertex_group_remove)

    @step("control")
    def hide_control(self, control):
        control.hide_viewport = not control.hide_viewport


def test_any_sequence_of_operations_shows_what_the_properties_ask_for():
    Artist.unsure = Artist.warped = 0
    run_sequences(Artist, SEQUENCES, STEPS)
    many = SEQUENCES >= 50  # the first dozens are short, and their shares vary: once 20 % could not be told
    assert Artist.unsure < (0.2 if many else 0.3) * Artist.checked
    if many:
        assert Artist.checked > 0.4 * STEPS * SEQUENCES
        assert Artist.warped > 0.1 * STEPS * SEQUENCES
