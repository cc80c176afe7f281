# SPDX-License-Identifier: GPL-3.0-or-later
"""What a bind costs in captures of the mesh, and that its refusal is shown once: counted in calls."""

from collections import Counter
from collections.abc import Callable

import bpy
import pytest
from inside import BINDING, ask_for_factor, calls_of, catch_up, room, use_threads
from rig import Rig, make_active, update

CAPTURE = "_rest_mesh"  # evaluates a copy of the object and makes a mesh of it


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


def test_renders_with_other_vertices_cost_one_capture_more(plate: Rig):
    modifier = plate.obj.modifiers.new("Subdivision", "SUBSURF")
    modifier.levels, modifier.render_levels = 0, 1
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
    plate.deformer.handles[0].vertex_group = "Nowhere"
    update()


def by_a_thread(plate: Rig) -> None:
    plate.deformer.method = "arap"
    ask_for_factor(plate.deformer)
    room("session").job(plate.deformer.uid).thread.join()
    catch_up()


def by_the_user(plate: Rig) -> None:
    plate.deformer.method = "arap"
    ask_for_factor(plate.deformer)
    room("session").cancel(plate.deformer.uid)


@pytest.mark.parametrize("refused", [by_an_operator, by_an_evaluation, by_a_thread, by_the_user])
def test_a_refusal_is_shown_by_one_call(
    plate: Rig, monkeypatch: pytest.MonkeyPatch, refused: Callable[[Rig], None]
):
    plate.bind("thin_shell").lift(0.1)
    if refused in (by_a_thread, by_the_user):
        use_threads(monkeypatch)
        monkeypatch.setattr(room(BINDING), "build_factor", refuse)
    found = calls_of(lambda: refused(plate))
    assert found["fail"] == 1, found
    assert plate.deformer.status_level == "ERROR"


def refuse(*_arguments: object, **_options: object) -> None:
    """Stands in for a native call."""
    raise room("core.errors").SinewError("Refused")
