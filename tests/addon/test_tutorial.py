# SPDX-License-Identifier: GPL-3.0-or-later
"""The tutorial, rebuilt: each figure is on the page, or said to be missing, and shows what the page says."""

import re
from functools import cache, partial

import numpy as np
import pytest
from test_comparison import ROOT

from blend_samples.comparison import FIGURES, distortion, figures, native_solve
from blend_samples.comparison.matrix import areas, edges_of, lengths
from blend_samples.comparison.numpy_rows import axis_and_angle, turned
from sinew.core import methods

sn = pytest.importorskip("sinew_native")
pytestmark = pytest.mark.slow
PAGE = (ROOT / "docs/methods/tutorial.md").read_text("utf-8")


@cache
def views(number: int) -> list[figures.Shown]:
    """Those of a figure, as its picture has them."""
    return list(FIGURES[number](partial(native_solve, methods, sn), sn))


def shapes(number: int) -> list[np.ndarray]:
    return [each.shape for each in views(number)]


def measured(number: int, what: str) -> list[float]:
    return [getattr(distortion(each.case, each.shape), what) for each in views(number)]


def test_the_page_shows_each_figure_or_says_that_it_is_missing() -> None:
    parts = dict(re.findall(r"^### (.+)\n([^#]*)", PAGE, flags=re.M))
    assert list(parts) == [f"Figure {k}" for k in range(1, 25)] + ["Table 1", "Table 2"]
    shown = {name: re.findall(r"images/([\w-]+)\.jpg\)", part) for name, part in parts.items()}
    for name, part in parts.items():
        test = re.search(r"\[`(\w+)`\]\(\.\./\.\./(tests/.+?\.py)\)", part)
        if "not yet rebuilt" in part:
            assert (shown[name], test) == ([], None), name
        else:
            assert f"def {test[1]}(" in (ROOT / test[2]).read_text("utf-8"), name
            assert [(ROOT / f"docs/manual/images/{each}.jpg").is_file() for each in shown[name]] == [True]
    assert all(shown[f"Figure {k}"] == [f"tutorial-{k:02}"] for k in FIGURES)


def test_each_step_has_four_times_the_faces_and_is_nearer_to_the_limit() -> None:
    *steps, limit = views(1)
    faces = [int(each.note.split()[0].replace(",", "")) for each in steps]
    assert faces == [faces[0], 4 * faces[0], 16 * faces[0]]
    count = faces[0] + 2  # control points of a closed surface of quads without holes
    off = [np.linalg.norm(each.shape[:count] - limit.shape[:count], axis=1).mean() for each in steps]
    assert off[0] > 3.0 * off[1] > 9.0 * off[2]


def test_four_times_the_faces_have_a_quarter_of_the_error() -> None:
    errors = np.array([re.findall(r"([\d.]+)%", each.note) for each in views(2)], float)
    np.testing.assert_allclose(errors[2:] / errors[1:-1], 0.25, atol=0.02)
    assert np.all(errors[1] < 0.3 * errors[0])


def test_the_diagnosis_names_what_is_not_manifold() -> None:
    """What it names is marked: all three meet in the origin, or in a line through it."""
    for each, kind, mark in zip(views(3), ("vertex", "edge", "vertex"), (218, 8, 218)):
        assert f"1 non-manifold {kind}" in each.note
        np.testing.assert_allclose(each.shape[-mark:].mean(0), 0.0, atol=1e-9)
        np.testing.assert_allclose(each.colours[-mark:], [figures.ORANGE] * mark)


