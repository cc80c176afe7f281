# SPDX-License-Identifier: GPL-3.0-or-later
"""What an overlay draws over one mesh: points, triangles, one colour per vertex, and the legend.

It is kept until the shape, the regions or the settings change, and costs some microseconds until then. It
needs no graphics card, so it also works without a window.
"""

from dataclasses import dataclass

import numpy as np
from bpy.types import Context, Depsgraph, Object

from ...core.geometry.distortion import Measure
from ...core.labels import label_of
from ...core.methods import Parameter, group_property
from ...preferences import preferences
from ...properties import SinewDeformer, SinewHandle, row_at
from ...properties.scene import MEASURES
from ...session.results import final_mesh, result
from ...session.results.result import Result
from . import overlay_colours as colours
from .overlay_colours import Colour, Legend
from .overlay_grid import graph_mesh, grid_mesh

_SUPPORT = "support"  # key of the fixed region around a support, see ``session/controls/handles/regions.py``
_MOST_ROWS = 12
_MEASURE_LABELS = {identifier: label for identifier, label, *_rest in MEASURES}
_ENDS = {
    Measure.STRETCH: ("compressed", "stretched"),
    Measure.AREA: ("smaller", "larger"),
    Measure.ANGLE: ("unchanged", "sheared"),
    Measure.DIRICHLET: ("unchanged", "distorted"),
}


@dataclass(frozen=True)
class OverlaySettings:
    """The settings of the overlays, as plain values."""

    overlay: str
    parameter: str
    measure: Measure
    distortion_range: float
    opacity: float
    fixed: Colour
    compressed: Colour
    stretched: Colour


@dataclass(frozen=True)
class OverlayMesh:
    """``points`` float32 (m, 3) in object space, ``triangles`` int32 (t, 3), ``colours`` float32 (m, 4).

    The colours are not premultiplied by their opacity.
    """

    key: tuple
    source: tuple
    points: np.ndarray
    triangles: np.ndarray
    colours: np.ndarray
    legend: Legend


class OverlayCache:
    """The overlay meshes of all deformers, by key; ``computed`` counts how many were computed."""

    def __init__(self) -> None:
        self.computed = 0
        self._meshes: dict[str, OverlayMesh] = {}
        self._revisions: dict[str, int] = {}

    def mark_changed(self, obj: Object) -> None:
        """Note that the mesh that Blender shows of this object may have changed."""
        self._revisions[obj.name_full] = self._revisions.get(obj.name_full, 0) + 1

    def clear(self) -> None:
        """Forget all overlay meshes."""
        self._meshes.clear()
        self._revisions.clear()

    def overlay_mesh(
        self, obj: Object, deformer: SinewDeformer, settings: OverlaySettings, depsgraph: Depsgraph
    ) -> OverlayMesh | None:
        """What to draw over this object now; None if the deformer is not bound to the mesh as it is."""
        source = result.source(obj, deformer)
        if source is None or not final_mesh.is_current(obj, deformer):
            return None
        key = (
            settings,
            obj.mode == "EDIT",
            self._revisions.get(obj.name_full, 0),
            _subject(deformer, settings),
        )
        known = self._meshes.get(deformer.uid)
        if known is not None and known.key == key and result.same(known.source, source):
            return known
        shape = result.shape_shown(obj, deformer)
        if not len(shape.triangles):
            return None
        lines = _lines(deformer, settings)
        if lines is not None:
            self._meshes[deformer.uid] = OverlayMesh(key, source, *lines)
            self.computed += 1
            return self._meshes[deformer.uid]
        painted, legend = _paint(obj, deformer, settings, shape)
        drawn = final_mesh.find(obj, depsgraph, deformer, shape)
        if drawn.origin is not None:
            painted = colours.spread(painted, drawn.origin, drawn.edges)
        painted = colours.straight(painted, drawn.triangles)
        self._meshes[deformer.uid] = OverlayMesh(key, source, drawn.points, drawn.triangles, painted, legend)
        self.computed += 1
        return self._meshes[deformer.uid]


def overlay_settings(context: Context) -> OverlaySettings:
    """The settings of the scene and of the preferences."""
    settings, chosen = context.scene.sinew, preferences(context)
    return OverlaySettings(
        overlay=settings.overlay,
        parameter=settings.parameter,
        measure=Measure(settings.measure),
        distortion_range=settings.distortion_range,
        opacity=settings.opacity * chosen.overlay_opacity,
        fixed=colours.on_screen(chosen.overlay_fixed),
        compressed=colours.on_screen(chosen.overlay_compressed),
        stretched=colours.on_screen(chosen.overlay_stretched),
    )


