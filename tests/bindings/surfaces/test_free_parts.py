# SPDX-License-Identifier: GPL-3.0-or-later
"""Parts without a handle that ride on those that have one, through the Python module."""

import numpy as np
import pytest

import sinew_native as sn

from ..meshes import STILL, ends, grid, halved, joined, quad_grid, shift, sphere, turn
from ..methods import SURFACE_METHODS, bound_to, made

METHODS = pytest.mark.parametrize("method", SURFACE_METHODS)


def dressed() -> tuple[sn.SurfaceMesh, list[np.ndarray]]:
    """A hill with a ball and a smaller ball on it, and the handles of the hill."""
    points, faces = grid(20)
    ball, ball_faces = sphere(1)
    peak = points[points[:, 2].argmax()]
    balls = [(0.4 * ball + peak + (0, 0, 0.5), ball_faces), (0.1 * ball + peak + (0, 0, 1.02), ball_faces)]
    return sn.SurfaceMesh(*joined((points, faces), *balls)), ends(points, 2.5)


@METHODS
def test_riding_parts_are_reported_and_written_in_single_precision(method: type) -> None:
    mesh, handles = dressed()
    surface = made(method, mesh)
    report = surface.set_handles(handles, free_parts="follow")
    n, poses = 21**2, [STILL, shift(0, 0, 9)]
    assert repr(report.rides[1]) == "<Ride: part 2 of 18 vertices on part 1, 1 frame>"
    assert "0 free parts, 2 riding" in repr(report)
    np.testing.assert_array_equal(report.riding_vertices, np.arange(n, n + 36))
    positions, out = surface.solve(poses)[0], np.empty((n + 36, 3), np.float32)
    assert np.linalg.norm(positions[n:] - mesh.points[n:], axis=1).min() > 1
    np.testing.assert_array_equal(surface.solve(poses, out=out)[0], positions.astype(np.float32))


def test_bad_options_are_refused_and_the_last_bind_stays() -> None:
    mesh, handles = dressed()
    shell = bound_to(sn.ThinShell(mesh), handles, free_parts="follow")
    assert len(shell.set_stiffness(1.0, 1.0).rides) == 2
    poses = [STILL, shift(0, 0, 3)]
    before, _ = shell.solve(poses)
    painted = np.full(mesh.vertex_count, 0.5)
    painted[[3, 7]] = 1.5, np.nan
    with pytest.raises(sn.InvalidOption, match="not one of 'stay', 'follow'"):
        shell.set_handles(handles, free_parts="fly")
    for wrong in (-0.1, 1.1, np.nan, [0.5, 0.5]):
        with pytest.raises(sn.InvalidOption, match="free_part_stiffness"):
            shell.set_handles(handles, free_parts="follow", free_part_stiffness=wrong)
    with pytest.raises(sn.InvalidOption, match="vertices 3, 7") as refused:
        shell.set_handles(handles, free_parts="follow", free_part_stiffness=painted)
    assert (refused.value.elements, refused.value.element_kind) == ([3, 7], "vertex")
    np.testing.assert_array_equal(shell.solve(poses)[0], before)


def test_a_painted_stiffness_makes_a_long_part_rigid() -> None:
    points, faces = grid(20, jitter=0.0)
    cells, quads = quad_grid(64, 1)
    strip = cells * (0.25, 1, 0) + (2, 10, 3)
    mesh = sn.SurfaceMesh(*joined((points, faces), (strip, halved(quads))))
    stretched = []
    for stiffness in (1.0, 0.0):
        painted = np.where(np.arange(mesh.vertex_count) < len(points), 0.0, stiffness)
        shell = sn.ThinShell(mesh)
        (ride,) = shell.set_handles(ends(points, 2.5), free_parts="follow", free_part_stiffness=painted).rides
        assert ride.frame_count > 1
        moved = shell.solve([STILL, shift(0, 0, 8)])[0][len(points) :]
        stretched.append(np.linalg.norm(moved[-1] - moved[0]) / np.linalg.norm(strip[-1] - strip[0]) - 1)
    assert abs(stretched[0]) < 1e-12 < 1e-3 < abs(stretched[1])


