# SPDX-License-Identifier: GPL-3.0-or-later
"""The shape that the properties of a scene describe, computed by mathematics of its own.

It reads settings, rest meshes, vertex groups and Blender's evaluated matrices, and follows the modifier stack
in NumPy. A new native object says what a method makes of these: its contract is that equal poses give
equal shapes, whatever came before. That its shapes are those of the formulas, the tests of the bindings show.

Triangles only, so that no choice of diagonals comes in.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field

import bpy
import numpy as np
from expected import faces_of, new_native, space_warp
from registry import BY_ID, Control
from rigs.rig import apply_matrix, base_points, coordinates, painted, points_of

IDENTITY = np.eye(4)[:3]
EPSILON32 = 2.0**-23
CAGED = 2e-5  # float32 weights and positions, of shapes of a few units
Key = tuple[str, str]  # of a deformer and its handle


class Refusal(Exception):
    """These settings have no shape: rest is expected, and a status that says why."""


class Unsure(Exception):
    """Too close to singular for an answer to compare with."""


@dataclass
class Region:
    """Vertices that follow one pose. ``strength`` (k,) is 1 for a hard constraint."""

    members: np.ndarray
    strength: np.ndarray
    continuity: float
    handle: object = None  # None: the fixed surroundings of a support


@dataclass
class Expected:
    """``points`` float32 (n, 3), None where nothing can be said; ``tolerance`` in object units."""

    points: np.ndarray | None
    faces: np.ndarray  # (m, 3)
    source: np.ndarray  # (n,) the mesh vertex behind each point
    tolerance: float = 0.0
    refused: dict[str, str] = field(default_factory=dict)  # by deformer key: why it shows rest
    shown: set[str] = field(default_factory=set)  # keys of the deformers that show a solution


class Oracle:
    """``last`` holds the pose that each handle showed last: a handle without control stays there.

    ``recalled`` names handles of a file or a copy, which have only the property ``last_pose`` to go by.
    """

    def __init__(self, native) -> None:
        self.native = native
        self.last: dict[Key, np.ndarray] = {}
        self.recalled: set[Key] = set()

    def forget_missing(self, objects: Iterable[bpy.types.Object]) -> bool:
        """These were loaded, or copied; True where a handle of theirs has no control."""
        missing = {
            (deformer.uid, handle.uid)
            for obj in objects
            for deformer in obj.sinew.deformers
            for handle in deformer.handles
            if handle.kind == "HANDLE" and is_missing(handle)
        }
        self.recalled |= missing
        return bool(missing)

    def skip_poses(self, obj: bpy.types.Object) -> None:
        """Forget the poses of an object that is not compared: only the add-on has followed its controls."""
        for deformer in obj.sinew.deformers:
            self.recalled |= {(deformer.uid, handle.uid) for handle in deformer.handles}

    def expected(self, obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> Expected:
        """What ``obj`` shows in the viewport; notes the poses on the way."""
        points = base_points(obj).astype(np.float32)
        answer = Expected(points, triangles(obj.data), np.arange(len(points)))
        answer.tolerance = EPSILON32 * max(np.abs(answer.points).max(initial=0.0), 1e-3)
        by_shape = {deformer.proxy: deformer for deformer in obj.sinew.deformers if deformer.proxy}
        after_sinew = broken = False
        for modifier in obj.modifiers:
            if not modifier.show_viewport:
                continue
            deformer = by_shape.get(shape_of(modifier)) if modifier.type == "NODES" else None
            if deformer is None:
                broken = broken or after_sinew
                follow(obj, modifier, answer)
                continue
            # A deformer behind another, with something in between, adds its displacement: its note says so.
            if self._take(obj, deformer, depsgraph, answer, broken):
                after_sinew, broken = True, broken or bool(deformer.mask_group)
        return answer

    def _take(self, obj, deformer, depsgraph, answer: Expected, displaces: bool) -> bool:
        row, regions = BY_ID[deformer.method], []
        is_caged = row.control is Control.CAGE
        holds = deformer.cage_rest if is_caged else any(handle.enabled for handle in deformer.handles)
        if deformer.rest is None or not holds:
            return False
        rest = coordinates(deformer.rest.vertices)
        incoming = answer.points
        weights = Weights(obj, answer.source, deformer.rest)
        try:
            if len(incoming) != len(rest) or not np.array_equal(answer.faces, triangles(deformer.rest)):
                raise Refusal("Topology changed")
            faces = triangles(deformer.rest)
            part = parts(len(rest), faces)
            if is_caged:
                displaces, moved, error = True, self._warp(obj, deformer, depsgraph, rest), CAGED
            else:
                regions = regions_of(deformer, weights, part)
                options = options_of(deformer, row, weights)
                before = rest if displaces else incoming.astype(np.float64)
                poses, flags = self._poses(obj, deformer, regions, depsgraph, rest, before)
                held = deformer.loose_parts.lower()
                moved, error = self._solve(row, held, rest, faces, options, regions, poses, flags, before)
        except Refusal as refusal:
            answer.refused[deformer.uid] = str(refusal)
            return False
        answer.shown.add(deformer.uid)
        if displaces:
            moved = incoming + (moved - rest).astype(np.float32)
        moved = moved.astype(np.float32)
        mask = Weights(obj, answer.source)(deformer.mask_group)
        share = np.float32(deformer.factor) * (np.ones(len(moved)) if mask is None else mask).astype(
            np.float32
        )
        answer.points = incoming * (1 - share)[:, None] + moved * share[:, None]
        # float32 shapes: a rounding for the shape, the mix and the stack below; and the solve's own error.
        size = max(np.abs(incoming).max(), np.abs(moved).max(), np.abs(rest).max(), 1e-3)
        answer.tolerance += 8 * EPSILON32 * size + error
        if any(region.handle is not None and is_missing(region.handle) for region in regions):
            answer.tolerance += 1e-4 * size  # from a saved float32 shape, where a file was loaded
        return True

    def _warp(self, obj, deformer, depsgraph, rest: np.ndarray) -> np.ndarray:
        """By double weights that are bound anew, of the rest cage in the file; Blender places the cage."""
        if deformer.cage_missing:
            raise Unsure("the last pose stays, whatever it was")
        cage, target = (each.evaluated_get(depsgraph) for each in (deformer.cage, obj))
        now = apply_matrix(target.matrix_world.inverted() @ cage.matrix_world, points_of(cage))
        before = coordinates(deformer.cage_rest.vertices)
        if len(now) != len(before):
            raise Refusal("the cage has other vertices")
        mesh = self.native.SurfaceMesh(before, faces_of(deformer.cage_rest))
        weights = getattr(self.native, BY_ID[deformer.method].native)(mesh, precision="double")
        weights.bind(rest)
        return weights.warp(now)

    def _poses(self, obj, deformer, regions, depsgraph, rest_points, before) -> tuple[np.ndarray, np.ndarray]:
        """(k, 3, 4), and (k,) whether each moves the rest shape.

        Where a handle stands on the surface, its region goes to its control from where it has been carried.
        """
        world = np.array(obj.evaluated_get(depsgraph).matrix_world, dtype=np.float64)
        poses, flags = [], []
        for region in regions:
            handle = region.handle
            if handle is None or handle.kind == "FIXED":
                poses.append(IDENTITY)
                flags.append(False)
                continue
            key = (deformer.uid, handle.uid)
            surface, rides = np.eye(4), handle.stands_on == "SURFACE"
            if rides:
                surface = carried(rest_points[region.members], before[region.members], world[:3, :3])
            if is_missing(handle):
                if key in self.recalled:
                    if not handle.has_last_pose:
                        raise Unsure("its control was gone before anything was evaluated")
                    self.last[key] = np.array(handle.last_pose, dtype=np.float64).reshape(3, 4)
            else:
                control = np.array(handle.control.evaluated_get(depsgraph).matrix_world, dtype=np.float64)
                rest = np.array(handle.rest_matrix, dtype=np.float64)
                rest = rest if rest.shape == (4, 4) else rest.reshape(4, 4).T
                assert handle.has_rest, f"{handle.name} has a control, and no rest frame"
                seen = np.linalg.solve(surface, np.linalg.solve(world, control))
                self.last[key] = (seen @ np.linalg.inv(rest))[:3]
                self.recalled.discard(key)
            pose = surface @ np.vstack((self.last.get(key, IDENTITY), (0.0, 0.0, 0.0, 1.0)))
            if rides and BY_ID[deformer.method].is_space:
                pose = pose - surface + np.eye(4)
            elif rides:
                pose = pose @ np.linalg.inv(surface)
            poses.append(pose[:3])
            flags.append(handle.from_rest and not rides)
        return np.array(poses), np.array(flags)

    def _solve(
        self, row, free_parts, rest, faces, options, regions, poses, flags, before
    ) -> tuple[np.ndarray, float]:
        """Solve with a new native object, which has no history."""
        incoming = None if np.array_equal(before, rest) else before
        members, strengths = zip(*((region.members, region.strength) for region in regions), strict=True)
        if row.is_space:
            try:
                warp = space_warp(row, rest, faces, [rest[rows] for rows in members], options, strengths)
                return warp(poses, incoming), 0.0
            except self.native.InvalidConstraint as error:  # as of one place that two handles pull apart
                raise Refusal(str(error)) from error
        mesh = self.native.SurfaceMesh(rest, faces)
        steps = steps_of(row, options)
        try:
            if row.wraps:
                base, given = options["base"]
                steps = steps_of(base, given) | steps
                options["base"] = new_native(base, mesh, given)
            solver = new_native(row, mesh, options)
        except self.native.InvalidOption as error:  # as of a base without any stiffness
            raise Refusal(str(error)) from error
        by_handle = {"continuity": [region.continuity for region in regions]} if row.handle_parameters else {}
        solver.set_handles(members, weights=strengths, free_parts=free_parts, **by_handle)
        moved, _report = solver.solve(poses, incoming=incoming, from_rest=flags, **steps)
        # Where a pose or an incoming shape differs in its last digit, the steps may stop one earlier.
        exact = incoming is None and not any(r.handle is not None and is_missing(r.handle) for r in regions)
        return moved, 0.0 if exact else (3e-3 if row.iterative else 1e-5) * np.abs(moved - before).max()


def carried(rest: np.ndarray, now: np.ndarray, linear: np.ndarray) -> np.ndarray:
    """The rigid motion of the world (``linear`` leads there) that fits best, (4, 4) in object space."""
    if np.array_equal(rest, now):
        return np.eye(4)
    rest, now = rest @ linear.T, now @ linear.T
    a, b = rest - rest.mean(axis=0), now - now.mean(axis=0)
    if len(a) < 3 or np.linalg.svd(a, compute_uv=False)[1] <= 1e-3 * np.linalg.norm(a):
        raise Unsure("a region that does not tell how it turns")
    u, _sizes, v = np.linalg.svd(b.T @ a)
    turn = u @ np.diag((1.0, 1.0, np.linalg.det(u) * np.linalg.det(v))) @ v
    found = np.eye(4)
    found[:3, :3] = np.linalg.solve(linear, turn @ linear)
    found[:3, 3] = np.linalg.solve(linear, now.mean(axis=0) - turn @ rest.mean(axis=0))
    return found


def is_missing(handle) -> bool:
    """No datablock stands behind the handle's control. An object taken out of the scene still does."""
    return handle.control is None


