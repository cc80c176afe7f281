# SPDX-License-Identifier: GPL-3.0-or-later
"""The frame of the stored rest shapes of a deformer, relative to the object space of its target.

Apply and Set Origin change the mesh and the frame of its object at once. The stored meshes then stay as they
are, since copies of the target share them and undo may keep them. A matrix in the settings takes them along.
"""

import numpy as np
from bpy.types import Mesh
from mathutils import Matrix

from ...core.errors import MeshError
from ...ids import Keys
from ...mesh_io import RestShape, read_rest
from ...properties import SinewDeformer
from . import own_shape
from .shapes import shapes

_UNKNOWN = "It is not known any more what Apply did to the rest shape - Unbind, then Bind"


def matrix(settings: SinewDeformer) -> np.ndarray:
    """From the stored rest shapes to the object space of the target, (4, 4)."""
    if not settings.has_applied:
        return np.eye(4)
    found = np.array(settings.applied, dtype=np.float64).reshape(4, 4, order="F")
    if not np.isfinite(found).all() or np.linalg.det(found) == 0.0:
        raise MeshError(_UNKNOWN)
    return found


def move(settings: SinewDeformer, by: np.ndarray) -> None:
    """Take the rest shapes along with an affine map ``by`` (4, 4) of the object space of the target."""
    found = by @ matrix(settings)
    settings.applied = found.ravel(order="F").tolist()
    settings.has_applied = not np.array_equal(found, np.eye(4))


def forget(deformer: SinewDeformer) -> None:
    """Call when the rest shapes are stored in the object space of the target again."""
    deformer.has_applied = False


def token(settings: SinewDeformer, rest: Mesh) -> str:
    """What tells a rest shape in its frame from any other."""
    found = rest.get(Keys.REST_TOKEN, "")
    return f"{found} {matrix(settings).tobytes().hex()}" if settings.has_applied else found


def read(settings: SinewDeformer, mesh: Mesh) -> RestShape:
    """The shape of a rest mesh of the target or of its control, in the object space of the target."""
    rest = read_rest(mesh)
    return rest.moved(matrix(settings), token(settings, mesh)) if settings.has_applied else rest


def put_back(settings: SinewDeformer, mesh: Mesh) -> None:
    """Take a mesh in the object space of the target to the frame in which the rest shapes are stored."""
    if settings.has_applied:
        transform(mesh, np.linalg.inv(matrix(settings)))


def transform(mesh: Mesh, by: np.ndarray) -> None:
    """Move a rest mesh by an affine map (4, 4). Its faces point to the same side after a reflection."""
    mesh.transform(Matrix(by.tolist()))
    own_shape.move(mesh, by)
    if np.linalg.det(by) < 0.0:
        mesh.flip_normals()


def absorb(deformer: SinewDeformer) -> None:
    """Store the rest shapes of controls in the object space of the target; its own must be stored next.

    Main thread only, as this makes datablocks.
    """
    if not deformer.has_applied:
        return
    try:
        frame = matrix(deformer)
    except MeshError:
        frame = np.eye(4)
    for row in (*deformer.all_controls, *deformer.handles):
        if row.rest is not None:
            mesh = row.rest.copy()
            transform(mesh, frame)
            mesh[Keys.REST_TOKEN] = shapes.new_key()
            row.rest = shapes.put_mesh(row.rest, mesh)
    forget(deformer)
