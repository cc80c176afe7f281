# SPDX-License-Identifier: GPL-3.0-or-later
"""New triangles for a surface: their size, how far away they are, and what they take over."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import sinew_native as sn

from ..cages import CUBE, QUADS
from ..inputs.test_random_meshes import EVERY_RUN, meshes
from ..meshes import STILL, grid, halved, joined, messy, sphere, torus, tube
from ..methods import SURFACE_METHODS, bound_to, made as on_mesh


def edges_of(faces: np.ndarray) -> np.ndarray:
    return np.unique(np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])), axis=0)


def halves(mesh: tuple[np.ndarray, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    return mesh[0], halved(mesh[1])


def lengths(points: np.ndarray, pairs: np.ndarray) -> np.ndarray:
    return np.linalg.norm(points[pairs[:, 0]] - points[pairs[:, 1]], axis=1)


def closest(points: np.ndarray, faces: np.ndarray, at: np.ndarray) -> np.ndarray:
    """The distance of a point from each triangle (m,), by its plane and its three sides."""
    a, b, c = points[faces].swapaxes(0, 1)
    normal = np.cross(b - a, c - a)
    height = ((at - a) * normal).sum(1) / (normal**2).sum(1)
    foot = at - height[:, None] * normal
    inside = np.ones(len(faces), dtype=bool)
    found = np.full(len(faces), np.inf)
    for start, end in ((a, b), (b, c), (c, a)):
        inside &= (np.cross(end - start, foot - start) * normal).sum(1) >= 0
        along = end - start
        share = np.clip(((at - start) * along).sum(1) / (along**2).sum(1), 0, 1)
        found = np.minimum(found, np.linalg.norm(start + share[:, None] * along - at, axis=1))
    return np.where(inside, np.linalg.norm(foot - at, axis=1), found)


def makers(mesh: sn.SurfaceMesh, **options):
    yield sn.remesh(mesh, **options)
    yield sn.decimate(mesh, max(4, len(mesh.triangles) // 4), **options)
    yield sn.semi_regular(mesh, 2, **options).finest
    yield sn.remove_degenerate(mesh, **options)


@pytest.mark.parametrize("share", [0.5, 1.0, 2.0])
def test_edges_are_of_the_length_asked_for_and_stay_on_the_surface(share: float):
    points, faces = sphere(4)
    mean = lengths(points, edges_of(faces)).mean()
    made = sn.remesh(sn.SurfaceMesh(points, faces), share * mean, rounds=5)
    found = lengths(made.points, edges_of(made.faces)) / (share * mean)
    assert ((found > 4 / 5) & (found < 4 / 3)).mean() > 0.8
    assert made.mean_distance < 1e-12  # vertices are put back
    assert made.distance < 0.5 * (max(share, 1.0) * mean) ** 2  # of a chord of the unit sphere, four times
    assert sn.SurfaceMesh(made.points, made.faces).diagnose().euler_characteristic == 2


def test_lengths_by_curvature_keep_the_tolerance_and_halve_the_error_of_as_many_even_triangles():
    axes = np.array((1.0, 1.0, 0.3))
    points, faces = sphere(6)
    mesh = sn.SurfaceMesh(points * axes, faces)

    def off(made) -> float:
        """How far its faces are from the ellipsoid, to first order."""
        inside = np.random.default_rng(0).dirichlet((1, 1, 1), 20) @ made.points[made.faces]
        height = ((inside / axes) ** 2).sum(2) - 1
        return np.abs(height / (2 * np.linalg.norm(inside / axes**2, axis=2))).max()

    for tolerance in (4e-3, 1e-3):
        wanted = sn.lengths_by_curvature(mesh, tolerance)
        ends = edges_of(mesh.triangles)
        assert (np.abs(np.diff(wanted[ends])[:, 0]) <= 0.5 * lengths(mesh.points, ends) + 1e-12).all()
        made = sn.remesh(mesh, wanted)
        a, b, c = made.points[made.faces].swapaxes(0, 1)
        area = np.linalg.norm(np.cross(b - a, c - a), axis=1).mean() / 2
        even = sn.remesh(mesh, np.sqrt(4 / np.sqrt(3) * area))
        assert off(made) < tolerance
        assert made.distance < tolerance
        assert len(even.faces) > 0.95 * len(made.faces)
        assert off(made) < 0.5 * off(even)


def test_folds_are_not_bent_but_round_borders_are():
    e = 1e-2
    on_circle = 0.75 * np.sqrt(6 * e - 3 * e**2)
    box = sn.SurfaceMesh(*grid_cube())
    assert (sn.lengths_by_curvature(box, longest=0.7) == 0.7).all()
    assert np.allclose(sn.lengths_by_curvature(sn.SurfaceMesh(*sphere(4)), e), on_circle, rtol=0.01)
    turns = np.linspace(0, 2 * np.pi, 64, endpoint=False)
    disc = np.concatenate([np.column_stack([np.cos(turns), np.sin(turns), 0 * turns]), np.zeros((1, 3))])
    fan = [(k, (k + 1) % 64, 64) for k in range(64)]
    found = sn.lengths_by_curvature(sn.SurfaceMesh(disc, fan), e, longest=10)
    assert np.allclose(found, [*[on_circle] * 64, on_circle + 0.5], rtol=0.01)


def test_values_come_from_the_closest_point():
    points, faces = grid(9)
    for made in makers(sn.SurfaceMesh(points, faces)):
        weights = made.vertex_weights
        assert weights.min() >= 0
        assert np.allclose(weights.sum(1), 1, atol=1e-14)
        places = (points[made.vertex_sources] * weights[..., None]).sum(1)
        farthest = 0.0
        for at, place in zip(made.points, places, strict=True):
            least = closest(points, faces, at).min()
            assert abs(np.linalg.norm(at - place) - least) < 1e-12
            farthest = max(farthest, least)
        for centre, source in zip(made.points[made.faces].mean(1), made.face_sources, strict=True):
            distances = closest(points, faces, centre)
            assert distances[source] < distances.min() + 1e-12
            farthest = max(farthest, distances.min())
        assert made.distance >= farthest - 1e-12


def test_texture_coordinates_keep_their_seam():
    points, quads = tube(12, 24)
    faces = halved(quads)
    around = np.arctan2(points[:, 2], points[:, 1]) / (2 * np.pi) % 1
    corners = around[faces]
    corners[(corners == 0) & (corners.max(1) > 0.5)[:, None]] = 1.0  # beyond the last column
    seam = np.stack([np.arange(12), np.arange(1, 13)], 1) * 24
    for made in makers(sn.SurfaceMesh(points, faces), lines=seam):
        carried = (corners.ravel()[made.corner_sources] * made.corner_weights).sum(2)
        assert np.ptp(carried, axis=1).max() < 0.3  # no face goes around
        angle = np.arctan2(made.points[:, 2], made.points[:, 1]) / (2 * np.pi) % 1
        wrong = np.abs(carried - angle[made.faces])
        assert np.minimum(wrong, 1 - wrong).max() < 0.01
        assert wrong.max() > 0.9  # both ends are there
        assert np.isclose(lengths(made.points, made.lines).sum(), 12)
        assert np.abs(made.points[made.lines][..., 2]).max() < 1e-12
        assert np.array_equal(np.unique(made.line_sources), np.arange(12)) or len(made.lines) < 12


def test_folds_corners_and_borders_stay():
    cube = sn.SurfaceMesh(*grid_cube())
    for made in (*makers(cube, angle=0.5), sn.decimate(cube, 12, angle=0.5)):
        for corner in np.unique(CUBE, axis=0):
            assert np.linalg.norm(made.points - corner, axis=1).min() < 1e-12
        assert np.isclose(made.distance, 0, atol=1e-12)
    points, faces = grid(8)
    flat = points * (1, 1, 0)
    for made in makers(sn.SurfaceMesh(flat, faces)):
        a, b, c = made.points[made.faces].swapaxes(0, 1)
        assert np.isclose(np.cross(b - a, c - a)[:, 2].sum() / 2, 64)
        assert sn.SurfaceMesh(made.points, made.faces).diagnose().clean


def grid_cube() -> tuple[np.ndarray, np.ndarray]:
    made = sn.remesh(sn.SurfaceMesh(CUBE, QUADS), 0.2 * np.ptp(CUBE), angle=0.5)
    return made.points, made.faces


def test_decimation_reaches_its_count_and_stays_near():
    points, faces = sphere(4)
    mesh = sn.SurfaceMesh(points, faces)
    before = np.inf
    for count in (40, 160, 640):
        made = sn.decimate(mesh, count, angle=3.0)
        assert count - 2 <= len(made.faces) <= count
        assert made.distance < 0.5 * before
        before = made.distance
        assert sn.SurfaceMesh(made.points, made.faces).diagnose().euler_characteristic == 2


def test_needles_and_caps_go():
    points, faces = grid(12)
    points = np.concatenate([points, points[60:61] + 1e-3 * (points[61] - points[60])])
    split = [face for face in faces.tolist() if {60, 61} <= set(face)]
    faces = np.array([face for face in faces.tolist() if face not in split])
    parts = [[169 if v == one else v for v in face] for face in split for one in (60, 61)]
    mesh = sn.SurfaceMesh(points, np.concatenate([faces, parts]))
    made = sn.remove_degenerate(mesh)
    sides = np.stack([lengths(made.points, made.faces[:, list(pair)]) for pair in ((0, 1), (1, 2), (2, 0))])
    assert (sides.max(0) / sides.min(0)).max() < 4
    assert len(made.faces) == 288
    assert made.distance < 0.01
    assert sn.SurfaceMesh(made.points, made.faces).diagnose().euler_characteristic == 1


def test_levels_split_in_four_and_approach_the_surface():
    mesh = sn.SurfaceMesh(*sphere(4))
    distances = []
    for levels in (1, 2, 3):
        made = sn.semi_regular(mesh, levels, base_faces=60, angle=3.0)
        faces, points = made.base_faces, made.finest.points[: made.counts[0]]
        assert len(made.finest.faces) == len(faces) * 4**levels
        for level in range(levels):
            edges = edges_of(faces)
            assert made.counts[level + 1] == made.counts[level] + len(edges)
            middles = np.concatenate([points, made.finest.points[len(points) : made.counts[level + 1]]])
            split = middles[len(points) :] - made.displacements[level]
            expected = points[edges].mean(1)
            order = np.lexsort(np.round(split, 9).T), np.lexsort(np.round(expected, 9).T)
            assert np.allclose(split[order[0]], expected[order[1]], atol=1e-12)
            if level + 1 < levels:
                coarse = sn.semi_regular(mesh, level + 1, base_faces=60, angle=3.0).finest
                faces, points = coarse.faces, coarse.points
                assert np.array_equal(points, made.finest.points[: len(points)])
        distances.append(made.finest.distance)
    assert distances[1] < 0.5 * distances[0]
    assert distances[2] < 0.6 * distances[1]  # the old surface is no sphere itself


def test_what_is_no_manifold_stays_joined():
    points, faces = grid(6)
    wall = points[[21, 22, 23]] + (0, 0, 3)
    fin = [(21, 22, 50), (21, 50, 49), (22, 23, 51), (22, 51, 50)]
    apart = points + (20, 0, 0)  # a second part, which touches itself in one vertex
    kept = np.delete(faces, np.flatnonzero((faces == 24).any(1))[1:-1], axis=0) + 52
    mesh = sn.SurfaceMesh(np.concatenate([points, wall, apart]), np.concatenate([faces, fin, kept]))
    told = mesh.diagnose()
    for made in makers(mesh):
        found = sn.SurfaceMesh(made.points, made.faces).diagnose()
        assert found.component_count == 2
        assert found.euler_characteristic == told.euler_characteristic
        assert len(found.non_manifold_edges) > 0
        assert len(found.slit_edges) == 0


PARTS = ((2, 0, *sphere(2)), (1, 1, *grid(6)), (0, 0, *halves(torus(9, 6))), (0, 2, *halves(tube(5, 8))))
FAULTS = ("hole", "double", "turned", "fin", "needle", "loose")


def with_faults(parts, faults, seed: int) -> tuple[sn.SurfaceMesh, list[str]]:
    """Parts side by side with faults that are apart from each other, and those that found a place."""
    rng, found = np.random.default_rng(seed), []
    apart = [(PARTS[part][2] + (9 * k, 0, 0), PARTS[part][3]) for k, part in enumerate(parts)]
    points, faces = (each.tolist() for each in joined(*apart))
    used = {v for loop in sn.SurfaceMesh(np.array(points), faces).diagnose().boundary_loops for v in loop}
    for fault in faults:
        free = [k for k, face in enumerate(faces) if not used & set(face)]
        if not free:
            break
        k = free[rng.integers(len(free))]
        face, corners = faces[k], np.array(points)[faces[k]]
        used |= {v for other in faces if set(other) & set(face) for v in other}
        found.append(fault)
        if fault == "hole":
            del faces[k]
        elif fault == "double":
            faces.append(face[1:] + face[:1])
        elif fault == "turned":
            faces[k] = face[::-1]
        else:
            used.add(len(points))
            at = {"loose": (0, 0, 9), "needle": corners[0] + 1e-4 * (corners[1:].mean(0) - corners[0])}
            normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
            at["fin"] = corners[:2].mean(0) + normal / np.sqrt(np.linalg.norm(normal))
            points.append(list(at[fault]))
            if fault == "fin":
                faces.append([*face[:2], len(points) - 1])
            elif fault == "needle":
                faces[k : k + 1] = [[*pair, len(points) - 1] for pair in (face[:2], face[1:], face[::-2])]
    return sn.SurfaceMesh(np.array(points), faces), found


@settings(EVERY_RUN, max_examples=60)
@given(
    st.lists(st.sampled_from(range(len(PARTS))), min_size=1, max_size=3),
    st.lists(st.sampled_from(FAULTS), max_size=8),
    st.integers(0, 2**32 - 1),
)
def test_random_faults_are_counted_and_mended(parts, faults, seed: int):
    mesh, planted = with_faults(parts, faults, seed)
    told, count = mesh.diagnose(), planted.count
    euler = sum(PARTS[part][0] for part in parts) - count("hole")
    assert told.component_count == len(parts) + count("loose")
    assert told.euler_characteristic == euler + count("double")
    assert len(told.boundary_loops) >= sum(PARTS[part][1] for part in parts) + count("hole")
    assert len(told.non_manifold_edges) == count("fin") + 3 * count("double")
    found = told.duplicate_faces, told.flipped_faces, told.loose_vertices
    assert [len(each) for each in found] == [count(fault) for fault in ("double", "turned", "loose")]
    for made in makers(mesh):
        after = sn.SurfaceMesh(made.points, made.faces).diagnose()
        assert (after.component_count, after.euler_characteristic) == (len(parts), euler)
        faults_left = after.duplicate_faces, after.flipped_faces, after.loose_vertices, after.degenerate_faces
        assert not any(map(len, faults_left))


@settings(EVERY_RUN, max_examples=120)
@given(meshes())
def test_random_meshes_are_remade_or_refused(drawn):
    points, faces = drawn
    try:
        mesh = sn.SurfaceMesh(points, ([len(face) for face in faces], [v for face in faces for v in face]))
        a, b, c = points[mesh.triangles].swapaxes(0, 1)
        longest = np.max([((x - y) ** 2).sum(1) for x, y in ((a, b), (b, c), (c, a))], axis=0, initial=0)
        makes = (
            lambda: sn.remesh(mesh, max(np.sqrt(longest.sum() / 4000), 1e-200)),
            lambda: sn.decimate(mesh, 8),
            lambda: sn.semi_regular(mesh, 2).finest,
            lambda: sn.remove_degenerate(mesh),
        )
    except sn.InvalidMesh:
        return
    for make in makes:
        try:
            made = make()
        except (sn.InvalidMesh, sn.InvalidOption):
            continue
        assert np.isfinite(made.points).all()
        assert np.isfinite(made.vertex_weights).all()
        assert np.isfinite(made.corner_weights).all()
        assert np.isfinite(made.distance)
        assert len(made.face_sources) == len(made.faces)
        assert all(len(set(face)) == 3 for face in made.faces.tolist())


def test_threads_and_calls_change_no_bit_and_progress_cancels():
    mesh = sn.SurfaceMesh(*grid(20))
    first = [(made.points, made.corner_weights) for made in makers(mesh)]
    sn.limit_threads(1)
    try:
        again = [(made.points, made.corner_weights) for made in makers(mesh)]
    finally:
        sn.limit_threads(0)
    for one, other in zip(first, again, strict=True):
        assert all(np.array_equal(*pair) for pair in zip(one, other, strict=True))
    for make in (sn.remesh, lambda m, **o: sn.decimate(m, 90, **o), sn.semi_regular):
        with pytest.raises(sn.Cancelled):
            make(mesh, progress=lambda fraction, _stage: fraction < 0.7)


def test_levels_open_in_subdivision_editing_and_multiresolution():
    made = sn.semi_regular(sn.SurfaceMesh(*sphere(4)), 2, base_faces=60, angle=3.0)
    mesh = sn.SurfaceMesh(made.finest.points, made.finest.faces)
    editing = sn.SubdivisionEditing(mesh, coarsening="levels", levels=2)
    editing.set_handles([np.arange(3)])
    assert editing.level_counts() == [2]
    assert editing.control_mesh().vertex_count == made.counts[0]
    sn.Multiresolution(mesh, sn.ThinShell(mesh)).set_handles([np.arange(3), np.arange(20, 24)])


@pytest.mark.parametrize("method", SURFACE_METHODS)
def test_remade_messy_meshes_bind_in_every_method(method: type):
    for result in makers(sn.SurfaceMesh(*messy())):
        ends = [np.argsort(result.points[:, 0])[each] for each in (slice(4), slice(-4, None))]
        surface = bound_to(on_mesh(method, sn.SurfaceMesh(result.points, result.faces)), ends)
        assert np.abs(surface.solve([STILL, STILL])[0] - result.points).max() < 1e-6 * np.ptp(result.points)


def test_refusals():
    mesh = sn.SurfaceMesh(*grid(3))
    for wrong in ([], 0.0, -1.0, np.nan, np.inf):
        with pytest.raises(sn.InvalidOption):
            sn.remesh(mesh, wrong)
    for call in (
        lambda: sn.remesh(mesh, rounds=0),
        lambda: sn.remesh(mesh, angle=0.0),
        lambda: sn.remesh(mesh, 1e-6),
        lambda: sn.remesh(mesh, np.ones(3)),
        lambda: sn.remesh(mesh, np.arange(mesh.vertex_count)),
        lambda: sn.lengths_by_curvature(mesh, -1.0),
        lambda: sn.lengths_by_curvature(mesh, shortest=2.0, longest=1.0),
        lambda: sn.decimate(mesh, 3),
        lambda: sn.semi_regular(mesh, 0),
        lambda: sn.semi_regular(mesh, 2, base_faces=3),
        lambda: sn.remove_degenerate(mesh, ratio=1.0),
        lambda: sn.remove_degenerate(mesh, cap=1.0),
        lambda: sn.remove_degenerate(mesh, share=0.0),
    ):
        with pytest.raises(sn.InvalidOption):
            call()
    flat = sn.SurfaceMesh(np.zeros((3, 3)), [[0, 1, 2]])
    for call in (sn.remesh, lambda m: sn.decimate(m, 4), sn.semi_regular):
        with pytest.raises(sn.InvalidMesh, match="area"):
            call(flat)
