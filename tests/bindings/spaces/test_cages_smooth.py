# SPDX-License-Identifier: GPL-3.0-or-later
"""Smooth cages: the same coordinates on the refined cage, with weights of its few control points."""

from itertools import pairwise

import numpy as np
import pytest

import sinew_native as sn

from ..cages import CUBE
from ..meshes import turn

METHODS = [
    (sn.MeanValue, {}),
    (sn.PositiveMeanValue, {}),
    (sn.Harmonic, {"solver": "boundary", "quality": "fast"}),
    (sn.Harmonic, {"solver": "lattice", "quality": "fast"}),
    (sn.Green, {"normals": "faces"}),
    (sn.Green, {"normals": "faces", "faces": "quads"}),
    (sn.Green, {}),
    (sn.Green, {"faces": "quads"}),
]
BY_NAME = pytest.mark.parametrize(("method", "options"), METHODS)
CREASES = {"creases": ([(0, 1), (4, 5)], (10.0, 1.3)), "corners": ([7], 2.0)}


def bar() -> tuple[np.ndarray, np.ndarray]:
    """A bar of three cubes, with points of no symmetry."""
    points = np.concatenate([CUBE[:4] + (x, 0.0, 0.0) for x in range(4)])
    points += np.random.default_rng(4).uniform(-0.1, 0.1, points.shape)
    sides = [(a, a + 4, a + 5, a + 1) for a in (0, 4, 8)] + [(a + 1, a + 5, a + 7, a + 3) for a in (0, 4, 8)]
    sides += [(a + 3, a + 7, a + 6, a + 2) for a in (0, 4, 8)] + [(a + 2, a + 6, a + 4, a) for a in (0, 4, 8)]
    return points, np.array([(0, 1, 3, 2), (12, 14, 15, 13), *sides])


BAR, SIDES = bar()
CAGE = sn.SurfaceMesh(BAR, SIDES)
INSIDE = np.random.default_rng(5).uniform((0.2, 0.4, 0.4), (2.8, 0.6, 0.6), (60, 3))


def refined(level: int, **creases: object) -> tuple[sn.SubdivisionSurface, sn.SurfaceMesh]:
    surface = sn.SubdivisionSurface(CAGE, level=level, limit=True, **creases)
    return surface, sn.SurfaceMesh(surface.refine(BAR), surface.faces)


def smooth(method: type, level: int = 2, points: np.ndarray = INSIDE, **options: object):
    made = method(CAGE, smooth="levels", levels=level, precision="double", **options)
    made.bind(points)
    return made


def bent(points: np.ndarray, angle: float = 1.2) -> np.ndarray:
    """Around a line beside it, by so much along its length."""
    x, y, z = points.T
    turned, reach = angle * x / 3, y + 3 / angle
    return np.column_stack((reach * np.sin(turned), reach * np.cos(turned), z))


@BY_NAME
def test_weights_are_those_of_the_refined_cage_times_the_stencils(method: type, options: dict):
    """The corrections that Harmonic makes at the end depend on how many weights there are."""
    surface, mesh = refined(2, **CREASES)
    whole = method(mesh, precision="double", **{k: v for k, v in options.items() if k != "normals"})
    whole.bind(INSIDE)
    made = smooth(method, **options, **CREASES)
    apart = made.vertex_weights - whole.vertex_weights @ surface.matrix
    assert np.abs(apart).max() < (2e-4 if method is sn.Harmonic else 1e-12)
    if options.get("normals"):
        assert np.abs(made.face_weights - whole.face_weights).max() < 1e-12
        pose = bent(BAR)
        assert np.abs(made.warp(pose) - whole.warp(surface.refine(pose))).max() < 1e-12
    assert made.vertex_weights.shape == (len(INSIDE), len(BAR))


def stretched(rest: np.ndarray, posed: np.ndarray) -> np.ndarray:
    """s n' of triangles (t, 3, 3), by the paper's equation 9."""
    (u, v), (p, q) = ((t[:, 1] - t[:, 0], t[:, 2] - t[:, 0]) for t in (rest, posed))
    dot = lambda a, b: (a * b).sum(1)  # noqa: E731
    square = dot(p, p) * dot(v, v) - 2 * dot(p, q) * dot(u, v) + dot(q, q) * dot(u, u)
    area, to = np.linalg.norm(np.cross(u, v), axis=1), np.cross(p, q)
    return (np.sqrt(square / 2) / area / np.linalg.norm(to, axis=1))[:, None] * to


