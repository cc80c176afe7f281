# SPDX-License-Identifier: GPL-3.0-or-later
"""A handle where an artist presses on the surface, found there or made there, which then moves with the hand.

A handle that is made is a region within a radius over the surface at rest. What holds the rest of the part is
a support around it, as wide as the reach, unless regions hold it already. A method that deforms space gets a
handle without a region instead, at the very place; it drags curves, text, hair and clouds by their points,
too. Main thread only.
"""

from dataclasses import dataclass

import bpy
import numpy as np
from bpy.types import Depsgraph, Object, PoseBone
from mathutils import Matrix

from ...core import status
from ...core.errors import ConstraintError, SinewError
from ...core.geometry import frames, reach
from ...core.methods import BY_ID
from ...core.status import Level
from ...mesh_io import group_weights, read_rest
from ...properties import SinewDeformer, SinewHandle, deformers_of
from ..controls import kinds, movers
from ..datablocks import surface
from ..datablocks.parts import Parts
from ..datablocks.surface import Hit
from ..evaluation import binding
from ..state.background import Work
from ..state.evaluation import is_shown
from ..targets import targets
from ..targets.kinds import kind_of
from .bind import bind, unbind
from .deformers import add_deformer, put_before_subdivision, remove_deformer
from .handles import surface_points
from .handles.handles import NewRegion, add_handle, remove_handle
from .handles.region_names import name_of_region
from .rigging import rig_region

_FEW = 2  # vertices of a region on a mesh that is too coarse for it: there the divided surface is dragged


@dataclass(frozen=True)
class Brush:
    """What a drag makes where there is no handle.

    ``radius`` is that of the handle and ``reach`` how far what is around follows, both in world units over
    the surface; an infinite reach lets the whole part follow. ``method`` is for an object without a deformer.
    With ``places`` a handle has no region, and deformers whose handles need one are passed over.
    """

    method: str
    radius: float
    reach: float
    places: bool = False


class _Settings:
    """What is active, and other settings that a drag may change."""

    def __init__(self, obj: Object) -> None:
        self._deformer = obj.sinew.active_deformer
        self._handles = [deformer.active_handle for deformer in deformers_of(obj)]
        self._group = obj.vertex_groups.active_index
        self._locks = bpy.context.scene.render.use_lock_interface

    def restore(self, obj: Object) -> None:
        obj.sinew.active_deformer = self._deformer
        for deformer, active in zip(deformers_of(obj), self._handles, strict=True):
            deformer.active_handle = active
        if len(obj.vertex_groups):
            obj.vertex_groups.active_index = self._group
        bpy.context.scene.render.use_lock_interface = self._locks


@dataclass(frozen=True)
class _Plan:
    """The vertices of a new handle and of its support, as masks (n,); None where it needs no support."""

    region: np.ndarray
    support: np.ndarray | None
    is_held: bool  # whether anything holds the part


