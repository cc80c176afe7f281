# SPDX-License-Identifier: GPL-3.0-or-later
"""Words and buttons as artists meet them: what is called how, and what a message tells them to press."""

import re
from pathlib import Path
from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from inside import inner, notes_of, use_threads
from mathutils import Matrix
from registry import METHODS, other_values
from rigs import rig as scenes
from rigs.cages import ball, box, surround
from rigs.sheet import WIDE, Sheet, draw, draw_panel


def test_the_menu_of_methods_is_headed_by_what_artists_move():
    items = inner.properties.method_items()
    assert [item[1] for item in items if not item[0]][:2] == ["Handles", "Cages"]
    heading, found = "", {}
    for name, label, *_rest in items:
        if name:
            found[name] = heading
        else:
            heading = label
    assert found == {method.id: method.control.value for method in METHODS}


def test_a_row_is_called_after_its_task_and_follows_it(plate: scenes.Rig):
    plate.bind("thin_shell")
    assert plate.deformer.name == "Sheet"
    plate.deformer.method = "arap"
    assert plate.deformer.name == "Limb"
    bpy.ops.sinew.deformer_add(method="thin_shell")
    bpy.ops.sinew.deformer_add(method="thin_shell")
    names = [deformer.name for deformer in plate.obj.sinew.deformers]
    assert names == ["Limb", "Sheet", "Sheet 2"]
    plate.obj.sinew.deformers[2].method = "arap"
    assert plate.obj.sinew.deformers[2].name == "Limb 2"


def test_a_row_that_was_renamed_keeps_its_name(plate: scenes.Rig, tmp_path: Path):
    plate.bind("thin_shell")
    plate.deformer.name = "Face"
    plate.deformer.method = "arap"
    assert plate.deformer.name == "Face"
    scenes.reopen(tmp_path / "named.blend")
    plate.deformer.method = "thin_shell"
    assert plate.deformer.name == "Face"


@pytest.mark.parametrize(
    "given", ["Cage", "Sinew", "Cage.002", "Mean Value Cage", "Quick Cage.001", "Parts 3"]
)
def test_a_row_that_an_earlier_build_named_follows_its_method(given: str):
    deformer = surround(ball(), box())
    assert deformer.name == "Cage"
    deformer.name = given
    deformer.method = "ffd"
    assert deformer.name == "Box"


@pytest.mark.parametrize("index", [-1, 0])
@pytest.mark.parametrize("saved", [False, True])
def test_new_control_takes_over_where_one_was_lost(
    plate: scenes.Rig, tmp_path: Path, index: int, saved: bool
):
    plate.bind()
    turned = Matrix.Translation((0.1, 0.2, 0.5)) @ Matrix.Rotation(0.4, 4, "X") @ Matrix.Scale(1.2, 4)
    scenes.move_world(plate.control, turned)
    before = plate.points()
    assert not bpy.ops.sinew.control_new.poll()
    bpy.data.objects.remove(plate.control)
    scenes.update()
    if saved:
        scenes.reopen(tmp_path / "lost.blend")
    scenes.make_active(plate.obj)
    assert "sinew.control_new" in draw_panel().operator_names()
    assert bpy.ops.sinew.control_new(index=index) == {"FINISHED"}
    assert plate.control.name == "Plate Top"
    assert plate.deformer.handles[0].owns_control
    assert not plate.deformer.handles[0].control_missing
    assert bpy.context.selected_objects == [plate.control]
    assert np.abs(plate.points() - before).max() < 1e-5
    plate.lift(0.25)
    assert np.abs(plate.points()[plate.top] - before[plate.top] - (0.0, 0.0, 0.25)).max() < 1e-5
    plate.control.matrix_basis = Matrix.Identity(4)
    assert np.abs(plate.points() - plate.rest()).max() < 1e-5, "Alt G brings it to rest"


def test_a_lost_bone_gets_an_empty_too(plate: scenes.Rig):
    armature = scenes.add_armature(plate.obj)
    plate.obj.modifiers.remove(plate.obj.modifiers["Armature"])
    plate.bind(control_object="Rig", bone="high")
    with scenes.in_mode(armature):
        armature.data.edit_bones.remove(armature.data.edit_bones["high"])
    scenes.press(plate.obj, "control_new")
    handle = plate.deformer.handles[0]
    assert (handle.control.type, handle.bone, handle.control_missing) == ("EMPTY", "", False)
    assert armature.name in bpy.data.objects


