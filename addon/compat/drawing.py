# SPDX-License-Identifier: GPL-3.0-or-later
"""Shaders and text of the viewport. ``gpu`` is imported on use: without a window it may crash Blender."""


def smooth_colour_shader():
    """The built-in shader that interpolates the colours of vertices. Blender 4.0 renamed it."""
    import gpu

    try:
        return gpu.shader.from_builtin("SMOOTH_COLOR")
    except ValueError:
        return gpu.shader.from_builtin("3D_SMOOTH_COLOR")


def set_text_size(font: int, size: float) -> None:
    """Set the height of text in pixels.

    Before 4.0, Blender also takes dots per inch; 72 of them mean pixels.
    """
    import blf

    try:
        blf.size(font, size)
    except TypeError:
        blf.size(font, size, 72)
