# SPDX-License-Identifier: GPL-3.0-or-later
"""The tutorial, rebuilt: each figure is on the page, or said to be missing, and shows what its sentence says.

The samples of Blender among them are asserted in tests/blender/methods/test_tutorial_samples.py.
"""

import re
from functools import cache, partial
from pathlib import Path

import numpy as np
import pytest

from sinew.core import methods

from test_comparison import ROOT  # isort: skip

from blend_samples.comparison import ROWS, distortion, native_solve  # noqa: E402
from blend_samples.comparison import figures  # noqa: E402
from blend_samples.comparison.matrix import areas, edges_of, lengths  # noqa: E402
from blend_samples.comparison.numpy_rows import axis_and_angle, turned  # noqa: E402

sn = pytest.importorskip("sinew_native")
pytestmark = pytest.mark.slow
PAGE = ROOT / "docs" / "methods" / "tutorial.md"


@cache
def drawn(name: str) -> dict[str, figures.Shown]:
    """The views of a figure by their captions, as its picture has them."""
    row = next(row for row in ROWS if row.name == name)
    return {each.caption: each for each in row.draw(partial(native_solve, methods, sn), sn)}


def shapes(name: str) -> list[np.ndarray]:
    return [each.shape for each in drawn(name).values()]


def measured(name: str, what: str) -> list[float]:
    """Of each view the measure of that name."""
    return [getattr(distortion(each.case, each.shape), what) for each in drawn(name).values()]


def test_every_figure_and_table_has_a_row() -> None:
    assert [row.name for row in ROWS] == [f"Figure {k}" for k in range(1, 25)] + ["Table 1", "Table 2"]
    assert [row.section for row in ROWS] == sorted(row.section for row in ROWS)


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row.name)
def test_the_page_shows_each_row_or_says_that_it_is_missing(row) -> None:
    parts = dict(re.findall(r"^### (.+?)\n(.*?)(?=^##|\Z)", PAGE.read_text("utf-8"), flags=re.M | re.S))
    part = parts[row.name]
    assert row.shows in part
    assert f"\n## {row.section} " in PAGE.read_text("utf-8") or row.section.count(".") == 2
    pictures = re.findall(r"!\[[^]]+\]\(\.\./manual/images/([\w-]+)\.jpg\)", part)
    if not row.picture:
        assert "not yet rebuilt" in row.shows
        assert not pictures
        return
    assert pictures == [row.picture]
    assert (ROOT / "docs/manual/images" / f"{row.picture}.jpg").is_file()
    tests = re.findall(r"\[assertion\]\(\.\./\.\./(tests/[\w/]+\.py)\)", part)
    assert any(f"def {row.test}(" in (ROOT / name).read_text("utf-8") for name in tests)
    assert re.search(r"\]\((\w+|\.\./\.\./native/[\w/]+)\.(md|h)\)", part), "no method is named"


def test_each_step_of_subdivision_has_four_times_the_faces_and_is_nearer_to_the_limit() -> None:
    *steps, limit = drawn("Figure 1").values()
    faces = [int(each.note.split()[0].replace(",", "")) for each in steps]
    assert faces == [faces[0], 4 * faces[0], 16 * faces[0]]
    control = limit.shape[: faces[0] + 2]  # of a closed surface of quads without holes
    away = [np.linalg.norm(each.shape[: len(control)] - control, axis=1).mean() for each in steps]
    assert away[0] > 3.0 * away[1]
    assert away[1] > 3.0 * away[2]


def test_four_times_the_faces_have_a_quarter_of_the_error() -> None:
    errors = [[float(share) for share in re.findall(r"([\d.]+)%", each.note)] for each in drawn("Figure 2").values()]
    off, bent = np.array(errors).T
    np.testing.assert_allclose(off[1:] / off[:-1], 0.25, atol=0.01)
    np.testing.assert_allclose(bent[1:] / bent[:-1], 0.25, atol=0.04)


def test_the_diagnosis_names_what_is_not_manifold() -> None:
    """All three meet in the origin, or in a line through it."""
    views = list(drawn("Figure 3").values())
    kinds = ("1 non-manifold vertex", "1 non-manifold edge", "1 non-manifold vertex")
    assert all(kind in each.note for kind, each in zip(kinds, views))
    for each, mark in zip(views, (218, 8, 218)):
        np.testing.assert_allclose(each.shape[-mark:].mean(0), 0.0, atol=1e-9)
        np.testing.assert_allclose(each.colours[-mark:], [figures.ORANGE] * mark)


