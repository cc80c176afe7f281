# SPDX-License-Identifier: GPL-3.0-or-later
"""Edits of animations, next to NumPy, and between their keys, next to SciPy's cubics."""

import itertools

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

import sinew_native as sn

from ..meshes import STILL, grid, moved, nearest_rotations, shift, turn
from ..methods import bound, bound_to

LIFTED = turn((0, 1, 0), 40, move=(0.5, 0, 2))
KEYS = np.array([(frame, 1, *edit.ravel()) for frame, edit in ((0, STILL), (10, LIFTED), (20, STILL))])


def shapes(points: np.ndarray, frames: np.ndarray) -> np.ndarray:
    """A sheet that rolls up, swells and travels."""
    found = []
    for frame in frames:
        bend, x, z = 0.004 * frame + 1e-6, points[:, 0], points[:, 2] * (1 + 0.02 * frame)
        away = 1 / bend - z
        rolled = [np.sin(bend * x) * away, points[:, 1], 1 / bend - np.cos(bend * x) * away]
        found.append(np.column_stack(rolled) + 0.1 * frame)
    return np.array(found)


def moving_frame(points, faces, handle, shape) -> tuple[np.ndarray, np.ndarray]:
    """The rotation of the triangles at a handle, each as often as it has its vertices, and the centre."""
    corners = np.repeat(faces, np.isin(faces, handle).sum(1), axis=0).ravel()
    before, after = points[corners], shape[corners]
    Q = nearest_rotations((after - after.mean(0)).T @ (before - before.mean(0)))
    return Q, shape[handle].mean(0)


def test_frames_meet_their_keys_in_the_moving_frames() -> None:
    method, points, handles = bound(sn.MeshSequence, 12)
    rng, frames = np.random.default_rng(4), np.arange(21.0)
    animation = shapes(points, frames)
    found, reports = method.solve_frames(frames, animation, keys=KEYS)
    assert found.shape == animation.shape
    assert all(report.converged for report in reports)
    np.testing.assert_allclose(found[[0, 20]], animation[[0, 20]], atol=1e-10)
    keys = []
    for frame, h in itertools.product((2, 9, 15), (0, 1)):
        keys.append((frame, h, turn(rng.normal(size=3), 60, move=rng.uniform(-2, 2, 3)) * (1.2, 1, 0.8, 1)))
    found, _ = method.solve_frames(frames, animation, keys=[(f, h, *edit.ravel()) for f, h, edit in keys])
    for frame, h, edit in keys:
        shape, handle = animation[frame], handles[h]
        Q, centre = moving_frame(points, grid(12)[1], handle, shape)
        expected = moved(edit, (shape[handle] - centre) @ Q) @ Q.T + centre
        np.testing.assert_allclose(found[frame][handle], expected, rtol=0, atol=1e-11)


def test_an_edit_is_carried_by_what_carries_the_handle() -> None:
    """The same shape, elsewhere: the edited shape goes along, for an edit that was made at another frame."""
    method, points, _ = bound(sn.MeshSequence, 12)
    here, carried = shapes(points, [7.0])[0], turn((1, -2, 0.5), 130, (3, 7, 1), (30, -20, 10))
    edited, _ = method.solve_frame(7, keys=KEYS, incoming=here)
    assert np.abs(edited - here).max() > 1
    found, _ = method.solve_frame(7, keys=KEYS, incoming=moved(carried, here))
    # The iteration may end a step earlier: by a decrease below 1e-4.
    np.testing.assert_allclose(found, moved(carried, edited), rtol=0, atol=0.01)


def test_a_rigid_edit_of_all_handles_is_rigid_in_every_frame() -> None:
    method, points, handles = bound(sn.MeshSequence, 12)
    frames, whole = np.arange(0.0, 21.0, 4.0), turn((1, 2, -0.5), 70, (3, 7, 1), (5, -2, 3))
    animation, keys = shapes(points, frames), []
    for frame, shape in zip(frames, animation):
        for h, handle in enumerate(handles):
            Q, centre = moving_frame(points, grid(12)[1], handle, shape)
            edit = Q.T @ np.column_stack([whole[:, :3] @ Q, moved(whole, centre) - centre])
            keys.append((frame, h, *edit.ravel()))
    found, _ = method.solve_frames(frames, animation, keys=keys)
    np.testing.assert_allclose(found, moved(whole, animation), rtol=0, atol=1e-9)


def test_frames_are_as_smooth_in_time_as_the_edit_of_the_handle() -> None:
    method, points, handles = bound(sn.MeshSequence, 12)
    frames = np.linspace(0, 20, 61)
    animation = shapes(points, frames)
    edit = method.solve_frames(frames, animation, keys=KEYS)[0] - animation

    def jitter(of: np.ndarray) -> float:
        """The second difference in time, as a share of the edit, both as root mean squares."""
        return np.sqrt((np.diff(of, 2, axis=0) ** 2).mean() / (of**2).mean())

    assert jitter(edit) < 1.2 * jitter(edit[:, handles[1]])
    assert jitter(edit) < 0.02


def test_a_control_that_follows_the_animation_edits_by_what_it_does_beyond() -> None:
    method, points, handles = bound(sn.MeshSequence, 12)
    shape, follows = shapes(points, [6.0])[0], [False, True]
    first, second = method.still_poses(incoming=shape, from_rest=follows)
    np.testing.assert_array_equal(first, STILL)
    # Ten degrees about an axis of the control, in its frame: the same as a key.
    own = turn((0, 0, 1), 10, points[handles[1]].mean(0))
    posed = second[:, :3] @ own + np.column_stack([np.zeros((3, 3)), second[:, 3]])
    found, _ = method.solve_frame(6, poses=[first, posed], from_rest=follows, incoming=shape)
    keys = [(6, 1, *turn((0, 0, 1), 10).ravel())]
    expected, _ = method.solve_frame(6, keys=keys, incoming=shape)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9)


