# SPDX-License-Identifier: GPL-3.0-or-later
"""Tasks: what each starts on a fresh object, why it is grey; the browser, its search, and the menus."""

from collections import Counter
from collections.abc import Callable
from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from editing import edit, selection
from inside import inner
from registry import BY_ID, METHODS
from rigs import rig as scenes
from rigs.cages import ball, box, surround
from rigs.point_objects import text
from rigs.puppets import figure
from rigs.rig_of_curves import polyline
from rigs.sheet import WIDE, DrawContext, Sheet, draw

LINE = np.column_stack((np.linspace(-1.0, 1.0, 6), np.zeros((6, 2))))
TASKS = inner.tasks.TASKS


def far_side(point) -> bool:
    return point.y > 0.9


def grid_in_edit_mode() -> None:
    edit(scenes.grid_object(), far_side)


def posed_by_bones() -> None:
    obj = scenes.grid_object()
    scenes.add_armature(obj)
    scenes.subdivided(obj)
    scenes.make_active(obj)


def in_pose_mode_of_bones() -> None:
    posed_by_bones()
    scenes.in_pose_mode(bpy.data.objects["Rig"], "high", bpy.data.objects["Plate"])


def with_another(make: Callable[[], bpy.types.Object]) -> Callable[[], None]:
    """The plate is active, and what ``make`` makes is selected, too."""

    def prepare() -> None:
        obj = scenes.grid_object()
        scenes.make_active(obj, make())

    return prepare


def caged() -> None:
    cage = box()
    scenes.make_active(ball(), cage)


def body() -> bpy.types.Object:
    """A closed mesh around the bones of a figure."""
    obj = ball("Body")
    obj.scale, obj.location.z = (2.0, 1.0, 2.0), 1.0
    bpy.ops.object.transform_apply()
    return obj


def puppet(active: str) -> Callable[[], None]:
    def prepare() -> None:
        armature, mesh = figure(), body()
        scenes.make_active(*((mesh, armature) if active == "mesh" else (armature, mesh)))

    return prepare


def keyed() -> None:
    obj = scenes.grid_object()
    obj.shape_key_add(name="Basis")
    raised = obj.shape_key_add(name="Raised")
    raised.data[0].co.z = 1.0
    raised.keyframe_insert("value", frame=1)


def letters() -> None:
    scenes.make_active(text())


def twin(points: int = 10) -> Callable[[], bpy.types.Object]:
    return lambda: scenes.grid_object("Twin", points)


# By the task: the scene, and of the deformer that it makes the name, the method, and what moves it
STARTS = {
    "limb": (scenes.grid_object, ("Limb", "arap", set())),
    "limb of a selection": (grid_in_edit_mode, ("Limb", "arap", {"HANDLE"})),
    "joint": (posed_by_bones, ("Joint", "arap", set())),
    "joint in Pose Mode": (in_pose_mode_of_bones, ("Joint", "arap", set())),
    "sheet": (scenes.grid_object, ("Sheet", "thin_shell", {"FIXED"})),
    "sheet of a selection": (grid_in_edit_mode, ("Sheet", "thin_shell", {"FIXED", "HANDLE"})),
    "sheet of a closed body": (ball, ("Sheet", "thin_shell", set())),
    "box": (ball, ("Box", "ffd", {"LATTICE"})),
    "box of a selected lattice": (
        with_another(
            lambda: scenes.linked(bpy.data.objects.new("Lattice", bpy.data.lattices.new("Lattice")))
        ),
        ("Box", "ffd", {"LATTICE"}),
    ),
    "cage": (ball, ("Cage", "mean_value", {"MESH"})),
    "cage of a selected mesh": (caged, ("Cage", "mean_value", {"MESH"})),
    "parts": (letters, ("Parts", "mls", set())),
    "parts of selected empties": (
        with_another(lambda: scenes.new_empty("Empty")),
        ("Parts", "mls", {"HANDLE"}),
    ),
    "lines": (with_another(lambda: polyline(LINE, "Wire")), ("Brows", "wires", {"CURVE"})),
    "lines of selected edges": (grid_in_edit_mode, ("Brows", "wires", {"CURVE"})),
    "clay": (scenes.grid_object, ("Clay", "vector_field", {"EMPTY"})),
    "figure": (puppet("mesh"), ("Figure", "mesh_puppetry", {"HANDLE"})),
    "figure of an active armature": (puppet("armature"), ("Figure", "mesh_puppetry", {"HANDLE"})),
    "animation": (keyed, ("Animation", "mesh_sequence", set())),
    "morph": (with_another(twin()), ("Morph", "pyramid_coordinates", set())),
    "once": (grid_in_edit_mode, None),
}