def test_weights_and_masses_are_those_of_the_drawn_angles_and_areas() -> None:
    first, second = drawn("Figure 4").values()
    count = 1 + len(figures.RING)
    points = first.shape[:count]
    ring = np.arange(1, count)
    mesh = sn.SurfaceMesh(points, np.stack((0 * ring, ring, np.roll(ring, -1)), 1))
    angles = []
    for corner, *rim in (first.shape[-28:-14], first.shape[-14:]):
        one, other = rim[0] - corner, rim[-1] - corner
        angles.append(np.arctan2(np.linalg.norm(np.cross(one, other)), one @ other))
    weight = -sn.laplacian(mesh)[0, 1 + figures.EDGE]
    assert weight == pytest.approx(0.5 * sum(1.0 / np.tan(angles)))
    assert first.note == f"weight {weight:.3f}"
    cell = np.arange(count + 1, count + 1 + 2 * len(ring))
    fan = np.stack((0 * cell + count, cell, np.roll(cell, -1)), 1)
    assert areas(second.shape, fan).sum() == pytest.approx(sn.mass(mesh)[0])


def test_the_cotangent_laplacian_with_areas_sees_the_surface_and_not_its_faces() -> None:
    """A lifted thin plate is a cubic in x, whatever its faces are; so the exact curvature is known, too."""
    _rest, *views = drawn("Figure 5").values()
    x = views[0].case.points[:, 0]
    t = np.clip((x - 0.2) / 1.6, 0.0, 1.0)
    cubic, slope, second = 0.8 * (3 * t**2 - 2 * t**3), 3.0 * t * (1 - t), 1.875 * (1 - 2 * t)
    off = [np.abs(each.shape[:, 2] - cubic).max() for each in views]
    assert off[0] > 2.0 * off[1] > 10.0 * off[2]
    assert off[2] < 0.0125 * 0.8  # of the lift; the rest is what the coarse faces at the right cost
    inside = (x > 0.3) & (x < 1.7)
    exact = -0.5 * second / (1.0 + slope**2) ** 1.5
    rms = []
    for each in views:
        found = sn.curvature(sn.SurfaceMesh(each.shape, each.case.triangles)).mean
        rms.append(np.sqrt(np.mean((found - exact)[inside] ** 2)))
    assert rms[0] > 3.0 * rms[1] > 6.0 * rms[2], rms


def test_splines_of_degree_one_are_creased_and_smoother_ones_less_round_than_the_thin_shell() -> None:
    """On the way from the fixed frame to the lifted disc."""
    points = next(iter(drawn("Figure 6").values())).case.points
    middle = np.flatnonzero(np.abs(points[:, 1] - 1.0) < 1e-9)
    middle = middle[np.argsort(points[middle, 0])]
    x = points[middle[1:-1], 0]
    between, border = (x > 0.15) & (x < 0.5), np.abs(x - 0.55) < 0.06
    creased, smooth, finer, shell = (np.abs(np.diff(shape[middle, 2], 2)) for shape in shapes("Figure 6"))
    assert creased[between].max() > 5.0 * smooth[between].max()
    assert min(smooth[border].max(), finer[border].max()) > 1.5 * shell[border].max()


def test_the_field_is_one_on_the_handle_and_damps_its_move() -> None:
    _regions, field, tilted = drawn("Figure 7").values()
    way = np.subtract(figures.ORANGE, figures.PLAIN)
    share = (field.colours - figures.PLAIN) @ way / (way @ way)
    case = tilted.case
    assert share.min() > -1e-9 and share.max() < 1.0 + 1e-9
    np.testing.assert_allclose(share[case.handles[1]], 1.0, atol=1e-9)
    np.testing.assert_allclose(share[case.handles[0]], 0.0, atol=1e-9)
    pose, centre = case.poses[1], np.array((1.0, 1.0, 0.0))
    axis, angle = axis_and_angle(pose[:, :3])
    move = pose[:, :3] @ centre + pose[:, 3] - centre
    damped = centre + turned(case.points - centre, axis, (share * angle)[:, None]) + share[:, None] * move
    np.testing.assert_allclose(tilted.shape, damped, atol=1e-6)


