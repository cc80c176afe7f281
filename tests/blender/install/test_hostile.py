# SPDX-License-Identifier: GPL-3.0-or-later
"""Values that no button of ours writes: a file from elsewhere, a script gone wrong, another add-on.

Whatever stands in our properties: no traceback, no crash, no point that is not finite, nobody else's mesh
changed; and where the shape is not the one asked for, a status says so. Also after saving and loading.
"""

import math
import os
import time
from pathlib import Path

import bpy
import numpy as np
import pytest
from error_log import ErrorLog
from hypothesis import HealthCheck, Phase, given, note, seed, settings, strategies as st
from inside import catch_up, inner, settle
from rigs.kinds import HandleRig
from rigs.rig import Rig, add_group, make_active, new_nodes, new_object, reopen, storage, update

SEED = os.environ.get("SINEW_RANDOM_SEED")
NAN, INF = math.nan, math.inf
LONG = "x" * 63
STRANGE_NAMES = ("", LONG, "../../etc/passwd", 'a"]["b', "C:\\x", "Ü☃", "a\nb", "%s{0}", "x" * 300)


def other_mesh(name: str = "Mine") -> bpy.types.Object:
    """A mesh of the user's with as many vertices as a shape of the plate."""
    return new_object(name, [(float(index), 5.0, 5.0) for index in range(122)], [(0, 1, 2)])


def raw(plate: Rig, *path: object) -> object:
    """The ID property group below the object's ``sinew``."""
    found = storage(plate.obj)["sinew"]
    for step in path:
        found = found[step]
    return found


def assert_sound(plate: Rig) -> None:
    """Finite. Where the status is bad, at rest, or still as it was before anything happened."""
    points = plate.points()
    assert np.isfinite(points).all()
    if plate.before is not None and plate.deformer is not None and plate.deformer.status_level == "ERROR":
        assert min(np.abs(points - shape).max() for shape in (plate.rest(), plate.before)) < 1e-6


def press(operator, **keywords) -> None:
    """A button may refuse in words."""
    words = ""
    try:
        operator(**keywords)
    except RuntimeError as refusal:
        words = str(refusal)
    assert "Traceback" not in words, words


def live_with_it(plate: Rig, folder: Path) -> None:
    """Evaluate, move, animate, press every button that fits, save and load."""
    make_active(plate.obj)
    assert_sound(plate)
    catch_up()
    assert_sound(plate)
    for control in [obj for obj in bpy.context.scene.objects if obj.type == "EMPTY"]:
        control.location.z += 0.25
    bpy.context.scene.frame_set(7)
    assert_sound(plate)
    reopen(folder / "hostile.blend")
    assert_sound(plate)
    make_active(plate.obj)
    for operator, keywords in (
        (bpy.ops.sinew.bind, {}),
        (bpy.ops.sinew.select_handle, {"index": 0}),
        (bpy.ops.sinew.handle_add, {"kind": "FIXED", "vertex_group": "Side"}),
        (bpy.ops.sinew.handle_remove, {"index": 1}),
        (bpy.ops.sinew.unbind, {}),
        (bpy.ops.sinew.bind, {}),
        (bpy.ops.object.duplicate, {}),
        (bpy.ops.sinew.deformer_remove, {}),
    ):
        press(operator, **keywords)
        settle()
        if bpy.context.object != plate.obj:
            make_active(plate.obj)
    assert_sound(plate)


@pytest.fixture
def posed(plate: Rig) -> Rig:
    """Bound, lifted, and with one vertex group more."""
    add_group(plate.obj, "Side", lambda point: abs(point[1]) < 0.1)
    plate.bind("thin_shell").lift(0.5)
    plate.before = plate.points()
    return plate


def rest_matrix(value: float):
    def wound(plate: Rig) -> None:
        matrix = [value if index == 5 else float(index % 5 == 0) for index in range(16)]
        plate.deformer.handles[0].rest_matrix = matrix

    return wound


def applied(value: float):
    """What Apply is said to have done to the rest shape."""

    def wound(plate: Rig) -> None:
        plate.deformer.has_applied, plate.deformer.applied = True, [value] * 16

    return wound


def raw_value(value: object, *path: object):
    def wound(plate: Rig) -> None:
        raw(plate, *path[:-1])[path[-1]] = value

    return wound


