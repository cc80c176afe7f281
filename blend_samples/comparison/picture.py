# SPDX-License-Identifier: GPL-3.0-or-later
"""Sheets in a Blender scene: rows of shapes, such as those of a matrix, with figures below each."""

import textwrap
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from math import radians

import bpy
import numpy as np
from bpy.types import Material, NodeSocket, Scene
from mathutils import Vector

from .. import denoise, materials, posing, studio
from ..models.objects import add_colours, add_fields, add_groups, mesh_object
from ..models.shapes import rotation
from .cases import Case
from .figures import PLAIN, Shown
from .matrix import Distortion, Matrix, distortion

INSIDE = (0.30, 0.10, 0.22)  # the side of a surface that is plain on the other
PAPER = (0.90, 0.90, 0.885)
KEY = Vector((-0.62, -0.52, 0.59)).normalized()  # where the light comes from
PIXELS = 100  # per unit of the scene
CELL, PICTURE, LINE, HEADING, MARGIN = 3.0, 2.1, 0.21, 0.36, 0.2
TEXT, TITLE = 0.185, 0.235
TILT = 16.0  # degrees by which one looks down
APART = 40.0  # between two sheets


@dataclass(frozen=True)
class Frame:
    """How all shapes of a case are placed in their cells: turned, then moved and scaled alike."""

    turn: np.ndarray  # (3, 3)
    centre: np.ndarray  # (3,)
    scale: float

    @classmethod
    def around(cls, case: Case, shapes: Sequence[np.ndarray]) -> "Frame":
        """Every shape has room, unless it is much larger than the edit."""
        turn = rotation(x=TILT) @ rotation(z=case.heading)
        wanted = np.vstack((case.points, case.targets)) @ turn.T
        low, high = wanted.min(0), wanted.max(0)
        room = 0.35 * (high - low)
        for shape in shapes:
            seen = shape @ turn.T
            low = np.maximum(np.minimum(low, seen.min(0)), low - room)
            high = np.minimum(np.maximum(high, seen.max(0)), high + room)
        size = high - low
        scale = min(0.92 * CELL / size[0], 0.96 * PICTURE / size[2])
        return cls(turn, 0.5 * (low + high), scale)

    def place(self, points: np.ndarray, x: float, z: float) -> np.ndarray:
        return self.scale * (points @ self.turn.T - self.centre) + (x, 0.0, z)


@dataclass(frozen=True)
class View:
    """One shape of a case, or why there is none; with lines below it. Colours are (n, 3)."""

    case: Case
    shape: np.ndarray | None
    frame: Frame
    lines: Sequence[str]
    colours: np.ndarray | None = None
    flat: bool = False


@dataclass(frozen=True)
class Sheet:
    """One picture: a line of headings, and rows of views, each with a title."""

    name: str
    heads: Sequence[str]
    rows: Mapping[str, Sequence[View]]

    @property
    def lines(self) -> int:
        return max(len(view.lines) for views in self.rows.values() for view in views)

    @property
    def row_height(self) -> float:
        return HEADING + PICTURE + self.lines * LINE + 0.12

    @property
    def top(self) -> float:
        return MARGIN + (0.35 if self.heads else 0.0)

    @property
    def size(self) -> tuple[float, float]:
        across = max(len(views) for views in self.rows.values())
        return 2 * MARGIN + CELL * across, self.top + MARGIN + self.row_height * len(self.rows)


def figures(found: Distortion) -> tuple[str, ...]:
    """What is written below a picture."""
    volume = "" if found.volume is None else f"   volume {found.volume:.2f}"
    return (
        f"edges {found.edge_rms:.3f} rms,  {found.edge_least:.2f} to {found.edge_largest:.2f}",
        f"angles {found.angle_mean:.1f}° mean,  {found.angle_max:.0f}° most",
        f"faces ±{found.face_area_mean:.2f} mean,  {found.face_area_max:.2f} most",
        f"area {found.area:.2f}{volume}",
    )


