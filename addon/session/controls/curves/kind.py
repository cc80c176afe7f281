# SPDX-License-Identifier: GPL-3.0-or-later
"""Curves move the shape: wires that carry what lies within their radius. See ``kinds``.

A curve is read as Blender draws it: at even steps of its parameter, after its shape keys, hooks and
modifiers. So the same number belongs to the same parameter, whatever the length. The rest mesh of a wire
holds its places and then, if it has a domain curve, one place of that beside each of them.
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import bpy
import numpy as np
from bpy.types import Depsgraph, Mesh, Object

from ....backend import ControlPoints
from ....compat import read_edges, read_positions
from ....core.geometry import frames
from ....core.geometry.polylines import Lines, lengths, lines_of, resampled
from ....core.status import Remedy
from ....ids import Datablocks, Keys
from ....mesh_io import RestShape
from ....properties import SinewControl, SinewDeformer
from ...datablocks import own_shape
from ...datablocks.shapes import shapes
from ...state.evaluation import NO_VERTICES, Place
from ...targets.modified import evaluated_mesh
from .. import placement
from ..multi_object import Part, SeveralKind, label_of


class CurvesKind(SeveralKind):
    """Curve objects with a radius each. Each of their splines is a wire."""

    KIND = "curves"
    TYPES = ("CURVE",)
    MISSING = "No wires yet - Draw Wire, or let Wires from Selected take selected curves"
    NOUN = "wire"
    POINTS = "places"
    WANTED = "a wire is a curve object"

    def make_rest(self, control: Object, depsgraph: Depsgraph) -> Mesh:
        mesh = super().make_rest(control, depsgraph)
        lines = _lines(mesh)
        if lines is None:
            bpy.data.meshes.remove(mesh)
            raise self.ERROR(_surface(control))
        length = sum(lengths(read_positions(mesh).astype(np.float64), lines))
        mesh[Keys.REST_STRUCTURE] = replace(lines, length=length).to_text()
        return mesh

    def point_count(self, rest: Mesh) -> int:
        return _rest_lines(rest).total

    def place_of(self, row: SinewControl, depsgraph: Depsgraph) -> Place | None:
        control = row.object
        if control is None or control.type not in self.TYPES:
            return None
        read = partial(_read, None if row.rest is None else _rest_lines(row.rest))
        return placement.read_place(control, depsgraph, read_points=read)

    def wrong(self, row: SinewControl, points: np.ndarray) -> str:
        lines = _rest_lines(row.rest)
        name = label_of(row)
        if not lines.counts:
            return f"{name} has no splines - add one in Edit Mode, then Rebind"
        size = np.abs(points).max(initial=0.0)
        empty = [
            str(i + 1) for i, way in enumerate(lengths(points[: lines.total], lines)) if way <= 1e-9 * size
        ]
        if not empty:
            return ""
        if len(lines.counts) == 1:
            return f"{name} has no length - draw it longer, then Rebind"
        which = f"spline {empty[0]}" if len(empty) == 1 else f"splines {', '.join(empty)}"
        return f"{name} has no length in {which} - delete or draw them longer, then Rebind"

    def part(self, settings: SinewDeformer, row: SinewControl, rest: RestShape) -> Part:
        lines = _rest_lines(row.rest)
        points, domain = rest.points[: lines.total], rest.points[lines.total :]
        if row.domain is None:
            domain = np.full_like(points, np.nan)
        elif not row.has_domain:
            text = f"The domain curve of {row.name} is not bound yet - press Rebind"
            raise self.ERROR(text, remedy=Remedy.BIND)
        own = {
            "counts": lines.counts,
            "closed": lines.closed,
            "domain": domain,
            "radius": row.radius * sum(lengths(points, lines)) / lines.length,
            "scale": row.scale,
            "rotation": row.rotation,
        }
        return Part(points, own)

    def merged(self, parts: Sequence[Part]) -> ControlPoints:
        whole = super().merged(parts)
        splines = [len(counts) for counts in whole.own["counts"]]
        own = {name: np.repeat(whole.own[name], splines) for name in ("radius", "scale", "rotation")}
        own |= {name: np.concatenate(whole.own[name]) for name in ("counts", "closed", "domain")}
        return ControlPoints(whole.points, own)

    def take_row_rest(self, obj: Object, row: SinewControl) -> None:
        super().take_row_rest(obj, row)
        row.has_domain = False
        self._take_domain(obj, row)

    def set_rest(self, obj: Object, deformer: SinewDeformer, renew: bool) -> None:
        super().set_rest(obj, deformer, renew)
        for row in self.rows(deformer):
            self._take_domain(obj, row)

    def _take_domain(self, obj: Object, row: SinewControl) -> None:
        """Store where the domain curve is beside the wire, if that is not stored yet."""
        if row.rest is None or row.domain is None or row.has_domain:
            return
        lines, depsgraph = _rest_lines(row.rest), bpy.context.evaluated_depsgraph_get()
        with evaluated_mesh(row.domain, depsgraph) as mesh:
            its = None if mesh is None else _lines(mesh)
            places = NO_VERTICES if mesh is None else read_positions(mesh)
        if its is None or not its.counts:
            raise self.ERROR(_surface(row.domain))
        to_target = frames.inverse(np.array(obj.matrix_world, dtype=np.float64), obj.name)
        world = np.array(row.domain.evaluated_get(depsgraph).matrix_world, dtype=np.float64)
        places = frames.transformed(to_target @ world, places.astype(np.float64))
        wire = read_positions(row.rest)[: lines.total]
        made = bpy.data.meshes.new(Datablocks.REST)
        made.from_pydata([*wire.tolist(), *resampled(places, its, lines).tolist()], [], [])
        made[Keys.REST_STRUCTURE] = row.rest[Keys.REST_STRUCTURE]
        made[Keys.REST_TOKEN] = shapes.new_key()
        own_shape.carry_over(row.rest, made)
        row.rest = shapes.put_mesh(row.rest, made)
        row.has_domain = True


def _surface(control: Object) -> str:
    return f"{control.name} shows faces or other meshes - a wire has no bevel, extrusion or fill"


def _lines(mesh: Mesh) -> Lines | None:
    """The lines of a curve as a mesh; None if it shows something else."""
    return None if len(mesh.polygons) else lines_of(len(mesh.vertices), read_edges(mesh))


def _rest_lines(rest: Mesh) -> Lines:
    return Lines.from_text(rest.get(Keys.REST_STRUCTURE, ""))


def _read(wanted: Lines | None, control: Object, depsgraph: Depsgraph) -> np.ndarray:
    """The places (c, 3) float32 of a curve, also if renders show it at more or fewer of them."""
    with evaluated_mesh(control, depsgraph) as mesh:
        if mesh is None:
            return NO_VERTICES
        found = read_positions(mesh)
        if wanted is None or len(found) == wanted.total or depsgraph.mode != "RENDER":
            return found
        lines = _lines(mesh)
    if lines is None or lines.closed != wanted.closed:
        return found
    return resampled(found.astype(np.float64), lines, wanted).astype(np.float32)


KIND = CurvesKind()
