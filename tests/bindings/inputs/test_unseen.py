# SPDX-License-Identifier: GPL-3.0-or-later
"""What nobody sees does not change a shape: loose vertices, how a mesh lies in the world, its unit of length,
the order of its vertices and faces, a single flipped face, a part far away.
"""

import inspect

import numpy as np
import pytest

import sinew_native as sn

from ..meshes import STILL, moved, off, sphere, turn
from ..methods import EVERY_SURFACE_METHOD, SPACE_METHODS, bound_to, called, made, required

TURN = turn((1, 2, 0.5), 37)[:, :3]
CHANGES = ("loose", "turned", "renumbered", "flipped", "smaller", "larger", "apart")
CLOSE = 1e-4  # of the size, but with a part far away: the starts of some are clusters of all parts together
# Whose stiffnesses of different orders have units, so that a scaled mesh is another one.
OF_UNITS = "variation"
# Their grid lies along the axes. With mirrors, faces end exactly at borders of cells, where rounding decides.
ALONG_AXES = ("RigidCells",)
# Numbers decide between vertices that mirrors make equal, so that the axes decide nothing.
BY_NUMBERS = "EmbeddedDeformation HierarchicalSmoothing SubspaceLaplacian VolumetricGraphLaplacian"
# Their means over the mesh (its area, its mean edge) hold for all parts together; cells are shared by them.
OF_ALL_PARTS = ("Arap", "MeshPuppetry", "MeshSequence", "Multiresolution", "MultiresolutionSpace")
SHARED_BY_PARTS = ("EmbeddedDeformation", "RigidCells", "InverseFfd")


def body(irregular: bool) -> tuple[np.ndarray, np.ndarray]:
    """An egg, whose two mirrors tie most of what can, or a creature without any."""
    points, faces = sphere(3)
    x, y, z = points.T
    if irregular:
        bumps = 0.3 * np.exp(-4 * ((x - 0.8) ** 2 + (y - 0.2) ** 2 + (z - 0.5) ** 2))
        bumps += 0.15 * np.sin(4 * z + x)
        points = points * (1 + 0.25 * np.sin(2.3 * x + 0.4) * np.cos(3.1 * y + 0.2) + bumps)[:, None]
    return points * (1.6, 0.7, 1.0), faces


