# SPDX-License-Identifier: GPL-3.0-or-later
"""The comparison gallery: its measures, and the failures that the literature reports, in our own numbers.

Nothing here needs Blender. The figures stand in docs/methods/comparison.md.
"""

from __future__ import annotations

import json
import subprocess
import sys
from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from sinew.core import methods

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from blend_samples.comparison import CASES, Case, Matrix, distortion, filled, native_solve, registry_rows  # noqa: E402
from blend_samples.comparison import igl_arap as libigl  # noqa: E402
from blend_samples.comparison.cases import bar, cylinder, plane  # noqa: E402

sn = pytest.importorskip("sinew_native")

# Root mean square of edge ratio less 1, over edges with a free end: of the results of implicit Laplacian
# editing that the authors of the survey publish, on models like ours.
PUBLISHED = {"plane": 0.130, "cylinder": 0.241, "bar": 0.200, "branches": 0.144}


def ours(name: str, **options: object):
    return native_solve(methods, sn, name, **options)


def implicit(**options: object):
    return ours("laplacian_editing", transforms="implicit", **options)


@cache
def case(name: str) -> Case:
    return CASES[name]()


def measured(edit: Case, solve):
    matrix = filled([("edit", edit)], [("method", solve)])
    return matrix.cells["method", "edit"].distortion


def unrotated_gradients(edit: Case) -> np.ndarray:
    """Anyone's NumPy method: the gradients at rest, new places of the handles, and a dense Poisson solve."""
    points, faces = edit.points, edit.triangles
    L = np.zeros((len(points), len(points)))
    for k in range(3):
        i, j, corner = (faces[:, (k + step) % 3] for step in (1, 2, 0))
        u, v = points[i] - points[corner], points[j] - points[corner]
        weight = 0.5 * (u * v).sum(1) / np.linalg.norm(np.cross(u, v), axis=1)
        for a, b, sign in ((i, j, -1), (j, i, -1), (i, i, 1), (j, j, 1)):
            np.add.at(L, (a, b), sign * weight)
    free, shape = np.flatnonzero(edit.free), edit.targets
    shape[free] = np.linalg.solve(
        L[np.ix_(free, free)], (L @ points)[free] - L[np.ix_(free, edit.held)] @ shape[edit.held]
    )
    return shape


# The measures.


def test_rest_has_no_distortion() -> None:
    for name in CASES:
        found = distortion(case(name), case(name).points)
        assert (found.edge_rms, found.angle_max, found.face_area_mean) == (0.0, 0.0, 0.0)
        assert (found.edge_least, found.edge_largest, found.area) == (1.0, 1.0, 1.0)
        assert found.volume == (1.0 if case(name).closed else None)
        assert found.handle_error > 0.1  # the handles are not where they should be


def test_a_scale_has_the_ratios_of_its_dimension() -> None:
    found = distortion(case("bar"), 1.5 * case("bar").points)
    assert found.edge_rms == pytest.approx(0.5)
    assert (found.edge_least, found.edge_largest) == pytest.approx((1.5, 1.5))
    assert (found.area, found.volume) == pytest.approx((1.5**2, 1.5**3))
    assert found.face_area_mean == pytest.approx(1.25)
    assert found.angle_max < 1e-4  # arctan2 of rounded products, in degrees