def _lines(
    deformer: SinewDeformer, settings: OverlaySettings
) -> tuple[np.ndarray, np.ndarray, np.ndarray, Legend] | None:
    """A mesh of bars and beads, and its legend; None where the overlay colours the mesh instead."""
    if settings.overlay == "GRID" and (grids := result.control_grids(deformer)):
        numbers = sorted({f"{grid.shape[1]} x {grid.shape[0]} points" for grid in grids})
        return *grid_mesh(grids, settings.opacity), Legend("Control Grid", note=", ".join(numbers))
    if settings.overlay == "GRAPH" and (found := result.network(deformer)) is not None:
        nodes, links = found
        return *graph_mesh(nodes, links, settings.opacity), Legend("Graph", note=f"{len(nodes):,} nodes")
    return None


def shown_parameter(deformer: SinewDeformer, chosen: str) -> Parameter | None:
    """The parameter ``chosen``; if the method does not have it, another one; None if none can be painted."""
    paintable = deformer.definition.paintable
    return next((parameter for parameter in paintable if parameter.id == chosen), next(iter(paintable), None))


def _subject(deformer: SinewDeformer, settings: OverlaySettings) -> tuple:
    """The names, colours and numbers that the colours depend on besides the settings and the shape."""
    if settings.overlay == "REGIONS":
        return tuple((handle.uid, handle.name, tuple(handle.colour)) for handle in deformer.handles)
    if settings.overlay == "WEIGHT":
        handle = row_at(deformer.handles, deformer.active_handle)
        return () if handle is None else (handle.uid, handle.name, handle.weight)
    if settings.overlay == "CAGE":
        return result.selected(deformer)
    if settings.overlay == "PARAMETER":
        parameter = shown_parameter(deformer, settings.parameter)
        return () if parameter is None else (parameter.id, *_painted_by(deformer, parameter))
    return ()


def _painted_by(deformer: SinewDeformer, parameter: Parameter) -> tuple[float, str]:
    values = deformer.parameters
    return getattr(values, parameter.id), getattr(values, group_property(parameter))


def _paint(
    obj: Object, deformer: SinewDeformer, settings: OverlaySettings, shape: Result
) -> tuple[np.ndarray, Legend]:
    return {
        "REGIONS": _regions,
        "WEIGHT": _weight,
        "PARAMETER": _parameter,
        "MASK": _mask,
        "CAGE": _cage,
        "GRID": _no_grid,
        "GRAPH": _no_graph,
        "BANDS": _bands,
        "DISTORTION": _distortion,
    }[settings.overlay](obj, deformer, settings, shape)


def _regions(
    obj: Object, deformer: SinewDeformer, settings: OverlaySettings, shape: Result
) -> tuple[np.ndarray, Legend]:
    by_key = {handle.uid: handle for handle in deformer.handles}
    parts, rows = [], {}
    for key, members in zip(shape.handles, shape.indices):
        handle = by_key.get(key)
        if handle is None and key != _SUPPORT:
            continue
        strength, name, colour = 1.0, "Still", settings.fixed
        if handle is not None:
            strength = _strength(shape, handle, members)
            if handle.kind == "HANDLE":
                name, colour = handle.name, colours.on_screen(handle.colour)
        parts.append((members, strength, colour))
        rows[name] = colour
    rows = {**{name: colour for name, colour in rows.items() if name != "Still"}, **_only(rows, "Still")}
    mask = result.weights(obj, deformer, deformer.mask_group)
    if mask is not None:
        rows["Masked out"] = colours.HIDDEN
    shown = tuple(rows.items())[:_MOST_ROWS]
    note = f"and {len(rows) - len(shown)} more" if len(rows) > len(shown) else ""
    painted = colours.regions(len(shape.points), parts, settings.opacity, mask)
    return painted, Legend("Regions", rows=shown, note=note)


def _only(rows: dict[str, Colour], name: str) -> dict[str, Colour]:
    return {name: rows[name]} if name in rows else {}


def _strength(shape: Result, handle: SinewHandle, members: np.ndarray) -> np.ndarray | float:
    """How firmly a region holds its members, as the deformer is bound."""
    painted = shape.rest.weights.get(handle.vertex_group)
    return handle.weight if painted is None else painted[members] * np.float32(handle.weight)