def moved_by(deformer) -> set[str]:
    return {row.kind for row in deformer.handles} | {row.object.type for row in deformer.all_controls}


def target() -> bpy.types.Object:
    return next(obj for obj in bpy.data.objects if obj.is_property_set("sinew") and obj.sinew.deformers)


def start(name: str, **options: object) -> set[str]:
    return bpy.ops.sinew.start_task(task=name.split()[0], **options)


@pytest.mark.parametrize("name", STARTS)
def test_a_task_starts_on_a_fresh_object(name: str):
    prepare, made = STARTS[name]
    prepare()
    assert start(name) == {"FINISHED"}
    scenes.update()
    if made is None:
        assert not [obj for obj in bpy.data.objects if obj.sinew.deformers], "nothing stays behind"
        return
    (deformer,) = target().sinew.deformers
    assert (deformer.name, deformer.method, moved_by(deformer)) == made
    assert deformer.status_level != "ERROR", deformer.status


def test_every_task_is_started():
    assert {name.split()[0] for name in STARTS} == {task.id for task in TASKS}


@pytest.mark.parametrize("task", [task for task in TASKS if len(task.methods) > 1], ids=lambda task: task.id)
def test_a_task_starts_with_each_of_its_methods(task):
    prepare, _made = STARTS[{"parts": "parts of selected empties"}.get(task.id, task.id)]
    for method in task.methods:
        bpy.ops.object.select_all(action="SELECT")
        bpy.ops.object.delete()
        prepare()
        assert start(task.id, method=method) == {"FINISHED"}
        assert target().sinew.active.method == method
    scenes.refused("has no method 'nonsense'", "start_task", None, task=task.id, method="nonsense")


@pytest.mark.parametrize("task", ["joint", "limb", "sheet"])
def test_a_bend_goes_behind_what_moves_the_mesh_and_before_what_divides_it(task: str):
    posed_by_bones()
    start(task)
    assert [modifier.type for modifier in target().modifiers] == ["ARMATURE", "NODES", "SUBSURF"]


def test_a_joint_is_as_wide_as_its_bone_lies_deep_on_both_sides():
    posed_by_bones()
    start("joint")
    for place, width in (((0.4, 0.5, 0.3), 1.0), ((0.0, 0.5, 0.0), 0.2), ((0.0, 1.6, 0.8), 2.0)):
        assert inner.picking.width_of_joint(target(), np.array(place)) == pytest.approx(width)
    target().sinew.active.name = "Arm"
    assert inner.picking.width_of_joint(target(), np.zeros(3)) is None


def test_the_border_of_a_sheet_holds_still_but_for_what_is_pulled():
    grid_in_edit_mode()
    chosen = np.array(selection(bpy.context.object)[:121])
    start("sheet")
    obj = target()
    held = {handle.kind: handle.vertex_group for handle in obj.sinew.active.handles}
    assert np.array_equal(scenes.members(obj, held["HANDLE"]), np.flatnonzero(chosen))
    assert len(scenes.members(obj, held["FIXED"])) == 40 - chosen.sum(), "the border has 40 vertices"


