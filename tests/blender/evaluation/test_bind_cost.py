# SPDX-License-Identifier: GPL-3.0-or-later
"""What a bind costs in captures of the mesh, and that its refusal is shown once: counted in calls."""

from collections import Counter
from collections.abc import Callable
from functools import partial
from types import SimpleNamespace

import bmesh
import bpy
import numpy as np
import pytest
from inside import ask_for_factor, calls_of, catch_up, finish, inner, settle, use_threads
from registry import BY_ID, ON_SURFACE, WITH_HANDLES, base_of, options_of
from rigs.kinds import HandleRig, rig_for
from rigs.rig import Rig, add_group, close, make_active, new_object, on_all, press, subdivided, update

CAPTURE = "_rest_meshes"  # evaluates copies of objects and makes a mesh of each


def add_handle(rig: Rig, role: str, group: str, **options: object) -> Counter:
    """Calls during the operator."""
    make_active(rig.obj)
    return calls_of(lambda: bpy.ops.sinew.handle_add(kind=role, vertex_group=group, **options))


def evaluations(obj: bpy.types.Object, action: Callable[[], Counter]) -> tuple[int, Counter]:
    """How often Blender computes the geometry of an object during the action, and what that returns."""
    found = []

    def note(_scene, depsgraph) -> None:
        found.extend(row for row in depsgraph.updates if row.id.original == obj and row.is_updated_geometry)

    bpy.app.handlers.depsgraph_update_post.append(note)
    try:
        calls = action()
    finally:
        bpy.app.handlers.depsgraph_update_post.remove(note)
    return len(found), calls


@pytest.mark.parametrize("role", ["HANDLE", "FIXED"])
def test_adding_a_handle_captures_and_evaluates_the_mesh_as_seldom_as_can_be(
    plate: Rig, role: str, monkeypatch: pytest.MonkeyPatch
):
    """Its control stands where the captured region is, and the same capture is bound.

    Blender evaluates once beside the copy that is captured, and once for the bind: the window waits for both.
    It evaluates earlier, and tells so again, for handlers of others: what counts here is none of them.
    """
    monkeypatch.setattr(inner.schedule, "others_listen", lambda edit: False)
    for group in ("Base", "Top"):
        update()
        count, found = evaluations(plate.obj, partial(add_handle, plate, role, group))
        assert (count, found[CAPTURE]) == (2, 1), found
        assert plate.deformer.is_bound, plate.deformer.status
    if role == "HANDLE":
        plate.lift(0.5)
        assert plate.points()[plate.base, 2] == pytest.approx(0.5, abs=1e-6)


def test_renders_with_other_vertices_cost_one_capture_more(plate: Rig):
    subdivided(plate.obj, 0, 1)
    found = add_handle(plate, "HANDLE", "Top")
    assert found[CAPTURE] == 2, found
    assert len(plate.deformer.rest_render.vertices) > len(plate.deformer.rest.vertices)


def test_a_handle_that_is_not_bound_leaves_no_mesh_behind(plate: Rig):
    plate.bind()
    before = len(bpy.data.meshes)
    found = add_handle(plate, "HANDLE", "Top")  # the same vertices again
    assert "share" in plate.deformer.status
    assert found[CAPTURE] == 1, found
    assert len(bpy.data.meshes) <= before


def by_an_operator(plate: Rig) -> None:
    bpy.ops.sinew.handle_add(kind="FIXED", vertex_group="Top")


def by_an_evaluation(plate: Rig) -> None:
    plate.deformer.handles[0].vertex_group = "Base"
    update()


def by_a_thread(plate: Rig, cancel: bool = False) -> None:
    plate.deformer.method = "arap"
    ask_for_factor(plate.deformer)
    if cancel:
        inner.binding.cancel(plate.deformer.uid)
    else:
        assert finish()


@pytest.mark.parametrize(
    "refused", [by_an_operator, by_an_evaluation, by_a_thread, partial(by_a_thread, cancel=True)]
)
def test_a_refusal_is_shown_by_one_call(plate: Rig, monkeypatch: pytest.MonkeyPatch, refused: Callable):
    plate.bind("thin_shell").lift(0.1)
    if refused not in (by_an_operator, by_an_evaluation):
        use_threads(monkeypatch)
        monkeypatch.setattr(inner.binding, "build_factor", refuse)
    found = calls_of(lambda: refused(plate))
    assert found["fail"] == 1, found
    assert plate.deformer.status_level == "ERROR"
    assert close(plate.points(), plate.rest())


