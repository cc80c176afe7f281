# SPDX-License-Identifier: GPL-3.0-or-later
"""Rows of methods that curves and tools steer: what an artist would do for each case by one of them.

They know no handles. So they meet the poses of the case only as far as a curve, or one tool, can say them.
"""

from collections.abc import Callable, Iterator
from functools import partial
from types import ModuleType
from typing import Any

import numpy as np

from .cases import Case
from .rows import Solve

_SAMPLES = 81
_REACH = 3.0  # of a wire, as a multiple of the distance of the farthest point


def space_rows(methods: ModuleType, native: ModuleType) -> Iterator[tuple[str, Solve]]:
    """A row per method that curves or tools steer, in the menu's order. The modules are as for the others."""
    ways = {methods.Control.CURVES: by_wire, methods.Control.TOOLS: by_tool}
    for method in methods.METHODS:
        if method.control in ways:
            yield method.known_as, partial(ways[method.control], getattr(native, method.native))


def by_wire(make: Callable[..., Any], case: Case) -> np.ndarray:
    """A curve through the middle of the shape, which the ends carry and bend: a twist is lost on it."""
    start, along, places, ends = _axis(case)
    t = np.linspace(places.min(), places.max(), _SAMPLES)
    rest = start + t[:, None] * along
    moved = rest @ case.poses[1, :, :3].T + case.poses[1, :, 3]
    u = np.clip((t - ends[0]) / (ends[1] - ends[0]), 0.0, 1.0)[:, None]
    way = (ends[1] - ends[0]) * along
    first, last = start + ends[0] * along, start + ends[1] * along
    last = case.poses[1, :, :3] @ last + case.poses[1, :, 3]
    between = (
        (1 + 2 * u) * (1 - u) ** 2 * first
        + u**2 * (3 - 2 * u) * last
        + u * (1 - u) ** 2 * way
        - u**2 * (1 - u) * (case.poses[1, :, :3] @ way)
    )
    posed = np.where(u <= 0.0, rest, np.where(u >= 1.0, moved, between))
    aside = case.points - start - places[:, None] * along
    wire = make(rest, radius=_REACH * np.linalg.norm(aside, axis=1).max())
    wire.bind(case.points)
    return wire.warp(posed)


def by_tool(make: Callable[..., Any], case: Case) -> np.ndarray:
    """One tool: a twist or a bend in the middle of the free part, or else a drag of the second handle."""
    start, along, places, ends = _axis(case)
    frame = _frame(along)
    rotation = _rotation(case.poses[1, :, :3])
    turned = rotation @ along
    swing = np.arctan2(np.linalg.norm(np.cross(along, turned)), along @ turned)
    angle = np.arccos(np.clip((np.trace(rotation) - 1.0) / 2.0, -1.0, 1.0))
    if angle < 1e-6:
        centre = case.points[case.handles[1]].mean(axis=0)
        inner, outer = (np.linalg.norm(case.points[handle] - centre, axis=1) for handle in case.handles[::-1])
        rest = np.vstack((np.zeros(3), frame)) + centre
        field = make(rest, tools="drag", inner=inner.max(), outer=max(outer.min(), 1.1 * inner.max()))
        posed = rest + case.poses[1, :, 3]
    else:
        half = 0.5 * (ends[1] - ends[0])
        centre = start + (ends[0] + half) * along
        aside = np.linalg.norm(case.points - start - places[:, None] * along, axis=1).max()
        tool = "bend" if swing > 0.5 * angle else "twist"
        rest = np.vstack((np.zeros(3), frame)) + centre
        field = make(rest, tools=tool, inner=-half, outer=half, width=1.5 * aside)
        posed = (rest - centre) @ rotation.T + centre
    field.bind(case.points)
    return field.warp(posed)


def _axis(case: Case) -> tuple[np.ndarray, np.ndarray, np.ndarray, tuple[float, float]]:
    """A point on the line through the middles of both handles, its direction, and places (n,) along it. The
    last two are the places where the free part begins and ends."""
    first, second = (case.points[handle].mean(axis=0) for handle in case.handles)
    along = (second - first) / np.linalg.norm(second - first)
    places = (case.points - first) @ along
    return first, along, places, (places[case.handles[0]].max(), places[case.handles[1]].min())


def _frame(along: np.ndarray) -> np.ndarray:
    """Three axes as rows, the last one along a direction."""
    helper = np.eye(3)[np.argmin(np.abs(along))]
    across = np.cross(helper, along)
    across /= np.linalg.norm(across)
    return np.stack((across, np.cross(along, across), along))


def _rotation(linear: np.ndarray) -> np.ndarray:
    """The rotation nearest to a map."""
    u, _values, vt = np.linalg.svd(linear)
    return u @ np.diag((1.0, 1.0, np.linalg.det(u @ vt))) @ vt