def triangles(mesh: bpy.types.Mesh) -> np.ndarray:
    """(m, 3)."""
    corners = np.empty(len(mesh.loops), dtype=np.int32)
    mesh.loops.foreach_get("vertex_index", corners)
    if len(corners) != 3 * len(mesh.polygons):
        raise Unsure("not all faces are triangles")
    return corners.reshape(-1, 3)


def shape_of(modifier: bpy.types.NodesModifier) -> bpy.types.Object | None:
    """The object in the input named Viewport Shape."""
    group = modifier.node_group
    if group is None:
        return None
    if hasattr(group, "interface"):
        sockets = [item for item in group.interface.items_tree if getattr(item, "in_out", "") == "INPUT"]
    else:
        sockets = list(group.inputs)
    for socket in sockets:
        if socket.name == "Viewport Shape":
            if hasattr(modifier, "properties"):
                return getattr(modifier.properties.inputs, socket.identifier).value
            return modifier.get(socket.identifier)
    return None


class Weights:
    """Weights by vertex group as they are painted now, (n,) for the points that enter.

    A group that was removed counts until the next bind: the rest mesh still has it.
    """

    def __init__(self, obj: bpy.types.Object, source: np.ndarray, rest: bpy.types.Mesh | None = None) -> None:
        self._obj, self._source, self._rest = obj, source, rest

    def __call__(self, name: str) -> np.ndarray | None:
        group = self._obj.vertex_groups.get(name) if name else None
        if group is not None:
            return painted(self._obj.data, group.index)[self._source]
        lists = ("sinew_groups", "sinew_lost_groups") if self._rest else ()
        kept = [other for key in lists for other in self._rest.get(key, ())]
        if name not in kept:
            return None
        stored = self._rest.attributes.get(f".sinew_weight_{kept.index(name)}")
        if stored is None:
            return painted(self._rest, kept.index(name))
        return np.array([value.value for value in stored.data], dtype=np.float64)