OTHER_OBJECTS = {
    "empty": lambda _plate: bpy.data.objects.new("Nothing", None),
    "camera": lambda _plate: bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera")),
    "mine": lambda _plate: other_mesh(),
    "itself": lambda plate: plate.obj,
    "gone": lambda _plate: None,
}


def proxy_is(name: str, other: str):
    return lambda plate: setattr(plate.deformer, name, OTHER_OBJECTS[other](plate))


def other_rest(points: int, faces: list, ours: bool = True):
    def wound(plate: Rig) -> None:
        mesh = bpy.data.meshes.new("Elsewhere")
        mesh.from_pydata([(float(i), 0.1 * i, 0.0) for i in range(points)], [], faces)
        if ours:
            mesh["sinew_token"] = plate.deformer.rest["sinew_token"]
            mesh["sinew_groups"] = plate.deformer.rest["sinew_groups"]
        plate.deformer.rest = mesh

    return wound


def not_finite_rest(plate: Rig) -> None:
    plate.deformer.rest.vertices[3].co.x = NAN
    plate.deformer.rest["sinew_token"] = "another"


def active_out_of_range(plate: Rig) -> None:
    plate.obj.sinew.active_deformer = -7
    plate.deformer.chosen_handle, plate.deformer.chosen_control = 2_000_000_000, -7


def group_key_of_another_type(plate: Rig) -> None:
    for group in bpy.data.node_groups:
        group["sinew_group_version"], group["sinew_group_kind"] = [1, 2], {"MESH": 1}


def rest_key(key: str, value: object):
    def wound(plate: Rig) -> None:
        plate.deformer.rest[key] = value
        plate.obj.update_tag()

    return wound


def names(prop: str, value: str):
    def wound(plate: Rig) -> None:
        for owner in (plate.deformer, *plate.deformer.handles):
            if hasattr(owner, prop):
                setattr(owner, prop, value)

    return wound


def group_named(value: str):
    def wound(plate: Rig) -> None:
        plate.obj.vertex_groups["Top"].name = value
        plate.deformer.handles[0].vertex_group = plate.obj.vertex_groups[0].name
        plate.deformer.mask_group = plate.obj.vertex_groups[0].name

    return wound


def twice_the_same(prop: str):
    """In two deformers."""

    def wound(plate: Rig) -> None:
        make_active(plate.obj)
        bpy.ops.sinew.deformer_add(method="arap")
        first, second = plate.obj.sinew.deformers
        setattr(second, prop, getattr(first, prop))

    return wound


def cleared_inputs(plate: Rig) -> None:
    modifier = plate.obj.modifiers[-1]
    group, modifier.node_group = modifier.node_group, None
    modifier.node_group = group


def group_of_other_sockets(plate: Rig) -> None:
    """Our key on somebody's node group, and ours gone."""
    for group in list(bpy.data.node_groups):
        bpy.data.node_groups.remove(group)
    group, start, end = new_nodes("Theirs")
    group["sinew_group_version"], group["sinew_group_kind"] = 1, "MESH 1"
    group.links.new(start, end)
    plate.obj.modifiers[-1].node_group = group


def clashing_attribute(plate: Rig) -> None:
    """Our attribute names on the mesh, with other types and domains."""
    uid = plate.deformer.uid
    plate.obj.data.attributes.new(f".sinew_in_{uid}", "INT", "FACE")
    plate.obj.data.attributes.new(f".sinew_index_{uid}", "FLOAT_COLOR", "CORNER")
    plate.obj.data.attributes.new("Mask", "FLOAT", "POINT")