def of_matrix(matrix: Matrix, rows: Sequence[str], name: str, lines: int = 4, rest: str = "") -> Sheet:
    """A sheet of some rows of a matrix; the row ``rest``, if it is named, comes first."""
    cases = matrix.columns
    frames = {key: Frame.around(case, matrix.column(key)) for key, case in cases.items()}
    found: dict[str, list[View]] = {}
    if rest:
        found[rest] = [View(case, case.points, frames[key], ()) for key, case in cases.items()]
    for row in rows:
        found[row] = []
        for key, case in cases.items():
            cell = matrix.cells[row, key]
            words = figures(cell.distortion) if cell.distortion else refused(cell.refusal)
            found[row].append(View(case, cell.shape, frames[key], words[:lines]))
    return Sheet(name, [case.name for case in cases.values()], found)


def refused(why: str) -> Sequence[str]:
    return ("cannot do this:", *textwrap.wrap(why, 30))


def of_figure(title: str, every: Sequence[Shown], name: str) -> Sheet:
    """A sheet with one row: the views of a figure of the tutorial."""
    frame = Frame.around(every[0].case, [each.shape for each in every])
    views = []
    for each in every:
        note = figures(distortion(each.case, each.shape))[0] if each.note is None else each.note
        words = (each.caption, note) if note else (each.caption,)
        views.append(View(each.case, each.shape, frame, words, each.colours, each.flat))
    return Sheet(name, (), {title: views})


def show(scene: Scene, sheets: Sequence[Sheet]) -> None:
    """Fill the scene with the sheets, side by side, on paper; the camera sees the first. There is no light
    but what the camera sees itself, and colours are as they are."""
    data = bpy.data.cameras.new("Camera")
    data.type, data.clip_end = "ORTHO", 200.0
    scene.camera = studio.put(scene, "Camera", data)
    scene.camera.rotation_euler = (radians(90.0), 0.0, 0.0)
    _add_sheets(scene, sheets)
    studio.set_up_render(scene, 16, 1440, 600)
    scene.cycles.use_adaptive_sampling, scene.cycles.max_bounces = False, 0
    scene.cycles.filter_width = 1.0
    scene.view_settings.view_transform, scene.view_settings.look = "Standard", "None"
    scene.view_settings.exposure = 0.0
    look_at(scene, sheets, 0)
    studio.look_through_camera()


def _add_sheets(scene: Scene, sheets: Sequence[Sheet]) -> None:
    ink = _glowing(materials.patched_material("Ink", (0.012, 0.012, 0.015), (), roughness=0.6))
    material = _material()
    scene.world = bpy.data.worlds.new("Paper")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (*PAPER, 1.0)
    for number, sheet in enumerate(sheets):
        left = APART * number + MARGIN
        for across, head in enumerate(sheet.heads):
            studio.add_text(scene, head, (left + CELL * (across + 0.5), -6.0, -MARGIN - TITLE), TITLE, ink)
        for down, (title, views) in enumerate(sheet.rows.items()):
            top = -sheet.top - sheet.row_height * down
            studio.add_text(scene, title, (left, -6.0, top - 0.24), TITLE, ink, "LEFT")
            for across, view in enumerate(views):
                place = left + CELL * (across + 0.5), top - HEADING
                _add_view(scene, f"{title} {across}", view, place, material, ink)


def rendered(scene: Scene, sheets: Sequence[Sheet]) -> Iterator[tuple[str, np.ndarray]]:
    """One picture per sheet: its name and its light (height, width, 3)."""
    for number, sheet in enumerate(sheets):
        look_at(scene, sheets, number)
        bpy.context.view_layer.update()
        yield sheet.name, denoise.render_passes(scene, ("Image",))["Image"]


def look_at(scene: Scene, sheets: Sequence[Sheet], number: int) -> None:
    """Point the camera at a sheet, and set the size of its picture."""
    width, height = sheets[number].size
    camera = scene.camera
    camera.data.ortho_scale = max(width, height)
    camera.location = (APART * number + 0.5 * width, -50.0, -0.5 * height)
    scene.render.resolution_x, scene.render.resolution_y = round(PIXELS * width), round(PIXELS * height)


