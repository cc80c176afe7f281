# SPDX-License-Identifier: GPL-3.0-or-later
"""Lattices next to SciPy's splines and dense pseudo-inverses; and what they refuse."""

import numpy as np
import pytest
from scipy.interpolate import BSpline
from scipy.optimize import brentq
from scipy.stats import binom

import sinew_native as sn

from ..methods import bound_to

POINTS = np.random.default_rng(4).uniform(0.0, 1.0, (200, 3))
SHEAR = np.array(((1.2, 0.3, 0.0), (-0.4, 0.8, 0.1), (0.5, 0.2, 2.0)))


def lattice(u: int, v: int, w: int) -> np.ndarray:
    """The points of the unit cube, the first axis first."""
    lines = [np.linspace(0.0, 1.0, count) if count > 1 else np.array([0.5]) for count in (w, v, u)]
    z, y, x = np.meshgrid(*lines, indexing="ij")
    return np.stack((x, y, z), axis=-1).reshape(-1, 3)


def bound(rest: np.ndarray, points: np.ndarray, **options: object) -> sn.Ffd:
    return bound_to(sn.Ffd(rest, **options), points)


def along(count: int, degree: int, places: np.ndarray) -> np.ndarray:
    """SciPy's functions of evenly spaced points at places in [0, 1], (n, count)."""
    knots = np.concatenate((np.zeros(degree), np.linspace(0.0, 1.0, count - degree + 1), np.ones(degree)))
    even = BSpline(knots, np.linspace(0.0, 1.0, count), degree)
    t = np.array([brentq(lambda s, x=x: even(s) - x, 0.0, 1.0, xtol=1e-15) for x in places])
    return BSpline(knots, np.eye(count), degree)(t)


def bernstein(count: int, places: np.ndarray) -> np.ndarray:
    return binom.pmf(np.arange(count), count - 1, places[:, None])


def convolved(count: int, a: float, places: np.ndarray) -> np.ndarray:
    """Cubic convolution of evenly spaced points; those beyond an end are as the end, as in Blender."""
    neighbours = np.arange(-3 * count, 4 * count)
    d = abs((count - 1) * np.clip(places, -2, 3)[:, None] - neighbours)
    near, far = ((2 - a) * d + a - 3) * d * d + 1, ((5 - d) * d - 8) * a * d + 4 * a
    weights = np.where(d < 1, near, np.where(d < 2, far, 0))
    return weights @ np.eye(count)[np.clip(neighbours, 0, count - 1)]


CONVOLUTIONS = [
    ({"basis": "blender", "interpolation": [name] * 3}, a)
    for name, a in (("cardinal", 0.71), ("catmull_rom", 0.5))
]


@pytest.mark.parametrize(
    ("counts", "options", "functions", "reach"),
    [
        *(((6, 7, 9), {"degree": d}, lambda n, x, d=d: along(n, d, x), 0.0) for d in (1, 2, 3, 4, 5)),
        *((n, {"basis": "bezier"}, bernstein, 0.0) for n in ((2, 3, 4), (5, 6, 2), (9, 1, 16))),
        *(((4, 5, 3), k, lambda n, x, a=a: convolved(n, a, x), 9) for k, a in CONVOLUTIONS),
    ],
)
def test_lattices_blend_by_the_functions_of_each_axis(counts, options, functions, reach) -> None:
    rest, points = lattice(*counts), POINTS + reach * (POINTS[:, :1] - 0.5)
    posed = rest + np.random.default_rng(1).uniform(-0.3, 0.3, rest.shape)
    u, v, w = (functions(count, points[:, axis]) for axis, count in enumerate(counts))
    moves = (posed - rest).reshape(*counts[::-1], 3)
    expected = points + np.einsum("pi,pj,pk,kjic->pc", u, v, w, moves)
    found = bound(rest, points, resolution=counts, **options).warp(posed)
    np.testing.assert_allclose(found, expected, atol=1e-12)


@pytest.mark.parametrize("continuity", [0, 1, 2])
def test_frozen_borders_end_the_deformation_with_continuous_derivatives(continuity: int) -> None:
    """Four points inside, one on the border and one outside: the move grows with a power of the distance."""
    points, rest = np.full((6, 3), 0.5), lattice(11, 1, 1)
    points[:, 0] = 1 + 1e-3 * np.arange(-4, 2)
    method = bound(rest, points, resolution=(11, 1, 1), outside="freeze", continuity=continuity)
    moved = (method.warp(rest + (1, 0, 0)) - points)[:, 0]
    assert moved[4] == moved[5] == 0 < moved[0]
    assert np.log2(moved[0] / moved[2]) == pytest.approx(continuity + 1, abs=0.1)


