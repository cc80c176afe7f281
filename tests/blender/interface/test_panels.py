# SPDX-License-Identifier: GPL-3.0-or-later
"""What the panels show in each situation: few buttons, no label cut, the right page, nothing looked up."""

from collections.abc import Callable
from pathlib import Path

import bpy
import pytest
import situations
from inside import READS, calls_of, catch_up, inner
from libraries import put_into_a_library, read
from registry import METHODS
from rigs.point_objects import text
from rigs.puppets import figure
from rigs.rig import Rig, linked, make_active, new_file, on_all, save, update
from rigs.sheet import NARROW, draw_panel
from ruler import Label, buttons, cut, measured, measured_panel

TAB = 238  # pixels: the Properties editor of the factory layout, in a window of 1600


def waiting() -> None:
    """For a press on the surface."""
    MADE["a posed mesh"]()
    bpy.ops.sinew.start_task(task="joint")


def counted(many: bool = False) -> None:
    """An open sheet; or as many of them as nobody would take for one thing."""
    plate = Rig.plate()
    make_active(plate.obj)
    if many:
        on_all(plate.obj, bpy.ops.mesh.edge_split)
    inner.traits.count(plate.obj.data)


def file_is_missing() -> None:
    """Of a bake."""
    situations.handles()
    save(Path(bpy.app.tempdir) / "shot.blend")
    bpy.context.scene.frame_end = 2
    bpy.ops.sinew.bake(target="PC2")
    Path(bpy.path.abspath(bpy.context.object.sinew.active.bake.filepath)).unlink()
    assert "missing" not in draw_panel().texts()  # nobody has looked yet
    catch_up()


def posing_a_cage() -> None:
    situations.cage()
    assert bpy.ops.sinew.control_edit() == {"FINISHED"}
    assert bpy.context.mode == "EDIT_MESH"


def changed() -> None:
    """The mesh has other vertices than at bind."""
    situations.handles()
    bpy.context.object.sinew.active.auto_rebind = False
    on_all(bpy.context.object, bpy.ops.mesh.subdivide)
    update()


MADE = situations.SITUATIONS
# By name: what makes it, the most buttons of the main panel, and the page of its question mark.
SITUATIONS: dict[str, tuple[Callable[[], object], int, str]] = {
    "nothing": (lambda: None, 2, "start"),
    "a mesh": (MADE["a mesh"], 5, "start"),
    "a posed mesh": (MADE["a posed mesh"], 5, "correct-an-elbow"),
    "a sheet": (counted, 5, "shape-a-sheet"),
    "loose parts": (lambda: counted(many=True), 5, "move-loose-parts"),
    "a text": (MADE["a text"], 5, "move-loose-parts"),
    "hair": (MADE["hair"], 5, "move-loose-parts"),
    "a lattice object": (MADE["a lattice object"], 5, "move-loose-parts"),
    "a mesh in Edit Mode": (MADE["a mesh in Edit Mode"], 5, "start"),
    "Sculpt Mode": (lambda: situations.handles(mode="SCULPT"), 2, "start"),
    "handles": (MADE["handles"], 6, "shape-a-sheet"),
    "handles in Edit Mode": (MADE["handles in Edit Mode"], 11, "shape-a-sheet"),
    "handles in Weight Paint": (MADE["handles in Weight Paint"], 6, "shape-a-sheet"),
    "handle points": (MADE["handle points"], 6, "move-loose-parts"),
    "a lost control": (MADE["a lost control"], 8, "troubles"),
    "other vertices": (changed, 8, "troubles"),
    "a cage": (MADE["a cage"], 6, "wrap-in-a-cage"),
    "a cage in Edit Mode": (posing_a_cage, 6, "wrap-in-a-cage"),
    "a cage inside out": (MADE["a cage inside out"], 8, "troubles"),
    "a lattice": (MADE["a lattice"], 6, "put-in-a-box"),
    "a wire": (MADE["a wire"], 8, "brows-and-folds"),
    "tools": (MADE["tools"], 8, "push-like-clay"),
    "keys": (MADE["keys"], 10, "edit-an-animation"),
    "a morph": (lambda: situations.handles("pyramid_coordinates"), 6, "morph-and-copy"),
    "baked": (MADE["baked"], 8, "bake"),
    "a missing file": (file_is_missing, 8, "troubles"),
    "a puppet": (MADE["a puppet"], 6, "pose-by-bones"),
    "an armature": (lambda: make_active(figure()), 2, "pose-by-bones"),
    "a skin": (MADE["a skin"], 7, "pose-by-bones"),
    "a task that waits": (waiting, 6, "correct-an-elbow"),
    "two deformers": (MADE["two deformers"], 8, "bend-a-limb"),
    "a rig to try": (MADE["a rig to try"], 10, "brows-and-folds"),
}


def begin(name: str) -> None:
    new_file()
    SITUATIONS[name][0]()


def all_labels(width: int, region: str) -> list[Label]:
    return [label for cls in situations.panels() for label in measured_panel(cls, width, region)]


@pytest.mark.parametrize("name", SITUATIONS)
def test_each_situation_has_few_buttons_whole_labels_and_its_page(name):
    begin(name)
    _make, most, page = SITUATIONS[name]
    shown = buttons(measured_panel(bpy.types.SINEW_PT_sinew, NARROW))
    assert len(shown) <= most, shown
    assert not cut(all_labels(NARROW, "UI"))
    assert not cut(all_labels(TAB, "WINDOW"))
    assert inner.situations.situation_of(bpy.context).page(bpy.context) == page


