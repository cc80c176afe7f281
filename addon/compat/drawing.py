# SPDX-License-Identifier: GPL-3.0-or-later
"""Shaders and text of the viewport. ``gpu`` is imported on use: without a window it may crash Blender."""


def smooth_colour_shader():
    """The built-in shader of coloured vertices; Blender 4.0 renamed it."""
    import gpu

    try:
        return gpu.shader.from_builtin("SMOOTH_COLOR")
    except ValueError:
        return gpu.shader.from_builtin("3D_SMOOTH_COLOR")


def set_text_size(font: int, size: float) -> None:
    """Text height in pixels. Blender 4.0 dropped the dots per inch, of which 72 mean pixels."""
    import blf

    try:
        blf.size(font, size)
    except TypeError:
        blf.size(font, size, 72)
