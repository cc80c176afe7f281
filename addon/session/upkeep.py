# SPDX-License-Identifier: GPL-3.0-or-later
"""Upkeep on the main thread, of what handlers may not do themselves: they make no datablocks.

A copied object shows the shapes of the original until it gets its own.

Main thread only: this makes datablocks.
"""

import bpy
from bpy.types import Object

from ..ids import Datablocks
from . import binding, census, rig, state


def copies() -> list[Object]:
    """Objects that share a deformer's key with another object, or show shapes linked from a library."""
    seen: set[str] = set()
    found = []
    for obj in bpy.data.objects:
        keys = [deformer.uid for deformer in obj.sinew.deformers]
        linked = obj.library is None and any(
            rig.is_linked(deformer.proxy) for deformer in obj.sinew.deformers
        )
        if linked or any(key in seen for key in keys):
            found.append(obj)
        seen.update(keys)
    return found


def separate(obj: Object) -> None:
    """Give a copy keys and shapes of its own. The rest mesh is never written, so it stays shared."""
    for deformer in obj.sinew.deformers:
        modifier = rig.find_modifier(obj, deformer)
        deformer.uid = rig.new_key()
        for name, proxy in ((Datablocks.PROXY_VIEWPORT, "proxy"), (Datablocks.PROXY_RENDER, "proxy_render")):
            shared = getattr(deformer, proxy)
            if shared is not None:
                setattr(deformer, proxy, bpy.data.objects.new(name, shared.data.copy()))
        if modifier is not None:
            rig.connect(modifier, deformer)
    rig.keep_evaluated(obj)
    obj.update_tag()


def collect() -> None:
    """Take finished binds in; their deformers solve in the next evaluation."""
    ready = binding.collect()
    for obj in census.owners() if ready else ():
        if any(deformer.uid in ready for deformer in obj.sinew.deformers):
            obj.update_tag()


def tidy() -> None:
    """What handlers had to leave: shapes for copies, drivers for controls that were exchanged."""
    found = copies()
    for obj in found:
        separate(obj)
    if found:
        census.forget_owners()
    exchanged = set(state.rewired())
    for obj in census.owners() if exchanged else ():
        uids = exchanged.intersection(deformer.uid for deformer in obj.sinew.deformers)
        if uids:
            rig.keep_evaluated(obj)
        for uid in uids:
            state.of(uid).rewire = False
