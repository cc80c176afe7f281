# SPDX-License-Identifier: GPL-3.0-or-later
"""Edits at keys and between them, next to SciPy's cubics."""

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

import sinew_native as sn

from ..meshes import STILL, shift, turn


def edit_keys(frames, edits, handle: int = 0) -> sn.EditKeys:
    return sn.EditKeys([(frame, handle, *edit.ravel()) for frame, edit in zip(frames, edits, strict=True)])


def about_z(*degrees: float) -> list[np.ndarray]:
    return [turn((0, 0, 1), angle) for angle in degrees]


def test_no_keys_edit_nothing() -> None:
    assert sn.EditKeys([]).handle_count == 0
    np.testing.assert_array_equal(sn.EditKeys([]).at(3, 7.5), STILL)
    keys = edit_keys([10], about_z(30), handle=2)
    assert repr(keys) == "<EditKeys: 3 handles>"
    for handle in (-1, 0, 1, 5):
        np.testing.assert_array_equal(keys.at(handle, 10), STILL)


def test_a_key_is_met_to_the_bit_and_held_before_the_first_and_after_the_last() -> None:
    frames, edits = [30.0, -4.0, 12.5, 80.0], np.random.default_rng(3).uniform(-1, 1, (4, 3, 4))
    keys = edit_keys(frames, edits)
    for frame, edit in [*zip(frames, edits), (-1e6, edits[1]), (1e6, edits[3])]:
        np.testing.assert_array_equal(keys.at(0, frame), edit)
    one = edit_keys([30], edits[:1])
    for frame in (-9, 30, 31):
        np.testing.assert_array_equal(one.at(0, frame), edits[0])


def test_between_equal_keys_the_edit_is_constant_to_the_bit() -> None:
    held = turn((1, 2, 3), 40, move=(1, 2, 3))
    keys = edit_keys([0, 10, 20, 30, 40], [held, held, *about_z(90), STILL, STILL])
    for t in (0.5, 3.0, 9.9):
        np.testing.assert_array_equal(keys.at(0, t), held)
        np.testing.assert_array_equal(keys.at(0, 30 + t), STILL)


def test_moves_are_the_cubics_of_the_definition() -> None:
    """In one direction the slope at a middle key is a b (a + b) / (a^2 + b^2)."""
    frames, places = [0, 10, 15], [1, 3, 8]
    a, b = np.diff(places) / np.diff(frames)
    cubic = CubicHermiteSpline(frames, places, [0, a * b * (a + b) / (a * a + b * b), 0])
    keys = edit_keys(frames, [shift(x, 0, 0) for x in places])
    for t in np.arange(0.25, 15, 0.5):
        assert keys.at(0, t)[0, 3] == pytest.approx(cubic(t), abs=1e-12)


def test_half_a_symmetric_edit_is_half_the_move_and_half_the_turn() -> None:
    keys = edit_keys([0, 10, 20], [STILL, turn((0, 1, 0), 40, move=(0.5, 0, 2)), STILL])
    np.testing.assert_allclose(keys.at(0, 5), turn((0, 1, 0), 20, move=(0.25, 0, 1)), atol=1e-12)


def random_edits(count: int, seed: int) -> list[np.ndarray]:
    rng = np.random.default_rng(seed)
    stretches = np.eye(3) + 0.2 * rng.uniform(-1, 1, (count, 3, 3))
    turns = [turn(rng.normal(size=3), 80 * rng.uniform(-1, 1))[:, :3] for _ in range(count)]
    return [np.column_stack([R @ S, rng.uniform(-5, 5, 3)]) for R, S in zip(turns, stretches)]


def test_the_edit_is_smooth_and_along_a_line_never_exceeds_its_keys() -> None:
    rng, step = np.random.default_rng(8), 1e-5
    frames = 4 * np.arange(9) + rng.uniform(-1, 1, 9)
    keys = edit_keys(frames, random_edits(9, 8))
    for t in frames[1:-1]:
        before, here, after = (keys.at(0, t + by) for by in (-step, 0, step))
        # Curvatures of some units times the step, and rounding over it.
        np.testing.assert_allclose((after - here) / step, (here - before) / step, rtol=0, atol=1e-3)
    frames, places = 3 * np.arange(40) + rng.random(40), np.round(rng.uniform(-4, 4, 40))
    along = edit_keys(frames, [shift(x, 0, 0) for x in places])
    for k in range(39):
        low, high = sorted(places[k : k + 2])
        between = [along.at(0, t)[0, 3] for t in np.linspace(*frames[k : k + 2], 21)]
        assert min(between) >= low - 1e-12
        assert max(between) <= high + 1e-12


def test_turns_add_up_over_several_keys() -> None:
    keys = edit_keys([0, 10, 20, 30, 40], about_z(0, 120, 240, 360, 300))

    def angle(t: float) -> float:
        at = keys.at(0, t)
        return np.degrees(np.arctan2(at[1, 0], at[0, 0])) % 360

    # Even steps: the slope at the middle keys is that of the line.
    assert angle(15) == pytest.approx(180, abs=1e-9)
    assert angle(14.9) == pytest.approx(178.8, abs=0.01)
    assert angle(35) == pytest.approx(330, abs=1e-9)  # back again, from 360 to 300
    onward = [angle(t) for t in np.arange(20, 30, 0.5)]  # from 240 to 360 instead of back to 0
    assert (np.diff(onward) > 0).all()
    for t in np.arange(0, 40, 0.25):
        R = keys.at(0, t)[:, :3]
        np.testing.assert_allclose(R.T @ R, np.eye(3), atol=1e-14)


def test_edits_do_not_depend_on_the_axes() -> None:
    to = turn((1, -2, 0.5), 100)[:, :3]

    def seen(edit: np.ndarray) -> np.ndarray:
        return to @ np.column_stack([edit[:, :3] @ to.T, edit[:, 3]])

    edits, frames = random_edits(5, 2), range(0, 25, 5)
    here, there = edit_keys(frames, edits), edit_keys(frames, map(seen, edits))
    for t in np.arange(0.3, 20, 0.7):
        np.testing.assert_allclose(there.at(0, t), seen(here.at(0, t)), rtol=0, atol=1e-12)


def test_a_mirrored_edit_stays_finite_between_its_keys() -> None:
    keys = edit_keys([0, 10, 20], [STILL, STILL * [[1], [1], [-1]], 0 * STILL])
    assert all(np.isfinite(keys.at(0, t)).all() for t in np.arange(0, 20.1, 0.5))


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ([(0, 0, STILL), (np.nan, 0, STILL)], "key 1 has a number that is not finite"),
        ([(0, 0, shift(np.nan, 0, 0))], "key 0 has a number that is not finite"),
        ([(0, -1, STILL)], "key 0 names handle -1"),
        ([(0, 0.5, STILL)], "names handle -1"),
        ([(7.5, 2, STILL), (3, 2, STILL), (7.5, 2, STILL)], "handle 2 has two keys at frame 7.5"),
    ],
)
def test_keys_that_mean_nothing_are_refused_and_named(keys: list, words: str) -> None:
    with pytest.raises(sn.InvalidOption, match=words):
        sn.EditKeys([(frame, handle, *edit.ravel()) for frame, handle, edit in keys])