WOUNDS = {
    "rest_matrix_nan": rest_matrix(NAN),
    "rest_matrix_inf": rest_matrix(INF),
    "rest_matrix_huge": rest_matrix(1e38),
    "rest_matrix_singular": rest_matrix(0.0),
    "applied_nan": applied(NAN),
    "applied_huge": applied(1e38),
    "applied_singular": applied(0.0),
    "factor_nan": lambda plate: setattr(plate.deformer, "factor", NAN),
    "factor_nan_below": raw_value(NAN, "deformers", 0, "factor"),
    "factor_inf_below": raw_value(INF, "deformers", 0, "factor"),
    "factor_text_below": raw_value("half", "deformers", 0, "factor"),
    "weight_nan_below": raw_value(NAN, "deformers", 0, "handles", 0, "weight"),
    "weight_large_below": raw_value(9.0, "deformers", 0, "handles", 0, "weight"),
    "continuity_nan_below": raw_value(NAN, "deformers", 0, "handles", 0, "continuity"),
    "bending_nan": lambda plate: setattr(plate.deformer.thin_shell, "bending", NAN),
    "bending_negative_below": raw_value({"bending": -3.0}, "deformers", 0, "thin_shell"),
    "method_out_of_range": raw_value(99, "deformers", 0, "method"),
    "method_text_below": raw_value("arap", "deformers", 0, "method"),
    "kind_out_of_range": raw_value(-1, "deformers", 0, "handles", 0, "kind"),
    "laplacian_out_of_range": raw_value({"laplacian": 77}, "deformers", 0, "thin_shell"),
    "bake_result_out_of_range": raw_value({"result": 99, "filepath": 3.0}, "deformers", 0, "bake"),
    "bake_result_without_a_bake": lambda plate: setattr(plate.deformer.bake, "result", "PC2"),
    "bake_text": raw_value("none", "deformers", 0, "bake"),
    "deformers_text": raw_value("none", "deformers"),
    "handles_number": raw_value(7, "deformers", 0, "handles"),
    "handles_numbers": raw_value([1, 2, 3], "deformers", 0, "handles"),
    "thin_shell_text": raw_value("none", "deformers", 0, "thin_shell"),
    "sinew_text": lambda plate: storage(plate.obj).__setitem__("sinew", "none"),
    "sinew_numbers": lambda plate: storage(plate.obj).__setitem__("sinew", [1.0, 2.0]),
    "control_text_below": raw_value("Empty", "deformers", 0, "handles", 0, "control"),
    "uid_number_below": raw_value(5, "deformers", 0, "uid"),
    "proxy_text_below": raw_value("Plate", "deformers", 0, "proxy"),
    "rest_is_an_object_below": lambda plate: raw(plate, "deformers", 0).__setitem__("rest", plate.obj),
    **{
        f"{name}_{other}": proxy_is(name, other)
        for name in ("proxy", "proxy_render")
        for other in OTHER_OBJECTS
    },
    "one_shape_for_both": lambda plate: setattr(plate.deformer, "proxy_render", plate.deformer.proxy),
    "shape_of_no_vertices": lambda plate: setattr(plate.deformer.proxy, "data", bpy.data.meshes.new("None")),
    "rest_of_another_size": other_rest(7, [(0, 1, 2)]),
    "rest_of_another_size_and_no_keys": other_rest(300, [(0, 1, 2)], ours=False),
    "rest_without_vertices": other_rest(0, []),
    "rest_of_the_size_without_faces": other_rest(121, []),
    "rest_corners_out_of_range": lambda plate: plate.deformer.rest.loops.foreach_set(
        "vertex_index", [100_000] * len(plate.deformer.rest.loops)
    ),
    "rest_not_finite": not_finite_rest,
    "rest_is_the_mesh_itself": lambda plate: setattr(plate.deformer, "rest", plate.obj.data),
    "token_numbers": rest_key("sinew_token", [1, 2, 3]),
    "token_group": rest_key("sinew_token", {"a": 1}),
    "kind_number": rest_key("sinew_kind", 7),
    "kind_numbers": rest_key("sinew_kind", [1, 2]),
    "kind_of_curves": rest_key("sinew_kind", "BEZIER"),
    "structure_numbers": rest_key("sinew_structure", [1, 2]),
    "groups_number": rest_key("sinew_groups", 5),
    "groups_text": rest_key("sinew_groups", "Top"),
    "groups_numbers": rest_key("sinew_groups", [1.0, 2.0]),
    "groups_group": rest_key("sinew_groups", {"Top": 0}),
    "groups_too_many": rest_key("sinew_groups", [f"Group {number}" for number in range(5000)]),
    "twice_the_same_key": twice_the_same("uid"),
    "twice_the_same_handle_key": lambda plate: [setattr(h, "uid", "same") for h in plate.deformer.handles],
    "twice_the_same_shape": twice_the_same("proxy"),
    "its_own_control": lambda plate: setattr(plate.deformer.handles[0], "control", plate.obj),
    "bone_of_an_empty": lambda plate: setattr(plate.deformer.handles[0], "bone", 'x"] or "'),
    "cleared_inputs": cleared_inputs,
    "modifier_without_group": lambda plate: setattr(plate.obj.modifiers[-1], "node_group", None),
    "group_of_other_sockets": group_of_other_sockets,
    "group_key_of_another_type": group_key_of_another_type,
    "clashing_attribute": clashing_attribute,
    "driver_gone": lambda plate: plate.obj.__setitem__("sinew_keep_evaluated", "text"),
    "active_out_of_range": active_out_of_range,
    **{f"uid_{number}": names("uid", name) for number, name in enumerate(STRANGE_NAMES)},
    **{f"name_{number}": names("name", name) for number, name in enumerate(STRANGE_NAMES)},
    **{f"vertex_group_{number}": names("vertex_group", name) for number, name in enumerate(STRANGE_NAMES)},
    **{f"group_named_{number}": group_named(name) for number, name in enumerate(STRANGE_NAMES) if name},
}