def follow(obj: bpy.types.Object, modifier: bpy.types.Modifier, answer: Expected) -> None:
    """Blender's own modifiers, as far as the tests use them."""
    points = answer.points
    if modifier.type == "DISPLACE":
        axis = "XYZ".index(modifier.direction)
        weights = Weights(obj, answer.source)(modifier.vertex_group)
        distance = modifier.strength * (1.0 - modifier.mid_level)
        answer.points = points.copy()
        answer.points[:, axis] += np.float32(distance) * (
            1.0 if weights is None else weights.astype(np.float32)
        )
    elif modifier.type == "ARRAY":
        step = np.array(modifier.constant_offset_displace, dtype=np.float32)
        answer.points = np.concatenate([points + k * step for k in range(modifier.count)])
        answer.faces = np.concatenate([answer.faces + k * len(points) for k in range(modifier.count)])
        answer.source = np.tile(answer.source, modifier.count)
    else:
        raise Unsure(f"no formula for {modifier.type}")


def regions_of(deformer, weights: Weights, part: np.ndarray) -> list[Region]:
    """The regions in use, read off a table of who paints which vertex; ``part`` (n,) labels the parts.

    A vertex obeys one hard handle at most. Where there is a support, what nobody paints is fixed, but for the
    parts that nobody paints anywhere, if these follow. A region whose vertex group is empty or gone is none.
    """
    count = len(part)
    enabled = [handle for handle in deformer.handles if handle.enabled]
    painted = {handle.uid: weights(handle.vertex_group) for handle in enabled}
    handles = [h for h in enabled if painted[h.uid] is not None and painted[h.uid].any()]
    if not handles:
        raise Refusal("nothing holds the mesh")
    supports = [handle for handle in handles if handle.kind == "SUPPORT"]
    movers = [handle for handle in handles if handle.kind != "SUPPORT"]
    strengths = np.array([painted[handle.uid] * handle.weight for handle in movers]).reshape(-1, count)
    if ((strengths >= 1.0).sum(axis=0) > 1).any():
        raise Refusal("a vertex in two hard handles")
    is_space = BY_ID[deformer.method].is_space  # where what holds nothing is no handle
    found = [
        Region(members, strength[members], handle.continuity, handle)
        for handle, strength in zip(movers, strengths, strict=True)
        for members in [np.flatnonzero(strength if is_space else painted[handle.uid])]
        if len(members)
    ]
    free = ~np.any([painted[handle.uid] > 0.0 for handle in handles], axis=0)
    if deformer.loose_parts == "FOLLOW" and not is_space:
        free &= np.isin(part, part[~free])
    if supports and free.any():
        border = min(handle.continuity for handle in supports)
        found.append(Region(np.flatnonzero(free), np.ones(free.sum()), border))
    if not found:
        raise Refusal("nothing holds the mesh")
    return found


