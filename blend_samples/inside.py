# SPDX-License-Identifier: GPL-3.0-or-later
"""The compiled module and the registry of the add-on that is installed, for what no operator tells."""

import importlib
from collections.abc import Iterable
from types import ModuleType

import bpy
import numpy as np

from . import posing


def registry() -> ModuleType:
    """The method registry."""
    return importlib.import_module("sinew.core.methods")


def native() -> ModuleType:
    """The compiled module."""
    found = importlib.import_module("sinew.backend").availability()
    if found.module is None:
        raise posing.SampleError(found.remedy)
    return found.module


def bound(obj: bpy.types.Object, method: str, names: Iterable[str]) -> object:
    """A method of handle points, built from a posed object's handles and its parameters of these names."""
    points, parameters = posing.vertices(obj), obj.sinew.active.parameters
    faces = [list(face.vertices) for face in obj.data.polygons]
    groups = [obj.vertex_groups[handle.vertex_group].index for handle in obj.sinew.active.handles]
    rows = [(vertex.index, row.group) for vertex in obj.data.vertices for row in vertex.groups]
    held = [points[[vertex for vertex, of in rows if of == group]] for group in groups]
    made = getattr(native(), method)(
        native().SurfaceMesh(points, faces),
        np.concatenate(held),
        [len(own) for own in held],
        **{name: getattr(parameters, name) for name in names},
    )
    made.bind(points)
    return made