def test_a_handle_of_one_vertex_turns_with_the_faces_around_it_and_one_on_a_line_does_not() -> None:
    points, faces = grid(8)
    carried, lift = turn((1, 0, 2), 110, (1, 1, 1), (4, 0, 0)), np.array((0, 0, 2.0))
    for mesh, handles, turned in (
        (sn.SurfaceMesh(points, faces), [range(9), [80]], carried[:, :3] @ lift),
        (sn.SurfaceMesh(np.outer([0, 1, 2], [1.0, 0, 0]), [[0, 1, 2]]), [[1], [0]], lift),
    ):
        method = bound_to(sn.MeshSequence(mesh), handles)
        shape, tip = moved(carried, mesh.points), handles[1][0]
        found, _ = method.solve_frame(0, keys=[(0, 1, *shift(*lift).ravel())], incoming=shape)
        np.testing.assert_allclose(found[tip] - shape[tip], turned, rtol=0, atol=1e-12)


def test_a_frame_alone_has_the_bits_of_all_of_them() -> None:
    method, points, handles = bound(sn.MeshSequence, 12)
    frames = np.array([3.5, 17.0, 8.0])
    animation = shapes(points, frames)
    together, _reports = method.solve_frames(frames, animation, keys=KEYS)
    for frame, shape, expected in zip(frames, animation, together, strict=True):
        np.testing.assert_array_equal(method.solve_frame(frame, keys=KEYS, incoming=shape)[0], expected)
        poses = method.poses(frame, keys=KEYS, incoming=shape)
        arap, _, _ = bound(sn.Arap, 12)
        np.testing.assert_array_equal(arap.solve(poses, incoming=shape)[0], expected)
    assert method.set_handles(handles).factorizations == 4, "two per bind, none per frame"


def test_poses_edit_further_and_become_a_key() -> None:
    method, points, handles = bound(sn.MeshSequence)
    shape = shapes(points, [6.0])[0]
    posed = [STILL, turn((1, 0, 1), 20, points[handles[1]].mean(0), (0, 0, 1))]
    moved, _ = method.solve_frame(6, poses=posed, keys=KEYS, incoming=shape)
    before, _ = method.solve_frame(6, keys=KEYS, incoming=shape)
    np.testing.assert_allclose((moved - before)[handles[1]].mean(0), (0, 0, 1), atol=1e-12)
    edits = method.edits(6, poses=posed, keys=KEYS, incoming=shape)
    key = np.array([(6, handle, *edit.ravel()) for handle, edit in enumerate(edits)])
    again, _ = method.solve_frame(6, keys=key, incoming=shape)
    np.testing.assert_allclose(again, moved, atol=1e-9)


def test_still_poses_edit_nothing() -> None:
    method, points, _ = bound(sn.MeshSequence)
    shape = shapes(points, [6.0])[0]
    for from_rest in (False, True, [False, True]):
        poses = method.still_poses(incoming=shape, from_rest=from_rest)
        found, _ = method.solve_frame(6, poses=poses, incoming=shape, from_rest=from_rest)
        np.testing.assert_allclose(found, shape, atol=1e-10)
    np.testing.assert_array_equal(method.still_poses(incoming=shape), [STILL, STILL])
    still = KEYS[[0, 2]]
    np.testing.assert_array_equal(method.poses(6, keys=still, incoming=shape), [STILL, STILL])
    np.testing.assert_allclose(method.solve_frame(6, keys=still, incoming=shape)[0], shape, atol=1e-10)


def test_what_means_nothing_is_refused() -> None:
    method, points, _ = bound(sn.MeshSequence)
    animation = shapes(points, [1.0, 2.0])
    with pytest.raises(sn.InvalidOption, match=r"\(m, 14\)"):
        method.solve_frame(1, keys=KEYS[:, :5])
    for call in (method.solve_frame, method.edits):
        with pytest.raises(sn.InvalidConstraint, match="frame"):
            call(np.nan, incoming=points)
    for call in (method.solve_frame, method.edits, method.poses):
        with pytest.raises(sn.InvalidConstraint, match="2 handles"):
            call(1, poses=[STILL] * 3, incoming=points)
    one = bound_to(sn.MeshSequence(method.rest), [[0, 1, 2]])
    with pytest.raises(sn.InvalidConstraint, match="there is no handle 1; the mesh has 1"):
        one.solve_frame(0, keys=KEYS)
    with pytest.raises(sn.InvalidOption, match="2 given for 3 frames"):
        method.solve_frames([1, 2, 3], animation)
    with pytest.raises(sn.InvalidConstraint, match=r"\(f, n, 3\)"):
        method.solve_frames([1], animation[0])
    animation[1, 3, 0] = np.nan
    with pytest.raises(sn.InvalidConstraint, match="frame 2: "):
        method.solve_frames([1, 2], animation)
    with pytest.raises(sn.InvalidConstraint, match="frame 7: "):
        method.solve_frames([7], animation[:1, :-1])
    with pytest.raises(sn.Cancelled):
        method.solve_frames([1], animation[:1], progress=lambda fraction, stage: False)


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
    symmetric = edit_keys([0, 10, 20], [STILL, turn((0, 1, 0), 40, move=(0.5, 0, 2)), STILL])
    np.testing.assert_allclose(symmetric.at(0, 5), turn((0, 1, 0), 20, move=(0.25, 0, 1)), atol=1e-12)
    mirrored = edit_keys([0, 10, 20], [STILL, STILL * [[1], [1], [-1]], 0 * STILL])
    assert all(np.isfinite(mirrored.at(0, t)).all() for t in np.arange(0, 20.1, 0.5))


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
