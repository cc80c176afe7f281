# SPDX-License-Identifier: GPL-3.0-or-later
"""The same vertices and faces in two orders, against orders that are known."""

from itertools import product

import numpy as np
import pytest

from sinew.core.geometry import numbering

RANDOM = np.random.default_rng(5)
KEPT, QUADS = 49, 36  # the vertices and faces of a grid; each quad gets four more vertices inside


def refined_grid() -> list[list[int]]:
    """Each quad has a smaller one in its middle, and four around that."""
    faces: list[list[int]] = []
    for row, column in product(range(6), range(6)):
        first, inner = row * 7 + column, KEPT + 4 * (row * 6 + column)
        outside = [first, first + 1, first + 8, first + 7]
        inside = [inner, inner + 1, inner + 2, inner + 3]
        around = ([outside[i], outside[i - 3], inside[i - 3], inside[i]] for i in range(4))  # i - 3: the next
        faces += [inside, *around]
    return faces


FACES = refined_grid()
COUNT = KEPT + 4 * QUADS


def as_arrays(faces: list[list[int]]) -> numbering.Faces:
    return np.array([len(face) for face in faces]), np.concatenate(faces)


def in_another_order(fixed: int) -> tuple[list[list[int]], np.ndarray, np.ndarray]:
    """With other numbers after the ``fixed`` ones; the old number of each vertex, and which are turned."""
    old = np.concatenate((np.arange(fixed), fixed + RANDOM.permutation(COUNT - fixed)))
    new = np.argsort(old)
    turned = RANDOM.random(len(FACES)) < 0.5
    order = np.concatenate([5 * group + RANDOM.permutation(5) for group in range(QUADS)])
    faces = []
    for index in order:
        start = RANDOM.integers(len(FACES[index]))
        face = [int(new[vertex]) for vertex in np.roll(FACES[index], start)]
        faces.append(face[::-1] if turned[index] else face)
    return faces, old, turned[order]


def test_what_modifiers_have_numbered_anew_is_found():
    faces, old, turned = in_another_order(KEPT)
    found = numbering.matched(as_arrays(FACES), as_arrays(faces), COUNT, KEPT, QUADS)
    assert found is not None
    assert np.array_equal(found[0], old)
    assert np.array_equal(found[1], turned)


def other_own_vertices() -> list[list[int]]:
    return in_another_order(0)[0]


def an_edge_turned() -> list[list[int]]:
    """Two triangles in place of a quad, and the other diagonal."""
    first, second = FACES[0], FACES[1]
    return [[*first[:2], second[0]], [*first[2:], *second[1:]], *FACES[2:]]


def fewer_faces() -> list[list[int]]:
    return FACES[1:]


def all_reversed() -> list[list[int]]:
    """A grid has the same edges then, and faces in another order."""
    new = [*reversed(range(KEPT)), *reversed(range(KEPT, COUNT))]
    return [[new[vertex] for vertex in face] for face in FACES]


@pytest.mark.parametrize("others", [all_reversed, other_own_vertices, an_edge_turned, fewer_faces])
def test_other_meshes_are_told_apart(others):
    assert numbering.matched(as_arrays(FACES), as_arrays(others()), COUNT, KEPT, QUADS) is None


def test_what_is_symmetric_is_not_guessed():
    """Two quads at a common edge may be exchanged, unless more of their vertices are known."""
    faces, others = as_arrays([[0, 2, 4, 1], [1, 5, 3, 0]]), as_arrays([[0, 2, 5, 1], [1, 4, 3, 0]])
    assert numbering.matched(faces, others, 6, 2, 2) is None
    found = numbering.matched(faces, others, 6, 4, 2)
    assert found is not None
    assert found[0].tolist() == [0, 1, 2, 3, 5, 4]