@pytest.mark.parametrize(
    ("sides", "counts"),
    [((1, 1, 1), (3, 3, 3)), ((2, 1, 1), (5, 3, 3)), ((9, 1, 3), (7, 3, 3)), ((1, 1, 0), (7, 7, 3))],
)
def test_a_lattice_has_more_points_where_it_is_longer(sides: tuple, counts: tuple):
    obj = box("Box")
    obj.scale = sides
    scenes.make_active(obj)
    start("box")
    data = target().sinew.active.controls[0].object.data
    assert (data.points_u, data.points_v, data.points_w) == counts


def test_a_box_takes_all_that_is_selected():
    scenes.make_active(ball("One"), ball("Two"))
    start("box")
    assert all(bpy.data.objects[name].sinew.active.method == "ffd" for name in ("One", "Two"))


@pytest.mark.parametrize(("vertices", "faces"), [(8, 150), (1000, 150), (20_000, 368), (1_000_000, 600)])
def test_a_cage_has_more_faces_around_more_vertices(vertices: int, faces: int):
    obj = SimpleNamespace(data=SimpleNamespace(vertices=range(vertices)))
    assert inner.picking.cage_faces([obj]) == faces


def test_groups_that_overlap_all_over_give_way_to_new_ones():
    puppet("mesh")()
    obj = bpy.data.objects["Body"]
    for name in ("hip", "spine", "chest"):
        obj.vertex_groups.new(name=name).add(range(len(obj.data.vertices)), 0.5, "REPLACE")
    assert start("figure") == {"FINISHED"}
    assert all(handle.owns_group for handle in target().sinew.active.handles)


def test_a_mesh_that_does_not_enclose_is_no_cage():
    aside = box(size=1.0)
    scenes.make_active(ball(), aside)
    start("cage")
    assert target().sinew.active.cage != aside


def test_started_twice_before_anything_is_held_there_is_one_deformer():
    scenes.grid_object()
    start("limb")
    scenes.make_active(target())
    start("limb")
    assert len(target().sinew.deformers) == 1


REFUSALS = {
    "limb": (letters, "Needs a surface: this is a text - use Move Loose Parts"),
    "limb without a selection": (
        lambda: edit(scenes.grid_object(), lambda _point: False),
        "Select the vertices",
    ),
    "joint": (scenes.grid_object, "Nothing moves this mesh yet"),
    "sheet": (letters, "Needs a surface"),
    "box": (lambda: scenes.make_active(scenes.new_empty("Empty")), "Select a mesh object"),
    "lines": (letters, "Needs a curve - select it, and then Text"),
    "figure": (scenes.grid_object, "Needs an armature - select one together with Plate"),
    "animation": (scenes.grid_object, "Nothing before Sinew is keyed or cached"),
    "morph": (scenes.grid_object, "Select the mesh to morph to, and then Plate"),
    "morph to another mesh": (with_another(twin(11)), "Twin has 23 vertices more than Plate"),
    "once": (letters, "Needs a surface"),
}


@pytest.mark.parametrize("name", REFUSALS)
def test_a_task_that_cannot_start_is_grey_and_says_why(name: str):
    prepare, said = REFUSALS[name]
    prepare()
    task = inner.tasks.TASK_BY_ID[name.split()[0]]
    scenes.refused(said, "start_task", None, task=task.id)
    properties = SimpleNamespace(task=task.id, method="")
    tooltip = bpy.types.SINEW_OT_start_task.description(bpy.context, properties)
    assert tooltip.startswith(said.split(" - ")[0])
    popup = shown("SINEW_OT_all_tasks")
    greyed = [text for text, enabled in popup.buttons if not enabled]
    assert task.label in greyed
    assert len(popup.buttons) == len(TASKS), "it never vanishes"


