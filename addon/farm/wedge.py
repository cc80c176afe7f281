# SPDX-License-Identifier: GPL-3.0-or-later
"""Wedges: the same frames with several values of a property, each in a folder, and a picture of them all."""

import itertools
import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import bpy
from bpy.types import ID, Object, Scene, bpy_prop_array, bpy_prop_collection, bpy_struct
from mathutils import Euler, Vector

from ..bake import below, file_name, replacing
from ..compat import action_curves
from ..core.errors import SinewError
from ..properties import SinewDeformer

SHEET, TILE = "contact-sheet.png", "render.png"
_STEP = re.compile(r"(?:^|\.)([A-Za-z]\w*)|\[(\d{1,6})\]|\[\"([^\"\]]*)\"\]", re.ASCII)
_SIZE = 480, 360  # pixels of a render
_UNIT = 120  # pixels of the sheet
_LINE = 0.4  # units, of a line of text
_SAMPLES = 16, 4  # of a render, of the sheet
_LONGEST = 120  # letters of a folder


class _Place(NamedTuple):
    """A property: its owner, its name there, and the index in it if it is an array."""

    owner: bpy_struct
    name: str
    index: int = -1


@dataclass(frozen=True)
class Cell:
    """One combination of values, each by the path of its property below the object, and its folder."""

    folder: Path
    values: dict[str, str]

    def apply(self, obj: Object) -> None:
        """Set the values on an object. Raises an error that says which path or value does not fit."""
        for path, value in self.values.items():
            _set(obj, path, value)

    def is_rendered(self) -> bool:
        """Whether there is nothing to render, or the picture is there."""
        return not self.values or (self.folder / TILE).is_file()

    def render(self, frame: int, names: Sequence[str]) -> None:
        """Render a frame of the open shot into the folder; without a camera, one sees all the objects."""
        scene = bpy.context.scene
        scene.frame_set(frame)
        if scene.camera is None:
            scene.camera = _camera_around(scene, [bpy.data.objects[name, None] for name in names])
        if not any(obj.type == "LIGHT" for obj in scene.objects):
            sun = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
            sun.data.energy, sun.rotation_euler = 3.0, (0.6, 0.2, 0.4)
            scene.collection.objects.link(sun)
        _render(scene, below(self.folder, TILE), _SIZE, _SAMPLES[0])


def cells(out: Path, wedges: Sequence[tuple[str, list[str]]]) -> list[Cell]:
    """All combinations, in the order of the words; without wedges one, whose folder is ``out`` itself."""
    paths = [path for path, _values in wedges]
    last = [re.split(r"[.\[]", path)[-1] for path in paths]
    short = last if len(set(last)) == len(last) else paths
    found = []
    for values in itertools.product(*(values for _path, values in wedges)):
        text = ",".join(f"{name}={value}" for name, value in zip(short, values, strict=True))
        name = file_name(text, b"=.,[]")[:_LONGEST]
        found.append(Cell(below(out, name) if wedges else out, dict(zip(paths, values, strict=True))))
    if len({cell.folder for cell in found}) < len(found):
        raise SinewError("The names of the wedge's folders are too long to differ - use fewer properties")
    return found


def _steps(path: str) -> Iterator[str | int | tuple[str]]:
    at = 0
    while at < len(path):
        match = _STEP.match(path, at)
        if match is None:
            raise SinewError(f"{path} is no path such as sinew.deformers[0].factor, from {path[at:]!r} on")
        at = match.end()
        yield match[1] or (int(match[2]) if match[2] else (match[3],))


def _find(obj: Object, path: str) -> _Place:
    """Follow a path below an object, through properties of Blender alone, never to another datablock."""
    here, place = obj, None
    for step in _steps(path):
        if isinstance(step, str) and isinstance(here, SinewDeformer) and step == "parameters":
            here, place = here.parameters, None
        elif isinstance(step, str) and isinstance(here, bpy_struct) and step in here.bl_rna.properties:
            here, place = getattr(here, step), _Place(here, step)
        elif isinstance(here, bpy_prop_collection) and not isinstance(step, str):
            key = step if isinstance(step, int) else step[0]
            here, place = here[key] if _holds(here, key) else None, None
        elif (
            isinstance(step, int) and place is not None and isinstance(here, bpy_prop_array | Vector | Euler)
        ):
            here, place = here[step] if step < len(here) else None, place._replace(index=step)
        else:
            raise SinewError(f"{obj.name} has no property {path}: there is no {step} in it")
        if here is None or isinstance(here, ID):
            raise SinewError(f"{path} of {obj.name} leads to nothing, or to another datablock, at {step}")
    if place is None or isinstance(here, bpy_struct | bpy_prop_collection):
        raise SinewError(f"{path} of {obj.name} is no number and no choice")
    return place


def _holds(items: bpy_prop_collection, key: int | str) -> bool:
    return key < len(items) if isinstance(key, int) else key in items.keys()  # noqa: SIM118 (tuples, too)