def test_normals_follow_control_points_by_least_squares():
    """NumPy's least squares of the exact normals, by bilinear matrices: A n, with nine numbers per point."""
    surface, mesh = refined(2)
    plain = sn.SubdivisionSurface(CAGE, level=2, scheme="bilinear")
    quads = np.asarray(plain.matrix.toarray())[plain.faces].mean(axis=1)  # of the middles of quads
    exact = smooth(sn.Green, normals="faces")
    corners, pose = np.asarray(mesh.triangles), bent(BAR)
    rest, posed = mesh.points[corners], surface.refine(pose)[corners]
    normals, areas = (
        stretched(rest, rest),
        np.linalg.norm(np.cross(*np.diff(rest, axis=1).swapaxes(0, 1)), axis=1),
    )
    shares = quads[np.repeat(np.arange(len(quads)), 2)]
    basis = (shares[:, :, None] * normals[:, None, :]).reshape(len(corners), -1)
    wanted, scale = stretched(rest, posed), np.sqrt(areas)[:, None]
    found = basis @ np.linalg.lstsq(scale * basis, scale * wanted, rcond=1e-5)[0]
    fitted = exact.vertex_weights @ pose + exact.face_weights @ found
    assert np.abs(smooth(sn.Green).warp(pose) - fitted).max() < 1e-5
    assert 1e-5 < np.abs(exact.warp(pose) - fitted).max() < 1 / 500 * np.linalg.norm(np.ptp(BAR, axis=0))


@BY_NAME
def test_motions_of_the_control_points_are_motions_of_all(method: type, options: dict):
    linear = (
        1.7 * turn((1, 2, -1), 130)[:, :3]
        if method is sn.Green
        else [(1.2, 0.3, 0), (-0.4, 0.8, 0.1), (0.5, 0.2, 2)]
    )
    made = method(CAGE, smooth="levels", **options)
    made.bind(INSIDE)
    moved = made.warp(BAR @ np.transpose(linear) + (1, -2, 3))
    assert np.abs(moved - (INSIDE @ np.transpose(linear) + (1, -2, 3))).max() < 5e-6


@pytest.mark.parametrize(("method", "options"), [METHODS[0], METHODS[5]])
def test_each_level_is_four_times_as_close_to_the_limit(method: type, options: dict):
    pose = bent(BAR)
    places = [smooth(method, level, **options).warp(pose) for level in (1, 2, 3, 5)]
    errors = [np.abs(place - places[-1]).max() for place in places[:-1]]
    assert all(3.0 < coarse / fine < 5.5 for coarse, fine in pairwise(errors)), errors


def test_the_level_is_chosen_by_the_distance_from_the_limit():
    made = smooth(sn.MeanValue, 2)
    finer, surface = refined(4)[0], refined(2)[1]
    flat = sn.SubdivisionSurface(surface, level=2, scheme="bilinear")
    distance = np.abs(
        np.linalg.norm(finer.refine(BAR)[finer.faces] - flat.refine(surface.points)[flat.faces], axis=-1)
    ).max()
    assert 0.7 * made.smooth_error() < distance < made.smooth_error()
    size = np.linalg.norm(np.ptp(BAR, axis=0))
    chosen = sn.MeanValue(CAGE, smooth="automatic")
    assert chosen.smooth_error() <= 1e-3 * size < smooth(sn.MeanValue, chosen.smooth_level - 1).smooth_error()
    assert chosen.smooth_mesh.face_count == len(SIDES) * 4**chosen.smooth_level
    assert (sn.MeanValue(CAGE).smooth_level, sn.MeanValue(CAGE).smooth_mesh) == (0, None)


def test_bad_smooth_cages_are_refused_by_names_of_the_cage_itself():
    with pytest.raises(sn.InvalidOption, match="levels"):
        sn.MeanValue(CAGE, smooth="levels", levels=7)
    with pytest.raises(sn.InvalidOption, match="edge"):
        sn.MeanValue(CAGE, smooth="levels", creases=([(0, 15)], 1.0))
    with pytest.raises(sn.InvalidMesh, match="open") as error:
        sn.MeanValue(sn.SurfaceMesh(BAR, SIDES[1:]), smooth="automatic")
    assert list(error.value.elements) == [0, 1, 2, 3]
    with pytest.raises(sn.InvalidMesh, match="inside out"):
        sn.Green(sn.SurfaceMesh(BAR, SIDES[:, ::-1]), smooth="automatic")
    with pytest.raises(sn.InvalidConstraint, match="16 vertices"):
        smooth(sn.MeanValue).warp(BAR[:-1])
    made = sn.MeanValue(CAGE, smooth="levels", levels=1, precision="double")
    assert made.rebind(smooth(sn.MeanValue, 2), INSIDE).changed == "levels"


def test_a_flat_cage_has_a_smooth_outline():
    """A square becomes the closed B-spline of its corners; with sharp corners it stays a square."""
    square = sn.SurfaceMesh(CUBE[::2] * (1, 1, 0), [(0, 2, 3, 1)])
    for method in (sn.MeanValue, sn.Green):
        made = method(square, smooth="levels", levels=3, precision="double")
        points, rotation = np.array([(0.5, 0.5, 0.0), (0.02, 0.02, 0.0)]), turn((1, 1, 1), 40)[:, :3].T
        assert list(made.bind(points).outside) == [1]
        assert np.abs(made.warp(square.points @ rotation) - points @ rotation).max() < 1e-12
        kept = method(square, smooth="levels", levels=3, boundary_smooth="preserve_corners")
        assert not list(kept.bind([(0.02, 0.02, 0.0)]).outside)
