# SPDX-License-Identifier: GPL-3.0-or-later
"""A clean picture from few samples: Debian's Blender has no denoiser, so the light passes are filtered here.

Diffuse and glossy light are rendered apart from the colours of the surfaces. Each is smoothed by a wavelet
filter with holes that stops at edges of normal, depth and, measured against the noise, brightness; textures
stay untouched.

H. Dammertz et al. "Edge-Avoiding A-Trous Wavelet Transform for Fast Global Illumination Filtering." HPG 2010.
For the brightness: C. Schied et al. "Spatiotemporal Variance-Guided Filtering." HPG 2017.
"""

import tempfile
from collections.abc import Sequence
from itertools import product
from pathlib import Path

import bpy
import numpy as np

PASSES = ("DiffCol", "DiffDir", "DiffInd", "GlossCol", "GlossDir", "GlossInd", "Normal", "Depth")
KERNEL = {0: 3 / 8, 1: 1 / 4, 2: 1 / 16}


def render_clean(scene: bpy.types.Scene) -> np.ndarray:
    """Render the scene's current frame: linear light (height, width, 3)."""
    layer = scene.view_layers[0]
    for name in ("diffuse", "glossy"):
        for part in ("color", "direct", "indirect"):
            setattr(layer, f"use_pass_{name}_{part}", True)
    layer.use_pass_normal = layer.use_pass_z = True
    found = render_passes(scene, PASSES)
    diffuse = smooth(found["DiffDir"] + found["DiffInd"], found["Normal"], found["Depth"][..., :1], levels=4)
    glossy = smooth(found["GlossDir"] + found["GlossInd"], found["Normal"], found["Depth"][..., :1], levels=3)
    return found["DiffCol"] * diffuse + found["GlossCol"] * glossy


def render_passes(scene: bpy.types.Scene, names: Sequence[str]) -> dict[str, np.ndarray]:
    """Render passes by name, (height, width, 3) each: written by the compositor."""
    scene.use_nodes = True
    tree = scene.node_tree
    tree.nodes.clear()
    source, target = (tree.nodes.new(f"CompositorNode{kind}") for kind in ("RLayers", "OutputFile"))
    form = target.format
    form.file_format, form.color_depth, form.color_mode = "OPEN_EXR", "32", "RGB"
    target.file_slots.clear()
    for name in names:
        target.file_slots.new(name)
        tree.links.new(source.outputs[name], target.inputs[name])
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        target.base_path = folder
        bpy.ops.render.render()
        for name in names:
            image = bpy.data.images.load(str(next(Path(folder).glob(f"{name}*.exr"))))
            image.colorspace_settings.name = "Non-Color"
            width, height = image.size
            pixels = np.empty((height, width, 4), np.float32)
            image.pixels.foreach_get(pixels.ravel())
            bpy.data.images.remove(image)
            found[name] = pixels[..., :3]
    scene.use_nodes = False
    return found


def smooth(light: np.ndarray, normal: np.ndarray, depth: np.ndarray, levels: int) -> np.ndarray:
    """The light (h, w, 3) without its noise. ``normal`` (h, w, 3), ``depth`` (h, w, 1)."""
    slope = np.minimum(np.hypot(*np.gradient(depth[..., 0]))[..., None], 0.01 * depth)
    light = quench_fireflies(light)
    variance = local_variance(brightness(light))
    for level in range(levels):
        step = 2**level
        scale = 3.0 * np.sqrt(blur(variance)) + 1e-4
        bright = brightness(light)
        total, weights, squares = np.zeros_like(light), np.zeros_like(depth), np.zeros_like(depth)
        for dy, dx in product(range(-2, 3), repeat=2):
            move = (step * dy, step * dx)
            alike = np.maximum((normal * shifted(normal, move)).sum(2, keepdims=True), 0.0) ** 48
            reach = np.hypot(*move) * slope + 1e-3 * depth
            away = np.abs(depth - shifted(depth, move)) / reach
            away += np.abs(bright - shifted(bright, move)) / scale
            weight = KERNEL[abs(dy)] * KERNEL[abs(dx)] * (alike * np.exp(-away) if dy or dx else 1.0)
            total += weight * shifted(light, move)
            weights += weight
            squares += weight**2 * shifted(variance, move)
        light, variance = total / weights, squares / weights**2
    return light


def shifted(values: np.ndarray, move: tuple[int, int]) -> np.ndarray:
    """The values seen from ``move`` pixels away; the border repeats."""
    rows = np.clip(np.arange(values.shape[0]) + move[0], 0, values.shape[0] - 1)
    columns = np.clip(np.arange(values.shape[1]) + move[1], 0, values.shape[1] - 1)
    return values[rows][:, columns]


def brightness(light: np.ndarray) -> np.ndarray:
    return light @ np.array([[0.2126], [0.7152], [0.0722]], np.float32)


def blur(values: np.ndarray) -> np.ndarray:
    """Mean over 3 x 3 pixels."""
    rows = (shifted(values, (-1, 0)) + values + shifted(values, (1, 0))) / 3
    return (shifted(rows, (0, -1)) + rows + shifted(rows, (0, 1))) / 3


def local_variance(bright: np.ndarray) -> np.ndarray:
    """Variance of the noise around each pixel, by second differences, so that slow changes do not count."""
    across = 2 * bright - shifted(bright, (0, -1)) - shifted(bright, (0, 1))
    along = 2 * bright - shifted(bright, (-1, 0)) - shifted(bright, (1, 0))
    variance = np.minimum(across**2, along**2) / 6
    for _ in range(3):
        variance = blur(variance)
    return 2.0 * variance  # the smaller of two squares is about half their mean


def quench_fireflies(light: np.ndarray) -> np.ndarray:
    """No pixel brighter than the second brightest of its neighbours, with some room."""
    bright = brightness(light)
    around = [shifted(bright, (dy, dx)) for dy in (-1, 0, 1) for dx in (-1, 0, 1) if dy or dx]
    limit = 1.15 * np.sort(np.stack(around), axis=0)[-2]
    return light * np.minimum(1.0, limit / np.maximum(bright, 1e-6))


def write_picture(scene: bpy.types.Scene, light: np.ndarray, picture: Path) -> None:
    """Write a PNG or, by its name, a JPEG with the scene's colour management."""
    height, width = light.shape[:2]
    image = bpy.data.images.new("Picture", width, height, float_buffer=True)
    rgba = np.concatenate((light, np.ones((height, width, 1))), axis=2).astype(np.float32)
    image.pixels.foreach_set(rgba.ravel())
    settings = scene.render.image_settings
    stored = settings.file_format
    settings.file_format, settings.quality = {".jpg": "JPEG"}.get(picture.suffix, "PNG"), 90
    image.save_render(str(picture), scene=scene)
    settings.file_format = stored
    bpy.data.images.remove(image)