class Drag:
    """The handle at a place of an object. ``move`` moves its control, ``restore`` puts everything back.

    Only names, keys and numbers are kept. ``frame`` (4, 4) is the control in the world at the start.
    """

    def __init__(self, hit: Hit, depsgraph: Depsgraph, brush: Brush, wait: bool = True) -> None:
        """Find the handle, or make one. Without ``wait``, a thread binds a heavy mesh: see ``job``."""
        binding.require_backend()
        obj = hit.obj
        _require_target(obj)
        is_mesh = targets.is_mesh(obj)
        vertex = surface.vertex_at(hit, depsgraph) if is_mesh else -1
        painted = _painted(obj) if is_mesh else {}
        self._settings = _Settings(obj)
        has_regions = is_mesh and not brush.places
        found = _point_at(obj, hit, brush) or (_handle_at(obj, painted, vertex) if has_regions else None)
        self.is_new, self.is_held = found is None, True
        if found is None:
            deformer, handle = self._make(painted, vertex, brush, wait, hit)
        else:
            deformer, handle = found
            _require_working(obj, deformer)
            if not deformer.is_bound:
                raise SinewError(f"{deformer.name} is not bound - press Bind first")
            _mover(handle)  # refused before anything changes
            _make_active(obj, deformer)
            deformer.active_handle = list(deformer.handles).index(handle)
        self.uid, self._handle, self.name = deformer.uid, handle.uid, handle.name
        self.is_region = bool(handle.vertex_group)
        mover = _mover(handle)
        self._channels = movers.channels_of(mover)
        carrier = handle.control.matrix_world
        self.frame = np.array(carrier @ mover.matrix if handle.bone else carrier, dtype=np.float64)

    @property
    def job(self) -> Work | None:
        """The bind that a thread is working on."""
        return binding.job(self.uid)

    def handle_of(self, obj: Object) -> SinewHandle:
        """The handle. Raises a ``SinewError`` if it is gone."""
        deformer = self._deformer(obj)
        for handle in deformer.handles if deformer is not None else ():
            if handle.uid == self._handle:
                return handle
        raise SinewError("The handle was removed meanwhile - drag again")

    def move(self, obj: Object, motion: np.ndarray) -> None:
        """Move the control by a motion (4, 4) of the world, from where it was at the start.

        Locked channels stay.
        """
        if not np.isfinite(motion).all():
            raise ConstraintError("The motion is not a finite number - type another one")
        handle = self.handle_of(obj)
        _mover(handle)  # refused if it is gone
        place = Matrix((motion @ self.frame).tolist())
        movers.move_to(handle.control, handle.bone, place, self._channels)
        deformer = self._deformer(obj)
        if deformer is not None and not handle.vertex_group:
            surface_points.move_image(obj, deformer, handle)

    def key(self, obj: Object) -> None:
        """Insert keyframes for what has moved, as Auto Keying does when Blender's own tools end."""
        mover = _mover(self.handle_of(obj))
        for name, values in self._channels.items():
            if tuple(getattr(mover, name)) != values:
                mover.keyframe_insert(name)

    def restore(self, obj: Object) -> None:
        """Put everything back, as if nobody had pressed."""
        if self.is_new:
            self._remove(obj)
        else:
            mover = _mover(self.handle_of(obj))
            for name, values in self._channels.items():
                setattr(mover, name, values)
        self._settings.restore(obj)

    def _deformer(self, obj: Object) -> SinewDeformer | None:
        return next((deformer for deformer in deformers_of(obj) if deformer.uid == self.uid), None)

    def _make(
        self, painted: dict[str, np.ndarray], vertex: int, brush: Brush, wait: bool, hit: Hit
    ) -> tuple[SinewDeformer, SinewHandle]:
        """A handle around a vertex, with a support if it needs one, and a deformer if there is none."""
        obj = hit.obj
        if obj.data.library is not None:
            raise SinewError(f"The mesh of {obj.name} is linked - drag one of its handles, or make it local")
        may_hold = (each for each in _in_order(obj) if _marks_regions(each))
        deformer = next((each for each in may_hold if each.definition.is_space or not brush.places), None)
        rows = []
        if deformer is not None:
            _require_working(obj, deformer)
        method = BY_ID[brush.method] if deformer is None else deformer.definition
        targets.require_method(obj, method)
        if method.is_space:
            return self._make_point(obj, deformer, brush, wait, hit)
        if deformer is not None:
            rows = [row for row in deformer.handles if _is_used(row, painted)]
        plan = _plan(obj, rows, painted, vertex, brush)
        self.is_held = plan.is_held
        self._made: list[str] = []  # the keys of new rows
        self._is_first = deformer is None
        try:
            if deformer is None:
                deformer = add_deformer(obj, brush.method)
                if np.count_nonzero(plan.region) > _FEW:
                    put_before_subdivision(obj, deformer)
            self.uid, self._status = deformer.uid, status.current(deformer.uid)
            self._was_bound = deformer.is_bound
            _make_active(obj, deformer)
            if plan.support is not None:
                group = _new_group(obj, "SUPPORT", plan.support)
                self._made.append(add_handle(obj, deformer, NewRegion("SUPPORT", group, owns_group=True)).uid)
            group = _new_group(obj, "HANDLE", plan.region)
            handle, refusal = rig_region(obj, NewRegion("HANDLE", group, owns_group=True), wait=wait)
            self._made.append(handle.uid)
            if refusal is not None:
                raise refusal
        except SinewError:
            self._remove(obj)
            self._settings.restore(obj)
            raise
        return deformer, handle

    def _make_point(
        self, obj: Object, deformer: SinewDeformer | None, brush: Brush, wait: bool, hit: Hit
    ) -> tuple[SinewDeformer, SinewHandle]:
        """A handle without a region at the place that was hit, and a deformer if there is none."""
        self._made = []
        self._is_first = deformer is None
        try:
            deformer = add_deformer(obj, brush.method) if deformer is None else deformer
            self.uid, self._status = deformer.uid, status.current(deformer.uid)
            self._was_bound = deformer.is_bound
            _make_active(obj, deformer)
            made = surface_points.add_point_handles(obj, deformer, hit.place, brush.radius)
            self._made += [handle.uid for handle in made]
            bind(obj, deformer, wait)
        except SinewError:
            self._remove(obj)
            self._settings.restore(obj)
            raise
        return deformer, deformer.handles[deformer.active_handle]

    def _remove(self, obj: Object) -> None:
        """Remove what was made."""
        deformer = self._deformer(obj)
        if deformer is None:
            return
        if self._is_first:
            remove_deformer(obj, list(obj.sinew.deformers).index(deformer))
            obj.update_tag()
            return
        for uid in reversed(self._made):
            keys = [row.uid for row in deformer.handles]
            if uid in keys:
                remove_handle(obj, deformer, keys.index(uid))
        if self._was_bound:
            bind(obj, deformer, wait=False)
        else:
            unbind(obj, deformer)
            status.put(deformer.uid, self._status)


