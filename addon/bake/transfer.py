# SPDX-License-Identifier: GPL-3.0-or-later
"""Carries the animation of one mesh over to another with the same faces, as a cache that a modifier plays.

Both meshes rest as they are in Edit Mode, without shape keys and modifiers. A transfer keeps names and arrays
only, no Blender data, and ``cancel`` leaves the disk and the scene as they were.
"""

from collections.abc import Callable

import bpy
import numpy as np
from bpy.types import Modifier, Object, Scene

from .. import backend
from ..compat import move_modifier, read_positions
from ..core.errors import MeshError, SinewError
from ..core.geometry.frames import turned_faces
from ..mesh_io import read_rest
from ..session.targets import targets
from . import cache, paths
from .files import CacheFile

TARGET = "PC2"


class Transferring:
    """A transfer. Call ``step`` while it returns True, then ``finish``, or ``cancel`` at any time."""

    def __init__(self, source: Object, target: Object, scene: Scene, frames: range, chosen: str) -> None:
        if not len(frames):
            raise SinewError("The range of frames is empty - set End to the same frame as Start, or later")
        self.done = 0
        self.total = len(frames)
        self._names = source.name, target.name
        self._scene = scene.name
        self._frames = frames
        self._frame = scene.frame_current, scene.frame_subframe
        self._over = False
        _check(source, target)
        self._timed = cache.timing(scene, frames)
        self._path = paths.choose_for_transfer(source, target, chosen)
        self._transfer = _prepared(source, target)
        rate = scene.render.fps / scene.render.fps_base
        self._file = CacheFile(paths.absolute(self._path), TARGET, frames, rate)

    def step(self) -> bool:
        """Transfer one frame; True while there are more."""
        scene = bpy.data.scenes[self._scene]
        scene.frame_set(self._frames[self.done])
        source, target = self._objects()
        shown = source.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
        points = read_positions(shown)
        if len(points) != len(target.data.vertices):
            raise SinewError(
                f"The modifiers of {source.name} make {len(points):,} vertices of its "
                f"{len(source.data.vertices):,} - switch those off that add or remove vertices"
            )
        self._file.append(self._transfer(points.astype(np.float64)).astype(np.float32))
        self.done += 1
        return self.done < self.total

    def finish(self) -> list[str]:
        """Let a modifier of the target play the file. Returns no warnings."""
        source, target = self._objects()
        self._file.close()
        modifier = _modifier(source, target)
        self._file.commit()
        self._over = True
        cache.play_file(modifier, TARGET, self._path, self._timed)
        self._restore_frame()
        return []

    def cancel(self) -> None:
        """Undo everything that was done so far. After ``finish`` this does nothing."""
        if not self._over:
            self._over = True
            self._file.discard()
            self._restore_frame()

    def _objects(self) -> tuple[Object, Object]:
        found = [bpy.data.objects.get((name, None)) for name in self._names]
        for name, obj in zip(self._names, found, strict=True):
            if obj is None:
                raise SinewError(f"{name} was removed or renamed during the transfer - transfer again")
        return found[0], found[1]

    def _restore_frame(self) -> None:
        frame, subframe = self._frame
        scene = bpy.data.scenes.get(self._scene)
        if scene is not None:
            scene.frame_set(frame, subframe=subframe)


def _check(source: Object, target: Object) -> None:
    """Raise an error that says what to do if the target cannot play a cache, or the source cannot be read."""
    for obj in (source, target):
        if not targets.is_mesh(obj):
            raise SinewError(f"{obj.name} is a {targets.label(obj)} object - convert it to a mesh")
    if source == target:
        raise SinewError(f"{source.name} cannot take its own deformation - select another mesh, too")
    if not source.visible_get():
        raise SinewError(f"{source.name} is hidden - show the object and its collection")


def _prepared(source: Object, target: Object) -> Callable[[np.ndarray], np.ndarray]:
    """The native transfer between the meshes as they rest. Faces that are only turned are the same ones."""
    rests = [read_rest(obj.data) for obj in (source, target)]
    faces = [(rest.counts, rest.corners) for rest in rests]
    if turned_faces(*faces) is not None:
        faces[1] = faces[0]
    try:
        return backend.mesh_transfer(*map(backend.Shape, (rest.points for rest in rests), faces))
    except MeshError as error:
        raise SinewError(
            f"{source.name} and {target.name} do not have the same faces: {error} - the target has to be a "
            "copy of the source that was only reshaped"
        ) from error


def _modifier(source: Object, target: Object) -> Modifier:
    """The modifier that plays the last transfer from this source, or a new one before all others."""
    name = f"{source.name} Transfer"
    modifier = target.modifiers.get(name)
    if modifier is None or modifier.type != "MESH_CACHE":
        modifier = target.modifiers.new(name, "MESH_CACHE")
        if not move_modifier(target, modifier.name, 0):
            target.modifiers.remove(modifier)
            raise SinewError(
                f"Blender allows no Mesh Cache modifier at the top of {target.name} - move its modifiers"
            )
    return modifier
