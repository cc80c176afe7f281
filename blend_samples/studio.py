# SPDX-License-Identifier: GPL-3.0-or-later
"""The photo studio of the samples: backdrop, lights, camera, labels, render settings."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import cos, pi, radians, sin
from pathlib import Path

import bpy
from bpy.types import ID, Collection, Material, Object, Scene, SpaceView3D, VectorFont
from mathutils import Vector

from .materials import add_math, add_node, plain_material

FRAMES = (1, 96)
# Area lights: where they are from the target, as multiples of the lit place, and their size, power and colour
LAMPS = (
    ("Key", (-0.75, -0.95, 1.25), 0.70, 46.0, (1.0, 0.93, 0.84)),
    ("Rim", (0.95, 0.95, 0.95), 0.55, 32.0, (0.80, 0.90, 1.0)),
)


@dataclass(frozen=True)
class Shot:
    """How a sample is photographed: the camera sees ``width`` units at the target."""

    target: Sequence[float]
    width: float
    elevation: float = 10.0  # degrees
    distance: float = 24.0
    lit: float = 0.9  # the height at which the lights point
    light: float = 9.0  # the size of the lit place
    picture: tuple[int, int] = (1440, 600)  # pixels
    samples: int = 64
    tint: Sequence[float] = (0.54, 0.485, 0.42)  # of the backdrop
    text: float = 0.17  # the size of labels
    front: float = -1.0  # their y
    aside: float = 0.0  # how far to the right of an object
    nearer: float = 1.0  # the x of objects times this, as the camera sees their middle
    floor: float = 0.0  # the height that labels stand on

    def set_up(self, scene: Scene, labels: Iterable[tuple[str, float]]) -> None:
        """Add backdrop, camera, lights and a label for each object, by its x; and set up the renderer."""
        add_backdrop(scene, 14.0, self.tint)
        add_camera(scene, self.target, self.distance, self.elevation, self.width)
        add_lights(scene, (0.0, 0.0, self.lit), self.light)
        for text, x in labels:
            add_label(scene, text, (self.nearer * x + self.aside, self.front, self.floor), self.text)
        set_up_render(scene, self.samples, *self.picture)

    def add_notes(self, scene: Scene, notes: Iterable[tuple[str, float]]) -> None:
        """A second, smaller line below each label."""
        for text, x in notes:
            add_label(scene, text, (x + self.aside, self.front - 0.5, self.floor), 0.85 * self.text)


def empty_scene() -> Scene:
    """A scene with nothing in it, seconds of 24 frames, colours managed for soft daylight."""
    progress("modelling")
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)  # keeps the add-ons enabled
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = FRAMES
    scene.render.fps = 24
    scene.view_settings.view_transform = "Filmic"
    scene.view_settings.look = "High Contrast"
    scene.view_settings.exposure = 0.1
    return scene


def progress(text: str) -> None:
    print(f"> {text} ...", flush=True)


def set_up_render(scene: Scene, samples: int, width: int, height: int) -> None:
    """Cycles on the CPU, few bounces. Debian's build has no denoiser: see ``denoise``."""
    render, cycles = scene.render, scene.cycles
    render.engine, render.use_persistent_data = "CYCLES", False
    render.resolution_x, render.resolution_y, render.resolution_percentage = width, height, 100
    render.image_settings.file_format, render.image_settings.color_mode = "PNG", "RGB"
    render.image_settings.compression = 90
    cycles.device, cycles.use_denoising, cycles.samples = "CPU", False, samples
    cycles.use_adaptive_sampling, cycles.adaptive_threshold = True, 0.03
    cycles.adaptive_min_samples = min(24, samples)
    cycles.max_bounces, cycles.diffuse_bounces, cycles.glossy_bounces = 4, 2, 2
    cycles.transmission_bounces = cycles.transparent_max_bounces = 2
    cycles.sample_clamp_indirect, cycles.blur_glossy = 3.0, 1.0
    cycles.caustics_reflective = cycles.caustics_refractive = False
    cycles.pixel_filter_type, cycles.filter_width = "BLACKMAN_HARRIS", 1.6


def studio_collection(scene: Scene) -> Collection:
    """The collection of everything that is not posed."""
    if "Studio" not in scene.collection.children:
        scene.collection.children.link(bpy.data.collections.new("Studio"))
    return scene.collection.children["Studio"]


def put(
    scene: Scene,
    name: str,
    data: ID,
    place: Sequence[float] = (0.0, 0.0, 0.0),
    target: Sequence[float] | None = None,
) -> Object:
    """A new object of the studio, which looks at a target if there is one."""
    obj = bpy.data.objects.new(name, data)
    obj.location = place
    if target is not None:
        obj.rotation_euler = (Vector(target) - Vector(place)).to_track_quat("-Z", "Y").to_euler()
    studio_collection(scene).objects.link(obj)
    return obj


