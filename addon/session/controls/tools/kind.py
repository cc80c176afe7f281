# SPDX-License-Identifier: GPL-3.0-or-later
"""Tools move the shape: objects, mostly empties, whose path from rest is followed. See ``kinds``.

A tool is its frame, as four points. Its rest mesh holds the frame at rest, and then the stops on its path: so
the path is stored in the file, and follows Apply like any rest shape. From the last stop, the tool goes
straight to where it is now. The shape of a frame depends on that alone.
"""

import bpy
import numpy as np
from bpy.types import Depsgraph, Mesh, Object
from mathutils import Matrix

from ....compat import read_positions
from ....core.geometry.paths import AXES, cut, scale_of
from ....ids import Datablocks, Keys
from ....mesh_io import RestShape
from ....properties import SinewControl, SinewDeformer
from ...datablocks import rest_frame
from ...datablocks.evaluation_driver import Link
from ...datablocks.shapes import shapes
from ...state.evaluation import Evaluation
from .. import movers
from ..multi_object import Part, SeveralKind, label_of

_FRAME = len(AXES)


class ToolsKind(SeveralKind):
    """Objects whose frames are tools."""

    KIND = "tools"
    TYPES = ()
    MISSING = "No tools yet - press Drag Clay, then drag on the surface"
    NOUN = "tool"
    POINTS = "points"
    WANTED = "a tool is any object"

    def read_points(self, control: Object, depsgraph: Depsgraph) -> np.ndarray:
        return AXES.astype(np.float32)

    def make_rest(self, control: Object, depsgraph: Depsgraph) -> Mesh:
        mesh = bpy.data.meshes.new(Datablocks.REST)
        mesh.from_pydata(AXES.tolist(), [], [])
        return mesh

    def point_count(self, rest: Mesh) -> int:
        return _FRAME

    def wrong(self, row: SinewControl, points: np.ndarray) -> str:
        name = label_of(row)
        axes = points[1:_FRAME] - points[0]
        if abs(np.linalg.det(axes)) <= 1e-9 * np.linalg.norm(axes) ** 3:
            return f"{name} is flat, as its scale is 0 - scale it, then Rebind"
        if row.outer <= row.inner:
            return f"{name}: Outer must be larger than Inner"
        if row.tools == "drag" and row.inner < 0.0:
            return f"{name}: Inner must not be negative for a Drag"
        return ""

    def part(self, settings: SinewDeformer, row: SinewControl, rest: RestShape) -> Part:
        scale, frames = scale_of(rest.points[:_FRAME]), len(rest.points) // _FRAME
        lengths = {name: getattr(row, name) * scale for name in ("inner", "outer", "width")}
        own = {"counts": frames, "tools": row.tools, **lengths}
        return Part(np.tile(rest.points[:_FRAME], (frames, 1)), own)

    def posed(self, evaluation: Evaluation, row: SinewControl, points: np.ndarray) -> np.ndarray:
        """The frames on the way, as far as the tool has gone."""
        if row.progress >= 1.0 and len(row.rest.vertices) == _FRAME:
            return points
        rest = rest_frame.read(evaluation.settings, row.rest).points
        path = np.concatenate((rest, points)).reshape(-1, _FRAME, 3)
        return cut(path, row.progress, row.outer * scale_of(path[0])).reshape(-1, 3)

    def reset_row(self, obj: Object, deformer: SinewDeformer, row: SinewControl) -> None:
        """Put a tool back to its frame at rest, without a stop on the way."""
        origin, *ends = rest_frame.read(deformer, row.rest).points[:_FRAME]
        frame = np.eye(4)
        frame[:3] = np.column_stack((*(end - origin for end in ends), origin))
        world = np.array(obj.matrix_world, dtype=np.float64) @ frame
        movers.move_to(row.object, "", Matrix(world.tolist()))
        if len(row.rest.vertices) > _FRAME:
            self.set_stops(row, np.zeros((0, 3)))

    def links(self, deformer: SinewDeformer):
        for row in self.rows(deformer):
            if row.object is not None:
                yield Link(row.object)

    def stops(self, row: SinewControl) -> np.ndarray:
        """The stops on the path of a tool: frames (4 s, 3), in the space of the stored rest shapes."""
        return read_positions(row.rest)[_FRAME:].astype(np.float64)

    def set_stops(self, row: SinewControl, stops: np.ndarray) -> None:
        """Replace the stops on the path of a tool, as ``stops`` returns them. The next evaluation binds."""
        rest = read_positions(row.rest)[:_FRAME]
        mesh = bpy.data.meshes.new(Datablocks.REST)
        mesh.from_pydata([*rest.tolist(), *stops.tolist()], [], [])
        mesh[Keys.REST_TOKEN] = shapes.new_key()
        row.rest = shapes.put_mesh(row.rest, mesh)


KIND = ToolsKind()
