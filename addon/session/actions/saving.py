# SPDX-License-Identifier: GPL-3.0-or-later
"""What a file stores for computers that do not solve: renders there show what the viewport shows here.

Main thread only.
"""

from contextlib import suppress

import bpy
from bpy.types import Object

from ...compat import read_positions
from ...core.errors import SinewError
from ...properties import SinewDeformer
from ..controls import kinds
from ..datablocks.owners import owners
from ..datablocks.shapes import capture, shapes
from ..evaluation import binding, evaluate
from ..state import sessions
from ..state.evaluation import is_shown
from ..targets import modified
from ..targets.kinds import kind_of


def store() -> None:
    """Put the last solutions into the shapes for renders, before the file is saved.

    Where other vertices enter in renders than in the viewport, they are solved for the poses of now.
    """
    found = [obj for obj in owners() if obj.library is None]
    if not found:
        return
    bpy.context.view_layer.update()  # a script may save right after it has moved a control
    _solve_those_that_differ(found)
    for obj in found:
        for deformer in obj.sinew.deformers:
            for kind in kinds.every_kind():
                kind.keep_pose(deformer, sessions.open_session(deformer.uid).poses)
    store_shown()


def store_shown() -> None:
    """The same without a solve: only where the same vertices enter in renders and in the viewport."""
    for obj in owners():
        if obj.library is None:
            for deformer in obj.sinew.deformers:
                if _is_in_viewport(obj, deformer):
                    shapes.render_as_shown(deformer)


def _is_in_viewport(obj: Object, deformer: SinewDeformer) -> bool:
    shows = kind_of(obj).shown_by(obj, deformer)
    return shows is not None and is_shown(shows, "VIEWPORT")


def _first_that_differs(obj: Object) -> SinewDeformer | None:
    """The first deformer in the stack, if renders need a solve of their own for some deformer."""
    by_modifier = {}
    for deformer in obj.sinew.deformers:
        modifier = modified.shown_by(obj, deformer)
        if modifier is not None and modifier.show_render and deformer.is_bound:
            by_modifier[modifier.name] = deformer
    if not any(
        _is_ready(deformer)
        and (deformer.renders_differ or deformer.topology_changed or not obj.modifiers[name].show_viewport)
        for name, deformer in by_modifier.items()
    ):
        return None
    return next(by_modifier[modifier.name] for modifier in obj.modifiers if modifier.name in by_modifier)


def _is_ready(deformer: SinewDeformer) -> bool:
    """Whether a solve takes no long bind, for which the user of a window would have to wait at a save."""
    bound = shapes.session_of(deformer, "RENDER").bound
    return bound is not None or not binding.may_wait(len(deformer.rest_in("RENDER").vertices))


@sessions.suspended()
def _solve_those_that_differ(found: list[Object]) -> None:
    """Solve what a render would show of objects now, where it is not what the viewport shows."""
    differing = [(obj, first) for obj in found if (first := _first_that_differs(obj)) is not None]
    for (obj, _), meshes in zip(differing, capture.all_rest_meshes(differing), strict=True):
        if isinstance(meshes, SinewError):
            continue  # the panel says what is wrong
        shown, rendered = meshes
        entered = read_positions(shown if rendered is None else rendered)
        bpy.data.batch_remove([mesh for mesh in meshes if mesh is not None])
        with suppress(SinewError):
            evaluate.update_renders(obj, bpy.context.evaluated_depsgraph_get(), entered)