def odd_parts() -> dict[str, tuple[np.ndarray, list | np.ndarray]]:
    """Points around the middle of the hill, and triangles of them."""
    corner, one = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]), [(0, 1, 2)]
    return {
        "twice the same": (np.concatenate([corner, corner]), [(0, 1, 2), (3, 4, 5)]),
        "one place": (np.zeros((3, 3)), one),
        "a line": (np.outer([0, 1, 2], [1.0, 0, 0]), one),
        "an edge": (corner[:2], [(0, 1, 1)]),
        "far": (corner + 1e4, one),
        "tiny": (1e-160 * corner, one),
        "huge": (1e5 * corner, one),
        "debris": (np.random.default_rng(0).normal(0, 100, (3000, 3)), np.arange(1500).reshape(-1, 3)),
    }


@pytest.mark.slow
@METHODS
@pytest.mark.parametrize("odd", odd_parts())
def test_odd_parts_are_finite_and_move_with_everything(method: type, odd: str) -> None:
    points, faces = grid(20)
    more, triangles = odd_parts()[odd]
    mesh = sn.SurfaceMesh(*joined((points, faces), (more + points.mean(0), np.array(triangles))))
    surface, close = made(method, mesh), {"rtol": 0, "atol": 1e-6 * np.abs(mesh.points).max()}
    assert surface.set_handles(ends(points, 2.5), free_parts="follow").free_parts == 0
    assert np.isfinite(surface.solve([STILL, shift(0, 0, 9)])[0]).all()
    np.testing.assert_allclose(surface.solve([shift(1, 2, 3)] * 2)[0], mesh.points + (1, 2, 3), **close)
    incoming, _ = surface.solve([STILL] * 2, incoming=2 * mesh.points)
    np.testing.assert_allclose(incoming, 2 * mesh.points, **close)


def row_of_beads(gap: float) -> tuple[sn.SurfaceMesh, list[np.ndarray], np.ndarray]:
    """A strip with a row of balls along it, its ends as handles, and pairs of vertices where they touch."""
    points, quads = quad_grid(60, 8, 0.25)
    ball, faces = sphere(2)
    balls = [((0.5 - gap / 2) * ball + (4.0 + k, 1.0, 0.5), faces) for k in range(8)]
    first = len(points) + len(ball) * np.arange(7)
    pairs = np.stack([first + ball[:, 0].argmax(), first + len(ball) + ball[:, 0].argmin()], 1)
    return sn.SurfaceMesh(*joined((points, halved(quads)), *balls)), ends(points, 0.9), pairs


@pytest.mark.parametrize(("gap", "together"), [(0.005, True), (-0.1, True), (0.1, False)])
def test_parts_that_touch_ride_as_one(gap: float, together: bool) -> None:
    mesh, handles, pairs = row_of_beads(gap)
    arap = sn.Arap(mesh)
    rides = arap.set_handles(handles, free_parts="follow").rides
    assert [(ride.part, ride.host) for ride in rides] == [(part, 0) for part in range(1, 9)]
    bent, _ = arap.solve([STILL, turn((0, 1, 0), 80, (7.5, 0, 0))])
    apart = np.linalg.norm(bent[pairs[:, 0]] - bent[pairs[:, 1]], axis=1)
    assert (np.abs(apart - abs(gap)).max() < 0.02) == together