@pytest.mark.parametrize(
    ("is_there", "said"),
    [(False, "is not on the mesh - pick another"), (True, "has no vertices - assign some")],
)
def test_a_region_without_vertices_is_left_out_and_the_others_go_on(
    plate: scenes.Rig, is_there: bool, said: str
):
    scenes.add_group(plate.obj, "Side", lambda point: point[0] > 0.75 and abs(point[1]) < 0.3)
    plate.bind()
    scenes.press(plate.obj, "handle_add", kind="FIXED", vertex_group="Side")
    plate.lift(0.5)
    held, groups = plate.points(), plate.obj.vertex_groups
    if is_there:
        groups["Side"].remove(range(121))
    else:
        groups.remove(groups["Side"])
    scenes.press(plate.obj, "bind")
    assert plate.deformer.status_level == "INFO"
    assert notes_of(plate.deformer) == [f"Side is not used: its vertex group 'Side' {said}"]
    assert "1 handle, 1 still" in plate.deformer.status
    shown = plate.points()
    assert np.abs(shown[plate.top] - plate.rest()[plate.top] - (0.0, 0.0, 0.5)).max() < 1e-5
    assert np.abs(shown - held).max() > 0.01, "the side is free now"
    for name in ("Top", "Base"):
        groups.remove(groups[name])
    scenes.refused("'Top' is not on the mesh", "bind", plate.obj)


def test_the_report_after_add_handle_is_the_state_after_it(plate: scenes.Rig, capfd: pytest.CaptureFixture):
    scenes.make_active(plate.obj)
    for kind, group in (("HANDLE", "Top"), ("FIXED", "Base")):
        capfd.readouterr()
        bpy.ops.sinew.handle_add(kind=kind, vertex_group=group)
        assert f"Info: {group}: {plate.deformer.status}" in capfd.readouterr().out
    assert "1 handle, 1 still" in plate.deformer.status


def test_nothing_is_reported_of_a_bind_that_a_thread_still_computes(plate: scenes.Rig, monkeypatch):
    """The report comes when the thread has ended, and tells the state then."""
    use_threads(monkeypatch)
    waiting, said = inner.waiting, []

    class Operator(waiting.BindingOperator):
        def report(self, levels: set[str], text: str) -> None:
            said.append((levels, text))

    operator = Operator()
    deformer = inner.deformers.add_deformer(plate.obj, "thin_shell")
    region = inner.handles.NewRegion("FIXED", "Base")
    handle, refusal = inner.rigging.rig_region(plate.obj, region, wait=False)
    operator.report_bind(refusal, deformer.uid, handle.name)
    assert inner.binding.job(deformer.uid) is not None
    assert not said
    inner.binding.job(deformer.uid).thread.join()
    operator._uid = deformer.uid
    inner.housekeeping.collect()
    assert operator.look(bpy.context, is_cancelled=False) == {"FINISHED"}
    assert said == [({"INFO"}, f"Base: {deformer.status}")]
    assert "1 still, bound in" in deformer.status


@pytest.mark.parametrize(
    ("kinds", "said"),
    [
        (("HANDLE",), "1 handle"),
        (("HANDLE", "HANDLE"), "2 handles"),
        (("FIXED",), "1 still"),
        (("HANDLE", "FIXED"), "1 handle, 1 still"),
        (("HANDLE", "SUPPORT"), "1 handle, 1 free area"),
    ],
)
def test_the_status_counts_regions_by_their_role(plate: scenes.Rig, kinds, said: str):
    for kind, group in zip(kinds, ("Top", "Base"), strict=False):
        scenes.press(plate.obj, "handle_add", kind=kind, vertex_group=group)
    assert re.match(rf"121 vertices, {said}, bound in", plate.deformer.status), plate.deformer.status


def test_a_time_is_never_nothing():
    said = {0.0: "less than 0.1 ms", 0.04: "less than 0.1 ms", 0.4: "0.4 ms", 41.0: "41 ms", 2100.0: "2.1 s"}
    assert {milliseconds: inner.binding.duration(milliseconds) for milliseconds in said} == said


