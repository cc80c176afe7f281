# SPDX-License-Identifier: GPL-3.0-or-later
"""Draw overlay meshes and their legend. Only this file uses the graphics card, and only while it draws."""

from dataclasses import dataclass

import numpy as np
from bpy.types import Area, Context, Object, Region, SpaceView3D

from ... import compat
from .overlay_colours import Legend
from .overlay_mesh import OverlayMesh

_NEARER = 5e-4  # share of the distance: in front of the mesh's own surface, behind everything nearer
_NEARER_EDIT = 1e-4  # the same, but behind the vertices and edges that Edit Mode draws
_CARD = (0.09, 0.09, 0.10, 0.72)
_TEXT = (0.92, 0.92, 0.92, 1.0)
_DIM = (0.66, 0.66, 0.66, 1.0)
_FONT = 0


@dataclass
class _Batch:
    """The buffers on the graphics card for one overlay mesh."""

    mesh: OverlayMesh
    batch: object


_batches: dict[str, _Batch] = {}
_legend_batch: list = [None, None]  # the legend; its place on the screen and its batch


def release() -> None:
    """Free all buffers on the graphics card."""
    _batches.clear()
    _legend_batch[:] = None, None


def nearer(projection: np.ndarray, distance: float, share: float) -> np.ndarray:
    """The projection (4, 4) that moves everything a little towards the viewer, in depth alone.

    In perspective it moves a point by the ``share`` of its distance from the viewer, else by this share of
    ``distance``, the distance of the view.
    """
    moved = projection.copy()
    if projection[3, 3] == 0.0:
        moved[2, 3] /= 1.0 - share
    else:
        moved[2, 3] += projection[2, 2] * share * distance
    return moved


def draw_mesh(context: Context, key: str, obj: Object, mesh: OverlayMesh) -> None:
    """Draw an overlay mesh over the object, in the 3D space of the viewport."""
    import gpu
    from mathutils import Matrix

    shader = compat.smooth_colour_shader()
    known = _batches.get(key)
    if known is None or known.mesh is not mesh:
        known = _batches[key] = _Batch(mesh, _make_batch(mesh.points, mesh.colours, mesh.triangles))
    projection = np.array(gpu.matrix.get_projection_matrix(), dtype=np.float64)
    share = _NEARER_EDIT if obj.mode == "EDIT" else _NEARER
    gpu.state.blend_set("ALPHA")
    gpu.state.depth_test_set("LESS_EQUAL")
    with gpu.matrix.push_pop(), gpu.matrix.push_pop_projection():
        gpu.matrix.load_projection_matrix(
            Matrix(nearer(projection, context.region_data.view_distance, share).tolist())
        )
        gpu.matrix.multiply_matrix(obj.matrix_world)
        # Blender hides no far sides here: draw the depth first, so that ours are hidden.
        if _sees_through(context.space_data):
            gpu.state.depth_mask_set(True)
            gpu.state.color_mask_set(False, False, False, False)
            known.batch.draw(shader)
            gpu.state.color_mask_set(True, True, True, True)
            gpu.state.depth_mask_set(False)
        known.batch.draw(shader)
    gpu.state.depth_test_set("NONE")
    gpu.state.blend_set("NONE")


def _sees_through(space: SpaceView3D) -> bool:
    """Whether the viewport draws meshes that do not hide what lies behind them."""
    shading = space.shading
    return shading.type == "WIREFRAME" or (shading.type == "SOLID" and shading.show_xray)


def draw_legend(context: Context, legend: Legend) -> None:
    """Draw the legend on a card at the lower right corner of the viewport, beside the sidebar."""
    import blf
    import gpu

    unit = context.preferences.system.ui_scale
    size = context.preferences.ui_styles[0].widget.points * unit
    compat.set_text_size(_FONT, size)
    card = _lay_out(legend, *_corner(context.area, context.region), unit, blf)
    if _legend_batch[0] is not legend or _legend_batch[1][0] != card.place:
        _legend_batch[:] = legend, (card.place, _make_batch(*card.shapes()))
    gpu.state.blend_set("ALPHA")
    _legend_batch[1][1].draw(compat.smooth_colour_shader())
    gpu.state.blend_set("NONE")
    for x, y, text, colour in card.texts:
        blf.position(_FONT, x, y, 0.0)
        blf.color(_FONT, *colour)
        blf.draw(_FONT, text)


def draw_lines(context: Context, lines: list[str]) -> None:
    """Draw lines of text at the lower left corner of the viewport, beside the toolbar."""
    import blf

    unit = context.preferences.system.ui_scale
    compat.set_text_size(_FONT, context.preferences.ui_styles[0].widget.points * unit)
    left, bottom = _left_corner(context.area, context.region)
    blf.color(_FONT, *_TEXT)
    blf.enable(_FONT, blf.SHADOW)
    blf.shadow(_FONT, 3, 0.0, 0.0, 0.0, 1.0)
    for number, line in enumerate(reversed(lines)):
        blf.position(_FONT, left + 14 * unit, bottom + (14 + 19 * number) * unit, 0.0)
        blf.draw(_FONT, line)
    blf.disable(_FONT, blf.SHADOW)


def _make_batch(points: np.ndarray, colours: np.ndarray, triangles: np.ndarray):
    import gpu

    layout = gpu.types.GPUVertFormat()
    layout.attr_add(id="pos", comp_type="F32", len=3, fetch_mode="FLOAT")
    layout.attr_add(id="color", comp_type="F32", len=4, fetch_mode="FLOAT")
    vertices = gpu.types.GPUVertBuf(layout, len(points))
    vertices.attr_fill("pos", np.ascontiguousarray(points, dtype=np.float32))
    vertices.attr_fill("color", np.ascontiguousarray(colours, dtype=np.float32))
    indices = gpu.types.GPUIndexBuf(type="TRIS", seq=np.ascontiguousarray(triangles, dtype=np.int32))
    return gpu.types.GPUBatch(type="TRIS", buf=vertices, elem=indices)


