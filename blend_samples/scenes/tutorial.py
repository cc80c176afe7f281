# SPDX-License-Identifier: GPL-3.0-or-later
"""The figures of the tutorial that no other sample shows, on models of our own: a picture each."""

from collections.abc import Iterator
from functools import partial

import bpy
import numpy as np

from .. import posing, studio
from ..comparison import ROWS, native_solve, picture

_sheets: list[picture.Sheet] = []


def make() -> bpy.types.Scene:
    scene = studio.empty_scene()
    native = posing.native()
    ours = partial(native_solve, posing.registry(), native)
    for row in ROWS:
        if row.draw:
            studio.progress(row.name)
            _sheets.append(picture.of_figure(row.name, list(row.draw(ours, native)), row.picture))
    picture.show(scene, _sheets)
    return scene


def pictures(scene: bpy.types.Scene) -> Iterator[tuple[str, np.ndarray]]:
    return picture.rendered(scene, _sheets)
