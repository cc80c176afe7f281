# SPDX-License-Identifier: GPL-3.0-or-later
"""Try It: rigs open beside what the artist works on, their steps tick, and Back leaves nothing behind."""

from collections.abc import Callable

import bpy
import numpy as np
import pytest
from inside import inner
from registry import METHODS
from rigs import rig as scenes
from rigs.sheet import draw_panel

TICK = "CHECKBOX_HLT"
AHEAD = {"origin": (0.0, -5.0, 1.85), "direction": (0.0, 1.0, 0.0)}


def run(operator: str, **options: object) -> None:
    assert getattr(bpy.ops.sinew, operator)(**options) == {"FINISHED"}
    scenes.update()


def blocks() -> set[tuple[str, str]]:
    return {(type(block).__name__, block.name_full) for block in bpy.data.user_map()}


def ticks() -> int:
    return sum(words.get("icon") == TICK for _name, _args, words, _settings in draw_panel().calls)


def button(operator: str, **options: object) -> Callable[[], None]:
    return lambda: run(operator, **options)


def pull_the_elbow() -> None:
    arm = bpy.context.object
    lowest = min(
        scenes.apply_matrix(arm.matrix_world, scenes.evaluated_points(arm)), key=lambda place: place[2]
    )
    below = {"origin": lowest - (0.0, 0.0, 1.0), "direction": (0.0, 0.0, 1.0)}
    run("drag", value=(0.05, 0.0, -0.1), radius=0.1, reach=3.0, **below)


def move_a_point(control: str) -> Callable[[], None]:
    return button("control_drag", control=control, point=1, value=(0.0, 0.0, 0.1))


def go_back_in_time() -> None:
    bpy.context.scene.frame_set(10)


def widen() -> None:
    bpy.context.object.sinew.active.controls[0].radius = 0.2
    scenes.update()


def pin_a_foot() -> None:
    scenes.select_bone(bpy.context.object, "foot.L")
    run("puppet_pin", action="PIN")


RESET = button("reset_pose")
STEPS: dict[str, tuple[Callable[[], None], ...]] = {
    "limb": (
        button("drag", value=(0.3, 0.0, -0.1), **AHEAD),
        button("use_method", method="subspace_laplacian"),
        RESET,
    ),
    "joint": (button("start_task", task="joint"), pull_the_elbow, go_back_in_time),
    "lines": (move_a_point("Brow.L"), widen, RESET),
    "cage": (move_a_point("Cow Cage"), button("use_method", method="green"), RESET),
    "figure": (button("puppet_pose", bone="hand.L", value=(-0.2, 0.0, 0.3)), pin_a_foot, RESET),
}


@pytest.mark.parametrize("rig", STEPS)
def test_a_rig_opens_ticks_and_goes_without_a_trace(rig: str):
    own = scenes.grid_object()
    scenes.press(own, "deformer_add", method="arap")
    bpy.data.meshes.new("Not used")
    came_from, before = bpy.context.scene, blocks()
    run("try_it", rig=rig)
    assert bpy.context.scene != came_from
    assert own.name not in bpy.context.scene.objects
    steps = inner.core_rigs.RIG_BY_ID[rig].steps
    text = draw_panel().texts()
    assert all(word in text for step in steps for word in step.shown.split())
    assert ticks() == 0
    for number, step in enumerate(STEPS[rig]):
        step()
        assert ticks() == number + 1
        for deformer in bpy.context.object.sinew.deformers:
            assert deformer.status_level in {"", "INFO"}, deformer.status
    run("try_back")
    assert (bpy.context.scene, bpy.context.mode) == (came_from, "OBJECT")
    assert blocks() == before


def test_all_rigs_in_a_row_beside_objects_of_the_same_names(tmp_path):
    for rig in inner.core_rigs.RIGS:
        bpy.data.scenes.new(rig.label)
        for name in rig.objects:
            bpy.context.scene.collection.objects.link(bpy.data.objects.new(name, None))
    came_from, before = bpy.context.scene.name, blocks()
    for rig in inner.core_rigs.RIGS:
        run("try_it", rig=rig.id)
        assert [scene.name for scene in bpy.data.scenes if scene.sinew.rig] == [bpy.context.scene.name]
        assert all(row.is_bound for obj in bpy.context.scene.objects for row in obj.sinew.deformers)
    STEPS["figure"][0]()
    scenes.reopen(tmp_path / "tried.blend")
    run("try_back")
    assert bpy.context.scene.name == came_from
    assert blocks() == before


def test_what_the_artist_takes_along_stays():
    came_from = bpy.context.scene
    run("try_it", rig="limb")
    pillar = bpy.context.object
    came_from.collection.objects.link(pillar)
    run("try_back")
    assert [obj.name for obj in bpy.context.scene.objects] == [pillar.name]
    assert pillar.sinew.active.handles[0].control is not None
    scenes.refused("none that Try It has opened", "try_back")


def test_a_scene_that_is_gone_is_replaced():
    came_from = bpy.context.scene
    run("try_it", rig="joint")
    bpy.data.scenes.remove(came_from)
    run("try_back")
    assert [scene.sinew.rig for scene in bpy.data.scenes] == [""]


def test_a_rig_that_is_missing_is_said_and_nothing_changes(monkeypatch, tmp_path):
    monkeypatch.setattr(inner.try_it, "_FOLDER", tmp_path)
    came_from, before = bpy.context.scene, blocks()
    scenes.refused("missing or damaged", "try_it")
    (tmp_path / "limb.blend").write_bytes(b"no file of Blender")
    scenes.refused("missing or damaged", "try_it")
    assert (bpy.context.scene, blocks()) == (came_from, before)


def test_the_offer_is_hidden_for_good(preferences):
    def offered() -> bool:
        return "SINEW_MT_try_it" in draw_panel().menus()

    assert offered()
    scenes.make_active(scenes.grid_object())
    assert offered()
    preferences.show_try_it = False
    assert not offered()
    assert bpy.context.preferences.is_dirty
    preferences.show_try_it = True


@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.id)
def test_templates_set_values_that_the_method_takes(method):
    plate = scenes.Rig(scenes.grid_object())
    scenes.press(plate.obj, "deformer_add", method=method.id)
    method, values = plate.deformer.methods[-1]  # of one that keeps details, the base
    fitting = 0
    for template in inner.templates.TEMPLATES:
        wanted = inner.templates.values_of(template, method)
        if not wanted:
            scenes.refused("has no settings like", "use_template", plate.obj, template=template.id)
            continue
        scenes.press(plate.obj, "use_template", template=template.id)
        for name, value in wanted.items():
            found = getattr(values, name)
            assert found == value if isinstance(value, bool | str) else np.isclose(found, value)
        fitting += 1
    assert fitting != 1  # with one there is no choice
