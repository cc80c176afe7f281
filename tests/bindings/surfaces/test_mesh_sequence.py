# SPDX-License-Identifier: GPL-3.0-or-later
"""Edits of animations through the Python module, next to NumPy's own arithmetic and SciPy's rotations."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import sinew_native as sn

from ..meshes import STILL, ends, grid, shift, turn
from ..methods import bound

KEYS = np.array(
    [(0, 1, *STILL.ravel()), (10, 1, *turn((0, 1, 0), 40, move=(0.5, 0, 2)).ravel()), (20, 1, *STILL.ravel())]
)


def shapes(points: np.ndarray, frames: np.ndarray) -> np.ndarray:
    """A sheet that rolls up, swells and travels."""
    found = []
    for frame in frames:
        bend, x, z = 0.004 * frame + 1e-6, points[:, 0], points[:, 2] * (1 + 0.02 * frame)
        rolled = np.column_stack(
            [np.sin(bend * x) * (1 / bend - z), points[:, 1], 1 / bend - np.cos(bend * x) * (1 / bend - z)]
        )
        found.append(rolled + 0.1 * frame)
    return np.array(found)


def fitted(before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """The rotation (3, 3) between two sets of points, by SciPy."""
    rotation, _ = Rotation.align_vectors(after - after.mean(0), before - before.mean(0))
    return rotation.as_matrix()


def patch(faces: np.ndarray, handle: np.ndarray) -> np.ndarray:
    """The corners of the triangles at a handle, with repetitions as often as they hold its vertices."""
    times = np.isin(faces, handle).sum(1)
    return np.repeat(faces, times, axis=0).ravel()


def test_frames_meet_their_keys_in_the_moving_frames() -> None:
    method, points, handles = bound(sn.MeshSequence, 12)
    _, faces = grid(12)
    frames = np.arange(21.0)
    animation = shapes(points, frames)
    found, reports = method.solve_frames(frames, animation, keys=KEYS)
    assert found.shape == animation.shape
    assert all(report.converged for report in reports)
    for frame in (0, 20):
        np.testing.assert_allclose(found[frame], animation[frame], atol=1e-10)
    corners = patch(faces, handles[1])
    edit = KEYS[1, 2:].reshape(3, 4)
    shape = animation[10]
    Q, centre = fitted(points[corners], shape[corners]), shape[handles[1]].mean(0)
    local = (shape[handles[1]] - centre) @ Q
    expected = (local @ edit[:, :3].T + edit[:, 3]) @ Q.T + centre
    np.testing.assert_allclose(found[10][handles[1]], expected, atol=1e-7)  # SciPy's fit has half the digits


def test_a_frame_alone_has_the_bits_of_all_of_them() -> None:
    method, points, handles = bound(sn.MeshSequence, 12)
    farm, _, _ = bound(sn.MeshSequence, 12)  # another machine
    frames = np.array([3.5, 17.0, 8.0])
    animation = shapes(points, frames)
    together, reports = method.solve_frames(frames, animation, keys=KEYS)
    for frame, shape, expected, told in zip(frames, animation, together, reports, strict=True):
        alone, report = farm.solve_frame(frame, keys=KEYS, incoming=shape)
        np.testing.assert_array_equal(alone, expected)
        assert report.iterations == told.iterations
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


def test_edits_between_keys() -> None:
    keys = sn.EditKeys(KEYS)
    assert keys.handle_count == 2
    assert repr(keys) == "<EditKeys: 2 handles>"
    np.testing.assert_array_equal(keys.at(1, 10), KEYS[1, 2:].reshape(3, 4))
    np.testing.assert_array_equal(keys.at(0, 10), STILL)
    np.testing.assert_array_equal(keys.at(-1, 10), STILL)
    middle = keys.at(1, 5)  # half the move and half the turn, by symmetry
    np.testing.assert_allclose(middle, turn((0, 1, 0), 20, move=(0.25, 0, 1)), atol=1e-12)
    assert sn.EditKeys([]).handle_count == 0


def test_what_means_nothing_is_refused() -> None:
    method, points, _ = bound(sn.MeshSequence)
    animation = shapes(points, [1.0, 2.0])
    with pytest.raises(sn.InvalidOption, match=r"\(m, 14\)"):
        method.solve_frame(1, keys=KEYS[:, :5])
    with pytest.raises(sn.InvalidOption, match="two keys at frame 10"):
        sn.EditKeys(KEYS[[0, 1, 1]])
    with pytest.raises(sn.InvalidOption, match="names handle -1"):
        sn.EditKeys([(0, 0.5, *STILL.ravel())])
    one = sn.MeshSequence(method.rest)
    one.set_handles([[0, 1, 2]])
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


def test_a_move_alone_changes_no_direction() -> None:
    """Handles that only move keep their turn, so the shape between them does as with any method."""
    method, points, handles = bound(sn.MeshSequence)
    key = np.array([(0, 0, *shift(1, 2, 3).ravel()), (0, 1, *shift(1, 2, 3).ravel())])
    found, _ = method.solve_frame(0, keys=key)
    np.testing.assert_allclose(found, points + (1, 2, 3), atol=1e-10)
    assert len(ends(points)) == len(handles)