class Changed:
    """A mesh with the shape of another; ``of`` (n,) are the vertices of that, in ``frame`` * ``scale``."""

    def __init__(self, points: np.ndarray, faces: np.ndarray, change: str = "") -> None:
        n, (ball, ball_faces) = len(points), sphere(1)
        self.of, self.frame = np.arange(n), TURN if change == "turned" else np.eye(3)
        self.scale = {"smaller": 1e-3, "larger": 1e3}.get(change, 1.0)
        if change == "renumbered":
            random = np.random.default_rng(5)
            order = random.permutation(n)
            self.of = np.argsort(order)
            points, faces = points[order], self.of[faces][random.permutation(len(faces))]
            faces = np.array([np.roll(face, random.integers(3)) for face in faces])
        if change == "flipped":
            faces = faces.copy()
            faces[len(faces) // 3] = faces[len(faces) // 3][::-1]
        if change == "loose":
            points = np.concatenate((points, [(9.0, 3.0, -5.0)]))
        if change == "apart":
            points = np.concatenate((points, (12.0, 3.0, -5.0) + 0.6 * ball))
            faces = np.concatenate((faces, ball_faces + n))
        self.points, self.faces = self.scale * points @ self.frame.T, faces

    def pose(self, pose: np.ndarray) -> np.ndarray:
        turned = self.frame @ pose[:, :3] @ self.frame.T
        return np.column_stack((turned, self.scale * self.frame @ pose[:, 3]))

    def seen(self, points: np.ndarray) -> np.ndarray:
        return (points[self.of] / self.scale) @ self.frame


def solved(method: type, options: dict, rest: np.ndarray, mesh: Changed) -> np.ndarray:
    """The shape as it is seen from the first mesh, one end held and the other turned and moved."""
    x = rest[:, 0]
    handles = [mesh.of[x < x.min() + 0.3], mesh.of[x > x.max() - 0.3]]
    turned = turn((0.2, 1, 0.3), 40, (0.1, 0, 0), (0.2, 0.3, -0.3))
    poses = np.stack([mesh.pose(pose) for pose in (STILL, turned)])
    surface = sn.SurfaceMesh(mesh.points, mesh.faces)
    if issubclass(method, sn.SurfaceMethod):
        deformer = bound_to(made(method, surface, **options), handles)
        return mesh.seen(deformer.solve(poses)[0])
    points, counts = mesh.points[np.concatenate(handles)], [len(handle) for handle in handles]
    given = {"mesh": surface, "points": points, "counts": counts, **options}
    if method is sn.InverseFfd:
        given["frame"] = surface
    if "base" in required(method):
        given["base"] = sn.Rbf(points, counts)
    known = inspect.getdoc(method.__init__).splitlines()[0]
    deformer = method(**{word: value for word, value in given.items() if f"{word}: " in known})
    deformer.bind(mesh.points)
    if hasattr(deformer, "warp_poses"):
        return mesh.seen(deformer.warp_poses(poses))
    control = deformer.control if hasattr(deformer, "control") else points
    split = np.split(control, [len(control) // 2 if len(control) == 8 else counts[0]])
    return mesh.seen(deformer.warp(np.concatenate([moved(pose, part) for pose, part in zip(poses, split)])))


BY_HANDLES = [
    (method, {})
    for method in SPACE_METHODS
    if not issubclass(method, sn.CageCoordinates) and method not in (sn.Ffd, sn.VectorField, sn.Wires)
]
FEW_NODES = (sn.EmbeddedDeformation, {"nodes": 60})  # by default, each vertex of such small meshes is one
EVERY = [*EVERY_SURFACE_METHOD, *BY_HANDLES, (sn.Rbf, {"kernel": "wendland_c2"}), FEW_NODES]


@pytest.mark.slow
@pytest.mark.parametrize(("method", "options"), EVERY, ids=called)
@pytest.mark.parametrize("irregular", [True, False])
def test_what_nobody_sees_changes_nothing(method: type, options: dict, irregular: bool) -> None:
    points, faces = body(irregular)
    shape = solved(method, options, points, Changed(points, faces))
    size = np.linalg.norm(np.ptp(points, axis=0))
    far = {}
    differs = {
        "smaller": OF_UNITS in options,
        "larger": OF_UNITS in options,
        "turned": method.__name__ in ALONG_AXES,
        "renumbered": method.__name__ in BY_NUMBERS and not irregular,
        "apart": method.__name__ in (*OF_ALL_PARTS, *SHARED_BY_PARTS),
    }
    for change in CHANGES:
        if differs.get(change) or (method.__name__ in ALONG_AXES and not irregular):
            continue
        found = solved(method, options, points, Changed(points, faces, change))
        if not (most := off(found, shape) / size) < (1e-3 if change == "apart" else CLOSE):
            far[change] = f"{most:.0e}"
    assert far == {}


@pytest.mark.slow
@pytest.mark.parametrize("irregular", [True, False])
def test_an_automatic_cage_is_the_same(irregular: bool) -> None:
    points, faces = body(irregular)
    cages = {
        change: sn.automatic_cage(sn.SurfaceMesh(mesh.points, mesh.faces), 100, 0.06)[0] / mesh.scale
        for change in ("", "loose", "renumbered", "flipped", "smaller", "larger")
        for mesh in [Changed(points, faces, change)]
    }
    for by in (1e-9, 1e-12):
        cages[f"moved by {by}"] = sn.automatic_cage(sn.SurfaceMesh(points + by, faces), 100, 0.06)[0]
    expected = cages.pop("")
    for change, cage in cages.items():
        assert cage.shape == expected.shape, change
        np.testing.assert_allclose(cage, expected, atol=CLOSE, err_msg=change)
