# SPDX-License-Identifier: GPL-3.0-or-later
"""What Blender and the native module are asked for by binds and frames: counted, not timed."""

from __future__ import annotations

from collections import Counter

import bmesh
import bpy
import numpy as np
import pytest
from inside import ask_for_factor, calls_of, catch_up, inner, settle, use_threads
from registry import ON_SURFACE, WITH_HANDLES
from rigs.rig import Rig, add_group, on_all, press, update


@pytest.fixture
def native(count_native) -> Counter:
    """How often the native module was asked to build or bind something."""
    return count_native(inner.backend.availability().module)


def bound(plate: Rig):
    return inner.sessions.find(plate.deformer.uid).bound


def reused(plate: Rig) -> tuple[str, str]:
    """What the last bind took over, and what differed."""
    report = bound(plate).factor.report
    return report.reuse, report.changed


def bind(plate: Rig) -> None:
    press(plate.obj, "bind")


def add_middle(plate: Rig) -> None:
    add_group(plate.obj, "Middle", lambda point: abs(point[0]) < 0.05 and abs(point[1]) < 0.05)
    press(plate.obj, "handle_add", kind="HANDLE", vertex_group="Middle")


def paint(plate: Rig, value: float) -> None:
    """Half of the plate, as a brush does."""
    half = [index for index, point in enumerate(plate.rest()) if point[0] < 0.0]
    plate.obj.vertex_groups["Soft"].add(half, value, "REPLACE")
    plate.obj.data.update_tag()


def same_as_anew(plate: Rig) -> None:
    """A bind that starts with nothing gives the same shape, to rounding."""
    shown = plate.points()
    inner.memory.forget_all()
    bind(plate)
    np.testing.assert_allclose(plate.points(), shown, atol=1e-5)


NEW = {"SurfaceMesh": 1, "diagnose": 1, "set_handles": 1}


@pytest.mark.parametrize("method", ON_SURFACE)
def test_another_region_is_one_native_call(plate: Rig, native: Counter, method: str):
    plate.bind(method)
    plate.lift(0.5)
    native.clear()
    add_middle(plate)
    assert native == {"rebind": 1}
    assert reused(plate) == ("updated", "handles")
    same_as_anew(plate)


def test_painting_a_stiffness_is_one_native_call(plate: Rig, native: Counter):
    plate.obj.vertex_groups.new(name="Soft").add(list(range(len(plate.rest()))), 1.0, "REPLACE")
    plate.bind("thin_shell")
    plate.deformer.thin_shell.bending_group = "Soft"
    bind(plate)
    plate.lift(0.5)
    native.clear()
    paint(plate, 0.1)
    settle()
    assert native == {"rebind": 1}
    assert reused(plate) == ("updated", "bending")
    same_as_anew(plate)


@pytest.mark.parametrize("method", WITH_HANDLES)
def test_binding_again_costs_the_native_module_nothing(plate: Rig, native: Counter, method: str):
    plate.bind(method)
    plate.lift(0.5)
    shown = plate.points()
    native.clear()
    bind(plate)
    assert native == {"rebind": 1}
    assert reused(plate) == ("kept", "")
    np.testing.assert_array_equal(plate.points(), shown)


def test_another_rest_shape_needs_a_new_solver(plate: Rig, native: Counter):
    plate.bind("thin_shell")
    old = bound(plate)
    plate.obj.data.vertices[60].co.z += 0.1
    plate.obj.data.update_tag()
    native.clear()
    bind(plate)
    assert native == NEW
    assert not old.factor.is_released
    assert bound(plate) is not old


def test_a_refused_rebind_keeps_nothing(plate: Rig, native: Counter, monkeypatch: pytest.MonkeyPatch):
    plate.bind("thin_shell")
    plate.lift(0.5)
    module = inner.backend.availability().module
    shell = type(module.ThinShell(module.SurfaceMesh(np.eye(3), np.array([[0, 1, 2]]))))

    def refuse(*_arguments, **_keywords):
        raise module.FactorizationFailed("refused here")

    with monkeypatch.context() as patch:
        patch.setattr(shell, "rebind", refuse)
        add_middle(plate)
    assert plate.deformer.status == "refused here"
    assert bound(plate) is None
    np.testing.assert_allclose(plate.points(), plate.rest(), atol=1e-6)
    native.clear()
    bind(plate)
    assert native == NEW


@pytest.fixture
def heavy(monkeypatch: pytest.MonkeyPatch) -> None:
    """Binds go to a thread, as for a heavy mesh in a window."""
    use_threads(monkeypatch)