def test_in_sculpt_mode_every_task_says_so():
    scenes.grid_object()
    bpy.ops.object.mode_set(mode="SCULPT")
    for task in TASKS:
        scenes.refused("Leave Sculpt Mode first", "start_task", None, task=task.id)


def shown(name: str, search: str = "") -> Sheet:
    """What a popup draws, with words in its search."""
    cls, sheet = getattr(bpy.types, name), Sheet()
    ours = [base for base in reversed(cls.__mro__) if base.__module__.startswith(inner.ids.__package__)]
    known = {key: value for base in ours for key, value in vars(base).items() if not key.startswith("__")}
    popup = type("Popup", (), known | {"search": search, "layout": sheet})()
    popup.draw(DrawContext(WIDE))
    return sheet


def labels(name: str, search: str = "") -> list[str]:
    """What the popups of all tasks and of the methods offer."""
    return [text for text, _enabled in shown(f"SINEW_OT_{name}", search).buttons]


HANDLE_TASKS = [task for task in TASKS if task.id in ("limb", "sheet", "parts")]
HANDLE_METHODS = [method for task in HANDLE_TASKS for method in task.methods if not BY_ID[method].wraps]


def test_the_browser_has_a_cell_for_each():
    scenes.Rig.plate().bind("arap")
    wanted = {"all_tasks": [task.label for task in TASKS]}
    wanted["choose_method"] = [BY_ID[method].label for method in HANDLE_METHODS]
    for (name, expected), wide in zip(wanted.items(), (114, 83), strict=True):
        assert labels(name) == expected
        assert not [label for label in expected if inner.compat.text_width(label, 11.0) > wide]
    assert inner.compat.text_width("Rotation-Invariant Coordinates", 11.0) > 114, "it measures"


def test_cages_show_the_cages_and_a_lattice_has_nothing_to_choose():
    surround(ball(), box())
    assert labels("choose_method") == ["Quick Cage", "Split Cage", "Limb Cage", "Detail Cage"]
    scenes.make_active(scenes.grid_object())
    assert not bpy.ops.sinew.choose_method.poll()
    start("box")
    assert not bpy.ops.sinew.choose_method.poll()


def test_the_card_tells_all_about_the_chosen_one():
    scenes.Rig.plate().bind("arap")
    card = shown("SINEW_OT_all_tasks")
    assert [what.page for name, what in card.operators() if name == "sinew.help"] == ["methods/arap"]
    said = card.texts()
    for part in (
        "known as As-Rigid-As-Possible",
        "Bends limbs and bodies",
        "Best for: arms, legs",
        "Fails: leaves spikes",
        "Speed: medium, binds Plate in about",
        "Needs: a surface",
    ):
        assert part in said


@pytest.mark.parametrize(
    ("words", "first"),
    [("soft selection", "Rigid Points"), ("DELTA mush", "Correct a Joint"), ("outline", None)],
)
def test_the_search_shows_what_is_found(words: str, first: str | None):
    scenes.grid_object()
    said = shown("SINEW_OT_all_tasks", words).texts()
    assert first in labels("all_tasks", words) if first else "Nothing found" in said


def test_the_search_among_methods_finds_only_those_that_can_be_used():
    scenes.Rig.plate().bind("arap")
    assert "Wires" not in labels("choose_method", "face")
    assert "Smooth Points" in labels("choose_method", "face")


def state(plate: scenes.Rig) -> tuple:
    """Its handles, where their controls are and their keys."""
    rows = [
        (row.name, row.kind, row.vertex_group, row.control and row.control.name)
        for row in plate.deformer.handles
    ]
    return rows, [tuple(line) for line in plate.control.matrix_world], len(scenes.curves_of(plate.control))


