# SPDX-License-Identifier: GPL-3.0-or-later
"""A bake, frame by frame, so that Blender can redraw in between. The scene is not changed until ``finish``.

A bake keeps names and arrays only, no Blender data. ``cancel`` leaves the disk and the scene as they were.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

import bpy
import numpy as np
from bpy.types import Depsgraph, Object, Scene

from ..core import status
from ..core.errors import SinewError
from ..core.status import Level
from ..properties import SinewDeformer
from ..session.actions import housekeeping, refresh
from ..session.datablocks.shapes import baked
from ..session.evaluation import binding, evaluate
from ..session.state import sessions
from ..session.targets import modified, targets
from . import cache, paths, record, sequences, shape_keys
from .files import CacheFile
from .reader import ShapeReader, changes_count, labels


@dataclass(frozen=True)
class Request:
    """What to bake. ``deformers`` holds the name of an object and the key of a deformer each.

    ``filepath`` is the path that the user chose, or empty.
    """

    deformers: tuple[tuple[str, str], ...]
    target: str
    frames: range
    filepath: str = ""
    exact_keys: bool = True

    def __post_init__(self) -> None:
        if not len(self.frames):
            raise SinewError("The range of frames is empty - set End to the same frame as Start, or later")
        if self.filepath and len(self.deformers) > 1:
            raise SinewError(
                "One file cannot hold several deformers - bake them one by one, or leave Path empty"
            )


@dataclass
class Part:
    """The bake of one deformer.

    ``made`` is the name of a modifier that the bake added, ``points`` the number of vertices, and ``shapes``
    for shape keys the shapes before and after the deformer, float32 (n, 3), one pair per frame.
    """

    reader: ShapeReader
    filepath: str = ""
    file: CacheFile | None = None
    made: str = ""
    points: int = -1
    shapes: list[tuple[np.ndarray, np.ndarray]] = field(default_factory=list)


class Baking:
    """A bake. Call ``step`` while it returns True, then ``finish``. Call ``cancel`` instead at any time."""

    def __init__(self, request: Request, scene: Scene) -> None:
        self.request = request
        self.done = 0
        self._scene = scene.name
        self._frame = scene.frame_current, scene.frame_subframe
        self._parts = [Part(ShapeReader(obj, uid)) for obj, uid in request.deformers]
        self._opened = False
        self._over = False
        refresh.bind_renders()
        for part in self._parts:
            self._check(part, scene)
        try:
            self._open()
        except SinewError:
            self.cancel()
            raise

    @property
    def total(self) -> int:
        """The number of frames to bake."""
        return len(self.request.frames)

    def step(self) -> bool:
        """Bake one frame; True while there are more.

        While a thread still solves, the frame is tried again.
        """
        frame = self.request.frames[self.done]
        scene = bpy.data.scenes[self._scene]
        if (scene.frame_current, scene.frame_subframe) != (frame, 0.0) or self.done == 0:
            scene.frame_set(frame)  # solves to the end, unlike an edit in a window
        depsgraph = bpy.context.evaluated_depsgraph_get()
        if self._is_waiting():
            return True
        for part in self._parts:
            with _naming_frame(frame):
                self._take(part, depsgraph)
        self.done += 1
        return self.done < self.total

    def finish(self) -> list[str]:
        """Show the baked shapes instead of the deformers. Returns warnings for the user."""
        warnings = []
        self._close_readers()
        with sessions.suspended():
            for part in self._parts:
                self._complete(part)
            for part in self._parts:
                if part.file is not None:
                    part.file.commit()
                    part.file = None
            self._over = True
            for part in self._parts:
                warnings += self._show(part)
        self._restore_frame()
        return warnings

    def _complete(self, part: Part) -> None:
        """Do everything that may fail: write the last bytes, and add the modifier to the stack."""
        if part.file is None:
            return
        part.file.close()
        obj, deformer = part.reader.owner(), part.reader.deformer()
        if baked.find_cache(obj, deformer) is None:
            part.made = cache.insert(obj, deformer)

    def _show(self, part: Part) -> list[str]:
        """Show the baked shapes instead of the deformer. Returns warnings."""
        request, obj, deformer = self.request, part.reader.owner(), part.reader.deformer()
        scene, frames = bpy.data.scenes[self._scene], request.frames
        warnings = [*_differences(part.reader), *sequences.missing_frames(scene, obj, deformer, frames)]
        if request.target == "SHAPE_KEYS":
            warnings += record.remove(obj, deformer)
            shape_keys.install(scene, obj, deformer, frames, part.shapes, request.exact_keys)
        else:
            playing = obj.modifiers[part.made] if part.made else baked.find_cache(obj, deformer)
            warnings += record.remove_keys(obj, deformer)
            timed = cache.timing(scene, frames)
            cache.play(obj, deformer, playing, request.target, part.filepath, timed)
        record.mark_baked(obj, deformer, request.target, frames, part.filepath)
        return warnings

    def cancel(self) -> None:
        """Undo everything that was done so far. After ``finish`` this does nothing."""
        if self._over:
            return
        self._over = True
        for part in self._parts:
            if part.file is not None:
                part.file.discard()
        self._close_readers()
        with sessions.suspended():
            for part in self._parts if self._opened else ():
                obj = part.reader.owner()
                if part.made:
                    obj.modifiers.remove(obj.modifiers[part.made])
                record.resume(obj, part.reader.deformer())
        self._restore_frame()

    def _check(self, part: Part, scene: Scene) -> None:
        """Raise an error if this deformer cannot be baked, before anything is changed."""
        obj, deformer = part.reader.owner(), part.reader.deformer()
        targets.require_mesh(obj, "Shape keys, PC2 and MDD hold")
        if not deformer.is_bound:
            raise SinewError(f"{deformer.name} is not bound - press Bind first")
        modifier = part.reader.modifier()
        shown = deformer.bake.show_viewport if deformer.bake.is_baked else modifier.show_viewport
        if not shown:
            raise SinewError(f"The modifier {modifier.name} is off in the viewport - switch it on to bake it")
        if not obj.visible_get():
            raise SinewError(f"{obj.name} is hidden - show the object and its collection to bake it")
        if deformer.bake.result == "SHAPE_KEYS":
            shape_keys.require_own_mesh(obj)
        if self.request.target == "SHAPE_KEYS":
            self._check_keys(part.reader, obj, deformer, scene)
        else:
            if deformer.renders_differ:
                raise SinewError(
                    f"Modifiers before {deformer.name} give another number of vertices in renders than in "
                    "the viewport, and a cache holds one number only - use the same Subdivision levels and "
                    "the same visibility in both"
                )
            part.filepath = self._place(part, scene)

    def _place(self, part: Part, scene: Scene) -> str:
        """The path of the file of this deformer, which a modifier can play."""
        cache.timing(scene, self.request.frames)
        taken = [other.filepath for other in self._parts if other is not part]
        obj, deformer = part.reader.owner(), part.reader.deformer()
        return paths.choose(obj, deformer, self.request.target, self.request.filepath, taken)

    def _make_file(self, part: Part, rate: float) -> CacheFile:
        """The file of this deformer, which is empty yet. ``rate`` is the number of frames per second."""
        return CacheFile(paths.absolute(part.filepath), self.request.target, self.request.frames, rate)

    def _read(self, part: Part, depsgraph: Depsgraph) -> np.ndarray:
        """The positions after the deformer in this frame, float32 (n, 3)."""
        return part.reader.positions(depsgraph)

    def _check_keys(self, reader: ShapeReader, obj: Object, deformer: SinewDeformer, scene: Scene) -> None:
        """Blender adds shape keys before all modifiers, so no other modifier may come before the deformer."""
        shape_keys.require_keys(obj)
        shape_keys.require_room(scene, self.request.frames)
        here = {uid for name, uid in self.request.deformers if name == obj.name}
        ours = [other for other in obj.sinew.deformers if other.uid in here or other.bake.is_baked]
        replaced = {modified.shown_by(obj, other) for other in ours}
        earlier = [other for other in reader.earlier() if other not in replaced]
        if changes_count(obj, deformer):
            raise SinewError(
                f"{deformer.name} moves vertices that {labels(earlier) or 'earlier modifiers'} made, but "
                "shape keys hold the vertices of the mesh - apply these modifiers first, or bake to PC2"
            )
        if earlier:
            raise SinewError(
                f"{labels(earlier)} comes before {deformer.name}, but Blender adds shape keys before all "
                "modifiers - move the deformer up, or bake to PC2"
            )

    def _open(self) -> None:
        """Make deformers live that are baked already, and prepare to read their shapes and to write files."""
        scene = bpy.data.scenes[self._scene]
        self._opened = True
        with sessions.suspended():
            for part in self._parts:
                record.suspend(part.reader.owner(), part.reader.deformer())
        for part in self._parts:
            part.reader.open()
            if self.request.target != "SHAPE_KEYS":
                part.file = self._make_file(part, scene.render.fps / scene.render.fps_base)

    def _is_waiting(self) -> bool:
        """Whether a thread binds or solves, which happens only with a window."""
        uids = [part.reader.uid for part in self._parts]
        housekeeping.collect()
        is_waiting = any(uid in sessions.unsettled() or _has_thread(uid) for uid in uids)
        if is_waiting:
            evaluate.settle()
            for part in self._parts:
                part.reader.owner().update_tag(refresh={"OBJECT"})
            bpy.context.view_layer.update()
        return is_waiting

    def _take(self, part: Part, depsgraph: Depsgraph) -> None:
        deformer = part.reader.deformer()
        if deformer.status_level == Level.ERROR.value:
            remedy = status.current(deformer.uid).remedy
            raise SinewError(f"{deformer.name}: {deformer.status}", remedy=remedy)
        left = self._read(part, depsgraph)
        if part.points < 0:
            part.points = len(left)
        if len(left) != part.points:
            raise SinewError(
                f"{deformer.name} has {len(left)} vertices, but {part.points} in the first frame - let the "
                "modifiers before it give the same number in each frame"
            )
        if not np.isfinite(left).all():
            raise SinewError(
                f"{deformer.name} has invalid positions (NaN or infinite) - check the modifiers before it"
            )
        if part.file is not None:
            part.file.append(left)
        else:
            part.shapes.append((part.reader.incoming(depsgraph), left))

    def _close_readers(self) -> None:
        for part in self._parts:
            part.reader.close()

    def _restore_frame(self) -> None:
        frame, subframe = self._frame
        scene = bpy.data.scenes.get(self._scene)
        if scene is not None:
            scene.frame_set(frame, subframe=subframe)
        bpy.context.view_layer.update()


def _has_thread(uid: str) -> bool:
    """Whether a thread binds or solves this deformer."""
    known = sessions.find(uid)
    return binding.job(uid) is not None or (known is not None and known.work is not None)


@contextmanager
def _naming_frame(frame: int) -> Iterator[None]:
    """Add the frame to the message of an error."""
    try:
        yield
    except SinewError as error:
        raise error.with_elements(error.elements, error.remedy, f"Frame {frame}: {error}") from error


def _differences(reader: ShapeReader) -> list[str]:
    """A warning if modifiers before the deformer are shown in the viewport or in renders alone."""
    differing = [other for other in reader.earlier() if other.show_viewport != other.show_render]
    if not differing:
        return []
    return [
        f"{labels(differing)} differs between viewport and render: the bake has the shape of the viewport"
    ]
