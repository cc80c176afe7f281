# SPDX-License-Identifier: GPL-3.0-or-later
"""A bake, frame by frame, so that a window can draw in between. Nothing is changed until ``finish``.

It holds names and arrays only; ``cancel`` leaves file system and scene as they were.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

import bpy
import numpy as np
from bpy.types import Depsgraph, Object, Scene

from .. import session
from ..core.errors import SinewError
from ..core.status import Level
from ..properties import SinewDeformer
from . import cache, paths, record, shape_keys
from .files import CacheFile
from .stage import Stage, changes_count, labels


@dataclass(frozen=True)
class Request:
    """What to bake. ``deformers``: names of objects, keys of deformers; ``filepath`` is the user's choice."""

    deformers: tuple[tuple[str, str], ...]
    target: str
    frames: range
    filepath: str = ""
    exact_keys: bool = True

    def __post_init__(self) -> None:
        if not len(self.frames):
            raise SinewError("The range of frames is empty - let it end after it starts")
        if self.filepath and len(self.deformers) > 1:
            raise SinewError(
                "One path cannot serve several deformers - bake them one by one, or choose no path"
            )


@dataclass
class _Part:
    """One deformer. ``made`` is a modifier that was not there before, ``points`` the vertices of a frame.

    ``shapes``: what entered and what left the deformer, float32 (n, 3), a frame each, for shape keys.
    """

    stage: Stage
    filepath: str = ""
    file: CacheFile | None = None
    made: str = ""
    points: int = -1
    shapes: list[tuple[np.ndarray, np.ndarray]] = field(default_factory=list)