def refuse(*_arguments: object, **_options: object) -> None:
    """Stands in for a native call."""
    raise inner.errors.SinewError("Refused")


def estimate(rig: HandleRig) -> float:
    """Seconds that the rows name for the bind of a rig, with their defaults."""
    row, count = rig.deformer.definition, len(rig.unmoved(rig.obj))
    size = rig.control_size if row.is_space else 0
    rows = (row, base_of(row)) if row.wraps else (row,)
    return sum(each.bind_seconds(count, size, options_of(each, {})[0]) for each in rows)


def light(method: str) -> bpy.types.Object:
    """What the other tests pose, with the choices that cost least."""
    rig, row = rig_for(method), BY_ID[method]
    rig.bind(method)
    options = options_of(row, {})[0]
    for parameter in row.parameters:
        if parameter.rebinds and hasattr(parameter, "items"):
            choices = [{**options, parameter.id: item[0]} for item in parameter.items]
            options = min(choices, key=partial(row.bind_seconds, 99, 12))
            setattr(rig.deformer.parameters, parameter.id, options[parameter.id])
    update()
    return rig.obj


def littered(method: str) -> bpy.types.Object:
    """A small mesh under many loose shells that follow."""
    rig, count = rig_for(method), 500
    while inner.methods.following(count, 0) < 1.2 * inner.binding.HEAVY:
        count += 500
    shells = np.random.default_rng(0).uniform((-1, -1, 0.1), (1, 1, 0.2), (count, 1, 3))
    shells = shells + 0.01 * np.eye(3)[[2, 0, 1]] * (1.0, 1.0, 0.0)
    other = new_object("Shells", shells.reshape(-1, 3).tolist(), np.arange(3 * count).reshape(-1, 3).tolist())
    make_active(rig.obj, other)
    bpy.ops.object.join()
    return rig.bind(method).obj


@pytest.mark.parametrize("method", BY_ID)
def test_a_bind_that_costs_little_is_computed_at_once(method: str, monkeypatch: pytest.MonkeyPatch):
    decides_by_cost(light(method), False, monkeypatch)


@pytest.mark.parametrize("method", BY_ID)
@pytest.mark.parametrize(("heavy_from", "in_thread"), [(1.001, False), (0.999, True)])
def test_the_cost_of_a_bind_decides_whether_a_thread_computes_it(
    method: str, heavy_from: float, in_thread: bool, monkeypatch: pytest.MonkeyPatch
):
    """What counts as heavy lies just above the estimate, or just below it."""
    rig = rig_for(method)
    rig.bind(method)
    monkeypatch.setattr(inner.binding, "HEAVY", heavy_from * estimate(rig))
    decides_by_cost(rig.obj, in_thread, monkeypatch)


@pytest.mark.parametrize("method", ON_SURFACE)
def test_the_cost_of_a_bind_counts_the_loose_parts_that_follow(method: str, monkeypatch: pytest.MonkeyPatch):
    obj = littered(method)
    decides_by_cost(obj, True, monkeypatch)
    obj.sinew.active.loose_parts = "STAY"
    finish()
    alone = BY_ID[method].expected_seconds(len(obj.data.vertices))
    decides_by_cost(obj, alone >= inner.binding.HEAVY, monkeypatch)


