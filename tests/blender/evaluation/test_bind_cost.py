# SPDX-License-Identifier: GPL-3.0-or-later
"""What a bind costs in captures of the mesh, and that its refusal is shown once: counted in calls."""

from collections import Counter
from collections.abc import Callable
from functools import partial

import bmesh
import bpy
import numpy as np
import pytest
from inside import ask_for_factor, calls_of, catch_up, finish, inner, use_threads
from registry import BY_ID, ON_SURFACE, base_of, options_of
from rigs.kinds import HandleRig, rig_for
from rigs.rig import Rig, close, make_active, subdivided, update

CAPTURE = "_rest_meshes"  # evaluates copies of objects and makes a mesh of each


def add_handle(rig: Rig, role: str, group: str, **options: object) -> Counter:
    """Calls during the operator."""
    make_active(rig.obj)
    return calls_of(lambda: bpy.ops.sinew.handle_add(kind=role, vertex_group=group, **options))


@pytest.mark.parametrize("role", ["HANDLE", "FIXED"])
def test_adding_a_handle_captures_the_mesh_once(plate: Rig, role: str):
    """Its control stands where the captured region is, and the same capture is bound."""
    for group in ("Base", "Top"):
        found = add_handle(plate, role, group)
        assert found[CAPTURE] == 1, found
        assert plate.deformer.is_bound
    if role == "HANDLE":
        plate.lift(0.5)
        assert plate.points()[plate.base, 2] == pytest.approx(0.5, abs=1e-6)


def evaluations(obj: bpy.types.Object, action: Callable[[], object]) -> int:
    """How often Blender computes the geometry of an object during the action."""
    found = []

    def note(_scene, depsgraph) -> None:
        found.extend(row for row in depsgraph.updates if row.id.original == obj and row.is_updated_geometry)

    bpy.app.handlers.depsgraph_update_post.append(note)
    try:
        action()
    finally:
        bpy.app.handlers.depsgraph_update_post.remove(note)
    return len(found)


@pytest.mark.parametrize("role", ["HANDLE", "FIXED"])
def test_adding_a_handle_evaluates_the_mesh_as_seldom_as_can_be(
    plate: Rig, role: str, monkeypatch: pytest.MonkeyPatch
):
    """Once beside the copy that is captured, and once for the bind: the window waits for both.

    Blender evaluates earlier, and tells so again, for handlers of others: what counts here is none of them.
    """
    monkeypatch.setattr(inner.schedule, "others_listen", lambda edit: False)
    for group in ("Base", "Top"):
        update()
        assert evaluations(plate.obj, lambda group=group: add_handle(plate, role, group)) == 2
        assert plate.deformer.is_bound, plate.deformer.status


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


def by_a_thread(plate: Rig) -> None:
    plate.deformer.method = "arap"
    ask_for_factor(plate.deformer)
    inner.binding.job(plate.deformer.uid).thread.join()
    catch_up()


def by_the_user(plate: Rig) -> None:
    plate.deformer.method = "arap"
    ask_for_factor(plate.deformer)
    inner.binding.cancel(plate.deformer.uid)


@pytest.mark.parametrize("refused", [by_an_operator, by_an_evaluation, by_a_thread, by_the_user])
def test_a_refusal_is_shown_by_one_call(
    plate: Rig, monkeypatch: pytest.MonkeyPatch, refused: Callable[[Rig], None]
):
    plate.bind("thin_shell").lift(0.1)
    if refused in (by_a_thread, by_the_user):
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
    rig = rig_for(method)
    data, following = rig.obj.data, inner.methods.following
    count = next(
        count for count in range(500, 99_999, 500) if following(count, 0) > 1.2 * inner.binding.HEAVY
    )
    places = np.random.default_rng(0).uniform((-1, -1, 0.1), (1, 1, 0.2), (count, 3)).tolist()
    mesh = bmesh.new()
    mesh.from_mesh(data)
    for x, y, z in places:
        mesh.faces.new([mesh.verts.new(at) for at in ((x, y, z), (x + 0.01, y, z), (x, y + 0.01, z))])
    mesh.to_mesh(data)
    mesh.free()
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