def wounded(plate: Rig, wound) -> bool:
    """False where Blender itself refuses the value."""
    try:
        wound(plate)
    except (TypeError, ValueError, KeyError, AttributeError):
        return False
    plate.obj.update_tag()
    return True


@pytest.mark.parametrize("name", WOUNDS)
def test_a_hostile_value_gives_a_status_and_nothing_worse(posed: Rig, tmp_path: Path, name: str):
    """A mesh of the user's is neither written nor removed, even in place of a shape."""
    bystander = other_mesh("Bystander")
    before = [tuple(vertex.co) for vertex in bystander.data.vertices]
    if not wounded(posed, WOUNDS[name]):
        return  # Blender has refused it
    if name.startswith(("proxy_render", "one_shape")):
        posed.before = None  # the viewport goes on beside the complaint
    meshes = {obj.name: obj.data.name for obj in bpy.data.objects if obj.name in ("Mine", "Bystander")}
    live_with_it(posed, tmp_path)
    assert len(meshes) == 1 + name.endswith("_mine")
    for obj, mesh in meshes.items():
        assert bpy.data.objects[obj].data.name == mesh
        assert [tuple(vertex.co) for vertex in bpy.data.meshes[mesh].vertices] == before


def test_a_hundred_thousand_handles_stay_responsive(posed_plate: HandleRig):
    posed, seconds = posed_plate, []
    for _half in range(2):
        for _ in range(50_000):
            posed.deformer.handles.add()
        posed.obj.update_tag()
        start = time.process_time()
        update()
        assert posed.deformer.status_level == "INFO"  # they have no vertices, and the others go on
        for step in range(3):
            posed.control.location.z = 0.1 * step
            update()
        seconds.append(time.process_time() - start)
    assert seconds[1] < 3 * seconds[0]  # each handle takes the same time, on any processor
    assert posed.shows(posed.at(0.2))
    notes = inner.status.notes(posed.deformer.uid)
    assert [line.text for line in notes][3:] == ["99,997 more regions are not used"]


def test_hundreds_of_objects_that_claim_one_key_are_told_apart_in_time(posed: Rig):
    for _ in range(300):
        bpy.context.scene.collection.objects.link(posed.obj.copy())
    start = time.process_time()
    settle()
    assert time.process_time() - start < 20.0
    keys = [deformer.uid for obj in bpy.data.objects for deformer in obj.sinew.deformers]
    assert len(set(keys)) == len(keys) == 301
    for obj in list(bpy.data.objects):  # each to be bound anew; they share a mesh, so that takes minutes
        if obj.sinew.deformers and obj != posed.obj:
            bpy.data.objects.remove(obj)


def test_parents_in_a_circle_through_a_control(posed: Rig, capfd: pytest.CaptureFixture):
    """The target hangs on the control, whose driver hangs on it. Blender breaks the circle and says so."""
    posed.control.parent, posed.obj.parent = None, posed.control
    posed.control.location.z = 0.3
    assert np.isfinite(posed.points()).all()
    capfd.readouterr()