def _weight(
    obj: Object, deformer: SinewDeformer, settings: OverlaySettings, shape: Result
) -> tuple[np.ndarray, Legend]:
    handle = row_at(deformer.handles, deformer.active_handle)
    values = np.zeros(len(shape.points), dtype=np.float32)
    if handle is None:
        return colours.field(values, settings.opacity), Legend("Handle Weight", note="No handle")
    painted = result.weights(obj, deformer, handle.vertex_group)
    if painted is not None:
        values = painted * np.float32(handle.weight)
    return colours.field(values, settings.opacity), colours.field_legend(f"Weight of {handle.name}")


def _parameter(
    obj: Object, deformer: SinewDeformer, settings: OverlaySettings, shape: Result
) -> tuple[np.ndarray, Legend]:
    count, parameter = len(shape.points), shown_parameter(deformer, settings.parameter)
    if parameter is None:
        nothing = np.zeros((count, 4), dtype=np.float32)
        return nothing, Legend("Parameter", note=f"{label_of(deformer.definition)} has no parameter to paint")
    value, group = _painted_by(deformer, parameter)
    painted = result.weights(obj, deformer, group)
    note = f"Painted by {group}" if painted is not None else "The same everywhere"
    values = np.ones(count, dtype=np.float32) if painted is None else painted
    if value <= 0.0:  # there is nothing to scale, so the value is 0 everywhere
        value, values = 1.0, np.zeros(count, dtype=np.float32)
    return colours.field(values, settings.opacity), colours.field_legend(parameter.label, value, note)


def _mask(
    obj: Object, deformer: SinewDeformer, settings: OverlaySettings, shape: Result
) -> tuple[np.ndarray, Legend]:
    mask = result.weights(obj, deformer, deformer.mask_group)
    note = f"Painted by {deformer.mask_group}" if mask is not None else "No mask: shown everywhere"
    values = np.ones(len(shape.points), dtype=np.float32) if mask is None else mask
    return colours.field(values, settings.opacity), colours.field_legend("Mask", note=note)


def _cage(
    _obj: Object, deformer: SinewDeformer, settings: OverlaySettings, shape: Result
) -> tuple[np.ndarray, Legend]:
    found = result.influence(deformer)
    if found is None:
        bare = np.zeros((len(shape.points), 4), dtype=np.float32)
        return bare, Legend("Cage Weight", note=f"{label_of(deformer.definition)} has no cage")
    count = len(found.vertices)
    title = (
        f"Weight of cage vertex {found.vertices[0]:,}" if count == 1 else f"Weight of {count:,} cage vertices"
    )
    painted = colours.influence(
        found.values, settings.compressed, settings.stretched, found.outside, settings.opacity
    )
    notes = [
        "Select vertices of the cage" if count == 0 else "",
        f"Negative down to {found.values.min():.2g}" if found.values.min() < -0.005 else "",
        f"{len(found.outside):,} outside the cage" if len(found.outside) else "",
    ]
    return painted, colours.field_legend(title, note=", ".join(filter(None, notes)))


def _no_grid(
    _obj: Object, deformer: SinewDeformer, _settings: OverlaySettings, shape: Result
) -> tuple[np.ndarray, Legend]:
    bare = np.zeros((len(shape.points), 4), dtype=np.float32)
    return bare, Legend("Control Grid", note=f"{label_of(deformer.definition)} has no control grid")


def _no_graph(
    _obj: Object, deformer: SinewDeformer, _settings: OverlaySettings, shape: Result
) -> tuple[np.ndarray, Legend]:
    bare = np.zeros((len(shape.points), 4), dtype=np.float32)
    return bare, Legend("Graph", note=f"{label_of(deformer.definition)} has no graph")


def _bands(
    _obj: Object, deformer: SinewDeformer, settings: OverlaySettings, shape: Result
) -> tuple[np.ndarray, Legend]:
    found = result.bands(deformer)
    if found is None:
        bare = np.zeros((len(shape.points), 4), dtype=np.float32)
        return bare, Legend("Bands", note=f"{label_of(deformer.definition)} has no bands")
    painted = colours.bands(found, settings.opacity)
    return painted, Legend("Bands", note=f"{found.max() + 1:,} bands" if len(found) else "")


def _distortion(
    obj: Object, deformer: SinewDeformer, settings: OverlaySettings, _shape: Result
) -> tuple[np.ndarray, Legend]:
    values = result.measure(obj, deformer, settings.measure).values
    ends = settings.compressed, settings.stretched
    painted = colours.ratios(values, settings.distortion_range, settings.opacity, *ends)
    label = _MEASURE_LABELS[settings.measure.value]
    legend = colours.ratio_legend(
        label, _ENDS[settings.measure], settings.distortion_range, settings.measure.two_sided, *ends, values
    )
    return painted, legend