def _add_view(
    scene: Scene, name: str, view: View, corner: tuple[float, float], material: Material, ink: Material
) -> None:
    x, top = corner
    for number, line in enumerate(view.lines):
        studio.add_text(scene, line, (x, -6.0, top - PICTURE - LINE * (number + 0.8)), TEXT, ink)
    if view.shape is None:
        return
    case = view.case
    placed = view.frame.place(view.shape, x, top - 0.5 * PICTURE)
    mesh = mesh_object(name, placed, case.triangles, smooth=not view.flat, materials=[material]).data
    add_colours(mesh, np.tile(PLAIN, (len(placed), 1)) if view.colours is None else view.colours)
    mesh.use_auto_smooth, mesh.auto_smooth_angle = True, radians(50.0)
    held = [np.isin(np.arange(len(case.points)), handle) for handle in case.handles]
    add_fields(mesh, {field: np.where(own, 1.0, -1.0) for field, own in zip(("fixed", "handle"), held)})
    height = np.full((len(case.points), 3), 0.25, np.float32)  # between two lines
    if case.closed:
        height[:, 0] = case.points[:, 2]
    mesh.attributes["rest"].data.foreach_set("vector", height.ravel())


def _material() -> Material:
    """Light from one side and the sky, computed from the normal, and so without noise."""
    patches = (("handle", materials.HANDLE_COLOUR, 0.05), ("fixed", materials.FIXED_COLOUR, 0.05))
    material = materials.patched_material("Surface", PLAIN, patches, roughness=0.6)
    tree = material.node_tree
    base = tree.nodes["RGB"].outputs[0].links[0].to_socket
    tree.links.new(materials.attribute(material, "Colour", "Color"), base)
    seen = tree.nodes.new("ShaderNodeNewGeometry").outputs
    math = partial(materials.add_math, tree)
    key, up, front = (
        materials.add_node(tree, "VectorMath", {0: seen["Normal"], 1: way}, operation="DOT_PRODUCT")
        for way in (KEY, (0, 0, 1), (0, -1, 0))
    )
    sky = math("MULTIPLY_ADD", up, 0.10, 0.22)
    light = math("MULTIPLY_ADD", math("POWER", math("MAXIMUM", key, 0.0), 1.3), 0.85, sky)
    facing = math("MULTIPLY_ADD", math("MINIMUM", math("MULTIPLY", front, 1.6), 1.0), 0.45, 0.55)
    painted = tree.nodes["Principled BSDF"].inputs["Base Color"]
    sides = {"Fac": seen["Backfacing"], "Color1": painted.links[0].from_socket, "Color2": (*INSIDE, 1.0)}
    tree.links.new(materials.add_node(tree, "MixRGB", sides), painted)
    materials.rule_lines(material, cell=0.5, line=0.06)
    return _glowing(material, math("MULTIPLY", light, facing))


def _glowing(material: Material, light: NodeSocket | float = 1.0) -> Material:
    """The material as a lamp of its colour."""
    tree = material.node_tree
    colour = tree.nodes["Principled BSDF"].inputs["Base Color"].links[0].from_socket
    glow = materials.add_node(tree, "Emission", {"Color": colour, "Strength": light})
    tree.links.new(glow, tree.nodes["Material Output"].inputs["Surface"])
    return material


def laplacian_deform(case: Case) -> np.ndarray:
    """Blender's own Laplacian Deform modifier, with its default of one repetition."""
    peer = mesh_object("Peer", case.points, case.triangles)
    mesh = peer.data
    add_groups(peer, {"Anchors": case.held})
    modifier = peer.modifiers.new("Laplacian Deform", "LAPLACIANDEFORM")
    modifier.vertex_group = "Anchors"
    bpy.context.view_layer.update()
    with bpy.context.temp_override(object=peer, active_object=peer):
        bpy.ops.object.laplaciandeform_bind(modifier=modifier.name)
    bpy.context.view_layer.update()
    mesh.vertices.foreach_set("co", case.targets.astype(np.float32).ravel())
    mesh.update()
    peer.update_tag()
    points = posing.shape(peer).astype(np.float64)
    bpy.data.objects.remove(peer)
    bpy.data.meshes.remove(mesh)
    return points


def paged(matrix: Matrix, count: int, name: str) -> Iterator[Sheet]:
    """All rows of a matrix, on sheets of at most ``count`` rows each, of about the same length."""
    names = list(matrix.rows)
    pages = -(-len(names) // count)
    for page in range(pages):
        shown = names[len(names) * page // pages : len(names) * (page + 1) // pages]
        yield of_matrix(matrix, shown, f"{name}-{page + 1}")