class _Card:
    """Shapes and texts in pixels of the region. The layout depends on ``place`` alone."""

    def __init__(self, place: tuple) -> None:
        self.place = place
        self.texts: list[tuple[float, float, str, tuple]] = []
        self._points: list[np.ndarray] = []
        self._colours: list[np.ndarray] = []
        self._triangles: list[np.ndarray] = []
        self._count = 0

    def add(self, points: np.ndarray, colours: np.ndarray, triangles: np.ndarray) -> None:
        """Add a shape: points (k, 2), colours (k, 4) or (4,), triangles (t, 3)."""
        self._points.append(np.column_stack((points, np.zeros(len(points)))))
        self._colours.append(np.broadcast_to(colours, (len(points), 4)))
        self._triangles.append(triangles + self._count)
        self._count += len(points)

    def rounded(self, x: float, y: float, width: float, height: float, radius: float, colour: tuple) -> None:
        """Add a box with round corners."""
        turn = np.linspace(0.0, 0.5 * np.pi, 6)
        arc = np.column_stack((np.cos(turn), np.sin(turn))) * radius
        corners = (
            (arc, x + width - radius, y + height - radius),
            (arc @ ((0, 1), (-1, 0)), x + radius, y + height - radius),
            (-arc, x + radius, y + radius),
            (arc @ ((0, -1), (1, 0)), x + width - radius, y + radius),
        )
        points = np.concatenate([part + (cx, cy) for part, cx, cy in corners])
        middle = np.arange(1, len(points) - 1)
        fan = np.column_stack((np.zeros_like(middle), middle, middle + 1))
        self.add(points, np.array((*colour[:3], colour[3] if len(colour) == 4 else 1.0)), fan)

    def band(self, x: float, y: float, width: float, height: float, rgb: np.ndarray) -> None:
        """Add a bar with the colours (k, 3) from left to right."""
        at = np.repeat(np.linspace(x, x + width, len(rgb)), 2)
        points = np.column_stack((at, np.tile((y, y + height), len(rgb))))
        colours = np.column_stack((np.repeat(rgb, 2, axis=0), np.ones(2 * len(rgb))))
        left = np.arange(0, 2 * len(rgb) - 2, 2)[:, None]
        self.add(points, colours, np.concatenate((left + (0, 2, 1), left + (1, 2, 3))))

    def text(self, x: float, y: float, text: str, colour: tuple = _TEXT) -> None:
        """Add one line of text, with its base line at ``y``."""
        self.texts.append((x, y, text, colour))

    def shapes(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """All shapes as one mesh."""
        return (
            np.concatenate(self._points),
            np.concatenate(self._colours),
            np.concatenate(self._triangles),
        )


def _corner(area: Area, region: Region) -> tuple[int, int]:
    """The lower right corner of the area that other regions leave free, in pixels of the region."""
    right, bottom = region.width, 0
    for other in area.regions:
        if other.type == "UI" and other.alignment == "RIGHT" and other.width > 1:
            right = min(right, other.x - region.x)
        elif other.type != "WINDOW" and other.alignment == "BOTTOM" and other.height > 1:
            bottom = max(bottom, other.y + other.height - region.y)
    return right, bottom


def _left_corner(area: Area, region: Region) -> tuple[int, int]:
    """The lower left corner of the area that other regions leave free, in pixels of the region."""
    left = 0
    for other in area.regions:
        if other.type == "TOOLS" and other.alignment == "LEFT" and other.width > 1:
            left = max(left, other.x + other.width - region.x)
    return left, _corner(area, region)[1]


def _lay_out(legend: Legend, right: int, bottom: int, unit: float, blf) -> _Card:
    def width(text: str) -> float:
        return blf.dimensions(_FONT, text)[0]

    line, pad, swatch, gap = round(19 * unit), round(10 * unit), round(12 * unit), round(8 * unit)
    wide = max((width(text) for text in (legend.title, legend.note)), default=0.0)
    wide = max((wide, *(swatch + gap + width(name) for name, _colour in legend.rows)))
    lines = 1 + len(legend.rows) + bool(legend.note)
    lines += bool(legend.ends)
    bar_height = 0
    if legend.bar is not None:
        wide, bar_height = max(wide, 190 * unit), round(14 * unit) + line + gap // 2
    height = lines * line + bar_height + 2 * pad - round(6 * unit)
    x, y = right - wide - 2 * pad - 1.2 * pad, bottom + 1.2 * pad
    card = _Card((right, bottom, unit))
    card.rounded(x, y, wide + 2 * pad, height, 5 * unit, _CARD)
    x += pad
    y += height - pad - round(10 * unit)
    card.text(x, y, legend.title)
    for name, colour in legend.rows:
        y -= line
        card.rounded(x, y - 2 * unit, swatch, swatch, 2.5 * unit, colour)
        card.text(x + swatch + gap, y, name)
    if legend.bar is not None:
        y -= gap + round(14 * unit)
        card.band(x, y, wide, round(14 * unit), legend.bar)
        y -= line - gap // 2
        for share, text in legend.ticks:
            card.text(x + share * (wide - width(text)), y, text, _DIM)
    if legend.ends:
        y -= line - gap // 4
        card.text(x, y, legend.ends[0], _DIM)
        card.text(x + wide - width(legend.ends[1]), y, legend.ends[1], _DIM)
    if legend.note:
        y -= line
        card.text(x, y, legend.note, _DIM)
    return card
