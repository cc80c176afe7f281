# SPDX-License-Identifier: GPL-3.0-or-later
"""Scripts and operators give the same; the add-on comes and goes without a trace."""

import bpy
import numpy as np
import pytest
from rig import Rig, make_active


def test_operators_and_session_functions_give_the_same(room, plate: Rig):
    plate.bind("arap").lift(0.3)
    by_operator = plate.points()
    make_active(plate.obj)
    bpy.ops.sinew.deformer_remove()
    session, obj = room("session"), plate.obj
    deformer = session.add_deformer(obj, "arap")
    session.add_handle(obj, deformer, "HANDLE", "Top")
    session.add_handle(obj, deformer, "FIXED", "Base")
    session.bind(obj, deformer)
    plate.lift(0.3)
    assert np.array_equal(plate.points(), by_operator)


def test_one_call_rigs_a_region_and_binds_it(room, plate: Rig):
    """As Add Handle does. A refused bind leaves the region, an unknown group leaves nothing."""
    session, errors, obj = room("session"), room("core.errors"), plate.obj
    with pytest.raises(errors.SinewError):
        session.rig_region(obj, "HANDLE", "Nowhere", "arap")
    assert obj.sinew.active is None
    plate.bind("arap").lift(0.3)
    by_operator = plate.points()
    make_active(plate.obj)
    bpy.ops.sinew.deformer_remove()
    for kind, group in (("HANDLE", "Top"), ("FIXED", "Base")):
        handle, refusal = session.rig_region(obj, kind, group, "arap")
        assert handle.kind == kind
        assert refusal is None
    plate.lift(0.3)
    assert np.array_equal(plate.points(), by_operator)
    _handle, refusal = session.rig_region(obj, "FIXED", "Top")
    assert isinstance(refusal, errors.ConstraintError)
    assert len(plate.deformer.handles) == 3
    assert plate.deformer.status_level == "ERROR"


def test_register_and_unregister_leave_no_trace(addon):
    handlers = {
        event: len(getattr(bpy.app.handlers, event))
        for event in ("depsgraph_update_post", "frame_change_post", "load_post")
    }
    addon.unregister()
    assert not hasattr(bpy.types.Object, "sinew")
    assert not any("sinew" in handler.__module__ for handler in bpy.app.handlers.load_post)
    addon.register()
    assert {event: len(getattr(bpy.app.handlers, event)) for event in handlers} == handlers