class Baking:
    """``step`` until it says so, then ``finish``; ``cancel`` at any time instead."""

    def __init__(self, request: Request, scene: Scene) -> None:
        self.request = request
        self.done = 0
        self._scene = scene.name
        self._frame = scene.frame_current, scene.frame_subframe
        self._parts = [_Part(Stage(obj, uid)) for obj, uid in request.deformers]
        self._opened = False
        self._over = False
        for part in self._parts:
            self._refuse(part)
        try:
            self._open()
        except SinewError:
            self.cancel()
            raise

    @property
    def total(self) -> int:
        """How many frames there are."""
        return len(self.request.frames)

    def step(self) -> bool:
        """Take one frame; True while there are more. Where a thread still solves, it is tried again."""
        frame = self.request.frames[self.done]
        scene = bpy.data.scenes[self._scene]
        if (scene.frame_current, scene.frame_subframe) != (frame, 0.0) or self.done == 0:
            scene.frame_set(frame)  # solves to the end, unlike an edit in a window
        depsgraph = bpy.context.evaluated_depsgraph_get()
        if self._waits():
            return True
        for part in self._parts:
            with _naming_frame(frame):
                self._take(part, depsgraph)
        self.done += 1
        return self.done < self.total

    def finish(self) -> list[str]:
        """Show the baked shapes in the place of the deformers; what the user should know about it."""
        said = []
        self._close_stages()
        with session.suspended():
            for part in self._parts:
                self._put_down(part)
            for part in self._parts:
                if part.file is not None:
                    part.file.commit()
                    part.file = None
            self._over = True
            for part in self._parts:
                said += self._show(part)
        self._restore_frame()
        return said

    def _put_down(self, part: _Part) -> None:
        """Everything that may be refused: the last bytes, and the modifier's place in the stack."""
        if part.file is None:
            return
        part.file.close()
        obj, deformer = part.stage.owner(), part.stage.deformer()
        if session.find_cache(obj, deformer) is None:
            part.made = cache.insert(obj, deformer)

    def _show(self, part: _Part) -> list[str]:
        """Put the baked shapes in the place of the deformer."""
        request, obj, deformer = self.request, part.stage.owner(), part.stage.deformer()
        said = _differences(part.stage)
        if request.target == "SHAPE_KEYS":
            said += record.remove(obj, deformer)
            shape_keys.install(obj, deformer, request.frames, part.shapes, request.exact_keys)
        else:
            playing = obj.modifiers[part.made] if part.made else session.find_cache(obj, deformer)
            said += record.remove_keys(obj, deformer)
            cache.play(obj, deformer, playing, request.target, part.filepath, request.frames)
        record.note(obj, deformer, request.target, request.frames, part.filepath)
        return said

    def cancel(self) -> None:
        """Leave everything as it was. After ``finish`` it does nothing."""
        if self._over:
            return
        self._over = True
        for part in self._parts:
            if part.file is not None:
                part.file.discard()
        self._close_stages()
        with session.suspended():
            for part in self._parts if self._opened else ():
                obj = part.stage.owner()
                if part.made:
                    obj.modifiers.remove(obj.modifiers[part.made])
                record.resume(obj, part.stage.deformer())
        self._restore_frame()

    def _refuse(self, part: _Part) -> None:
        """Why this deformer cannot be baked, before anything is touched."""
        obj, deformer = part.stage.owner(), part.stage.deformer()
        session.require_mesh(obj, "Shape keys, PC2 and MDD hold")
        if not deformer.is_bound:
            raise SinewError(f"{deformer.name} is not bound - press Bind first")
        modifier = part.stage.modifier()
        shown = deformer.bake.show_viewport if deformer.bake.is_baked else modifier.show_viewport
        if not shown:
            raise SinewError(f"The modifier {modifier.name} is off in the viewport - switch it on to bake it")
        if not obj.visible_get():
            raise SinewError(f"{obj.name} is hidden - show the object and its collection to bake it")
        if deformer.bake.result == "SHAPE_KEYS":
            shape_keys.refuse_shared(obj)
        if self.request.target == "SHAPE_KEYS":
            shape_keys.refuse(obj)
            self._refuse_keys(part.stage, obj, deformer)
        else:
            if deformer.renders_differ:
                raise SinewError(
                    f"Modifiers before {deformer.name} give other vertices in renders, and a cache holds "
                    "one number of them - let viewport and render agree (Subdivision levels, visibility)"
                )
            cache.timing(self.request.frames)
            part.filepath = paths.choose(obj, deformer, self.request.target, self.request.filepath)

    def _refuse_keys(self, stage: Stage, obj: Object, deformer: SinewDeformer) -> None:
        """Shape keys come before all modifiers, so the deformer has to come first among them."""
        here = {uid for name, uid in self.request.deformers if name == obj.name}
        ours = [other for other in obj.sinew.deformers if other.uid in here or other.bake.is_baked]
        replaced = {session.find_modifier(obj, other) for other in ours}
        earlier = [other for other in stage.earlier() if other not in replaced]
        if changes_count(obj, deformer):
            raise SinewError(
                f"{deformer.name} works on vertices that {labels(earlier) or 'earlier modifiers'} made, and "
                "shape keys hold those of the mesh - apply them first, or bake to PC2"
            )
        if earlier:
            raise SinewError(
                f"{labels(earlier)} comes before {deformer.name}, and shape keys come before both - move the "
                "deformer up, or bake to PC2"
            )

    def _open(self) -> None:
        """Make the deformers live, where they are baked already, and prepare to read and write."""
        scene = bpy.data.scenes[self._scene]
        rate = scene.render.fps / scene.render.fps_base
        self._opened = True
        with session.suspended():
            for part in self._parts:
                record.suspend(part.stage.owner(), part.stage.deformer())
        for part in self._parts:
            part.stage.open()
            if self.request.target != "SHAPE_KEYS":
                path = paths.absolute(part.filepath)
                part.file = CacheFile(path, self.request.target, self.request.frames, rate)

    def _waits(self) -> bool:
        """A thread binds or solves; in a window only."""
        uids = [part.stage.uid for part in self._parts]
        session.collect()
        waits = any(uid in session.unsettled() or _is_at_work(uid) for uid in uids)
        if waits:
            session.settle()
            for part in self._parts:
                part.stage.owner().update_tag(refresh={"OBJECT"})
            bpy.context.view_layer.update()
        return waits

    def _take(self, part: _Part, depsgraph: Depsgraph) -> None:
        deformer = part.stage.deformer()
        if deformer.status_level == Level.ERROR.value:
            raise SinewError(f"{deformer.name}: {deformer.status}")
        left = part.stage.positions(depsgraph)
        if part.points < 0:
            part.points = len(left)
        if len(left) != part.points:
            raise SinewError(
                f"{deformer.name} has {len(left)} vertices, and {part.points} in the first frame - bakes "
                "need the same vertices in each frame"
            )
        if not np.isfinite(left).all():
            raise SinewError(
                f"{deformer.name} has positions that are no numbers - look at what comes before it"
            )
        if part.file is not None:
            part.file.append(left)
        else:
            part.shapes.append((part.stage.incoming(depsgraph), left))

    def _close_stages(self) -> None:
        for part in self._parts:
            part.stage.close()

    def _restore_frame(self) -> None:
        frame, subframe = self._frame
        scene = bpy.data.scenes.get(self._scene)
        if scene is not None:
            scene.frame_set(frame, subframe=subframe)
        bpy.context.view_layer.update()


def _is_at_work(uid: str) -> bool:
    """A thread binds or solves this deformer."""
    known = session.find(uid)
    return session.job(uid) is not None or (known is not None and known.work is not None)


@contextmanager
def _naming_frame(frame: int) -> Iterator[None]:
    """Say at which frame something was refused."""
    try:
        yield
    except SinewError as error:
        raise SinewError(f"Frame {frame}: {error}") from error


def _differences(stage: Stage) -> list[str]:
    """Modifiers before the deformer that viewport and render do not share: the viewport's are baked."""
    differing = [other for other in stage.earlier() if other.show_viewport != other.show_render]
    if not differing:
        return []
    return [f"{labels(differing)} differs between viewport and render: the bake shows the viewport's shape"]
