# SPDX-License-Identifier: GPL-3.0-or-later
"""The rigs of *Try It*: bring one in as a scene of its own, look at its steps, remove it with all its data.

Main thread only.
"""

from collections.abc import Callable, Iterator
from pathlib import Path

import bpy
from bpy.types import ID, Depsgraph, Object, Scene

from ...core.errors import SinewError
from ...core.memory import remember
from ...core.names import numbered
from ...core.rigs import RIG_BY_ID, Done, Rig, Step
from ...ids import Keys
from ...properties import SinewDeformer
from ..controls import kinds

_FOLDER = Path(__file__).parents[2] / "rigs"
# None of these needs what it shows.
_INTERFACE = (bpy.types.Screen, bpy.types.WindowManager, bpy.types.WorkSpace)
_done: dict[str, int] = remember({})  # how many steps are done, by the name of the scene


def bring(rig: Rig) -> tuple[Scene, dict[str, Object]]:
    """Append the scene of a rig; and its objects, by their names in the file of the rig."""
    before = set(bpy.data.libraries)
    try:
        with bpy.data.libraries.load(str(_FOLDER / f"{rig.id}.blend")) as (_there, here):
            here.scenes, here.objects = [rig.id], list(rig.objects)
    except OSError as error:
        raise SinewError(
            f"The rig '{rig.label}' is missing or damaged - install the Sinew zip again, which contains it"
        ) from error
    for library in set(bpy.data.libraries) - before:
        bpy.data.libraries.remove(library)  # what came from it is local
    (scene,) = here.scenes
    scene.name = numbered(rig.label, [other.name for other in bpy.data.scenes if other != scene])
    scene.sinew.rig = rig.id
    _done.pop(scene.name, None)
    for own in _only_of(scene):
        own[Keys.TRIED] = True
    return scene, dict(zip(rig.objects, here.objects, strict=True))


def remove(scene: Scene) -> None:
    """Remove a scene that no window shows, with all that nothing else uses, and what is left of the rig."""
    _done.pop(scene.name, None)
    scene.sinew.came_from = None
    lost = _only_of(scene)
    bpy.data.scenes.remove(scene)
    bpy.data.batch_remove(lost)
    left = {own for own in bpy.data.user_map() if not own.users and own.get(Keys.TRIED)}
    bpy.data.batch_remove(left)


def rig_of(scene: Scene) -> Rig | None:
    """The rig that a scene was opened for."""
    return RIG_BY_ID.get(scene.sinew.rig)


def steps_done(scene: Scene) -> int:
    """How many steps of the rig of a scene are done: they are counted in their order."""
    return _done.get(scene.name, 0)


def look(scene: Scene, depsgraph: Depsgraph) -> bool:
    """Tick the next steps of the rig of a scene, if they are done; whether any was."""
    rig, before = rig_of(scene), steps_done(scene)
    steps = () if rig is None else rig.steps[before:]
    now = before
    for step in steps:
        if not _SEEN[step.done](scene, step, depsgraph):
            break
        now += 1
    if now != before:
        _done[scene.name] = now
    return now != before


def _only_of(scene: Scene) -> set[ID]:
    """What a scene uses, directly or not, and nothing else does."""
    users = bpy.data.user_map()
    used: dict[ID, set[ID]] = {}
    for each, by in users.items():
        for user in by:
            used.setdefault(user, set()).add(each)
    own, new = {scene}, {scene}
    while new:
        new = set().union(*(used.get(each, ()) for each in new)) - own
        own |= new
    own = {each for each in own if each == scene or not (each.use_fake_user or isinstance(each, Scene))}
    while shared := {each for each in own - {scene} if any(_needs(user, own) for user in users[each])}:
        own -= shared
    return own - {scene}


def _needs(user: ID, own: set[ID]) -> bool:
    return user not in own and not isinstance(user, _INTERFACE)


def _deformers(scene: Scene) -> Iterator[tuple[Object, SinewDeformer]]:
    for obj in scene.objects:
        for deformer in obj.sinew.deformers:
            yield obj, deformer


def _posed(scene: Scene, depsgraph: Depsgraph) -> bool:
    return any(
        deformer.is_bound and kinds.kind_in_use(deformer).not_at_rest(obj, deformer, depsgraph)
        for obj, deformer in _deformers(scene)
    )


_SEEN: dict[Done, Callable[[Scene, Step, Depsgraph], bool]] = {
    Done.STARTED: lambda scene, _step, _depsgraph: any(_deformers(scene)),
    Done.POSED: lambda scene, _step, depsgraph: _posed(scene, depsgraph),
    Done.AT_REST: lambda scene, _step, depsgraph: not _posed(scene, depsgraph),
    Done.METHOD: lambda scene, step, _depsgraph: any(
        method.id == step.method
        for _obj, deformer in _deformers(scene)
        for method, _values in deformer.methods
    ),
    Done.FRAME: lambda scene, _step, _depsgraph: scene.frame_current != scene.frame_end,
    Done.RADIUS: lambda scene, step, _depsgraph: any(
        row.radius > step.more for _obj, deformer in _deformers(scene) for row in deformer.controls
    ),
    Done.PINNED: lambda scene, _step, _depsgraph: any(
        bone.sinew.pin for obj in scene.objects if obj.pose is not None for bone in obj.pose.bones
    ),
}