def _plan(
    obj: Object, rows: list[SinewHandle], painted: dict[str, np.ndarray], vertex: int, brush: Brush
) -> _Plan:
    """What is marked around a vertex, on a deformer that has these regions in use."""
    shape = read_rest(obj.data)
    points = shape.points @ np.array(obj.matrix_world, dtype=np.float64)[:3, :3].T
    taken, here, lost = np.zeros((3, len(points)), dtype=bool)
    for row in rows:
        members = painted[row.vertex_group] > 0.0
        if row.kind != "SUPPORT":
            taken |= members
            if members[vertex]:
                raise ConstraintError(
                    f"This place belongs to {row.name}, which stays - press elsewhere, or switch it off"
                )
    here[vertex], lost[shape.not_finite] = True, True
    triangles = reach.TriangleMesh(len(points), shape.counts, shape.corners)
    part, larger = _parts(points, (shape.counts, shape.corners), vertex)
    whole = np.isinf(brush.reach)
    furthest = brush.radius if whole else max(brush.radius, brush.reach)
    lengths = triangles.lengths(points, here, lost, furthest)
    is_supported = any(row.kind == "SUPPORT" for row in rows) or not (rows or (whole and not len(larger)))
    support = part.copy() if whole else np.isfinite(lengths)
    support[larger] = True
    return _Plan(
        (lengths <= brush.radius) & ~taken,
        support if is_supported else None,
        is_supported or bool((taken & part).any()),
    )


def _parts(
    points: np.ndarray, faces: tuple[np.ndarray, np.ndarray], vertex: int
) -> tuple[np.ndarray, np.ndarray]:
    """The part of a vertex as a mask (n,), and one vertex (k,) of each part that is larger.

    Larger parts must not ride on it. A support that has a vertex of them holds their other vertices.
    """
    parts = Parts(points, faces)
    own, sizes = parts.labels[vertex], np.linalg.norm(parts.sides, axis=1)
    return parts.labels == own, parts.firsts[sizes > sizes[own]]


def _in_order(obj: Object) -> list[SinewDeformer]:
    """The deformers of an object, the active one first."""
    deformers = list(deformers_of(obj))
    active = obj.sinew.active
    return [active, *(each for each in deformers if each != active)] if active is not None else deformers