def test_hair_that_touches_stays_together_and_on_the_head() -> None:
    """Strips from a head, of which each covers a part of the next one; the top of the head turns."""
    head = sphere(4)
    down = np.linspace(0, 1, 13)
    rise, out = 0.6 - 1.44 * down, 1.0 + 0.4 * down
    every = [head]
    for k in range(12):
        side = 0.06 * k + np.array([-0.035, 0.035])
        around = np.stack([np.cos(side), np.sin(side)], -1)
        away = out + 0.004 * (1 + k % 2)
        flat, high = away * np.cos(rise), np.column_stack([away * np.sin(rise)] * 2)
        strip = np.concatenate([flat[:, None, None] * around, high[..., None]], -1).reshape(-1, 3)
        every.append((strip, halved(quad_grid(1, 12)[1])))
    points, faces = joined(*every)
    strips = np.arange(len(head[0]), len(points)).reshape(12, -1, 2)
    arap = sn.Arap(sn.SurfaceMesh(points, faces))
    height = head[0][:, 2]
    handles = [np.flatnonzero(height < -0.7), np.flatnonzero(height > 0.85)]
    report = arap.set_handles(handles, free_parts="follow")
    assert {ride.host for ride in report.rides} == {0}
    assert len({ride.frame_count for ride in report.rides}) == 1  # one part, of many frames
    turned, _ = arap.solve([STILL, turn((0, 1, 0), 50, (0, 0, -0.7))])

    def gaps(shape: np.ndarray) -> np.ndarray:
        """A side of a strip lies on the next one: on the line between two vertices there."""
        sides = shape[strips]
        return np.linalg.norm(sides[:-1, :, 1] - (6 * sides[1:, :, 0] + sides[1:, :, 1]) / 7, axis=-1)

    assert np.abs(gaps(turned) - gaps(points)).max() < 0.01


@pytest.mark.parametrize("height", [0.01, 0.03])
@pytest.mark.parametrize("method", [sn.Arap, sn.ThinShell])
def test_a_sheet_on_another_follows_a_bump_that_is_smaller_than_its_frames(
    method: type, height: float
) -> None:
    """What lies above goes as far as what is beneath, and none of it is poked through."""
    points, quads = quad_grid(40, 40, 0.05)
    away = np.linalg.norm(points - (1, 1, 0), axis=1)
    sheet = made(method, sn.SurfaceMesh(*joined((points, quads), (points + (0, 0, height), quads))))
    sheet.set_handles([np.flatnonzero(away < 0.15), np.flatnonzero(away > 0.7)], free_parts="follow")
    below, above = np.split(sheet.solve([shift(0, 0, 0.2), STILL])[0][:, 2], 2)
    assert above.max() > 0.98 * 0.2 + height
    assert (above > below).all()


BALL = sphere(3)
BEADS = [(0.06 * BALL[0] + (x, -0.5 + x * x, 0.0), BALL[1]) for x in (-0.22, -0.11, 0.0, 0.11, 0.22)]
ON_THE_PLANE = {
    "ball": [(0.15 * BALL[0] - (0.0, 0.4, 0.0), BALL[1])],
    "tongue": [(BALL[0] * (0.05, 0.5, 0.05) - (0.0, 0.3, 0.0), BALL[1])],
    "teeth": BEADS,
}


@pytest.mark.parametrize("part", ON_THE_PLANE)
def test_a_part_on_the_mirror_plane_stays_on_it(part: str) -> None:
    """In a large ball whose cheeks are pulled alike: one frame, several, and parts that touch."""
    head, *inside = sphere(4), *ON_THE_PLANE[part]
    points, faces = joined(head, *inside)
    shell, cheeks = sn.ThinShell(sn.SurfaceMesh(points, faces)), ((0.8, -0.6, 0.0), (-0.8, -0.6, 0.0))
    held = [np.flatnonzero(np.linalg.norm(head[0] - place, axis=1) < 0.3) for place in cheeks]
    shell.set_handles([*held, np.flatnonzero(head[0][:, 1] > 0.7)], free_parts="follow")
    moved, _ = shell.solve([shift(0.3, -0.4, 0.1), shift(-0.3, -0.4, 0.1), STILL])
    mirror, own = np.array((-1.0, 1.0, 1.0)), np.arange(len(head[0]), len(points))
    assert np.linalg.norm((moved - points)[own].mean(axis=0)) > 0.02
    # Each vertex goes to the mirror image of where its own image goes; those of the plane stay on it.
    away = np.linalg.norm(points[own, None] * mirror - points[None, own], axis=2)
    assert away.min(axis=1).max() < 1e-12
    assert np.abs(moved[own] * mirror - moved[own][away.argmin(axis=1)]).max() < 4e-6
