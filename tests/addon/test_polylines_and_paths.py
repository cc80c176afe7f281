# SPDX-License-Identifier: GPL-3.0-or-later
"""Curves as rows of samples, and paths of frames that are cut."""

import numpy as np
import pytest

from sinew.core.geometry.paths import AXES, between, cut, scale_of
from sinew.core.geometry.polylines import Lines, lengths, lines_of, resampled


def test_edges_tell_lines_and_rings_apart():
    edges = np.array([(0, 1), (1, 2), (4, 3), (4, 5), (3, 5), (7, 6)])
    lines = lines_of(9, edges)
    assert lines == Lines((3, 3, 2, 1), (False, True, False, False))
    assert lines.total == 9
    assert lines_of(0, np.zeros((0, 2), dtype=int)) == Lines((), ())


@pytest.mark.parametrize("edges", [[(0, 2)], [(0, 1), (1, 2), (2, 3), (1, 3)], [(0, 1), (2, 3), (0, 3)]])
def test_edges_of_something_else_are_no_lines(edges):
    assert lines_of(4, np.array(edges)) is None


def test_lines_go_through_text():
    for lines in (Lines((3, 12), (False, True), 0.1 + 0.2), Lines((2,), (False,), 1e-30), Lines((), ())):
        assert Lines.from_text(lines.to_text()) == lines
    assert Lines.from_text("") == Lines((), ())


def test_lengths_count_the_last_side_of_a_ring():
    square = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], dtype=float)
    assert lengths(square, Lines((4,), (True,))) == [4.0]
    assert lengths(square, Lines((2, 2), (False, False))) == [1.0, 1.0]


def test_the_same_parameter_counts_and_not_the_length():
    line = np.array([(0, 0, 0), (1, 0, 0), (10, 0, 0)], dtype=float)
    fine = resampled(line, Lines((3,), (False,)), Lines((5,), (False,)))
    assert fine[:, 0].tolist() == [0.0, 0.5, 1.0, 5.5, 10.0]
    ring = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], dtype=float)
    finer = resampled(ring, Lines((4,), (True,)), Lines((8,), (True,)))
    assert np.allclose(finer[::2], ring)
    assert np.allclose(finer[7], (0.0, 0.5, 0.0))
    same = resampled(line, Lines((3,), (False,)), Lines((3,), (False,)))
    assert np.array_equal(same, line)


def turned(angle: float, place=(0.0, 0.0, 0.0), scale: float = 1.0) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return scale * AXES @ np.array(((c, -s, 0), (s, c, 0), (0, 0, 1))).T + place


def test_a_frame_between_two_has_moved_turned_and_stretched_evenly():
    before, after = turned(0.3, (1.0, 0.0, 0.0)), turned(1.5, (2.0, 4.0, 0.0), 3.0)
    assert np.allclose(between(before, after, 0.0), before)
    assert np.allclose(between(before, after, 1.0), after)
    assert np.allclose(between(before, after, 0.25), turned(0.6, (1.25, 1.0, 0.0), 1.5))
    half = between(turned(0.0), turned(np.pi), 0.5)
    assert np.allclose(np.abs(half[1, 1]), 1.0), "half a turn goes one way or the other"
    assert scale_of(after) == pytest.approx(3.0)


def test_a_path_is_cut_by_moves_and_turns():
    path = np.array([turned(0.0), turned(0.0, (2.0, 0.0, 0.0)), turned(1.0, (2.0, 0.0, 0.0))])
    assert np.array_equal(cut(path, 1.0, 2.0), path[1:])
    assert np.allclose(cut(path, 0.0, 2.0), [path[0], path[0]])
    assert np.allclose(cut(path, 0.25, 2.0), [turned(0.0, (1.0, 0.0, 0.0))] * 2)
    assert np.allclose(cut(path, 0.75, 2.0), [path[1], turned(0.5, (2.0, 0.0, 0.0))])
    still = np.array([turned(0.2)] * 3)
    assert np.array_equal(cut(still, 0.3, 1.0), still[1:])
