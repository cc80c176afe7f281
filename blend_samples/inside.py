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
    points, faces, parameters = posing.vertices(obj), obj.data.polygons, obj.sinew.active.parameters
    counts, corners = np.empty(len(faces), np.int32), np.empty(len(obj.data.loops), np.int32)
    faces.foreach_get("loop_total", counts)
    obj.data.loops.foreach_get("vertex_index", corners)
    groups = [obj.vertex_groups[handle.vertex_group].index for handle in obj.sinew.active.handles]
    held = [
        points[[v.index for v in obj.data.vertices if any(g.group == group for g in v.groups)]]
        for group in groups
    ]
    made = getattr(native(), method)(
        native().SurfaceMesh(points, (counts, corners)),
        np.concatenate(held),
        [len(own) for own in held],
        **{name: getattr(parameters, name) for name in names},
    )
    made.bind(points)
    return made