def test_only_what_is_free_counts() -> None:
    """One free vertex in the middle of a square of four, moved onto a corner."""
    points = np.array(((0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (1, 1, 0)), dtype=float)
    faces = np.array(((0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)))
    still = np.tile(np.eye(3, 4), (2, 1, 1))
    square = Case("square", points, faces, (np.array([0, 1]), np.array([2, 3])), still, closed=False)
    shape = points.copy()
    shape[4] = shape[0]
    found = distortion(square, shape)
    ratios = np.array((0.0, np.sqrt(2), 2.0, np.sqrt(2)))
    assert found.edge_rms == pytest.approx(np.sqrt(np.mean((ratios - 1) ** 2)))
    assert (found.edge_least, found.edge_largest) == pytest.approx((0.0, 2.0))
    assert (found.area, found.handle_error) == (1.0, 0.0)
    assert all(np.isfinite(value) for value in found.as_dict().values() if value is not None)


def test_the_comparison_needs_no_native_code() -> None:
    """Nothing but NumPy judges, so that a fault of the library cannot hide itself."""
    code = "import sys, blend_samples.comparison; print({'bpy', 'sinew_native'} & set(sys.modules))"
    found = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "set()"


# The matrix.


def test_compare_adds_a_row_or_a_column(tmp_path: Path) -> None:
    def refusing(_case: Case) -> np.ndarray:
        raise sn.InvalidMesh("not mine")

    matrix = Matrix(refusals=(sn.Error,))
    matrix.compare("bar", bar(3))
    matrix.compare("targets", lambda edit: edit.targets)
    matrix.compare("refusing", refusing)
    matrix.compare("short", lambda edit: edit.points[1:])
    matrix.compare("cylinder", cylinder(20))
    assert list(matrix.columns) == ["bar", "cylinder"]
    assert set(matrix.cells) == {(row, column) for row in matrix.rows for column in matrix.columns}
    matrix.write(tmp_path / "figures.json")
    rows = json.loads((tmp_path / "figures.json").read_text())["rows"]
    assert rows["targets"]["bar"]["handle_error"] == 0.0
    assert rows["refusing"]["cylinder"] == {"refused": "not mine"}
    assert "not" in rows["short"]["bar"]["refused"]


def test_every_surface_method_has_a_row() -> None:
    rows = [name for name, _solve in registry_rows(methods, sn)]
    wanted = [m for m in methods.METHODS if not m.is_space and m.control is methods.Control.HANDLES]
    assert all(any(row.split(":")[0] == method.label for row in rows) for method in wanted)
    assert sum(row.startswith("Multiresolution: ") for row in rows) == 4
    assert len(rows) == len(set(rows))


@pytest.mark.parametrize(
    ("name", "solve"), list(registry_rows(methods, sn)), ids=lambda value: str(value)[:40]
)
def test_every_row_puts_the_handles_where_they_belong(name: str, solve) -> None:
    found = filled([("bar", bar(4))], [(name, solve)], refusals=(sn.Error,)).cells[name, "bar"]
    if found.distortion is None:
        pytest.skip(found.refusal)
    assert found.distortion.handle_error < 1e-9


# What the tutorial and the survey say, section 4.6.


def test_gradient_editing_ignores_translation() -> None:
    """A handle that only moves turns no gradient, so the answer is the one of unrotated gradients."""
    edit = plane(40)
    found = ours("gradient_editing")(edit)
    assert np.abs(found - unrotated_gradients(edit)).max() < 1e-9
    blind, aware = measured(edit, ours("gradient_editing")), measured(edit, implicit())
    assert blind.edge_least < 0.9 < 0.95 < aware.edge_least
    assert blind.angle_mean > 1.4 * aware.angle_mean


def test_a_thin_shell_does_not_rotate_details() -> None:
    """It moves each point straight up, however steep the slope is; around it, details turn."""
    edit = case("plane")
    alone = ours("thin_shell")(edit)
    assert np.abs((alone - edit.points)[:, :2]).max() < 1e-9
    sheared, turned = measured(edit, ours("thin_shell")), measured(edit, ours("multiresolution"))
    assert turned.angle_mean < 0.7 * sheared.angle_mean
    assert turned.edge_least > 0.95 > 0.9 > sheared.edge_least


@pytest.mark.parametrize("mean_frame", [False, True])
def test_implicit_laplacian_editing_degrades_with_the_angle(mean_frame: bool) -> None:
    for make, angles, factor in ((bar, (45.0, 90.0, 135.0), 1.6), (cylinder, (30.0, 60.0, 90.0, 120.0), 1.5)):
        solve = implicit(mean_frame=mean_frame)
        found = [measured(make(6 if make is bar else 40, angle=angle), solve) for angle in angles]
        rms = [each.edge_rms for each in found]
        assert all(later > factor * before for before, later in pairwise(rms))
        assert all(later.edge_least < before.edge_least for before, later in pairwise(found))


@pytest.mark.parametrize("mean_frame", [False, True])
def test_substeps_made_anew_mend_the_twist(mean_frame: bool) -> None:
    """Two stages, as the product has them. The mean frame halves the angles, so it leaves less to mend."""
    edit = bar(6)
    rms = [measured(edit, implicit(mean_frame=mean_frame, substeps=k)).edge_rms for k in (1, 4, 16)]
    assert rms[0] > rms[1] > rms[2]
    assert rms[1] < (0.9 if mean_frame else 0.6) * rms[0]


def test_normal_displacements_distort_where_others_do_not() -> None:
    """Bumps on the inner side of a tight bend: they are pressed together along the normals of the base."""
    edit = plane(angle=140.0, bumps=0.12)
    found = {
        item[0]: measured(edit, ours("multiresolution", details=item[0], wavelength=20.0))
        for item in methods.BY_ID["multiresolution"].parameters[0].items
    }
    normal = found["normal_displacements"]
    for other in ("displacement_volumes", "deformation_transfer"):
        assert found[other].edge_least > 2.0 * normal.edge_least
        assert found[other].angle_max < 0.9 * normal.angle_max


def test_unrotated_gradients_distort() -> None:
    """Figure 15 b and d: a cylinder bent by 90 degrees."""
    edit = cylinder(28, angle=90.0)
    matrix = filled([("bend", edit)], [("b", unrotated_gradients), ("d", ours("gradient_editing"))])
    unrotated, rotated = (matrix.cells[row, "bend"].distortion for row in "bd")
    assert unrotated.edge_rms > 1.5 * rotated.edge_rms
    assert unrotated.volume < 0.9 * rotated.volume
    assert unrotated.edge_least < 0.7 * rotated.edge_least


@pytest.mark.parametrize("name", CASES)
def test_implicit_laplacian_editing_is_as_good_as_published(name: str) -> None:
    found = measured(case(name), implicit())
    assert found.edge_rms <= 1.2 * PUBLISHED[name]
    assert 0.6 < found.area < 1.2


@pytest.mark.parametrize("name", CASES)
def test_nonlinear_methods_are_below_implicit_laplacian_editing(name: str) -> None:
    linear = measured(case(name), implicit())
    for method in methods.METHODS:
        if method.family is methods.Family.SURFACE_NONLINEAR and method.control is methods.Control.HANDLES:
            assert measured(case(name), ours(method.id)).edge_rms < linear.edge_rms, method.id


@pytest.mark.parametrize("name", CASES)
def test_libigls_arap_enters_the_matrix(name: str) -> None:
    solve = libigl(60)
    if solve is None:
        pytest.skip("the package igl is not here")
    theirs, linear = measured(case(name), solve), measured(case(name), implicit())
    assert theirs.handle_error < 1e-9
    assert theirs.edge_rms < linear.edge_rms