def test_weights_and_masses_are_those_of_the_drawn_angles_and_areas() -> None:
    first, second = views(4)
    count = 1 + len(figures.RING)
    mesh = sn.SurfaceMesh(first.shape[:count], figures.fan(count))
    arms = first.shape[-6:].reshape(2, 3, 3)[:, 1:] - first.shape[-6:].reshape(2, 3, 3)[:, :1]
    cotangents = [u @ v / np.linalg.norm(np.cross(u, v)) for u, v in arms]
    assert -sn.laplacian(mesh)[0, 3] == pytest.approx(0.5 * sum(cotangents))
    assert first.note == f"weight {0.5 * sum(cotangents):.3f}"
    cell = figures.fan(2 * count - 1)
    assert areas(second.shape[count:], cell).sum() == pytest.approx(sn.mass(mesh)[0])


def test_the_cotangent_laplacian_with_areas_sees_the_surface_and_not_its_faces() -> None:
    """A lifted thin plate is a cubic in x, whatever its faces are; so the exact curvature is known, too."""
    lifted = views(5)[1:]
    x = lifted[0].case.points[:, 0]
    t, inside = np.clip((x - 0.2) / 1.6, 0.0, 1.0), (x > 0.3) & (x < 1.7)
    off = [np.abs(each.shape[:, 2] - 0.8 * (3 * t**2 - 2 * t**3)).max() for each in lifted]
    assert off[0] > 2.0 * off[1] > 10.0 * off[2]
    assert off[2] < 0.0125 * 0.8  # of the lift; the rest is what the coarse faces at the right cost
    exact = -0.5 * 1.875 * (1 - 2 * t) / (1.0 + (3.0 * t * (1 - t)) ** 2) ** 1.5
    found = [sn.curvature(sn.SurfaceMesh(each.shape, each.case.triangles)).mean for each in lifted]
    rms = [np.sqrt(np.mean((mean - exact)[inside] ** 2)) for mean in found]
    assert rms[0] > 3.0 * rms[1] > 6.0 * rms[2]


def test_splines_of_degree_one_are_creased_and_smoother_ones_less_round_than_the_thin_shell() -> None:
    """On the way from the fixed frame to the lifted disc."""
    points = views(6)[0].case.points
    middle = np.flatnonzero(np.abs(points[:, 1] - 1.0) < 1e-9)
    middle = middle[np.argsort(points[middle, 0])]
    x = points[middle[1:-1], 0]
    between, border = (x > 0.15) & (x < 0.5), np.abs(x - 0.55) < 0.06
    creased, smooth, finer, shell = (np.abs(np.diff(shape[middle, 2], 2)) for shape in shapes(6))
    assert creased[between].max() > 5.0 * smooth[between].max()
    assert min(smooth[border].max(), finer[border].max()) > 1.5 * shell[border].max()


def test_the_field_is_one_on_the_handle_and_damps_its_move() -> None:
    _regions, field, tilted = views(7)
    case, way, centre = tilted.case, np.subtract(figures.ORANGE, figures.PLAIN), np.array((1.0, 1.0, 0.0))
    share = (field.colours - figures.PLAIN) @ way / (way @ way)
    np.testing.assert_allclose(share[case.held], np.isin(case.held, case.handles[1]), atol=1e-9)
    assert -1e-9 < share.min() <= share.max() < 1.0 + 1e-9
    axis, angle = axis_and_angle(case.poses[1, :, :3])
    move = case.poses[1] @ (*centre, 1.0) - centre
    damped = centre + turned(case.points - centre, axis, (share * angle)[:, None]) + share[:, None] * move
    np.testing.assert_allclose(tilted.shape, damped, atol=1e-6)


def test_propagation_by_distance_dents_the_inside_of_a_handle() -> None:
    """Inside a lifted ring, only the distance field falls again; a thin shell is smooth."""
    rest, *lifted = shapes(8)
    inside = np.linalg.norm(rest[:, :2] - 1.0, axis=1) < 0.4
    geodesic, harmonic, shell = (shape[inside, 2] for shape in lifted)
    assert geodesic.min() < 0.75 * 0.5
    np.testing.assert_allclose(harmonic, 0.5, atol=1e-9)
    assert 0.5 < shell.min() < shell.max() < 1.05 * 0.5