def cancelled(plate: scenes.Rig, monkeypatch) -> None:
    use_threads(monkeypatch)
    inner.bind.bind(plate.obj, plate.deformer, wait=False)
    inner.binding.cancel(plate.deformer.uid)


@pytest.mark.parametrize(
    ("spoil", "press", "words"),
    [
        (cancelled, "", {}),
        (lambda *_given: bpy.ops.sinew.unbind(), "", {}),
        (lambda plate, _patch: plate.obj.modifiers.clear(), "apply", {}),
        (lambda plate, _patch: plate.obj.modifiers.clear(), "bake", {"target": "SHAPE_KEYS"}),
        (lambda *_given: bpy.ops.sinew.unbind(), "bake", {"target": "SHAPE_KEYS"}),
    ],
)
def test_a_message_names_the_button_as_it_reads(
    bound_plate: scenes.Rig, monkeypatch, spoil, press: str, words: dict
):
    """The status, or the refusal of another button."""
    scenes.make_active(bound_plate.obj)
    spoil(bound_plate, monkeypatch)
    text = bound_plate.deformer.status
    if press:
        with pytest.raises(RuntimeError) as refusal:
            getattr(bpy.ops.sinew, press)(**words)
        text = str(refusal.value)
    said = re.search(r"press (Rebind|Bind)\b", text)
    buttons = [
        keywords["text"]
        for name, args, keywords, _settings in draw(bpy.types.SINEW_PT_order).calls
        if name == "operator" and args == ("sinew.bind",)
    ]
    assert said[1] == buttons[-1]


def test_a_place_that_is_not_a_number_is_not_called_a_scale_of_zero(bound_plate: scenes.Rig):
    bound_plate.control.location.x = float("nan")
    scenes.update()
    assert bound_plate.deformer.status_level == "ERROR"
    assert bound_plate.deformer.status.startswith("The control of Top has a location, rotation or scale")
    bound_plate.control.location.x = 0.0
    scenes.update()
    assert bound_plate.deformer.status_level == "INFO"
    bound_plate.obj.location.y = float("nan")
    scenes.update()
    assert "not a number" in bound_plate.deformer.status
    bound_plate.obj.location.y = 0.0
    bound_plate.control.scale = (0.0, 1.0, 1.0)
    scenes.update()
    assert "scaled to zero" not in bound_plate.deformer.status, "a region may be made flat"


def test_an_error_of_the_library_names_the_handle(plate: scenes.Rig):
    """A file may hold a weight that Blender's own interface refuses."""
    plate.bind()
    binding, errors = inner.binding, inner.errors
    request = inner.kind.request(
        plate.deformer, plate.deformer.rest, inner.mesh_io.read_rest(plate.deformer.rest), (), 121
    )
    refused = errors.ConstraintError("handle 1: weights outside [0, 1] at vertices 3, 4; see handle 0")
    text = str(binding._with_selectable(refused, request))
    assert text == "Base: weights outside [0, 1] at vertices 3, 4; see Top"


def test_the_arrow_of_a_row_makes_the_row_active(bound_plate: scenes.Rig):
    scenes.make_active(bound_plate.obj)
    for mode in ("WEIGHT_PAINT", "EDIT", "OBJECT"):
        bpy.ops.object.mode_set(mode=mode)
        bound_plate.deformer.active_handle = 1
        bpy.ops.sinew.select_handle(index=0)
        assert (bound_plate.deformer.active_handle, bound_plate.obj.mode) == (0, mode)
        assert bound_plate.obj.vertex_groups.active.name == "Top"
    assert bpy.context.view_layer.objects.active == bound_plate.control, "in Object Mode, the last one"
    assert inner.operators.target_of(bpy.context) == bound_plate.obj
    assert "Shape a Sheet" in draw_panel().texts()


def from_selection(plate: scenes.Rig, name: str = "") -> None:
    """A handle, as Edit Mode makes it: its group and its empty are made for it."""
    with scenes.in_mode(plate.obj):
        bpy.ops.mesh.select_all(action="DESELECT")
        plate.obj.vertex_groups.active = plate.obj.vertex_groups["Top"]
        bpy.ops.object.vertex_group_select()
        bpy.ops.sinew.handle_add(kind="HANDLE", handle_name=name)
    scenes.update()