def test_a_file_from_elsewhere_runs_nothing_of_its_own(posed: Rig, tmp_path: Path):
    """Texts in our properties stay texts: as names, drivers and vertex groups."""
    trap = tmp_path / "sprung"
    code = f"__import__('pathlib').Path({str(trap)!r}).touch()"
    deformer = posed.deformer
    for owner in (deformer, *deformer.handles):
        owner.name = code
    deformer.mask_group = deformer.handles[0].vertex_group = deformer.handles[0].bone = code
    deformer.rest["sinew_token"] = code
    deformer.rest["sinew_groups"] = [code]
    posed.obj["sinew_keep_evaluated"] = code
    reopen(tmp_path / "trap.blend")
    update()
    press(bpy.ops.sinew.bind)
    for curve in posed.obj.animation_data.drivers if posed.obj.animation_data else ():
        assert curve.driver.type == "SUM"
    assert not trap.exists()


ANYTHING = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-(2**31), 2**31 - 1),
    st.floats(allow_nan=True, allow_infinity=True, width=32),
    st.sampled_from(STRANGE_NAMES),
    st.lists(st.integers(-5, 5), max_size=4),
    st.lists(st.floats(width=32), min_size=1, max_size=4),
    st.lists(st.floats(width=32), min_size=16, max_size=16),
    st.dictionaries(st.sampled_from(("a", "factor", "uid")), st.integers(0, 3), max_size=2),
    st.sampled_from(("object: Plate", "object: Mine", "mesh: Plate", "mesh: Mine", "arap", "FIXED")),
)
PLACES = st.sampled_from(
    ("object", "deformer", "handle", "fixed", "thin_shell", "rest", "modifier", "target")
)


def resolve(value: object) -> object:
    kind, _, name = value.partition(": ") if isinstance(value, str) else ("", "", "")
    if kind in ("object", "mesh") and name:
        return {"object": bpy.data.objects, "mesh": bpy.data.meshes}[kind].get(name)
    return value


def place(plate: Rig, where: str) -> object:
    if where in ("handle", "fixed"):
        return plate.deformer.handles[0 if where == "handle" else 1]
    if where in ("thin_shell", "rest"):
        return getattr(plate.deformer, where)
    owners = {"object": plate.obj.sinew, "deformer": plate.deformer, "target": plate.obj}
    return plate.obj.modifiers[-1] if where == "modifier" else owners[where]


def keys_of(owner: object, below: bool) -> list[str]:
    if not below and hasattr(owner, "bl_rna"):
        keys = [prop.identifier for prop in owner.bl_rna.properties if not prop.is_readonly]
        return sorted(key for key in keys if isinstance(owner, bpy.types.PropertyGroup)) or ["name"]
    names = {"sinew_token", "sinew_groups", "sinew_keep_evaluated", "sinew"}
    return sorted(names | set(owner.keys() if hasattr(owner, "keys") else ()))


@settings(
    max_examples=40,
    derandomize=SEED is None,
    database=None,
    deadline=None,
    phases=(Phase.generate, Phase.shrink),
    suppress_health_check=list(HealthCheck),
)
@given(
    wounds=st.lists(st.tuples(PLACES, st.booleans(), st.integers(0, 40), ANYTHING), min_size=1, max_size=6)
)
def fuzz(folder: Path, wounds: list) -> None:
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    error_log = ErrorLog()
    try:
        _inflict(folder, wounds)
        error_log.check()
    finally:
        error_log.close()


def _inflict(folder: Path, wounds: list) -> None:
    plate = Rig.plate(cells=10)
    other_mesh()
    plate.bind("thin_shell")
    plate.lift(0.5)
    plate.before = None  # whole deformers may have come to belong to another: no claim about the shape
    for where, below, number, value in wounds:
        try:
            owner = place(plate, where)
            owner = storage(owner) if below else owner
            key = keys_of(owner, below)[number % len(keys_of(owner, below))]
            if below:
                owner[key] = resolve(value)
            else:
                setattr(owner, key, resolve(value))
        except (TypeError, ValueError, KeyError, AttributeError, IndexError, OverflowError):
            continue  # Blender refuses it, or an earlier wound took the place away
        note(f"{where}{'[...]' if below else ''}.{key} = {value!r}")
        if where == "target" and not below:
            plate.name = owner.name
        plate.obj.update_tag()
        update()
    live_with_it(plate, folder)


def test_random_values_of_any_kind_in_any_property(tmp_path: Path):
    target = fuzz if SEED is None else seed(int(SEED))(fuzz)
    target(tmp_path)
