# SPDX-License-Identifier: GPL-3.0-or-later
"""Regular work that handlers may not do themselves, because it makes datablocks. Main thread only.

A copied object, for example, shows the shapes of the original until it gets its own here.
"""

import bpy
from bpy.types import Object

from ...ids import Datablocks
from ..controls import kinds
from ..datablocks import evaluation_driver, references, refined
from ..datablocks.owners import copies, forget_owners, has_copies, owners
from ..datablocks.shapes import shapes
from ..evaluation import binding, mirroring
from ..state import sessions
from ..targets import lattices, targets
from ..targets.kinds import kind_of
from . import deformers


def separate(obj: Object) -> None:
    """Give a copied object keys and shapes of its own. The rest mesh is never changed, so it stays shared."""
    kind = kind_of(obj)
    for deformer in obj.sinew.deformers:
        shows = kind.shown_by(obj, deformer)
        deformer.uid = shapes.new_key()
        shared = deformer.shape("VIEWPORT"), deformer.shape("RENDER")
        shapes.hide_overrides(*shared)
        if shared[0] is not None:
            deformer.proxy = bpy.data.objects.new(Datablocks.PROXY_VIEWPORT, shared[0].data.copy())
        if shared[1] is not None:
            deformer.proxy_render = bpy.data.objects.new(Datablocks.PROXY_RENDER, shared[1].data.copy())
        shapes.mark(deformer)
        references.unshare_curves(deformer)
        if shows is not None:
            kind.connect(shows, deformer)
    refined.separate(obj)
    kind.own_data(obj)
    kinds.keep_evaluated(obj)
    obj.update_tag()


def restore_shapes() -> None:
    """After undo and redo; see ``shapes.restore``."""
    for obj in owners():
        for deformer in obj.sinew.deformers if obj.library is None else ():
            shapes.restore(obj, deformer)
    lattices.forget_edits()


def collect() -> None:
    """Take in the results of threads. The next evaluation solves with them, or shows them."""
    ready = binding.collect()
    for obj in owners() if ready or sessions.has_work() else ():
        if any(
            deformer.uid in ready or sessions.has_answer(deformer.uid) for deformer in obj.sinew.deformers
        ):
            obj.update_tag(refresh={"OBJECT"})


def separate_copies() -> bool:
    """Give copied objects keys and shapes of their own; whether there were any."""
    found = copies()
    for obj in found:
        separate(obj)
    if found:
        forget_owners()
    return bool(found)


def tidy() -> None:
    """Give copied objects their own shapes, and renew drivers that are missing or name the wrong control."""
    separate_copies()
    for obj in _converted():
        for index in _former(obj):
            deformers.forget_deformer(obj, index)
    exchanged = set(sessions.rewired())
    for obj in owners():
        uids = exchanged.intersection(deformer.uid for deformer in obj.sinew.deformers)
        if (uids or not evaluation_driver.is_kept(obj)) and obj.library is None:
            kinds.keep_evaluated(obj)
        for uid in uids:
            sessions.open_session(uid).rewire = False


def _converted() -> list[Object]:
    """Objects that Blender has converted to a mesh or from one: with a fixed shape, without modifiers."""
    return [obj for obj in owners() if obj.library is None and _former(obj)]


def _former(obj: Object) -> list[int]:
    """The indices of the deformers that an object had before it was converted, the last first."""
    deformers = obj.sinew.deformers
    return [
        index
        for index in reversed(range(len(deformers)))
        if not targets.suits(obj, deformers[index]) and kind_of(obj).shown_by(obj, deformers[index]) is None
    ]


def has_pending() -> bool:
    """Whether there is work for ``tidy``, ``refresh``, ``settle`` or ``key_partners``."""
    waits = sessions.unsettled() or sessions.rewired() or sessions.has_edited() or _converted()
    waits_for_keys = mirroring.waits_for_keys()
    return (
        bool(waits)
        or waits_for_keys
        or has_copies()
        or not all(evaluation_driver.is_kept(obj) for obj in owners())
    )