def test_renaming_a_row_renames_what_was_made_for_it(plate: scenes.Rig, tmp_path: Path):
    from_selection(plate)
    plate.lift(0.5)
    before, handle = plate.points(), plate.deformer.handles[0]
    plate.deformer.mask_group = "Handle"
    plate.deformer.mask_group = ""
    for name in ("Head", "Ear.L"):
        plate.deformer.handles[0].name = name
        handle = plate.deformer.handles[0]
        assert (handle.name, handle.vertex_group, handle.control.name) == (name, name, f"Plate {name}")
        assert name in plate.obj.vertex_groups
        assert np.array_equal(plate.points(), before)
        assert plate.deformer.status_level == "INFO", plate.deformer.status
    assert [group.name for group in plate.obj.vertex_groups] == ["Top", "Base", "Ear.L"]
    scenes.reopen(tmp_path / "renamed.blend")
    assert np.abs(plate.points() - before).max() < 1e-6
    plate.deformer.handles[0].name = "Nose"
    assert plate.deformer.handles[0].vertex_group == "Nose"
    scenes.press(plate.obj, "bind")


def test_what_has_a_name_of_its_own_keeps_it(plate: scenes.Rig):
    from_selection(plate)
    handle = plate.deformer.handles[0]
    handle.control.name = "Mine"
    handle.vertex_group = "Top"
    handle.name = "Head"
    assert (handle.vertex_group, handle.control.name) == ("Top", "Mine")
    assert "Handle" in plate.obj.vertex_groups
    plate = scenes.Rig(scenes.grid_object("Second")).bind()
    plate.deformer.handles[0].name = "Head"
    assert plate.deformer.handles[0].vertex_group == "Top", "an armature may go by it"
    assert plate.control.name == "Second Head"


def test_a_copy_keeps_the_names_of_its_groups(plate: scenes.Rig):
    from_selection(plate)
    copy = scenes.linked(plate.obj.copy())
    copy.data = plate.obj.data.copy()
    scenes.update()
    inner.deferred.catch_up()
    plate.deformer.handles[0].name = "Head"
    scenes.make_active(copy)
    assert copy.sinew.active.handles[0].vertex_group == "Handle"
    copy.sinew.active.method = "thin_shell"
    scenes.update()
    assert not any("not used" in note for note in notes_of(copy.sinew.active))
    assert copy.sinew.active.status_level == "INFO", copy.sinew.active.status


@pytest.mark.parametrize("method", [method.id for method in METHODS])
def test_a_preset_brings_the_parameters_back(plate: scenes.Rig, method: str):
    scenes.press(plate.obj, "deformer_add", method=method)
    values, definition = plate.deformer.parameters, plate.deformer.definition
    defaults = {row.id: getattr(values, row.id) for row in definition.parameters}
    assert bpy.ops.sinew.preset_add(name="First") == {"FINISHED"}
    (folder,) = bpy.utils.preset_paths(f"sinew/{method}")
    path = Path(folder) / "First.py"
    others = {row.id: other_values(row) for row in definition.parameters}
    for name, different in others.items():
        for value in different:
            if value != defaults[name]:
                setattr(values, name, value)
    changed = {name for name in others if getattr(values, name) != defaults[name]}
    assert changed == {name for name in others if others[name]}
    assert bpy.ops.sinew.preset_apply(filepath=str(path)) == {"FINISHED"}
    assert defaults == {row.id: getattr(values, row.id) for row in definition.parameters}
    assert bpy.ops.sinew.preset_add(name="First", remove_name=True) == {"FINISHED"}
    assert not path.exists()


def test_a_preset_is_applied_where_a_control_is_active(plate: scenes.Rig):
    plate.bind("thin_shell")
    scenes.make_active(plate.control)
    plate.deformer.parameters.bending = 0.5
    bpy.ops.sinew.preset_add(name="Half")
    plate.deformer.parameters.bending = 1.0
    path = Path(bpy.utils.preset_paths("sinew/thin_shell")[0]) / "Half.py"
    bpy.ops.sinew.preset_apply(filepath=str(path))
    assert plate.deformer.parameters.bending == 0.5
    path.unlink()