def decides_by_cost(obj: bpy.types.Object, in_thread: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """As in a window, by the estimate of the row alone: the time that it takes here counts for nothing."""
    binding = inner.binding
    deformer = obj.sinew.active
    monkeypatch.setattr(binding, "may_wait", lambda seconds: seconds >= binding.HEAVY)
    inner.sessions.find(deformer.uid).bound = None
    inner.bind.bind(obj, deformer, wait=False)
    assert (inner.binding.job(deformer.uid) is not None) is in_thread
    assert finish()
    assert deformer.status_level == "INFO", deformer.status


# --- what is asked of the native module and of Blender when something is bound again


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


def same_as_anew(plate: Rig) -> None:
    """A bind that starts with nothing gives the same shape, to rounding."""
    shown = plate.points()
    inner.memory.forget_all()
    bind(plate)
    np.testing.assert_allclose(plate.points(), shown, atol=1e-5)


NEW = {"SurfaceMesh": 1, "diagnose": 1, "set_handles": 1}


@pytest.mark.parametrize("method", WITH_HANDLES)
def test_binding_again_and_another_region_are_one_native_call(plate: Rig, native: Counter, method: str):
    plate.bind(method)
    plate.lift(0.5)
    shown = plate.points()
    native.clear()
    bind(plate)
    assert native == {"rebind": 1}
    assert reused(plate) == ("kept", "")
    np.testing.assert_array_equal(plate.points(), shown)
    if method in ON_SURFACE:
        native.clear()
        add_middle(plate)
        assert native == {"rebind": 1}
        assert reused(plate) == ("updated", "handles")
        same_as_anew(plate)


def test_painting_a_stiffness_is_one_native_call_and_another_rest_shape_a_new_solver(
    plate: Rig, native: Counter
):
    group = plate.obj.vertex_groups.new(name="Soft")
    group.add(list(range(len(plate.rest()))), 1.0, "REPLACE")
    plate.bind("thin_shell")
    plate.deformer.thin_shell.bending_group = "Soft"
    bind(plate)
    plate.lift(0.5)
    native.clear()
    group.add(
        np.flatnonzero(plate.rest()[:, 0] < 0.0).tolist(), 0.1, "REPLACE"
    )  # half of it, as a brush does
    plate.obj.data.update_tag()
    settle()
    assert native == {"rebind": 1}
    assert reused(plate) == ("updated", "bending")
    same_as_anew(plate)
    old = bound(plate)
    plate.obj.data.vertices[60].co.z += 0.1
    plate.obj.data.update_tag()
    native.clear()
    bind(plate)
    assert native == NEW
    assert not old.factor.is_released
    assert bound(plate) is not old


def test_a_refused_rebind_keeps_nothing(plate: Rig, native: Counter, monkeypatch: pytest.MonkeyPatch):
    plate.bind("thin_shell").lift(0.5)
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
def posed(plate: Rig, monkeypatch: pytest.MonkeyPatch) -> Rig:
    """With three regions, and a thread that binds what comes next, as for a heavy mesh in a window."""
    plate.bind("thin_shell")
    add_middle(plate)
    plate.lift(0.5)
    plate.shown = plate.points()
    use_threads(monkeypatch)
    return plate


def rebind_in_thread(plate: Rig) -> None:
    """A region is switched off; a thread binds what is left."""
    plate.deformer.handles[1].enabled = False
    ask_for_factor(plate.deformer)
    assert inner.binding.job(plate.deformer.uid) is not None


def test_while_a_thread_binds_the_last_shape_stays(posed: Rig, native: Counter):
    old = bound(posed)
    native.clear()
    rebind_in_thread(posed)
    session = inner.sessions.find(posed.deformer.uid)
    assert old.factor.is_released
    assert session.bound is old
    inner.binding.job(posed.deformer.uid).thread.join()
    np.testing.assert_array_equal(session.view("VIEWPORT").positions, posed.shown.astype(np.float32))
    catch_up()
    assert native == {"rebind": 1}
    posed.lift(0.1)
    assert posed.points()[posed.top, 2] == pytest.approx(0.6, abs=1e-6)
    same_as_anew(posed)


def test_a_region_that_returns_while_a_thread_binds_is_bound_again(posed: Rig):
    """Its factor was handed over, and the thread's result is of no use."""
    rebind_in_thread(posed)
    posed.deformer.handles[1].enabled = True
    update()
    assert finish()
    assert not bound(posed).factor.is_released
    np.testing.assert_allclose(posed.points(), posed.shown, atol=1e-6)


def test_a_bind_captures_and_reads_the_mesh_once(plate: Rig):
    plate.bind("thin_shell").lift(0.5)
    found = calls_of(lambda: bind(plate))
    assert found["_new_meshes"] == 1, found
    assert max(found["read_rest"], found["group_weights"]) <= 1, found


@pytest.fixture
def copies(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """How often a rest mesh was copied as a whole."""
    made: list[int] = []
    monkeypatch.setattr(inner.rest, "bmesh", SimpleNamespace(new=lambda: made.append(1) or bmesh.new()))
    return made


@pytest.mark.parametrize("others", [0, 20])
def test_a_bind_of_the_same_shape_takes_over_the_weights(plate: Rig, copies: list[int], others: int):
    """Those in use, and those that come into use without a bind; where there are many, the whole mesh."""
    for number in range(others):
        plate.obj.vertex_groups.new(name=f"Other {number}")
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