@pytest.mark.parametrize("counts", [(1, 1, 1), (2, 1, 1), (1, 3, 1), (2, 2, 1), (1, 2, 5)])
@pytest.mark.parametrize("basis", ["bspline", "bezier", "blender linear", "blender bspline"])
def test_lattices_of_few_points_follow_what_they_have(counts: tuple[int, int, int], basis: str) -> None:
    basis, *kind = basis.split()
    options = {"basis": basis, "interpolation": 3 * kind} if kind else {"basis": basis}
    rest, points = lattice(*counts), 2.0 * POINTS - 0.5
    method = bound(rest, points, resolution=counts, **options)
    np.testing.assert_allclose(method.warp(rest + (1, 2, 3)), points + (1, 2, 3), rtol=0, atol=1e-13)


@pytest.mark.parametrize("basis", ["bspline", "bezier"])
def test_a_bent_lattice_places_points_by_its_own_map_and_a_mirrored_one_is_not_folded(basis: str) -> None:
    straight, mirror = lattice(4, 4, 4), (-1, 1, 1)
    x, y, z = straight.T
    bent = straight + 0.15 * np.column_stack([y * z, x * x, np.sin(2 * x)])
    posed = bent + np.random.default_rng(3).uniform(-0.3, 0.3, bent.shape)
    plain = bound(straight, POINTS, basis=basis)
    found = bound(bent, plain.warp(bent), basis=basis).warp(posed)
    np.testing.assert_allclose(found, plain.warp(posed), rtol=0, atol=1e-9)
    found = bound(straight * mirror, POINTS * mirror, basis=basis).warp(2 * straight * mirror)
    np.testing.assert_allclose(found, 2 * POINTS * mirror, rtol=0, atol=1e-13)


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_lattices_do_the_same_in_every_unit_and_place(scale: float) -> None:
    rest = lattice(4, 4, 4)
    posed = rest + np.random.default_rng(1).uniform(-0.2, 0.2, rest.shape)
    expected = bound(rest, POINTS).warp(posed)
    for offset in (0.0, 1000.0):
        at = scale * offset
        found = bound(scale * rest + at, scale * POINTS + at).warp(scale * posed + at)
        np.testing.assert_allclose((found - at) / scale, expected, atol=1e-9)


