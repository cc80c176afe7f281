# SPDX-License-Identifier: GPL-3.0-or-later
"""SubdivisionSurface by NumPy: published rules, identities, and what is refused."""

import numpy as np
import pytest
import scipy.sparse as sparse

import sinew_native as sn

from .. import limits
from ..cages import CUBE, OUTLINE, QUADS
from ..meshes import messy, moved, off, quad_grid, sphere

SHEET, CELLS = quad_grid(3, 2)


def over(points, faces, **options) -> sn.SubdivisionSurface:
    return sn.SubdivisionSurface(sn.SurfaceMesh(points, faces), **options)


def cube(**options) -> sn.SubdivisionSurface:
    return over(CUBE, QUADS, **options)


def loop_once(points: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Loop's rules for a closed mesh: moved vertices, and the new ones of edges."""
    neighbours: dict[int, set] = {}
    opposite: dict[tuple, list] = {}
    for face in faces:
        for k in range(3):
            a, b, c = face[k], face[(k + 1) % 3], face[(k + 2) % 3]
            neighbours.setdefault(a, set()).update((b, c))
            opposite.setdefault((min(a, b), max(a, b)), []).append(c)
    moved = np.empty_like(points)
    for v, ring in neighbours.items():
        n = len(ring)
        beta = (5 / 8 - (3 / 8 + np.cos(2 * np.pi / n) / 4) ** 2) / n
        moved[v] = (1 - n * beta) * points[v] + beta * points[list(ring)].sum(axis=0)
    middles = [(3 * points[list(e)].sum(0) + points[apexes].sum(0)) / 8 for e, apexes in opposite.items()]
    return moved, np.array(middles)


def test_loop_follows_the_published_rules() -> None:
    points, faces = sphere(1)
    points = points + np.random.default_rng(1).normal(0, 0.1, points.shape)
    surface = over(points, faces, scheme="loop", level=1)
    moved, middles = loop_once(points, faces)
    fine = surface.refine(points)
    # Weights below 1 over a few points of size 1: a few roundings.
    np.testing.assert_allclose(fine[: len(points)], moved, atol=1e-15)
    left = {tuple(point) for point in fine[len(points) :].round(12)}
    assert left == {tuple(point) for point in middles.round(12)}
    assert surface.faces.shape == (4 * len(faces), 3)


def catmull_clark(points: np.ndarray, faces: list, edges: dict, corners: dict) -> tuple:
    """One level, with borders and creases (T. DeRose et al. 1998): vertices, then those that edges and faces
    add; the faces; what is sharp then."""
    beside: dict[frozenset, list] = {}
    for f, face in enumerate(faces):
        for edge in zip(face, np.roll(face, -1)):
            beside.setdefault(frozenset(edge), []).append(f)
    sharp = {edge: edges.get(edge, 0.0) if len(own) == 2 else np.inf for edge, own in beside.items()}
    middles = np.array([points[list(face)].mean(0) for face in faces])

    def vertex(v: int, own: list, edges: list, corner: float) -> np.ndarray:
        ends = [sum(edge) - v for edge in own]
        creased = [w for w, s in zip(ends, edges) if s > 0]
        if corner > 0 or len(creased) > 2:
            return points[v]
        if len(creased) == 2:
            return 0.75 * points[v] + points[creased].sum(0) / 8
        around = middles[[v in face for face in faces]]
        return ((len(around) - 2) * points[v] + points[ends].mean(0) + around.mean(0)) / len(around)

    made, less = [], lambda s: max(s - 1, 0)
    for v in range(len(points)):
        own, corner = [edge for edge in beside if v in edge], corners.get(v, 0.0)
        now = [sharp[edge] for edge in own]
        share = np.mean([s for s in (*now, corner) if 0 < s <= 1] or [1.0])
        later = vertex(v, own, list(map(less, now)), less(corner))
        made.append(share * vertex(v, own, now, corner) + (1 - share) * later)
    for edge, own in beside.items():
        share, middle = min(sharp[edge], 1.0), points[list(edge)].mean(0)
        made.append(share * middle + (1 - share) * (middle + middles[own].mean(0)) / 2)
    number = {edge: len(points) + k for k, edge in enumerate(beside)}
    quads = [
        (v, number[frozenset((v, after))], len(made) + f, number[frozenset((before, v))])
        for f, face in enumerate(faces)
        for before, v, after in zip(np.roll(face, 1), face, np.roll(face, -1))
    ]
    halves = {frozenset((v, number[edge])): less(s) for edge, s in sharp.items() for v in edge}
    return np.array([*made, *middles]), quads, halves, {v: less(s) for v, s in corners.items()}


def limit(v: int, points: np.ndarray, faces: list, edges: dict, corners: dict) -> np.ndarray:
    """Where the rules take a vertex in 60 levels. At each of them nothing but the faces around it matters."""
    for _ in range(60):
        near = [face for face in faces if v in face]
        to = {w: k for k, w in enumerate(np.unique(np.concatenate(near)))}
        edges = {frozenset(to[w] for w in edge): s for edge, s in edges.items() if edge <= set(to)}
        corners, faces = {to[v]: corners.get(v, 0.0)}, [[to[w] for w in face] for face in near]
        points, faces, edges, corners = catmull_clark(points[list(to)], faces, edges, corners)
        v = to[v]
    return points[v]


@pytest.mark.parametrize("level", [0, 1, 2])
def test_polygons_borders_creases_and_corners_follow_the_published_rules_to_the_limit(level: int) -> None:
    """Also at the end of an endless crease, where Blender stops some levels in; see the tests in Blender."""
    faces = [list(range(8))[::-1], list(range(8, 16)), *[[i, i + 1, i + 9, i + 8] for i in range(7)]]  # open
    creases = {(0, 1): 10.0, (1, 2): 3.25, (2, 3): 1.5, (3, 11): 0.375, (5, 13): 10.0}
    sharp = {"creases": (list(creases), list(creases.values())), "corners": ([9, 14], [2.75, 10.0])}
    corners = [len(face) for face in faces], np.concatenate(faces)
    points = np.column_stack((np.tile(OUTLINE, (2, 1)), np.arange(16) // 8))
    plain, own = (
        over(points, corners, level=level, limit=smooth, **sharp).refine(points) for smooth in (False, True)
    )
    endless = {frozenset(edge): s if s < 10 else np.inf for edge, s in creases.items()}
    state = points, faces, endless, {9: 2.75, 14: np.inf}
    for _ in range(level):
        state = catmull_clark(*state)
    some = range(0, len(plain), 1 + 4 * level)
    for exact, found in ((state[0], plain), (np.array([limit(v, *state) for v in some]), own)):
        assert np.abs(exact[:, None] - found).max(axis=2).min(axis=1).max() < 1e-13  # of a width of 3
    assert state[0].shape == plain.shape == own.shape


@pytest.mark.parametrize("n", [3, 4, 5, 8])
def test_limits_of_triangles_are_those_of_the_published_masks(n: int) -> None:
    """C. Loop 1987, where n faces meet at vertex 0."""
    k, points = np.arange(n), np.random.default_rng(4).normal(size=(n + 2, 3))
    ring = np.stack([1 + k, 1 + (k + 1) % n], 1)
    fans = [np.insert(ring, 0, 0, axis=1), np.insert(ring[:, ::-1], 0, n + 1, axis=1)]
    beta = (5 / 8 - (3 / 8 + np.cos(2 * np.pi / n) / 4) ** 2) / n
    own = 1 / (1 + 8 * n * beta / 3)
    loop = over(points, np.concatenate(fans), scheme="loop", level=0, limit=True).matrix.toarray()
    np.testing.assert_allclose(loop[0], [own, *np.full(n, (1 - own) / n), 0], atol=1e-13)


def test_limits_of_triangles_are_where_many_levels_lead() -> None:
    """What OpenSubdiv's own rules give far down, with sharpness of every kind that is left."""
    points, faces = sphere(0)
    creases = [faces[f][k : k + 2] for f, k in ((0, 0), (1, 0), (1, 1), (3, 1))]
    sharp = {"creases": (creases, [10.0, 3.3, 1.5, 0.4]), "corners": ([faces[1][2]], 2.7)}

    def refined(level: int, limit: bool = False) -> np.ndarray:
        return over(points, faces, scheme="loop", level=level, limit=limit, **sharp).refine(points)

    far, farther = refined(7), refined(8)
    np.testing.assert_array_equal(refined(0), points)
    for level in (0, 1, 2):
        limit = refined(level, limit=True)
        left, last = (off(shape[: len(limit)], farther[: len(limit)]) for shape in (limit, far))
        # What is left shrinks by a factor of at most 0.7 a level (valence 5 or less).
        assert left < 0.7 / 0.3 * last + 1e-14
        assert left < 2e-3


@pytest.mark.parametrize("scheme", ["catmull_clark", "bilinear"])
@pytest.mark.parametrize("limit", [False, True])
def test_affine_maps_pass_through_on_any_mesh(scheme: str, limit: bool) -> None:
    points, faces = messy()
    faces = faces[[len(set(face)) == 3 for face in faces]]  # a corner twice is refused
    sharp = {"creases": ([(0, 1), (10, 11)], [2.5, 10.0]), "corners": ([30], 1.5)}
    surface = over(points, faces, scheme=scheme, limit=limit, **sharp)
    np.testing.assert_allclose(surface.matrix.sum(axis=1), 1.0, atol=1e-14)
    pose = np.random.default_rng(2).uniform(-1, 1, (3, 4))
    found, expected = surface.refine(moved(pose, points)), moved(pose, surface.refine(points))
    np.testing.assert_allclose(found, expected, atol=1e-12)


def test_level_zero_takes_no_memory_and_too_many_levels_are_refused() -> None:
    with limits.memory(1 << 20):
        assert over(*quad_grid(30, 30), level=0).vertex_count == 31**2
    with pytest.raises(sn.OutOfMemory):
        over(*quad_grid(30, 30), level=10)  # 9e8 vertices


def test_open_corners_stay_by_choice() -> None:
    for words, kept in (({}, False), ({"boundary_smooth": "preserve_corners"}, True)):
        fine = over(SHEET, CELLS, level=2, **words).refine(SHEET)
        assert (fine[0] == SHEET[0]).all() == kept
    halved = over(SHEET, CELLS, scheme="bilinear", level=2).refine(SHEET)
    assert {tuple(p) for p in halved} == {(x / 4, y / 4, 0.0) for x in range(13) for y in range(9)}


@pytest.mark.parametrize(
    "options", [{}, {"limit": True}, {"scheme": "bilinear"}, {"creases": ([(0, 1)], 2.5)}]
)
def test_matrix_is_what_refine_applies(options: dict) -> None:
    surface = cube(level=3, **options)
    assert sparse.issparse(surface.matrix)
    assert surface.matrix.format == "csr"
    assert surface.matrix.shape == (surface.vertex_count, surface.control_count)
    np.testing.assert_allclose(surface.matrix.sum(axis=1), 1.0, atol=1e-15)
    points = np.random.default_rng(2).normal(size=CUBE.shape)
    np.testing.assert_allclose(surface.refine(points), surface.matrix @ points, atol=1e-14)


def test_single_precision_stays_single_and_out_is_written() -> None:
    surface = cube(level=4)
    single = surface.refine(CUBE.astype(np.float32))
    assert single.dtype == np.float32
    np.testing.assert_allclose(single, surface.refine(CUBE), atol=1e-6)  # 8 weights and points of 1, in float
    out = np.empty_like(single)
    assert surface.refine(CUBE.astype(np.float32), out) is out
    np.testing.assert_array_equal(out, single)
    for wrong in (np.empty(single.shape), out[:, :2], out[::2]):
        with pytest.raises((TypeError, sn.InvalidConstraint), match="out"):
            surface.refine(CUBE.astype(np.float32), wrong)
    out.flags.writeable = False
    with pytest.raises(ValueError, match="not writeable"):
        surface.refine(CUBE.astype(np.float32), out)


def test_another_order_moves_rows_faces_and_normals() -> None:
    surface = cube(level=2, limit=True)
    order = np.random.default_rng(4).permutation(surface.vertex_count)
    other, fine = surface.reordered(order), surface.refine(CUBE)
    np.testing.assert_array_equal(other.refine(CUBE), fine[order])
    np.testing.assert_array_equal(order[other.faces], surface.faces)
    np.testing.assert_array_equal(other.normals(fine[order]), surface.normals(fine)[order])
    for wrong in (order[1:], np.zeros_like(order), order - 1, [*order, 0]):
        with pytest.raises(sn.InvalidOption, match="named once"):
            surface.reordered(wrong)


def test_normals_of_a_smooth_cube_look_outward() -> None:
    surface = cube(level=5, limit=True)
    fine = surface.refine(CUBE)
    normals = surface.normals(fine)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0, atol=1e-14)
    # At the middle of each face, by symmetry, the normal is that of the cube.
    middle = np.abs(fine - 0.5).min(axis=0)
    for axis in range(3):
        top = np.argmax(fine[:, axis])
        np.testing.assert_allclose(normals[top], np.eye(3)[axis], atol=1e-12)
    assert middle.max() < 0.1
    assert np.einsum("ni,ni->n", normals, fine - 0.5).min() > 0.1


def test_polygons_at_level_zero() -> None:
    points, faces = CUBE, (np.array([4, 4, 4, 4, 4, 3, 3]), np.array([*QUADS[:5].ravel(), 1, 5, 7, 1, 7, 3]))
    counts, corners = over(points, faces, level=0).faces
    np.testing.assert_array_equal(counts, faces[0])
    np.testing.assert_array_equal(corners, faces[1])
    assert over(points, faces, level=1).faces.shape == (26, 4)
    loose = over(points, [], level=3, limit=True)
    np.testing.assert_array_equal(loose.refine(points), points)
    np.testing.assert_array_equal(loose.normals(points), 0 * points)


def test_face_varying_values_are_refined_by_their_own_matrix() -> None:
    corners = np.arange(24)  # each face an island
    surface = cube(level=2, face_varying=corners, uv_smooth="none")
    values = np.random.default_rng(3).normal(size=(24, 2))
    fine = surface.refine_face_varying(values)
    np.testing.assert_allclose(fine, surface.face_varying_matrix @ values, atol=1e-14)
    with pytest.raises(sn.InvalidConstraint, match=r"\(24, d\)"):
        surface.refine_face_varying(values[:3])
    assert surface.face_varying_corners.shape == (surface.faces.size,)
    # Linear islands: the values of each refined face lie within those of its face.
    for face in range(6):
        inside = fine[surface.face_varying_corners[face * 64 : face * 64 + 64]]
        own = values[4 * face : 4 * face + 4]
        assert ((inside >= own.min(axis=0) - 1e-12) & (inside <= own.max(axis=0) + 1e-12)).all()


@pytest.mark.parametrize(
    ("smooth", "kept"), [("none", True), ("preserve_boundaries", True), ("smooth_all", False)]
)
def test_face_varying_values_keep_their_seams_and_corners_unless_all_is_smoothed(
    smooth: str, kept: bool
) -> None:
    sheet = np.array([(x, y, 0.0) for y in range(2) for x in range(3)])
    surface = over(sheet, [(0, 1, 4, 3), (1, 2, 5, 4)], level=1, face_varying=range(8), uv_smooth=smooth)
    matrix = surface.face_varying_matrix
    assert matrix.shape == (18, 8)
    np.testing.assert_allclose(matrix.sum(axis=1), 1.0, atol=1e-15)
    assert set(matrix @ np.repeat([0.0, 1.0], 4)) == {0.0, 1.0}, "no refined value mixes both islands"
    assert (matrix[0, 0] == 1.0) == kept


@pytest.mark.parametrize(
    ("options", "error", "words", "elements"),
    [
        ({"scheme": "doo_sabin"}, sn.InvalidOption, "'catmull_clark', 'loop', 'bilinear'", []),
        ({"boundary_smooth": "x"}, sn.InvalidOption, "boundary_smooth", []),
        ({"uv_smooth": "x"}, sn.InvalidOption, "uv_smooth", []),
        ({"scheme": "loop"}, sn.InvalidMesh, "other faces are 0, 1, 2", list(range(6))),
        ({"level": 11}, sn.InvalidOption, "not in 0 to 10", []),
        ({"level": -1}, sn.InvalidOption, "not in 0 to 10", []),
        ({"creases": ([(0, 7)], 1.0)}, sn.InvalidOption, "no edge joins", [0, 7]),
        ({"creases": ([(0, 99)], 1.0)}, sn.InvalidOption, "99", None),
        ({"creases": ([(0, 1)], -1.0)}, sn.InvalidOption, "below 0", None),
        ({"creases": ([(0, 1)], np.nan)}, sn.InvalidOption, "sharpness", None),
        ({"creases": ([0, 1], 1.0)}, sn.InvalidOption, "pairs", []),
        ({"creases": ([(0, 1)], [1.0, 2.0])}, sn.InvalidOption, "2 sharpnesses for 1", []),
        ({"creases": 3}, TypeError, "pair", None),
        ({"corners": ([3, 8], 1.0)}, sn.InvalidOption, "the mesh has no vertices 8", [8]),
        ({"corners": ([0], -1.0)}, sn.InvalidOption, "below 0", None),
        ({"face_varying": [0, 1]}, sn.InvalidOption, "2 indices for 24", []),
        ({"face_varying": [-1] * 24}, sn.InvalidOption, "face_varying", None),
    ],
)
def test_refusals_name_what_is_wrong(
    options: dict, error: type, words: str, elements: list[int] | None
) -> None:
    with pytest.raises(error, match=words) as refused:
        cube(**options)
    assert elements is None or refused.value.elements == elements


def test_faces_with_a_corner_twice_are_named_and_points_of_another_shape_refused() -> None:
    with pytest.raises(sn.InvalidMesh) as refused:
        over(CUBE, [[0, 1, 3], [1, 1, 5]])
    assert (refused.value.element_kind, refused.value.elements) == ("face", [1])
    for points in (CUBE[:7], CUBE[:, :2], CUBE.ravel()):
        with pytest.raises(sn.InvalidConstraint, match=r"\(8, 3\)"):
            cube().refine(points)
