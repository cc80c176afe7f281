# SPDX-License-Identifier: GPL-3.0-or-later
"""The figures of the tutorial that no other sample shows, on models of our own: a picture each."""

from functools import partial

import bpy

from .. import posing, studio
from ..comparison import FIGURES, native_solve, picture

_sheets: list[picture.Sheet] = []
pictures = partial(picture.rendered, sheets=_sheets)


def make() -> bpy.types.Scene:
    scene, native = studio.empty_scene(), posing.native()
    ours = partial(native_solve, posing.registry(), native)
    for number, draw in FIGURES.items():
        studio.progress(f"figure {number}")
        views = list(draw(ours, native))
        _sheets.append(picture.of_figure(f"Figure {number}", views, f"tutorial-{number:02}"))
    picture.show(scene, _sheets)
    return scene
