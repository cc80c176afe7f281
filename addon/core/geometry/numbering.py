# SPDX-License-Identifier: GPL-3.0-or-later
"""Two lists of the vertices and faces of one mesh: which entries are the same."""

import numpy as np

from . import frames

Faces = tuple[np.ndarray, np.ndarray]  # the number of corners of each face, and the vertices of all corners
_FACTORS = np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F], dtype=np.uint64)


def matched(
    one: Faces, other: Faces, count: int, kept: int, groups: int
) -> tuple[np.ndarray, np.ndarray] | None:
    """The vertex of ``one`` that each vertex of ``other`` is, (n,), and the faces that are turned, bool (m,).

    Both have ``count`` vertices. The first ``kept`` of them have the same numbers, and at least so many
    ``groups`` of faces follow each other in the same order: those that stem from one face. None if the meshes
    differ in more than the order of their other vertices and of the faces in groups, or if that cannot be
    told.

    Each vertex gets a colour: the first ones their numbers, as long as their edges have the same in both. All
    others get theirs from the colours around them, step by step, until each one has another (Weisfeiler and
    Leman 1968).
    """
    if len(one[0]) != len(other[0]) or len(one[1]) != len(other[1]):
        return None
    sides = [_Side(faces, count) for faces in (one, other)]
    differing = np.setxor1d(sides[0].edges, sides[1].edges) // count
    known = max(kept, differing.min(initial=count))
    colours = np.zeros(count, dtype=np.uint64)
    colours[:known] = np.arange(known) + 1
    found, different = [colours, colours], 0
    while True:
        orders = [np.argsort(each) for each in found]
        ranked = [each[order] for each, order in zip(found, orders, strict=True)]
        if not np.array_equal(ranked[0], ranked[1]):
            return None
        before, different = different, 1 + np.count_nonzero(np.diff(ranked[0]))
        if different == count:
            break
        if different == before:
            return None
        found = [side.spread(each) for side, each in zip(sides, found, strict=True)]
    places = np.empty(count, dtype=np.int64)
    places[orders[1]] = orders[0]
    if not np.array_equal(places[:kept], np.arange(kept)):
        return None
    same, directed = (
        [side.of_faces(each, way) for side, each in zip(sides, found, strict=True)] for way in (True, False)
    )
    by_face = [np.argsort(each) for each in same]
    if not np.array_equal(same[0][by_face[0]], same[1][by_face[1]]):
        return None
    order = np.empty(len(one[0]), dtype=np.int64)
    order[by_face[1]] = by_face[0]
    if np.count_nonzero(np.maximum.accumulate(order) == np.arange(len(order))) < groups:
        return None  # a symmetric mesh has the same edges when its vertices are renumbered
    turned = np.empty(len(one[0]), dtype=bool)
    turned[by_face[1]] = directed[0][by_face[0]] != directed[1][by_face[1]]
    return places, turned


class _Side:
    """The edges and faces of one of the meshes."""

    def __init__(self, faces: Faces, count: int) -> None:
        self.ends = frames.face_edges(*faces).astype(np.int64)
        self.starts = np.cumsum(faces[0]) - faces[0]
        low, high = np.sort(self.ends, axis=1).T
        self.edges = np.unique(low * count + high)
        low, high = self.edges // count, self.edges % count
        around = np.concatenate((low, high))
        self.around = np.concatenate((high, low))[np.argsort(around, kind="stable")]
        self.joined, self.first = np.unique(np.sort(around), return_index=True)

    def spread(self, colours: np.ndarray) -> np.ndarray:
        """New colours: the own one with those at the other ends of the edges."""
        spread = _mixed(colours)
        if len(self.joined):
            spread[self.joined] += np.add.reduceat(_mixed(spread)[self.around], self.first)
        return spread

    def of_faces(self, colours: np.ndarray, either_way: bool) -> np.ndarray:
        """A number for each face by the colours along its edges; for both sides one if ``either_way``."""
        mixed = _mixed(colours)
        before, after = mixed[self.ends.T]
        edges = _mixed(before + (after if either_way else _mixed(after)))
        return np.add.reduceat(edges, self.starts) if len(self.starts) else edges


def _mixed(numbers: np.ndarray) -> np.ndarray:
    """Other numbers, uint64, which are as good as random."""
    for factor in _FACTORS:
        numbers = (numbers ^ (numbers >> np.uint64(31))) * factor
    return numbers ^ (numbers >> np.uint64(29))