def test_switching_keeps_handles_poses_and_keys():
    plate = scenes.Rig.plate(cells=12)
    plate.obj.data.uv_layers.new()
    plate.bind("arap")
    assert len(HANDLE_METHODS) == 20
    scenes.key_heights(plate.control, {1: 0.4, 9: 0.5})
    scenes.make_active(plate.obj)
    before = state(plate)
    for method in HANDLE_METHODS[1:] + HANDLE_METHODS[:1]:
        assert bpy.ops.sinew.use_method(method=method) == {"FINISHED"}
        assert plate.deformer.method == method
        assert state(plate) == before
        assert plate.deformer.status_level != "ERROR", (method, plate.deformer.status)
        assert plate.points()[plate.top][:, 2] == pytest.approx(plate.control.location.z, abs=0.02), method


def test_details_stay_kept_where_another_method_is_chosen():
    plate = scenes.Rig.plate().bind("multiresolution")
    scenes.make_active(plate.obj)
    for method, kept in (("arap", "multiresolution"), ("mls", "multiresolution_space")):
        bpy.ops.sinew.use_method(method=method)
        assert (plate.deformer.method, plate.deformer.parameters.base) == (kept, method)
    bpy.ops.sinew.use_method(method="rigid_cells")
    assert plate.deformer.method == "rigid_cells", "whose details nothing keeps"


def test_methods_that_cannot_be_used_are_grey_and_say_why():
    letters()
    start("parts")
    greyed = {text for text, enabled in shown("SINEW_OT_choose_method").buttons if not enabled}
    assert "Soft Sheet" in greyed
    assert "Smooth Points" not in greyed
    scenes.refused("Needs a surface: this is a text", "use_method", None, method="arap")
    scenes.make_active(scenes.grid_object(), scenes.new_empty("Empty"))
    start("parts")
    scenes.refused("Needs regions", "use_method", None, method="arap")
    scenes.Rig.plate().bind("arap")
    scenes.refused("Needs a UV map", "use_method", None, method="spline_surface")


def test_a_click_on_a_method_is_one_step_back():
    plate = scenes.Rig.plate().bind("arap")
    scenes.make_active(plate.obj)
    scenes.push("bound")
    for method in ("thin_shell", "mls"):
        bpy.ops.sinew.use_method("EXEC_DEFAULT", True, method=method)
    for method in ("thin_shell", "arap"):
        bpy.ops.ed.undo()
        assert plate.deformer.method == method


def entries(menu: type, path: tuple[str, ...] = ()) -> list[tuple[str, object, tuple[str, ...]]]:
    """The labels of all entries below a menu, their settings, and the menus that lead to them."""
    found = []
    for name, args, keywords, settings in draw(menu, DrawContext()).calls:
        if name == "operator":
            rna = getattr(bpy.ops.sinew, args[0].partition(".")[2]).get_rna_type()
            found.append((keywords.get("text") or rna.name, settings, path))
        elif name == "menu":
            below = getattr(bpy.types, args[0])
            found += entries(below, (*path, keywords.get("text") or below.bl_label))
    return found


@pytest.mark.parametrize("mode", ["OBJECT", "EDIT"])
def test_no_label_is_there_twice(mode: str):
    scenes.grid_object()  # without vertex groups, whose names are in menus
    start("limb")
    bpy.ops.object.mode_set(mode=mode)
    times = Counter(label for label, _settings, _path in entries(bpy.types.SINEW_MT_object))
    assert [label for label, count in times.items() if count > 1] == []


def test_every_word_stands_in_a_label():
    scenes.grid_object()
    known = [
        (" ".join((*path, label)).lower(), settings)
        for label, settings, path in entries(bpy.types.SINEW_MT_object)
        if hasattr(settings, "task")
    ]
    for method in METHODS:
        task = () if method.wraps else (inner.tasks.task_of(method).label.lower(),)
        for word in (*method.search.split(), method.label.lower(), method.known_as.lower(), *task):
            assert any(word in text and settings.method == method.id for text, settings in known), word
    for task in TASKS:
        for word in (task.label, *task.other_names):
            assert any(word.lower() in text and settings.task == task.id for text, settings in known), word