def steps_of(row, options: dict[str, object]) -> dict[str, object]:
    """The keywords of ``solve``, which it takes out of the options."""
    return {parameter.id: options.pop(parameter.id) for parameter in row.parameters if not parameter.rebinds}


def options_of(deformer, row, weights: Weights) -> dict[str, object]:
    """The parameters of the row; one with a vertex group is an array (n,), not below its minimum.

    Of a row around another, ``base`` is that row with its parameters.
    """
    values = getattr(deformer, row.id)
    options = {parameter.id: getattr(values, parameter.id) for parameter in row.parameters}
    options = {name: None if value == "" else value for name, value in options.items()}  # no map is chosen
    if row.wraps:
        base = BY_ID[values.base]
        options["base"] = base, options_of(deformer, base, weights)
    for parameter in row.paintable:
        group = getattr(values, f"{parameter.id}_group")
        share = weights(group) if group else None
        if share is not None:  # without its group, a parameter is not painted
            options[parameter.id] = np.maximum(options[parameter.id] * share, parameter.span.minimum)
    return options


def parts(count: int, faces: np.ndarray) -> np.ndarray:
    """(n,) the least vertex of each vertex's connected part."""
    label = np.arange(count)
    while True:
        least = label[faces].min(axis=1)
        after = label.copy()
        for k in range(3):
            np.minimum.at(after, faces[:, k], least)
        if np.array_equal(after, label):
            return label
        label = after
