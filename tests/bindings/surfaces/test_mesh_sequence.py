# SPDX-License-Identifier: GPL-3.0-or-later
"""Edits of animations, next to NumPy."""

import numpy as np
import pytest

import sinew_native as sn

from ..meshes import STILL, grid, moved, nearest_rotations, shift, turn
from ..methods import bound, bound_to

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
    keys = [
        (frame, h, turn(rng.normal(size=3), 60, move=rng.uniform(-2, 2, 3)) * (1.2, 1, 0.8, 1))
        for frame in (2, 9, 15)
        for h in (0, 1)
    ]
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
