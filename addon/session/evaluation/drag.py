# SPDX-License-Identifier: GPL-3.0-or-later
"""How much a drag may spend on one redraw: a few steps of an iterative method, so that the shape keeps up."""

import bpy

from ...preferences import preferences

_MOST_STEPS = 10  # more would not show within a drag


def budget() -> float:
    """Milliseconds that a drag may spend on a redraw."""
    return preferences(bpy.context).drag_budget


def affordable_steps(milliseconds: float) -> int:
    """How many steps of this price a redraw may take: one at least."""
    return min(max(int(budget() / max(milliseconds, 1e-3)), 1), _MOST_STEPS)
