# SPDX-License-Identifier: GPL-3.0-or-later
"""What a window would send to a modal tool: views and events."""

from types import SimpleNamespace

import numpy as np
from inside import inner


def front_view(pixel: float = 0.01, centre: tuple[float, float] = (400.0, 300.0)):
    """Along y, with z upwards; by default a pixel is a centimetre."""
    right, up, toward = np.array(((1.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, -1.0, 0.0)))
    return inner.typed_motion.View(right=right, up=up, toward=toward, pixel=pixel, centre=centre)


def event(kind: str, value: str, x: float, y: float, unicode: str = "", **modifiers: bool) -> SimpleNamespace:
    """Of the mouse at a place, or of a key; modifiers are ``shift``, ``ctrl`` and ``is_repeat``."""
    held = {"shift": False, "ctrl": False, "is_repeat": False} | modifiers
    return SimpleNamespace(type=kind, value=value, mouse_x=x, mouse_y=y, unicode=unicode, **held)