def test_the_panel_offers_presets(bound_plate: scenes.Rig):
    sheet = Sheet()
    header = SimpleNamespace(layout=sheet, help_page=lambda _context: "start")
    bpy.types.SINEW_PT_advanced.draw_header_preset(header, bpy.context)
    found = [keywords for name, _args, keywords, _settings in sheet.calls if name == "popover"]
    assert [keywords["panel"] for keywords in found] == [inner.ids.Panels.PRESETS]


def test_a_copied_modifier_says_what_to_do(bound_plate: scenes.Rig):
    other = scenes.grid_object("Other")
    scenes.make_active(bound_plate.obj, other)
    bpy.ops.object.make_links_data(type="MODIFIERS")
    scenes.make_active(other)
    assert [modifier.type for modifier in other.modifiers] == ["NODES"]
    said = draw_panel(WIDE).texts()
    assert "was copied from another object" in said
    assert "remove it" in said
    bpy.ops.object.modifier_remove(modifier=other.modifiers[0].name)
    assert "copied" not in draw_panel(WIDE).texts()
    scenes.make_active(bound_plate.obj)
    assert "copied" not in draw_panel(WIDE).texts()


@pytest.mark.parametrize("kind", ["handles", "cage"])
def test_nothing_is_printed_when_a_script_deletes_what_is_deformed(kind: str, capfd, tmp_path: Path):
    if kind == "cage":
        target, controls = ball(), [box()]
        surround(target, controls[0])
    else:
        plate = scenes.Rig.plate().bind()
        target, controls = plate.obj, [plate.control]
    scenes.update()
    capfd.readouterr()
    bpy.data.objects.remove(target)
    scenes.update()
    for control in controls:
        bpy.data.objects.remove(control)
    scenes.update()
    bpy.context.scene.frame_set(3)
    scenes.reopen(tmp_path / "deleted.blend")
    said = "".join(capfd.readouterr()).splitlines()
    assert not [line for line in said if line and not re.search("Info: (Total|Saved)|Read b", line)], said


def test_after_tab_the_control_is_active_and_the_panel_stays(plate: scenes.Rig):
    scenes.make_active(plate.obj)
    scenes.push("start")
    from_selection(plate)
    scenes.push("Tab")
    assert bpy.context.mode == "OBJECT"
    assert bpy.context.view_layer.objects.active == plate.control
    assert bpy.context.selected_objects == [plate.control]
    assert inner.operators.target_of(bpy.context) == plate.obj
    bpy.context.object.location.z += 0.5  # as a number typed into the Item tab
    assert plate.points()[plate.top, 2] == pytest.approx(0.5, abs=1e-5)
    assert plate.obj.location.z == 0.0
    scenes.push("moved")
    bpy.ops.ed.undo()
    scenes.update()
    assert bpy.context.view_layer.objects.active == plate.control


def test_the_arrow_in_the_modifiers_tab_leaves_the_tab_where_it_is(bound_plate: scenes.Rig):
    scenes.make_active(bound_plate.obj)
    window = bpy.context.window_manager.windows[0]
    area = window.screen.areas[0]
    area.type = "PROPERTIES"
    with bpy.context.temp_override(window=window, area=area):
        bpy.ops.sinew.select_handle(index=0)
    assert bpy.context.view_layer.objects.active == bound_plate.obj
    assert bpy.context.selected_objects == [bound_plate.control]


def test_the_mesh_stays_active_where_the_artist_selects_it_again(plate: scenes.Rig):
    with scenes.in_mode(plate.obj):
        bpy.ops.mesh.select_all(action="SELECT")
        bpy.ops.sinew.handle_add(kind="FIXED")
    scenes.update()
    assert bpy.context.view_layer.objects.active == plate.obj


def test_the_panel_stays_with_its_mesh_where_a_control_moves_two():
    first, second = scenes.Rig.plate(), scenes.Rig(scenes.grid_object("Second"))
    first.bind()
    scenes.press(
        second.obj, "handle_add", kind="HANDLE", vertex_group="Top", control_object=first.control.name
    )
    assert bpy.context.view_layer.objects.active == first.control
    assert inner.operators.target_of(bpy.context) == second.obj
    scenes.press(first.obj, "select_handle", index=0)
    assert inner.operators.target_of(bpy.context) == first.obj