def test_propagation_by_distance_dents_the_inside_of_a_handle() -> None:
    """Inside a lifted ring, only the distance field falls again; a thin shell is smooth."""
    rest, *lifted = shapes("Figure 8")
    inside = np.linalg.norm(rest[:, :2] - 1.0, axis=1) < 0.4
    geodesic, harmonic, shell = (shape[inside, 2] for shape in lifted)
    assert geodesic.min() < 0.75 * 0.5
    np.testing.assert_allclose(harmonic, 0.5, atol=1e-9)
    assert 0.5 < shell.min() < shell.max() < 1.05 * 0.5


def test_only_what_turns_details_keeps_bumps_upright() -> None:
    _rest, shell, normal, rigid = measured("Figure 10", "angle_mean")
    assert rigid < normal < 0.7 * shell
    strain = measured("Figure 10", "edge_rms")
    assert strain[3] < strain[2] < strain[1]


@pytest.mark.parametrize("name", ["Figure 11", "Figure 12"])
def test_two_bands_come_apart_and_together_again(name: str) -> None:
    """The base is smooth, and the details on the bent base are as long as they were."""
    rest, base, bent, whole = shapes(name)
    case = next(iter(drawn(name).values())).case
    height = np.linalg.norm(rest - base, axis=1)
    np.testing.assert_allclose(np.linalg.norm(whole - bent, axis=1), height, atol=1e-9)
    rough = [np.abs(np.diff(sn.curvature(sn.SurfaceMesh(each, case.triangles)).mean[edges_of(case.triangles)])) for each in (rest, base)]
    assert rough[1].mean() < 0.5 * rough[0].mean()
    assert np.abs(bent - base).max() > 10.0 * height.max()


def test_details_in_global_coordinates_lean_over() -> None:
    """They are the base and unturned vectors: of a linear base, as if there were none."""
    rest, base, bent, _whole = shapes("Figure 12")
    _rest, flat, turned_with, _rigid = shapes("Figure 13")
    np.testing.assert_allclose(flat, bent + (rest - base), atol=1e-9)
    assert np.abs(turned_with - flat).max() > 0.01
    _rest, sheared, upright, _rigid = measured("Figure 13", "angle_max")
    assert upright < 0.5 * sheared
    _rest, sheared, upright, _rigid = measured("Figure 13", "edge_rms")
    assert upright < 0.65 * sheared


def test_volumes_and_transfer_keep_bumps_apart() -> None:
    _rest, normal, volumes, transfer = measured("Figure 14", "edge_least")
    assert normal < 0.5 * min(volumes, transfer)


def test_one_system_joins_the_turned_triangles() -> None:
    rest, squashed, torn, joined = drawn("Figure 15").values()
    _one, volume, _torn, kept = measured("Figure 15", "edge_least")
    assert volume < 0.1 < 0.7 < kept
    assert distortion(torn.case, torn.shape).edge_rms < 1e-9
    ends = torn.shape[np.argsort(rest.case.triangles.ravel(), kind="stable")]
    corners = np.sort(rest.case.triangles.ravel())
    gaps = np.linalg.norm(np.diff(ends, axis=0)[np.diff(corners) == 0], axis=1)
    assert gaps.max() > 0.1 * lengths(rest.shape, edges_of(rest.case.triangles)).max()
    assert not np.allclose(squashed.shape, joined.shape, atol=0.5)


def test_a_handle_that_moves_far_turns_too_little_or_too_much() -> None:
    """The turn of the forelegs, in degrees, of an animal whose head is lifted and carried back."""
    rest = next(iter(drawn("Figure 16").values())).case.points
    legs = (rest[:, 0] > 0.4) & (rest[:, 0] < 1.3) & (rest[:, 2] < 0.6)
    arm, turns = rest[legs] - rest[legs].mean(0), []
    for shape in shapes("Figure 16"):
        u, _s, v = np.linalg.svd(arm.T @ (shape[legs] - shape[legs].mean(0)))
        rotation = (u @ v).T
        turns.append(np.degrees(np.arctan2(rotation[2, 0], rotation[2, 2])))
    _shell, blind, overdone, rigid, _nonlinear = turns
    assert abs(blind) < 3.0
    assert 30.0 < rigid < 60.0 < 1.5 * rigid < overdone


def test_bumps_stay_as_they_are_in_a_large_bend() -> None:
    _rest, ninety, far, shell = measured("Figure 22", "edge_rms")
    assert ninety < far < 0.02 < 0.1 < shell
