# SPDX-License-Identifier: GPL-3.0-or-later
"""Go through the deformers in stack order. Called in every evaluation, so equal inputs cost next to nothing.

Handlers run this off the main thread in renders. It reads evaluated data from the depsgraph it is given, and
writes arrays of unchanged size; it never makes or removes a datablock.
"""

import bpy
from bpy.types import Depsgraph, Object

from .. import compat
from ..core import status
from ..core.errors import BackendMissingError, SinewError, TopologyChangedError
from ..core.status import Level, Status
from ..ids import Inputs
from ..properties import SinewDeformer
from . import binding, incoming, regions, rig, solving, state
from .census import owners
from .turn import Chain, Turn, is_shown

LINKED = "Linked: shows the last solution - make a library override to pose it here"


def update(depsgraph: Depsgraph, preview: bool = False) -> None:
    """Solve every deformer whose inputs changed. ``preview`` spends a budget; see ``settle``."""
    if state.is_suspended():
        return
    for obj in owners():
        evaluated = obj.evaluated_get(depsgraph)
        if evaluated.is_evaluated:
            _update_object(obj, evaluated, depsgraph, preview)


def _update_object(obj: Object, evaluated: Object, depsgraph: Depsgraph, preview: bool) -> None:
    by_proxy = {deformer.proxy: index for index, deformer in enumerate(obj.sinew.deformers) if deformer.proxy}
    chain = Chain()
    for modifier in obj.modifiers:
        if not is_shown(modifier, depsgraph.mode):
            continue
        is_nodes = modifier.type == "NODES"
        index = by_proxy.get(compat.modifier_input(modifier, Inputs.PROXY_VIEWPORT)) if is_nodes else None
        if index is None:
            chain = chain.after_other_modifier()
            continue
        deformer = obj.sinew.deformers[index]
        settings = _evaluated_settings(evaluated, index, deformer)
        session = state.of(deformer.uid)
        turn = Turn(obj, evaluated, depsgraph, modifier, deformer, settings, session, chain, preview)
        if turn.in_viewport and rig.connect_mask(obj, modifier, deformer):
            obj.update_tag()
        try:
            with session.lock:
                chain = _take(turn)
        except SinewError as error:
            chain = chain.unknown()
            _refuse(turn, error)


def _evaluated_settings(evaluated: Object, index: int, deformer: SinewDeformer) -> SinewDeformer:
    """The deformer with its animated values, or the original where Blender has not copied it yet."""
    copies = evaluated.sinew.deformers
    if index < len(copies) and copies[index].uid == deformer.uid:
        return copies[index]
    return deformer


def _take(turn: Turn) -> Chain:
    """Bring one deformer up to date; what it leaves for the next."""
    deformer, session = turn.deformer, turn.session
    if not turn.settings.live:
        return incoming.after(turn)
    if rig.is_linked(deformer.proxy):
        status.put(deformer.uid, Status(Level.INFO, LINKED))
        return Chain(broken=True)
    if not deformer.is_bound or not regions.has_constraints(turn.settings):
        rig.show_rest(deformer, turn.mode)
        return turn.chain.unknown()
    wait = bpy.app.background or not turn.in_viewport
    bound = binding.ensure(session, deformer, turn.settings, wait)
    if bound is None:
        if session.failed is not None:
            rig.show_rest(deformer, turn.mode)
        return turn.chain.unknown()
    solving.solve(turn, bound, *incoming.find(turn, bound))
    return incoming.after(turn)


def _refuse(turn: Turn, error: SinewError) -> None:
    if isinstance(error, TopologyChangedError):
        turn.shown.signature = ()  # the node group shows rest already, as its counts differ
    elif not isinstance(error, BackendMissingError):  # then the last solution stays
        rig.show_rest(turn.deformer, turn.mode)
    if turn.in_viewport:
        status.fail(turn.deformer.uid, error)
    else:
        turn.note(f"In the render: {error}")


def settle() -> bool:
    """Ask for the final answer of every preview; True where there was one. For a timer, and for tests."""
    asked = False
    for obj in owners():
        for deformer in obj.sinew.deformers:
            session = state.find(deformer.uid)
            if session is None or (session.final is not None and not session.final.done):
                continue
            if any(not shown.converged for shown in session.shown.values()):
                session.settle = asked = True
                obj.update_tag()
    return asked
