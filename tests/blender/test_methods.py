# SPDX-License-Identifier: GPL-3.0-or-later
"""Every row of the registry, in Blender: properties, rest, translation, and each of its parameters."""

import bpy
import numpy as np
import pytest
from rig import Rig, add_group, make_active


def test_each_method_is_offered_with_its_parameters(room, plate: Rig):
    make_active(plate.obj)
    for method in room("core.methods").METHODS:
        bpy.ops.sinew.deformer_add(method=method.id)
        deformer = plate.obj.sinew.active
        assert deformer.method == method.id
        for parameter in method.parameters:
            assert getattr(deformer.parameters, parameter.id) == pytest.approx(parameter.default)
        for parameter in method.paintable:
            assert getattr(deformer.parameters, f"{parameter.id}_group") == ""


def with_handles(room) -> list:
    methods = room("core.methods")
    return [method for method in methods.METHODS if method.control is methods.Control.HANDLES]


def test_each_method_translates_and_obeys_every_parameter(room, plate: Rig):
    for method in with_handles(room):
        make_active(plate.obj)
        plate.bind(method.id).lift(0.4)
        plate.control.rotation_euler.x += 0.5
        deformer = plate.deformer
        assert np.abs(plate.points()[plate.base] - plate.rest()[plate.base]).max() < 4e-6
        for parameter in method.parameters:
            before = getattr(deformer.parameters, parameter.id)
            for value in other_values(parameter):
                setattr(deformer.parameters, parameter.id, value)
                assert np.isfinite(plate.points()).all()
                assert deformer.status_level == "INFO", (method.id, parameter.id, value, deformer.status)
            setattr(deformer.parameters, parameter.id, before)
        make_active(plate.obj)
        bpy.ops.sinew.deformer_remove()


def other_values(parameter) -> list:
    kind = type(parameter).__name__
    if kind == "Choice":
        return [item[0] for item in parameter.items]
    if kind == "Bool":
        return [True, False]
    return [min(parameter.default * 2 + 1, parameter.soft_maximum)]


def test_a_painted_parameter_changes_the_shape_where_it_is_painted(room, plate: Rig):
    add_group(plate.obj, "Left", lambda point: point[0] < 0.0)
    for method in room("core.methods").METHODS:
        for parameter in method.paintable:
            plate.bind(method.id)
            plate.lift(0.4)
            plate.control.rotation_euler.x += 0.8
            setattr(plate.deformer.parameters, parameter.id, max(parameter.default, 0.5))
            even = plate.points()
            setattr(plate.deformer.parameters, f"{parameter.id}_group", "Left")
            painted = plate.points()
            assert plate.deformer.status_level == "INFO", plate.deformer.status
            assert np.abs(painted - even).max() > 1e-5, (method.id, parameter.id)
            make_active(plate.obj)
            bpy.ops.sinew.deformer_remove()


def test_switching_the_method_keeps_the_handles(plate: Rig):
    plate.bind("thin_shell").lift(0.5)
    handles = [(handle.name, handle.control) for handle in plate.deformer.handles]
    plate.deformer.method = "arap"
    assert plate.points()[plate.top, 2] == pytest.approx(0.5, abs=4e-6)
    assert [(handle.name, handle.control) for handle in plate.deformer.handles] == handles


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