def rebind_in_thread(plate: Rig) -> None:
    """A region is switched off; a thread binds what is left."""
    deformer = plate.deformer
    deformer.handles[1].enabled = False
    ask_for_factor(deformer)
    assert inner.binding.job(deformer.uid) is not None


def test_while_a_thread_binds_the_last_shape_stays(plate: Rig, heavy, native: Counter):
    plate.bind("thin_shell")
    add_middle(plate)
    plate.lift(0.5)
    shown = plate.points()
    old = bound(plate)
    native.clear()
    rebind_in_thread(plate)
    assert old.factor.is_released
    assert inner.sessions.find(plate.deformer.uid).bound is old
    inner.binding.job(plate.deformer.uid).thread.join()
    np.testing.assert_array_equal(
        inner.sessions.find(plate.deformer.uid).view("VIEWPORT").positions, shown.astype(np.float32)
    )
    catch_up()
    assert native == {"rebind": 1}
    plate.lift(0.1)
    assert plate.points()[plate.top, 2] == pytest.approx(0.6, abs=1e-6)
    same_as_anew(plate)


def test_a_region_that_returns_while_a_thread_binds_is_bound_again(plate: Rig, heavy):
    """Its factor was handed over, and the thread's result is of no use."""
    plate.bind("thin_shell")
    add_middle(plate)
    plate.lift(0.5)
    shown = plate.points()
    rebind_in_thread(plate)
    plate.deformer.handles[1].enabled = True
    update()
    while catch_up():
        pass
    update()
    assert not bound(plate).factor.is_released
    np.testing.assert_allclose(plate.points(), shown, atol=1e-6)


def test_a_bind_captures_and_reads_the_mesh_once(plate: Rig):
    plate.bind("thin_shell")
    plate.lift(0.5)
    found = calls_of(lambda: bind(plate))
    for name in ("_new_meshes", "read_rest", "group_weights"):
        assert found[name] <= 1, (name, found)
    assert found["_new_meshes"] == 1


@pytest.fixture
def copies(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """How often a rest mesh was copied as a whole."""
    rest, made = inner.rest, []

    class Counting:
        @staticmethod
        def new():
            made.append(1)
            return bmesh.new()

    monkeypatch.setattr(rest, "bmesh", Counting)
    return made


def add_groups(plate: Rig, count: int) -> None:
    for number in range(count):
        plate.obj.vertex_groups.new(name=f"Other {number}")


@pytest.mark.parametrize("others", [0, 20])
def test_a_bind_of_the_same_shape_takes_over_the_weights(plate: Rig, copies: list[int], others: int):
    """Those in use, and those that come into use without a bind; where there are many, the whole mesh."""
    add_groups(plate, others)
    add_group(plate.obj, "Late", lambda point: abs(point[1]) < 0.2)
    plate.bind("thin_shell")
    copies.clear()
    late = plate.obj.vertex_groups["Late"]
    late.add(list(range(len(plate.rest()))), 0.0, "REPLACE")
    late.add([60, 61], 1.0, "REPLACE")
    bind(plate)
    assert len(copies) == (1 if others else 0)
    plate.deformer.handles[0].vertex_group = "Late"
    plate.lift(0.5)
    assert bound(plate).indices[0].tolist() == [60, 61]
    same_as_anew(plate)


@pytest.mark.parametrize("change", ["shape", "faces", "groups"])
def test_a_bind_of_another_shape_takes_over_all_of_it(plate: Rig, copies: list[int], change: str):
    plate.bind("thin_shell")
    plate.lift(0.5)
    copies.clear()
    if change == "shape":
        plate.obj.data.vertices[60].co.z += 0.1
        plate.obj.data.update_tag()
    elif change == "faces":
        on_all(plate.obj, bpy.ops.mesh.quads_convert_to_tris)
    else:
        plate.obj.vertex_groups.remove(plate.obj.vertex_groups["Base"])
        add_group(plate.obj, "Base", lambda point: point[1] < -0.5)
        plate.deformer.handles[1].vertex_group = "Base"
    bind(plate)
    assert len(copies) == (0 if change == "groups" else 1)
    np.testing.assert_array_equal(bound(plate).rest.points, plate.rest())
    assert len(bound(plate).rest.counts) == len(plate.obj.data.polygons)
    if change == "groups":
        held = bound(plate).indices[1]
        np.testing.assert_array_equal(held, np.flatnonzero(plate.rest()[:, 1] < -0.5))
    same_as_anew(plate)
