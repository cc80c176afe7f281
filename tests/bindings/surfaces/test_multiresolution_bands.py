# SPDX-License-Identifier: GPL-3.0-or-later
"""Rest and rigid motions with any number of bands, where smooth bases shrink to threads."""

import numpy as np
import pytest

import sinew_native as sn

from ..meshes import STILL, moved, sphere, turn

TURNED = turn((1, 2, 3), 70, (0.5, 0.0, 0.0), (0.1, 0.2, 0.3))
DETAILS = ("displacement_vectors", "normal_displacements", "displacement_volumes", "deformation_transfer")


def limbs() -> tuple[np.ndarray, np.ndarray]:
    """A ball with six limbs along the axes, each with a bump at its end."""
    points, faces = sphere(4)
    along = np.abs(points).max(axis=1)
    length = 0.3 + 4.0 * np.clip((along - 0.9) / 0.1, 0.0, 1.0) + 0.1 * (along > 0.99)
    return points * length[:, None], faces


POINTS, FACES = limbs()
HANDLES = [np.flatnonzero(POINTS[:, 0] > 3.0), np.flatnonzero(POINTS[:, 1] < -3.0)]


@pytest.mark.parametrize("bands", [1, 4, 8])
@pytest.mark.parametrize("details", DETAILS)
def test_rest_and_rigid_motions_are_kept_with_any_number_of_bands(details: str, bands: int) -> None:
    mesh = sn.SurfaceMesh(POINTS, FACES)
    method = sn.Multiresolution(mesh, sn.Arap(mesh), details=details, bands=bands)
    remarks = method.set_handles(HANDLES).remarks
    off = [
        np.linalg.norm(method.solve([pose, pose])[0] - moved(pose, POINTS), axis=1).max()
        for pose in (STILL, TURNED)
    ]
    used = len(method.levels()) - 1
    print(f"{details}: {used} of {bands} bands, rest off by {off[0]:.1e}, a rigid motion by {off[1]:.1e}")
    assert max(off) < 1e-6
    assert used == bands or bands > 1
    assert len(remarks) == (used < bands)
    assert all(text.startswith(f"only {used} of {bands} bands are used") for text in remarks)


@pytest.mark.parametrize("bands", [1, 4, 8])
@pytest.mark.parametrize("details", DETAILS)
def test_a_space_method_as_the_base_keeps_them_too(details: str, bands: int) -> None:
    places = POINTS[np.concatenate(HANDLES)]
    mesh = sn.SurfaceMesh(POINTS, FACES)
    method = sn.MultiresolutionSpace(places, sn.Rbf(places), mesh, details=details, bands=bands)
    method.bind(POINTS)
    for pose in (STILL, TURNED):
        off = np.linalg.norm(method.warp(moved(pose, places)) - moved(pose, POINTS), axis=1).max()
        assert off < 1e-6
