# SPDX-License-Identifier: GPL-3.0-or-later
"""Every method of the module, found by walking it, and how to make one."""

import inspect
import re

import numpy as np

import sinew_native as sn

from .meshes import ends, grid


def arguments(function: object) -> list[str]:
    """Of a signature in a docstring, without self and types: `points`, `*`, `weights = None`."""
    line = inspect.getdoc(function).splitlines()[0]
    inside = line[line.index("(") + 1 : line.rindex(")")]
    bare = re.sub(r"\[[^\[\]]*(?:\[[^\[\]]*\])*[^\[\]]*\]", "", inside)  # type[a, b] has commas of its own
    parts = [re.sub(r":[^=]*", " ", part).strip() for part in bare.split(",")]
    return [part for part in parts if part and part != "self"]


def required(method: type) -> list[str]:
    """What the constructor cannot do without."""
    return [word for word in arguments(method.__init__) if word.isidentifier()]


def methods_of(base: type) -> list[type]:
    """Those that can be made, not what they have in common, by name: a module holds them as it was linked."""
    classes = (value for value in vars(sn).values() if inspect.isclass(value) and issubclass(value, base))
    return sorted((each for each in classes if required(each)), key=lambda each: each.__name__)


SURFACE_METHODS = methods_of(sn.SurfaceMethod)
SPACE_METHODS = methods_of(sn.SpaceMethod)
CAGE_METHODS = methods_of(sn.CageCoordinates)


def control(method: type, mesh: sn.SurfaceMesh) -> np.ndarray:
    """The points of a control: those of the mesh, a frame of a tool, or corners of a lattice around it."""
    if method is sn.VectorField:
        return np.concatenate((np.zeros((1, 3)), np.eye(3)))
    if method is sn.Ffd:
        low, high = mesh.points.min(axis=0), mesh.points.max(axis=0)
        w, v, u = np.meshgrid(*3 * [(0.0, 1.0)], indexing="ij")
        return low + np.stack((u, v, w), axis=-1).reshape(-1, 3) * (high - low)
    return mesh.points


def made(method: type, mesh: sn.SurfaceMesh, **options: object):
    """A method on a mesh, or moved by its vertices, or around another one."""
    given = {"mesh": mesh, "cage": mesh, "points": control(method, mesh)}
    if "base" in required(method):
        given["base"] = sn.Rbf(mesh.points) if issubclass(method, sn.SpaceMethod) else sn.ThinShell(mesh)
    return method(**{word: given[word] for word in required(method)}, **options)


def bound_to(method, parts, *more: object, **words: object):
    """A surface method, now bound to these handles, or a space method to these points."""
    (method.set_handles if isinstance(method, sn.SurfaceMethod) else method.bind)(parts, *more, **words)
    return method


def bound(method: type, n: int = 8, **options: object):
    """A method on the hill, its two ends held: the object, the points and the handles."""
    points, faces = grid(n)
    surface = made(method, sn.SurfaceMesh(points, faces), **options)
    return bound_to(surface, ends(points)), points, ends(points)


# What a docstring says of a choice, and the options with which such a method works in another way.
CHOICES: dict[str, list[dict[str, object]]] = {
    "exact: bool": [{"exact": False}],
    "'lattice'": [{"solver": "lattice"}],
    "smoothness: ": [{"smoothness": 0.0}],
    "'rims'": [{"cells": "rims"}],
    "variation: ": [{"variation": 1.0, "stretching": 1.0}],
    "field: str": [{"field": "geodesic"}, {"field": "euclidean"}],
    "bands: ": [{"bands": 2}],
    "transforms: str": [{"transforms": name} for name in ("none", "explicit", "implicit")],
    "smooth: typing": [{"smooth": "levels"}],
    "threshold: ": [{"threshold": 1e-3, "precision": "double"}],
}


def choices(method: type) -> list[dict[str, object]]:
    text = inspect.getdoc(method.__init__)
    return [{}] + [each for says, options in CHOICES.items() if says in text for each in options]


def called(entry: type | dict[str, object]) -> str:
    """A name for the tests of a method or of its options."""
    return entry.__name__ if isinstance(entry, type) else ",".join(f"{k}={v}" for k, v in entry.items())


EVERY_SURFACE_METHOD = [(method, options) for method in SURFACE_METHODS for options in choices(method)]
EVERY_CAGE_METHOD = [(method, options) for method in CAGE_METHODS for options in choices(method)]


def inside(cage: np.ndarray, count: int = 40) -> np.ndarray:
    """Points around the middle of a convex cage."""
    middle = cage.mean(0)
    shares = np.random.default_rng(2).dirichlet(np.ones(len(cage)), count)
    return middle + 0.9 * (shares @ (cage - middle))
