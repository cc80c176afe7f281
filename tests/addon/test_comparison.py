# SPDX-License-Identifier: GPL-3.0-or-later
"""The comparison gallery: its measures, and the failures that the literature reports, in our own numbers.

Nothing here needs Blender. The figures stand in docs/methods/comparison.md.
"""

import json
import subprocess
import sys
from dataclasses import replace
from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from sinew.core import methods

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))


from blend_samples.comparison import (  # noqa: E402
    CASES,
    Case,
    Matrix,
    distortion,
    filled,
    igl_arap as libigl,
    native_solve,
    registry_rows,
)
from blend_samples.comparison.cases import bar, branches, cylinder, plane  # noqa: E402
from blend_samples.comparison.figures import bent_bumps  # noqa: E402
from blend_samples.comparison.numpy_rows import unrotated_gradients  # noqa: E402
from blend_samples.comparison.space_rows import space_rows  # noqa: E402

sn = pytest.importorskip("sinew_native")
pytestmark = pytest.mark.slow

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


def test_every_method_that_regions_steer_has_a_row() -> None:
    rows = [name for name, _solve in registry_rows(methods, sn)]
    steered = [m for m in methods.METHODS if m.control is methods.Control.HANDLES]
    wanted = [m for m in steered if not m.keyed]
    assert all(any(row.split(":")[0] == method.known_as for row in rows) for method in wanted)
    assert sum(row.startswith("Multiresolution: ") for row in rows) == 4
    assert len(rows) == len(set(rows))


def test_wires_and_tools_do_what_they_can_say() -> None:
    """A wire bends and does not twist; a tool twists exactly, keeps volumes, and meets no translation."""
    cases = [(name, CASES[name]()) for name in ("cylinder", "bar")]
    cells = filled(cases, space_rows(methods, sn), refusals=(sn.Error,)).cells
    twisted = dict(cases)["bar"]
    assert cells["Vector Fields", "bar"].distortion.handle_error < 1e-6
    assert abs(cells["Vector Fields", "bar"].distortion.volume - 1.0) < 0.01
    assert abs(cells["Vector Fields", "cylinder"].distortion.volume - 1.0) < 0.01
    assert np.abs(cells["Wires", "bar"].shape - twisted.points).max() < 0.1, "a twist is lost on a wire"
    assert cells["Wires", "cylinder"].distortion.handle_error < 0.3


@pytest.mark.parametrize(
    ("name", "solve"), list(registry_rows(methods, sn)), ids=lambda value: str(value)[:40]
)
def test_every_row_puts_the_handles_where_they_belong(name: str, solve) -> None:
    found = filled([("bar", bar(4))], [(name, solve)], refusals=(sn.Error,)).cells[name, "bar"]
    if found.distortion is None:
        pytest.skip(found.refusal)
    # Space methods keep weights in single precision, and Rbf meets handles to a tolerance of their moves. A
    # lattice knows no handles: how near it comes, the figures say.
    controls = {m.known_as: m.control for m in methods.METHODS if m.is_space}
    control = controls.get(name.split(":")[0])
    allowed = 1e-9 if control is None else 0.1 if control is methods.Control.LATTICE else 1e-3
    assert found.distortion.handle_error < allowed


def test_gradient_editing_ignores_translation() -> None:
    """A handle that only moves turns no gradient, so the answer is the one of unrotated gradients."""
    edit = plane(40)
    found = ours("gradient_editing")(edit)
    assert np.abs(found - unrotated_gradients(edit)).max() < 1e-9
    blind, aware = measured(edit, ours("gradient_editing")), measured(edit, implicit())
    assert blind.edge_least < 0.9 < 0.95 < aware.edge_least
    assert blind.angle_mean > 1.4 * aware.angle_mean


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


def test_implicit_transforms_let_what_hangs_free_turn() -> None:
    """At a small turn of the crown, where they are nearly exact."""
    edit = branches(0.13)
    still, pose = edit.poses
    centre = edit.points[edit.handles[1]].mean(0)
    angle = np.radians(9.0)
    linear = np.array(((np.cos(angle), 0, np.sin(angle)), (0, 1, 0), (-np.sin(angle), 0, np.cos(angle))))
    move = 0.125 * (pose[:, :3] @ centre + pose[:, 3] - centre)
    edit = replace(edit, poses=np.stack((still, np.column_stack((linear, centre + move - linear @ centre)))))
    right = edit.points[:, 0] > 1.1
    arm = edit.points[right] - edit.points[right].mean(0)

    def turn(solve) -> float:
        found = solve(edit)[right]
        u, _sizes, v = np.linalg.svd(arm.T @ (found - found.mean(0)))
        return float(np.degrees(np.arccos(min(0.5 * (np.trace(u @ v) - 1.0), 1.0))))

    assert turn(implicit()) > 4.0 * turn(ours("arap"))


@pytest.mark.parametrize(("bumps", "first"), [(0.09, 133), (0.12, 82), (0.12, 122)])
def test_volumes_follow_a_bend_without_jumps(bumps: float, first: int) -> None:
    """Degree by degree they move as vectors do, but for a tenth of an edge, also where bumps meet."""

    def moves(details: str) -> np.ndarray:
        solve = ours("multiresolution", details=details, wavelength=20.0)
        return np.diff([solve(bent_bumps(bumps, float(first + k))) for k in range(8)], axis=0)

    edit = bent_bumps(bumps)
    edge = np.linalg.norm(edit.points[edit.triangles[0, 0]] - edit.points[edit.triangles[0, 1]])
    assert np.abs(moves("displacement_volumes") - moves("displacement_vectors")).max() < 0.1 * edge


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
            # The default cage of 82 vertices is made for speed; it is above on the plane and the bar.
            finer = {"cage_faces": 400} if method.id == "subspace_laplacian" else {}
            assert measured(case(name), ours(method.id, **finer)).edge_rms < linear.edge_rms, method.id


@pytest.mark.parametrize("name", CASES)
def test_libigls_arap_enters_the_matrix(name: str) -> None:
    solve = libigl(60)
    if solve is None:
        pytest.skip("the package igl is not here")
    theirs, linear = measured(case(name), solve), measured(case(name), implicit())
    assert theirs.handle_error < 1e-9
    assert theirs.edge_rms < linear.edge_rms