def test_a_thin_shell_does_not_rotate_details() -> None:
    """It moves each point straight up, however steep the slope is; around it, details turn."""
    assert np.abs((shapes(10)[1] - shapes(10)[0])[:, :2]).max() < 1e-9
    _rest, shell, normal, rigid = measured(10, "angle_mean")
    assert rigid < normal < 0.7 * shell
    _rest, shell, normal, rigid = measured(10, "edge_least")
    assert rigid > normal > 0.95 > 0.9 > shell


@pytest.mark.parametrize("number", [11, 12])
def test_two_bands_come_apart_and_together_again(number: int) -> None:
    """The base is smooth, and the details on the bent base are as long as they were."""
    rest, base, bent, whole = shapes(number)
    case, height = views(number)[0].case, np.linalg.norm(rest - base, axis=1)
    np.testing.assert_allclose(np.linalg.norm(whole - bent, axis=1), height, atol=1e-9)
    bent_at = (sn.curvature(sn.SurfaceMesh(each, case.triangles)).mean[case.free] for each in (rest, base))
    rough, smooth = (mean.std() for mean in bent_at)
    assert smooth < 0.3 * rough
    assert np.abs(bent - base).max() > 10.0 * height.max()


def test_details_in_global_coordinates_lean_over() -> None:
    """Unturned details on a bent base are what the thin shell alone gives."""
    rest, base, bent, _whole = shapes(12)
    np.testing.assert_allclose(shapes(13)[1], bent + (rest - base), atol=1e-9)
    for measure, share in (("angle_max", 0.5), ("edge_rms", 0.65)):
        _rest, sheared, upright, _rigid = measured(13, measure)
        assert upright < share * sheared
    _rest, sheared, upright, _rigid = measured(13, "edge_least")
    assert sheared < 0.5 * upright


def test_volumes_and_transfer_keep_bumps_apart() -> None:
    _rest, vectors, normal, volumes, transfer = measured(14, "edge_least")
    assert 0.9 * vectors < normal < 0.5 * min(volumes, transfer)
    _rest, vectors, normal, volumes, transfer = measured(14, "angle_max")
    assert max(vectors, volumes, transfer / 0.6) < normal


def test_one_system_joins_the_turned_triangles() -> None:
    _rest, squashed, torn, joined = measured(15, "edge_least")
    assert squashed < 0.1 < 0.7 < joined < torn
    assert torn == pytest.approx(1.0)
    corners = views(15)[0].case.triangles.ravel()
    order = np.argsort(corners, kind="stable")
    gaps = np.diff(shapes(15)[2][order], axis=0)[np.diff(corners[order]) == 0]
    longest = lengths(shapes(15)[0], edges_of(views(15)[0].case.triangles)).max()
    assert np.linalg.norm(gaps, axis=1).max() > 0.1 * longest


def test_a_handle_that_moves_far_turns_too_little_or_too_much() -> None:
    """The turn of the forelegs, in degrees, of an animal whose head is lifted and carried back."""
    rest, turns = views(16)[0].case.points, []
    legs = (rest[:, 0] > 0.4) & (rest[:, 0] < 1.3) & (rest[:, 2] < 0.6)
    for shape in shapes(16):
        found = shape[legs] - shape[legs].mean(0)
        u, _s, v = np.linalg.svd((rest[legs] - rest[legs].mean(0)).T @ found)
        turns.append(np.degrees(np.arctan2(*(u @ v)[[0, 2], 2])))
    _shell, blind, overdone, rigid, _nonlinear = turns
    assert abs(blind) < 3.0
    assert 30.0 < rigid < 60.0 < 1.5 * rigid < overdone


def test_bumps_stay_as_they_are_in_a_large_bend() -> None:
    _rest, shell, rigid = measured(22, "edge_least")
    assert shell < 0.1 < 0.9 < rigid
