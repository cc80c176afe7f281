# SPDX-License-Identifier: GPL-3.0-or-later
"""A matrix as sheets in a Blender scene: a row per method, a picture per case, and figures below each."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import radians

import bpy
import numpy as np
from mathutils import Euler

from .. import materials, studio
from .cases import Case
from .matrix import Cell, Matrix
from .measures import Distortion

PLAIN = (0.56, 0.52, 0.46)
PIXELS = 100  # per unit of the scene
CELL, PICTURE, LINE, HEADING, MARGIN = 3.0, 2.1, 0.21, 0.36, 0.2
TEXT, TITLE = 0.185, 0.235
TILT = 16.0  # degrees by which one looks down
APART = 40.0  # between two sheets


@dataclass(frozen=True)
class Sheet:
    """One picture: rows of a matrix, under a number of lines of figures."""

    name: str
    rows: Sequence[str]
    lines: int = 3


def figures(found: Distortion) -> tuple[str, str, str]:
    """What is written below a picture."""
    volume = "" if found.volume is None else f"   volume {found.volume:.2f}"
    return (
        f"edges {found.edge_rms:.3f} rms,  {found.edge_least:.2f} to {found.edge_largest:.2f}",
        f"angles {found.angle_mean:.1f}° mean,  {found.angle_max:.0f}° most",
        f"area {found.area:.2f}{volume}",
    )


def add_sheets(scene: bpy.types.Scene, matrix: Matrix, sheets: Sequence[Sheet]) -> None:
    """Fill the scene with the sheets, side by side, and light them alike."""
    frames = {name: Frame.around(case, matrix.column(name)) for name, case in matrix.columns.items()}
    material = _material()
    for number, sheet in enumerate(sheets):
        left = APART * number
        for across, case in enumerate(matrix.columns.values()):
            x = left + MARGIN + CELL * (across + 0.5)
            add_text(scene, case.name, (x, -MARGIN - TITLE), TITLE, "CENTER")
        top = -MARGIN - 0.35
        for row in sheet.rows:
            add_text(scene, row, (left + MARGIN, top - 0.24), TITLE, "LEFT")
            for across, (name, case) in enumerate(matrix.columns.items()):
                x = left + MARGIN + CELL * (across + 0.5)
                cell = matrix.cells.get((row, name)) or Cell(case.points, None)
                _add_cell(
                    scene,
                    f"{row} {name}",
                    cell,
                    case,
                    frames[name],
                    (x, top - HEADING),
                    sheet.lines,
                    material,
                )
            top -= row_height(sheet.lines)
    _add_wall_and_light(scene, APART * len(sheets))


def row_height(lines: int) -> float:
    return HEADING + PICTURE + lines * LINE + 0.12


def look_at(scene: bpy.types.Scene, matrix: Matrix, sheets: Sequence[Sheet], number: int) -> None:
    """Point the camera at a sheet, and set the size of its picture."""
    sheet = sheets[number]
    width = 2 * MARGIN + CELL * len(matrix.columns)
    height = 2 * MARGIN + 0.35 + row_height(sheet.lines) * len(sheet.rows)
    camera = scene.camera
    camera.data.ortho_scale = max(width, height)
    camera.location = (APART * number + 0.5 * width, -50.0, -0.5 * height)
    scene.render.resolution_x, scene.render.resolution_y = round(PIXELS * width), round(PIXELS * height)


def add_camera(scene: bpy.types.Scene) -> None:
    data = bpy.data.cameras.new("Camera")
    data.type, data.clip_end = "ORTHO", 200.0
    scene.camera = bpy.data.objects.new("Camera", data)
    scene.camera.rotation_euler = (radians(90.0), 0.0, 0.0)
    studio.studio_collection(scene).objects.link(scene.camera)


@dataclass(frozen=True)
class Frame:
    """How all shapes of a case are placed in their cells: turned, then moved and scaled alike."""

    turn: np.ndarray  # (3, 3)
    centre: np.ndarray  # (3,)
    scale: float

    @staticmethod
    def around(case: Case, shapes: Sequence[np.ndarray]) -> Frame:
        """Every shape has room, unless it is much larger than the edit."""
        tilt = (
            Euler((radians(TILT), 0.0, 0.0)).to_matrix()
            @ Euler((0.0, 0.0, radians(case.heading))).to_matrix()
        )
        turn = np.array(tilt)
        wanted = np.vstack((case.points, case.targets)) @ turn.T
        low, high = wanted.min(0), wanted.max(0)
        room = 0.35 * (high - low)
        for shape in shapes:
            seen = shape @ turn.T
            low = np.maximum(np.minimum(low, seen.min(0)), low - room)
            high = np.minimum(np.maximum(high, seen.max(0)), high + room)
        size = high - low
        scale = min(0.92 * CELL / size[0], 0.96 * PICTURE / size[2])
        return Frame(turn, 0.5 * (low + high), scale)

    def place(self, points: np.ndarray, x: float, z: float) -> np.ndarray:
        return self.scale * (points @ self.turn.T - self.centre) + (x, 0.0, z)


def _add_cell(
    scene: bpy.types.Scene,
    name: str,
    cell: Cell,
    case: Case,
    frame: Frame,
    corner: tuple[float, float],
    lines: int,
    material: bpy.types.Material,
) -> None:
    x, top = corner
    if cell.shape is None:
        words = [cell.refusal[k : k + 34] for k in range(0, min(len(cell.refusal), 170), 34)]
        for number, line in enumerate(["cannot do this:", *words]):
            add_text(scene, line, (x, top - 0.6 - LINE * number), TEXT, "CENTER")
        return
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(frame.place(cell.shape, x, top - 0.5 * PICTURE).tolist(), [], case.triangles.tolist())
    mesh.polygons.foreach_set("use_smooth", [True] * len(mesh.polygons))
    mesh.use_auto_smooth, mesh.auto_smooth_angle = True, radians(50.0)
    for field, handle in zip(("fixed", "handle"), case.handles):
        values = np.full(len(case.points), -1.0, np.float32)
        values[handle] = 1.0
        mesh.attributes.new(field, "FLOAT", "POINT").data.foreach_set("value", values)
    height = np.zeros((len(case.points), 3), np.float32) + 0.25
    height[:, 0] = case.points[:, 2] if case.closed else 0.25
    mesh.attributes.new("rest", "FLOAT_VECTOR", "POINT").data.foreach_set("vector", height.ravel())
    mesh.materials.append(material)
    scene.collection.objects.link(bpy.data.objects.new(name, mesh))
    if cell.distortion is not None:
        for number, line in enumerate(figures(cell.distortion)[:lines]):
            add_text(scene, line, (x, top - PICTURE - LINE * (number + 0.8)), TEXT, "CENTER")


def _material() -> bpy.types.Material:
    patches = (("handle", materials.HANDLE_COLOUR, 0.05), ("fixed", materials.FIXED_COLOUR, 0.05))
    material = materials.patched_material("Surface", PLAIN, patches, roughness=0.6)
    materials.rule_lines(material, cell=0.5, line=0.06)
    return material


def add_text(scene: bpy.types.Scene, text: str, place: tuple[float, float], size: float, align: str) -> None:
    curve = bpy.data.curves.new(text, "FONT")
    curve.body, curve.font, curve.size, curve.align_x = text, studio.label_font(), size, align
    curve.materials.append(materials.ink_material())
    label = bpy.data.objects.new(f"Text {text}", curve)
    label.location = (place[0], -6.0, place[1])
    label.rotation_euler = (radians(90.0), 0.0, 0.0)
    label.hide_select, label.visible_shadow = True, False
    studio.studio_collection(scene).objects.link(label)


def _add_wall_and_light(scene: bpy.types.Scene, width: float) -> None:
    mesh = bpy.data.meshes.new("Wall")
    corners = [(-20, 4, -60), (width + 20, 4, -60), (width + 20, 4, 20), (-20, 4, 20)]
    mesh.from_pydata(corners, [], [(0, 1, 2, 3)])
    mesh.materials.append(materials.backdrop_material((0.78, 0.77, 0.74)))
    wall = bpy.data.objects.new("Wall", mesh)
    wall.hide_select = True
    sun = bpy.data.lights.new("Sun", "SUN")
    sun.energy, sun.angle = 2.6, radians(12.0)
    lamp = bpy.data.objects.new("Sun", sun)
    lamp.rotation_euler = Euler((radians(48.0), radians(-28.0), 0.0))
    for obj in (wall, lamp):
        studio.studio_collection(scene).objects.link(obj)
    scene.world = bpy.data.worlds.new("Sky")
    scene.world.use_nodes = True
    background = scene.world.node_tree.nodes["Background"].inputs
    background["Color"].default_value, background["Strength"].default_value = (0.75, 0.82, 0.95, 1.0), 0.55


def laplacian_deform(case: Case) -> np.ndarray:
    """Blender's own Laplacian Deform modifier, with its default of one repetition."""
    mesh = bpy.data.meshes.new("Peer")
    mesh.from_pydata(case.points.tolist(), [], case.triangles.tolist())
    peer = bpy.data.objects.new("Peer", mesh)
    bpy.context.scene.collection.objects.link(peer)
    peer.vertex_groups.new(name="Anchors").add(case.held.tolist(), 1.0, "REPLACE")
    modifier = peer.modifiers.new("Laplacian Deform", "LAPLACIANDEFORM")
    modifier.vertex_group = "Anchors"
    bpy.context.view_layer.update()
    with bpy.context.temp_override(object=peer, active_object=peer):
        bpy.ops.object.laplaciandeform_bind(modifier=modifier.name)
    bpy.context.view_layer.update()
    mesh.vertices.foreach_set("co", case.targets.astype(np.float32).ravel())
    mesh.update()
    peer.update_tag()
    points = np.empty(3 * len(case.points), np.float32)
    seen = peer.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    seen.vertices.foreach_get("co", points)
    bpy.data.objects.remove(peer)
    bpy.data.meshes.remove(mesh)
    return points.reshape(-1, 3).astype(np.float64)


def paged(rows: Mapping[str, object], count: int, name: str) -> Iterator[Sheet]:
    """Sheets of at most ``count`` rows each, of about the same length."""
    names = list(rows)
    pages = -(-len(names) // count)
    for page in range(pages):
        yield Sheet(
            f"{name}-{page + 1}", names[len(names) * page // pages : len(names) * (page + 1) // pages]
        )