def _marks_regions(deformer: SinewDeformer) -> bool:
    return deformer.method in BY_ID and kinds.marks_regions(deformer.definition)


def _make_active(obj: Object, deformer: SinewDeformer) -> None:
    obj.sinew.active_deformer = list(obj.sinew.deformers).index(deformer)


def _new_group(obj: Object, role: str, members: np.ndarray) -> str:
    """A new vertex group of the vertices in a mask (n,), for a region with a role."""
    points = np.empty((len(obj.data.vertices), 3), dtype=np.float32)
    obj.data.vertices.foreach_get("co", points.ravel())
    group = obj.vertex_groups.new(name=name_of_region(obj, role, points, members))
    group.add(np.flatnonzero(members).tolist(), 1.0, "REPLACE")
    return group.name


def _painted(obj: Object) -> dict[str, np.ndarray]:
    """The weights (n,) of the mesh by vertex group, for the regions of all deformers."""
    wanted = {row.vertex_group for deformer in deformers_of(obj) for row in deformer.handles}
    return group_weights(obj.data, [group.name for group in obj.vertex_groups], wanted - {""})


def _is_used(row: SinewHandle, painted: dict[str, np.ndarray]) -> bool:
    return row.enabled and row.vertex_group in painted and bool((painted[row.vertex_group] > 0.0).any())


def _point_at(obj: Object, hit: Hit, brush: Brush) -> tuple[SinewDeformer, SinewHandle] | None:
    """The handle without a region that is shown there, and its deformer."""
    for deformer in _in_order(obj):
        if _marks_regions(deformer) and deformer.definition.is_space:
            handle = surface_points.point_handle_near(deformer, hit.place, brush.radius)
            if handle is not None:
                return deformer, handle
    return None


def _handle_at(
    obj: Object, painted: dict[str, np.ndarray], vertex: int
) -> tuple[SinewDeformer, SinewHandle] | None:
    """The handle whose region has this vertex, first of the active deformer, and its deformer."""
    for deformer in _in_order(obj):
        rows = [row for row in deformer.handles if row.kind == "HANDLE" and _is_used(row, painted)]
        handle = max(rows, key=lambda row: painted[row.vertex_group][vertex], default=None)
        if handle is not None and painted[handle.vertex_group][vertex] > 0.0:
            return deformer, handle
    return None


def _require_target(obj: Object) -> None:
    """Refuse an object on which no handle can be made."""
    if not targets.can_be_moved(obj):
        targets.require_mesh(obj, "This tool drags")
    if obj.library is not None:
        raise SinewError(f"{obj.name} is linked - make a library override first")
    if obj.mode != "OBJECT":
        mode = obj.bl_rna.properties["mode"].enum_items[obj.mode].name
        raise SinewError(f"{obj.name} is in {mode} Mode - bring it to Object Mode first")
    frames.inverse(np.array(obj.matrix_world, dtype=np.float64), obj.name)


def _require_working(obj: Object, deformer: SinewDeformer) -> None:
    """Refuse a deformer that would not show the drag."""
    kind, line = kind_of(obj), status.current(deformer.uid)
    modifier = kind.shown_by(obj, deformer)
    if deformer.bake.is_baked:
        raise SinewError(f"{deformer.name} is baked - Unbake it first")
    if modifier is not None and not is_shown(modifier, "VIEWPORT"):
        raise SinewError(
            f"The {kind.NOUN} {modifier.name} of {obj.name} is hidden - show it in viewports first"
        )
    if not deformer.live:
        raise SinewError(f"{deformer.name} is not live - switch Live on first")
    if line.level is Level.ERROR:
        raise SinewError(f"{deformer.name} shows an error: {line.text}")


def _mover(handle: SinewHandle) -> Object | PoseBone:
    """The object or the bone that moves a region. Refuses what cannot be moved."""
    control = handle.control
    if control is None or handle.control_missing:
        raise SinewError(f"{handle.name} has no control - choose New Control in its panel, below the list")
    if control.library is not None:
        raise SinewError(f"{control.name}, the control of {handle.name}, is linked - make a library override")
    return movers.mover_of(control, handle.bone)