def cells(counts: tuple[int, int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Boxes in the unit cube: points, and all quads."""
    u, v, w = counts
    number = np.arange((u + 1) * (v + 1) * (w + 1)).reshape(w + 1, v + 1, u + 1)
    sheets = [np.moveaxis(number, axis, -1) for axis in range(3)]
    quads = [np.stack((n[:-1, :-1], n[1:, :-1], n[1:, 1:], n[:-1, 1:]), -1).reshape(-1, 4) for n in sheets]
    return lattice(u + 1, v + 1, w + 1), np.concatenate(quads).astype(np.int32)


def test_unsmoothed_hexahedra_are_trilinear_and_their_affine_maps_affine() -> None:
    points, quads = cells((2, 3, 2))
    mesh = sn.SurfaceMesh(points, quads)
    method = bound(mesh, POINTS, smooth=0)
    posed = points + np.random.default_rng(1).uniform(-0.1, 0.1, points.shape)
    linear = bound(points, POINTS, resolution=(3, 4, 3), degree=1)
    np.testing.assert_allclose(method.warp(posed), linear.warp(posed), atol=1e-12)
    outside = 4.0 * POINTS - 1.5
    for smooth in range(3):
        method = bound(mesh, outside, smooth=smooth)
        np.testing.assert_allclose(method.warp(points @ SHEAR.T + 3.0), outside @ SHEAR.T + 3.0, atol=1e-9)


def test_cells_that_come_apart_at_a_hanging_edge_are_remarked_on() -> None:
    one, two = cells((1, 1, 1)), cells((1, 2, 1))
    points = np.concatenate((one[0] - (1, 0, 0), two[0]))
    points, number = np.unique(points, axis=0, return_inverse=True)
    quads = number.ravel()[np.concatenate((one[1], two[1] + len(one[0])))]
    middle = np.flatnonzero((points[:, 0] == 0) & (points[:, 1] == 0.5)).tolist()
    [remark] = sn.Ffd(sn.SurfaceMesh(points, quads), smooth=0).bind(POINTS).remarks
    assert remark.startswith(f"control points {middle[0]}, {middle[1]} lie on cells")
    whole = sn.Ffd(sn.SurfaceMesh(*cells((2, 2, 1))), smooth=0)
    assert whole.bind(POINTS).remarks == []


def test_a_folded_lattice_and_a_flat_one_are_named() -> None:
    rest = lattice(3, 3, 3)
    folded = rest.copy()
    folded[13, 0] = 1.4
    for wrong, some in ((folded, 13), (rest * (1.0, 1.0, 0.0), 5)):
        with pytest.raises(sn.InvalidMesh) as refused:
            sn.Ffd(wrong)
        assert refused.value.element_kind == "vertex"
        assert some in refused.value.elements
    assert refused.value.elements == list(range(27))
    rest[4, 1] = np.nan
    with pytest.raises(sn.InvalidMesh) as refused:
        sn.Ffd(rest)
    assert (refused.value.element_kind, refused.value.elements) == ("vertex", [4])


@pytest.mark.parametrize(
    "wrong",
    [
        {"basis": "blender", "interpolation": "cubic"},
        {"basis": "blender", "interpolation": ["linear"]},
        {"outside": "freeze", "continuity": 1},  # leaves no plane that moves
        {"resolution": (4, 4, 5)},
        {"resolution": (4, 16)},
        {"axes": np.eye(2)},
    ],
    ids=str,
)
def test_options_out_of_range_are_refused(wrong: dict) -> None:
    with pytest.raises(sn.InvalidOption):
        sn.Ffd(lattice(4, 4, 4), **wrong)
    with pytest.raises(sn.InvalidOption, match="no cube"):
        sn.Ffd(lattice(3, 4, 5))
    with pytest.raises(sn.InvalidOption):
        sn.Ffd(lattice(17, 1, 1), resolution=(17, 1, 1), basis="bezier")


def responses(method: sn.InverseFfd, handles: np.ndarray, count: int) -> np.ndarray:
    """How far each handle goes if one control point of count^3 goes by one."""
    rest = method.lattice
    forward = bound(rest, handles, resolution=(count, count, count))
    moved = [forward.warp(rest + np.outer(row, (1.0, 0.0, 0.0))) for row in np.eye(count**3)]
    return np.stack([shape[:, 0] - handles[:, 0] for shape in moved], 1)


@pytest.mark.parametrize(
    ("count", "points", "cut_off"), [(5, 4, 1e-3), (40, 4, 1e-3), (200, 4, 1e-3), (5, 6, 1e-6)]
)
def test_the_inverse_leaves_out_small_singular_values(count: int, points: int, cut_off: float) -> None:
    """With more and fewer handles than control points, one of them twice unless all are met."""
    random = np.random.default_rng(8)
    handles, drag = random.uniform(0.0, 1.0, (count, 3)), random.uniform(-1.0, 1.0, (count, 3))
    if points == 4:
        handles[1] = handles[0]
    method = bound_to(sn.InverseFfd(handles, resolution=points, cut_off=cut_off), handles)
    B = responses(method, handles, points)
    expected = np.linalg.pinv(B, rcond=cut_off) @ drag
    assert method.rank == np.linalg.matrix_rank(B, tol=cut_off * np.linalg.norm(B, 2))
    # Squares of singular values lose half of the digits of the smallest ones kept.
    found = method.control_moves(handles + drag)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-7 * np.abs(expected).max())
    if points == 6:
        np.testing.assert_allclose(method.warp(handles + drag), handles + drag, atol=1e-9)


def test_an_inverse_lattice_needs_handles_and_a_lattice_of_its_range() -> None:
    for handles, elements in ((np.zeros((0, 3)), []), ([(0, 0, 0), (np.inf, 0, 0)], [1])):
        with pytest.raises(sn.InvalidConstraint) as refused:
            sn.InverseFfd(handles)
        assert list(refused.value.elements) == elements
    for wrong in ({"resolution": (1, 5, 5)}, {"resolution": (5, 17, 5)}, {"cut_off": 0.0}):
        with pytest.raises(sn.InvalidOption):
            sn.InverseFfd(POINTS[:1], **wrong)
    with pytest.raises(sn.InvalidConstraint):
        sn.InverseFfd(POINTS[:1]).control_moves(POINTS[:1])  # before bind()


def test_handles_at_one_place_are_met_in_the_mean_and_reported() -> None:
    handles = np.array(((0.5, 0.5, 0.5), (0.5, 0.5, 0.5)))
    method = sn.InverseFfd(handles)
    report = method.bind(POINTS)
    assert method.rank == 1
    [remark] = report.remarks
    assert remark.startswith("handle points 1 coincide with others: where they are dragged apart, they meet")
    drag = np.array(((0.2, 0.0, 0.0), (0.0, 0.2, 0.0)))
    forward = bound(method.lattice, handles[:1], resolution=(5, 5, 5))
    met = forward.warp(method.lattice + method.control_moves(handles + drag))
    np.testing.assert_allclose(met[0], (0.6, 0.6, 0.5), atol=1e-12)


def test_where_handles_cannot_all_be_met_their_weights_count() -> None:
    random = np.random.default_rng(11)
    handles, weights = random.uniform(0.0, 1.0, (40, 3)), random.uniform(0.05, 1.0, 40)
    method = sn.InverseFfd(handles, weights=weights, resolution=2, cut_off=1e-6)
    assert method.bind(POINTS).remarks == []
    drag = random.uniform(-0.2, 0.2, handles.shape)
    B = responses(method, handles, 2)
    expected = np.linalg.solve(B.T @ (weights[:, None] * B), B.T @ (weights[:, None] * drag))
    np.testing.assert_allclose(method.control_moves(handles + drag), expected, atol=1e-9)
    twice = sn.InverseFfd(np.concatenate((handles, handles[:2])), weights=[*weights, 0.5, 1.0])
    assert "handle points 41 coincide" in twice.bind(POINTS).remarks[0]
    with pytest.raises(sn.InvalidConstraint, match="weights"):
        sn.InverseFfd(handles, weights=[0.5])
    with pytest.raises(sn.InvalidOption, match="weights"):
        sn.InverseFfd(handles, weights=np.zeros(40))
