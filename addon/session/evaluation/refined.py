# SPDX-License-Identifier: GPL-3.0-or-later
"""Moves the points of a refined mesh with those of the control mesh."""

import numpy as np
from bpy.types import NodesModifier

from ...compat import write_positions
from ...core import status
from ...core.errors import SinewError
from ...core.memory import remember
from ...ids import Inputs, Keys
from ..datablocks import refined
from ..state import sessions
from ..state.evaluation import Chain, ObjectEvaluation
from ..targets import refined_group

_shown: dict[str, np.ndarray] = remember({})  # the control points, by the token of the places


def update(shared: ObjectEvaluation, modifier: NodesModifier, chain: Chain, changed: bool) -> None:
    """Let a refined mesh follow what enters it. Where that is unknown, the control mesh is shown.

    ``changed``: whether more than controls may have changed, such as other modifiers.
    """
    obj = shared.obj
    if not shared.in_viewport or obj.library is not None:
        return
    if changed and refined.keep_incoming(obj, modifier):  # what entered it was not kept in this evaluation
        sessions.note_count(obj.name)
    try:
        points, refusal = _refined(shared, modifier, chain)
    except SinewError as error:
        points, refusal = None, str(error)
    for deformer in obj.sinew.deformers:
        status.put_refined(deformer.uid, refusal)
    if refined_group.connect(modifier, Inputs.REFINED_POINTS, -1 if points is None else len(points)):
        obj.update_tag()


def _refined(
    shared: ObjectEvaluation, modifier: NodesModifier, chain: Chain
) -> tuple[np.ndarray | None, str]:
    """The control points that the refined mesh shows now, float32 (n, 3); None, and why, if it does not fit
    them.
    """
    by, scene = refined_group.subdivision_of(shared.obj, modifier), shared.depsgraph.scene
    mesh, places = refined.mesh_of(modifier), refined.places_of(modifier)
    if by is None:
        return None, "no Subdivision modifier stands right before it"
    how, wanted = refined.subdivision(by, scene), refined.signature(by, scene)
    if by.show_viewport or how.levels == 0:
        return None, ""
    refusal = refined.refusal(shared.obj, wanted)
    if refusal:
        return None, refusal
    if mesh is None or places is None or mesh[Keys.REFINED_FOR] != wanted:
        sessions.note_count(shared.obj.name)
        return None, ""
    if places.library is not None:
        return None, "it is linked - make it local, or let its Subdivision modifier refine"
    surface, points = refined.surface_of(mesh, how), chain.points
    if chain.entered:
        count = surface.control_count
        points = refined.read_entering(shared, chain.entered, count).points
    if points is None:
        return None, "a mask or another modifier stands before it, so the mesh is known too late"
    if len(points) != surface.control_count:
        if shared.obj.mode != "EDIT":
            sessions.note_count(shared.obj.name)
        return None, ""
    token = places[Keys.REFINED_TOKEN]
    if _shown.get(token) is not points:
        write_positions(places, surface.refine(points))
        _shown[token] = points
    return points, ""