def _set(obj: Object, path: str, text: str) -> None:
    owner, name, index = _find(obj, path)
    row = owner.bl_rna.properties[name]
    if (
        row.is_readonly
        or row.type not in ("FLOAT", "INT", "BOOLEAN", "ENUM")
        or (row.type != "ENUM" and row.is_array == (index < 0))
    ):
        raise SinewError(f"{path} of {obj.name} cannot be set: it is no single number and no choice")
    full = owner.path_from_id(name)
    animation = obj.animation_data
    keyed = [curve for _action, curve in action_curves(obj)] + list(animation.drivers if animation else ())
    if any(curve.data_path == full for curve in keyed):
        raise SinewError(f"{path} of {obj.name} is animated - remove its keys or drivers to set it")
    value = _read(row, text)
    if value is None:
        raise SinewError(f"{path} of {obj.name} cannot be {text}")
    try:
        if index < 0:
            setattr(owner, name, value)
        else:
            getattr(owner, name)[index] = value
    except TypeError as error:  # no item of a choice
        raise SinewError(f"{path} of {obj.name} cannot be {text}: {error}") from error
    obj.update_tag()


def _read(row: bpy.types.Property, text: str) -> float | int | bool | str | None:
    """The value that a text is for this property; None for one out of its range."""
    if row.type == "ENUM":
        return None if row.is_enum_flag else text
    if row.type == "BOOLEAN":
        return {"0": False, "1": True, "false": False, "true": True}.get(text.lower())
    try:
        value = int(text) if row.type == "INT" else float(text)
    except ValueError:
        return None
    return value if row.hard_min <= value <= row.hard_max else None


def _camera_around(scene: Scene, objects: Sequence[Object]) -> Object:
    """A new camera that sees the objects as they are shown now, from the front and above."""
    shown = [obj.evaluated_get(bpy.context.evaluated_depsgraph_get()) for obj in objects]
    corners = [obj.matrix_world @ Vector(corner) for obj in shown for corner in obj.bound_box]
    low, high = (Vector(map(most, zip(*corners, strict=True))) for most in (min, max))
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    turn, size = Euler((1.1, 0.0, 0.5)), max((high - low).length, 1e-3)
    camera.rotation_euler = turn
    camera.location = (low + high) / 2 + turn.to_matrix() @ Vector((0.0, 0.0, 1.9 * size))
    camera.data.clip_start, camera.data.clip_end = size / 100, size * 10
    scene.collection.objects.link(camera)
    return camera


def _render(scene: Scene, path: Path, size: tuple[int, int], samples: int) -> None:
    """Render one picture by the processor, for which no window and no graphics card is needed."""
    render = scene.render
    render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.device, scene.cycles.use_denoising = samples, "CPU", False
    render.resolution_x, render.resolution_y = size
    render.resolution_percentage, render.use_border = 100, False
    if hasattr(render.image_settings, "media_type"):
        render.image_settings.media_type = "IMAGE"
    render.image_settings.file_format = "PNG"
    with replacing(path) as made:
        render.filepath = str(made)
        bpy.ops.render.render(write_still=True, scene=scene.name)


def write_sheet(out: Path, cells: Sequence[Cell]) -> Path:
    """Write the picture of all renders, with the values below each. Returns its path."""
    columns = math.ceil(math.sqrt(len(cells)))
    lines = len(cells[0].values)
    width, height = _SIZE[0] / _UNIT, _SIZE[1] / _UNIT + _LINE * (lines + 0.5)
    rows = math.ceil(len(cells) / columns)
    scene = bpy.data.scenes.new("Contact Sheet")
    scene.view_settings.view_transform = "Standard"
    for number, cell in enumerate(cells):
        left, top = number % columns * width, -(number // columns) * height
        _add_picture(scene, cell.folder / TILE, left, top)
        text = bpy.data.curves.new("Values", "FONT")
        text.body = "\n".join(f"{path.rpartition('.')[2]} = {value}" for path, value in cell.values.items())
        text.align_x, text.size = "CENTER", 0.3
        text.materials.append(_glow(None))
        label = bpy.data.objects.new("Values", text)
        label.location = left + width / 2, top - _SIZE[1] / _UNIT - _LINE, 0.0
        scene.collection.objects.link(label)
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.data.type, camera.data.sensor_fit = "ORTHO", "HORIZONTAL"
    camera.data.ortho_scale = columns * width
    camera.location = columns * width / 2, -rows * height / 2, 5.0
    scene.collection.objects.link(camera)
    scene.camera = camera
    path = below(out, SHEET)
    size = round(columns * width * _UNIT), round(rows * height * _UNIT)
    _render(scene, path, size, _SAMPLES[1])
    return path


def _add_picture(scene: Scene, path: Path, left: float, top: float) -> None:
    """A rectangle that shows a picture as it is."""
    wide, high = (pixels / _UNIT for pixels in _SIZE)
    mesh = bpy.data.meshes.new("Picture")
    corners = [(left, top - high, 0), (left + wide, top - high, 0), (left + wide, top, 0), (left, top, 0)]
    mesh.from_pydata(corners, [], [(0, 1, 2, 3)])
    for loop, place in zip(mesh.uv_layers.new().data, ((0, 0), (1, 0), (1, 1), (0, 1)), strict=True):
        loop.uv = place
    mesh.materials.append(_glow(bpy.data.images.load(str(path))))
    scene.collection.objects.link(bpy.data.objects.new("Picture", mesh))


def _glow(image: bpy.types.Image | None) -> bpy.types.Material:
    """A material that is seen as it is, without light: a picture, or white."""
    material = bpy.data.materials.new("Glow")
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    out, glow = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("OutputMaterial", "Emission"))
    tree.links.new(out.inputs["Surface"], glow.outputs["Emission"])
    glow.inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
    if image is not None:
        shown = tree.nodes.new("ShaderNodeTexImage")
        shown.image = image
        tree.links.new(glow.inputs["Color"], shown.outputs["Color"])
    return material