def add_backdrop(scene: Scene, behind: float, tint: Sequence[float], width: float = 80.0) -> None:
    """A floor at z = 0 that bends up into a wall at ``y = behind``, seen from -y."""
    radius = 6.0
    turns = [pi * k / 48 for k in range(25)]
    bow = [(behind - radius + radius * sin(turn), radius - radius * cos(turn)) for turn in turns]
    profile = [(-40.0, 0.0), *bow, (behind, 40.0)]
    points = [(x, y, z) for y, z in profile for x in (-width / 2, width / 2)]
    faces = [(2 * i, 2 * i + 1, 2 * i + 3, 2 * i + 2) for i in range(len(profile) - 1)]
    mesh = bpy.data.meshes.new("Backdrop")
    mesh.from_pydata(points, [], faces)
    mesh.polygons.foreach_set("use_smooth", [True] * len(faces))
    mesh.materials.append(plain_material("Backdrop", tint, roughness=0.9, specular=0.1))
    put(scene, "Backdrop", mesh).hide_select = True


def add_lights(scene: Scene, target: Sequence[float], size: float) -> None:
    """A large warm key from the upper left, a cool rim from behind; the sky fills the shadows."""
    world = bpy.data.worlds.new("Sky")
    scene.world = world
    world.use_nodes = True
    tree, background = world.node_tree, world.node_tree.nodes["Background"].inputs
    split = tree.nodes.new("ShaderNodeSeparateXYZ")
    tree.links.new(add_node(tree, "TexCoord", {}), split.inputs[0])
    ramp = add_node(tree, "ValToRGB", {0: add_math(tree, "MULTIPLY_ADD", split.outputs["Z"], 0.5, 0.5)})
    low, high = ramp.node.color_ramp.elements
    low.position, low.color = 0.35, (0.55, 0.50, 0.46, 1)
    high.position, high.color = 1.0, (0.62, 0.72, 0.90, 1)
    tree.links.new(ramp, background["Color"])
    background["Strength"].default_value = 0.31
    world.cycles.sampling_method = "NONE"  # smooth: chance finds it with less noise

    for name, direction, spread, power, colour in LAMPS:
        light = bpy.data.lights.new(name, "AREA")
        light.shape, light.size = "DISK", spread * size
        light.energy, light.color = power * size * size, colour  # as bright there at any size
        lamp = put(scene, name, light, Vector(target) + size * Vector(direction), target)
        lamp.hide_set(True)  # its lines would cross the view; it shines all the same


def add_camera(
    scene: Scene, target: Sequence[float], distance: float, elevation: float, width: float
) -> None:
    """A long lens that sees ``width`` units at the target, from ``elevation`` degrees above it."""
    camera = bpy.data.cameras.new("Camera")
    camera.sensor_width = 36.0
    camera.lens = camera.sensor_width * distance / width
    camera.clip_end = 500.0
    rise = radians(elevation)
    place = Vector(target) + distance * Vector((0.0, -cos(rise), sin(rise)))
    scene.camera = put(scene, "Camera", camera, place, target)


def add_label(scene: Scene, text: str, place: Sequence[float], size: float) -> None:
    """A line of text above ``place`` on the floor, parallel to the picture; the camera is there already."""
    above = Vector(place) + Vector((0.0, 0.0, 0.28 * size))  # room below the line for g and p
    ink = plain_material("Ink", (0.035, 0.035, 0.04), roughness=0.8, specular=0.1)
    add_text(scene, text, above, size, ink).data.extrude = 0.02 * size


def add_text(
    scene: Scene, text: str, place: Sequence[float], size: float, ink: Material, align: str = "CENTER"
) -> Object:
    """A line of text, parallel to the picture, without a shadow."""
    curve = bpy.data.curves.new(text, "FONT")
    curve.body, curve.font, curve.size, curve.align_x = text, label_font(), size, align
    curve.materials.append(ink)
    label = put(scene, f"Label {text}", curve, place)
    label.rotation_euler = scene.camera.rotation_euler
    label.hide_select, label.visible_shadow = True, False
    return label


def label_font() -> VectorFont:
    """Blender's own interface font, stored in the file; the built-in one where it is missing."""
    for font in bpy.data.fonts:
        if font.name.startswith("DejaVu"):
            return font
    folder = Path(bpy.utils.system_resource("DATAFILES")) / "fonts"
    for file in sorted(folder.glob("DejaVuSans.*")):
        font = bpy.data.fonts.load(str(file))
        font.pack()
        return font
    return bpy.data.fonts.load("<builtin>")


def open_at(scene: Scene, frame: int, posed: Object) -> None:
    """Make the file open with the view through the camera; a control is selected, or what has none."""
    scene.frame_set(frame)
    for other in scene.objects:
        other.select_set(other == posed and not posed.sinew.deformers)
    for deformer in posed.sinew.deformers[:1]:
        for control in (deformer.cage, *(handle.control for handle in deformer.handles[:1])):
            if control:
                control.select_set(True)
    bpy.context.view_layer.objects.active = posed
    for space in look_through_camera():
        space.shading.color_type = "VERTEX" if posed.data.color_attributes else "MATERIAL"


def look_through_camera() -> list[SpaceView3D]:
    """Let every 3D view of the file open with the camera's view, and return them."""
    areas = (area for screen in bpy.data.screens for area in screen.areas)
    spaces = [area.spaces.active for area in areas if area.type == "VIEW_3D"]
    for space in spaces:
        space.region_3d.view_perspective = "CAMERA"
        space.region_3d.view_camera_zoom = 12.0
        space.show_region_ui = True
        space.shading.color_type = "MATERIAL"
        space.overlay.show_floor = space.overlay.show_axis_x = space.overlay.show_axis_y = False
    return spaces