def test_a_linked_object_has_one_button(bound_plate: Rig, tmp_path: Path):
    path = put_into_a_library(tmp_path / "library.blend", bound_plate.obj)
    make_active(linked(read(path, True, "objects", "Plate")))
    labels = measured_panel(bpy.types.SINEW_PT_sinew, NARROW)
    assert buttons(labels) == ["Override to Pose It"]
    assert not cut(labels)
    sheet = draw_panel()
    assert sheet.operator_names() == ["object.make_override_library"]
    assert "Linked from library.blend" in sheet.texts()


def test_no_label_of_a_setting_is_cut(plate: Rig):
    """Of all methods. Where labels stood beside their fields, many were."""
    bpy.ops.sinew.deformer_add()
    deformer = plate.obj.sinew.active
    draw, beside = inner.parameters.draw_parameter, 0
    for method in METHODS:
        for parameter in method.parameters:
            values = getattr(deformer, method.id)
            assert not cut(measured(lambda *where: draw(*where, values, parameter), NARROW))  # noqa: B023
            beside += Label("prop", parameter.label, 55).is_cut
        for parameter in (*method.handle_parameters, *method.control_parameters):
            assert not Label("prop", parameter.label, 168 - 75).is_cut
    assert beside > 15


SUGGESTED = {
    "a mesh": ["Put in a Box", "Wrap in a Cage"],
    "a posed mesh": ["Correct a Joint", "Pose by Bones", "Wrap in a Cage"],
    "a sheet": ["Shape a Sheet", "Put in a Box", "Wrap in a Cage"],
    "loose parts": ["Move Loose Parts", "Shape a Sheet", "Put in a Box"],
    "a text": ["Move Loose Parts", "Put in a Box"],
}


@pytest.mark.parametrize("name", SUGGESTED)
def test_what_is_suggested_depends_on_what_is_selected(name):
    begin(name)
    labels = {task.label for task in inner.tasks.TASKS}
    shown = buttons(measured_panel(bpy.types.SINEW_PT_sinew, NARROW))
    assert [label for label in shown if label in labels] == SUGGESTED[name]
    shown = shown[shown[0] == "Try It" :]
    assert shown[0] == SUGGESTED[name][0] or shown[0].startswith("Drag ")
    assert shown[-1] == "All Tasks..."


@pytest.mark.parametrize(("name", "step"), [("a skin", "Bones"), ("a task that waits", "the Surface")])
def test_the_tool_for_the_next_step_is_a_button(name: str, step: str):
    begin(name)
    assert f"Drag {step}" in buttons(measured_panel(bpy.types.SINEW_PT_sinew, NARROW))


@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.id)
def test_keep_details_is_a_switch(plate: Rig, method):
    """Which gives the method back; grey where it has nothing to be put around."""
    methods = inner.methods
    if method.wraps or method.control is not methods.Control.HANDLES:
        pytest.skip("it has no such switch")
    deformer = plate.bind(method.id).deformer
    before = [(handle.name, handle.control) for handle in deformer.handles]
    deformer.keep_details = True
    assert deformer.keep_details == (methods.wrapper_of(method) is not None)
    assert deformer.methods[-1][0] is method
    assert ("keep_details" in draw_panel().greyed) != deformer.keep_details
    deformer.keep_details = False
    assert deformer.method == method.id
    assert [(handle.name, handle.control) for handle in deformer.handles] == before


def test_a_twin_that_is_selected_suggests_a_morph():
    one, two = Rig.plate(), Rig.plate()
    make_active(one.obj)
    two.obj.select_set(True)
    assert buttons(measured_panel(bpy.types.SINEW_PT_sinew, NARROW))[0] == "Morph to a Mesh"


@pytest.mark.parametrize("name", ["a mesh", "handles"])
def test_drawing_looks_at_no_vertex(name):
    """A heavy mesh takes the same calls as a light one."""
    begin(name)
    obj = bpy.context.object
    light = calls_of(draw_panel)
    heavy = bpy.data.meshes.new("Heavy")
    heavy.vertices.add(500_000)
    obj.data = heavy
    made = calls_of(draw_panel)
    assert not READS & made.keys()
    assert made["foreach_get"] == light["foreach_get"] == 0
    if name == "a mesh":
        assert made == light


def test_a_click_on_a_row_selects_its_control(plate: Rig):
    plate.bind()
    deformer = plate.deformer
    make_active(plate.obj)
    row = [handle.kind for handle in deformer.handles].index("HANDLE")
    deformer.chosen_handle = row
    assert deformer.active_handle == row
    assert bpy.context.view_layer.objects.active == plate.control
    make_active(plate.obj)
    deformer.active_handle = row  # what scripts set
    assert bpy.context.view_layer.objects.active == plate.obj
    bpy.ops.object.mode_set(mode="EDIT")
    deformer.chosen_handle = row
    assert bpy.context.mode == "EDIT_MESH"


def test_a_baked_file_that_was_moved_is_found_again():
    begin("a missing file")
    texts = draw_panel().texts()
    assert "The baked file" in texts
    assert {"sinew.bake", "sinew.bake_find", "sinew.unbake"} <= set(draw_panel().operator_names())
    moved = Path(bpy.app.tempdir) / "moved.pc2"
    moved.write_bytes(b"POINTCACHE2\0")
    assert bpy.ops.sinew.bake_find(filepath=str(moved)) == {"FINISHED"}
    assert "missing" not in draw_panel().texts()


def test_a_text_in_edit_mode_leaves_it_first():
    make_active(text())
    bpy.ops.object.mode_set(mode="EDIT")
    assert buttons(measured_panel(bpy.types.SINEW_PT_sinew, NARROW)) == ["Object Mode"]
