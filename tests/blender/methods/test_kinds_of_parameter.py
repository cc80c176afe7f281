# SPDX-License-Identifier: GPL-3.0-or-later
"""Parameters whose values lie in other datablocks: drawn curves, boxes, meshes, UV maps; a base method."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np
import pytest
from expected import faces_of
from inside import factor_of, inner, native, notes_of, settle
from mathutils import Matrix
from rigs.cages import box, transform
from rigs.kinds import HandleRig
from rigs.rig import CORNERS, close, duplicated, evaluated_points, new_empty, press, refused, reopen, update
from rigs.sheet import DrawContext, Sheet

DRAWN = 1e-3  # Blender keeps a drawn curve as a table
ITERATED = 1e-3  # where the cage differs in its last digits, the method may stop a step earlier


@pytest.fixture
def rig(request: pytest.FixtureRequest) -> HandleRig:
    """Bound with a method, and lifted by one."""
    rig = HandleRig.new()
    rig.bind(request.param)
    rig.lift()
    return rig


def rig_with(method: str) -> pytest.MarkDecorator:
    return pytest.mark.parametrize("rig", [method], indirect=True)


def expected(rig: HandleRig, **options: object) -> np.ndarray:
    """What a new native object makes of it, which takes its rest from a control at rest."""
    rig.lift_to(0.0)
    poses = rig.expected(rig.deformer.method, **options)
    rig.lift_to(1.0)
    return poses.lifted(1.0)


def draw(obj: bpy.types.Object, height: float) -> None:
    """The middle of the falloff curve lies there; straight lines lead to it."""
    tree = obj.sinew.active.parameters.transfer
    curve = tree.nodes[0].mapping.curves[0]
    if len(curve.points) == 2:
        curve.points.new(0.5, height)
    curve.points[1].location = 0.5, height
    for point in curve.points:
        point.handle_type = "VECTOR"
    tree.nodes[0].mapping.update()
    tree.update_tag()
    update()


def curve_of(height: float) -> np.ndarray:
    return np.interp(np.linspace(0.0, 1.0, 257), (0.0, 0.5, 1.0), (0.0, height, 1.0))


def curves() -> list[str]:
    return [tree.name for tree in bpy.data.node_groups if "sinew_curve" in tree]


def drawn(rig: HandleRig) -> set[str]:
    """What the panel has for the curve."""
    (curve,) = (each for each in rig.deformer.definition.parameters if each.id == "transfer")
    sheet = Sheet()
    inner.parameters.draw_parameter(DrawContext(), sheet, rig.deformer.parameters, curve)
    return {name for name, *_rest in sheet.calls} & {"operator", "template_curve_mapping"}


@rig_with("propagation")
def test_a_curve_is_drawn_reset_saved_and_belongs_to_one_deformer(rig: HandleRig, tmp_path: Path):
    straight = rig.points()
    assert (curves(), drawn(rig)) == ([], {"operator"})
    press(rig.obj, "curve_edit", parameter="transfer")
    assert drawn(rig) == {"operator", "template_curve_mapping"}
    assert np.array_equal(rig.points(), straight), "an editor alone changes nothing"
    draw(rig.obj, 0.125)
    low = rig.points()
    assert close(low, expected(rig, transfer=curve_of(0.125)), DRAWN)
    assert not close(low, straight, 0.1)
    reopen(tmp_path / "curve.blend")
    assert close(rig.points(), low)
    copy = duplicated(rig.obj)
    settle()
    draw(copy, 0.75)
    assert close(evaluated_points(copy), expected(rig, transfer=curve_of(0.75)), DRAWN)
    assert close(rig.points(), low)
    press(rig.obj, "curve_edit", parameter="transfer", reset=True)
    assert close(rig.points(), straight)
    refused("has no curve 'laplacian' - its curves: transfer", "curve_edit", parameter="laplacian")
    for obj in (rig.obj, copy):
        press(obj, "deformer_remove")
    assert not curves()


@rig_with("inverse_ffd")
def test_an_empty_gives_its_cube_also_hidden_until_it_is_deleted(rig: HandleRig):
    rig.obj.location = 1.0, 2.0, 3.0
    own, empty = rig.points(), new_empty("Box", (1.2, 2.1, 3.0))
    rig.deformer.parameters.frame = empty
    for size, hidden in ((1.5, False), (2.5, True)):
        empty.hide_viewport = hidden
        empty.scale = size, 1.4, 1.6
        settle()
        frame = [[size, 0.0, 0.0, 0.2], [0.0, 1.4, 0.0, 0.1], [0.0, 0.0, 1.6, 0.0]]
        assert close(rig.points(), expected(rig, frame=np.array(frame)), 1e-5)
        assert not close(rig.points(), own, 1e-3)
    bpy.data.objects.remove(empty)
    assert close(rig.points(), own, 1e-5)


@rig_with("subspace_laplacian")
def test_a_mesh_object_is_taken_in_the_space_of_the_target_and_followed(rig: HandleRig):
    own, cage = rig.points(), box(size=4.0)
    cage.location = 0.2, 0.1, 0.0
    rig.deformer.parameters.cage = cage
    caged = rig.points()
    assert rig.deformer.status_level == "INFO", rig.deformer.status
    assert np.abs(caged - own).max() > 5 * ITERATED
    shape = native().SurfaceMesh(2.0 * np.array(CORNERS) + (0.2, 0.1, 0.0), faces_of(cage.data))
    assert close(caged, expected(rig, cage=shape), ITERATED)
    transform(cage, Matrix.Diagonal((1.5, 1.0, 1.0, 1.0)))
    edited = rig.points()
    cage.scale.y = 1.4
    for one, other in ((edited, caged), (rig.points(), edited)):
        assert np.abs(one - other).max() > 1e-4
    transform(cage, Matrix.Scale(0.1, 4))
    update()
    assert rig.deformer.status_level == "ERROR"
    assert "outside" in rig.deformer.status
    rig.deformer.parameters.cage = None
    assert close(rig.points(), own)


def add_map(rig: HandleRig, corners: np.ndarray) -> None:
    """A UV map with a place of each corner, (c, 2)."""
    layer = rig.obj.data.uv_layers.get("Map") or rig.obj.data.uv_layers.new(name="Map")
    layer.data.foreach_set("uv", corners.astype(np.float32).ravel())
    rig.obj.data.update()
    rig.deformer.parameters.uv_map = "Map"


def wave(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    return np.column_stack((x + 0.3 * y * y, y - 0.2 * x))


def torn(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """A vertex of a seam takes the place of its first corner."""
    return np.random.default_rng(3).random((len(x), 2))


@rig_with("spline_surface")
def test_a_uv_map_is_read_at_each_vertex_followed_after_a_bind_and_named_when_it_is_gone(rig: HandleRig):
    rig.deformer.parameters.degree = 2
    flat, vertices = rig.points(), faces_of(rig.obj.data)[1]
    first = np.unique(vertices, return_index=True)[1]
    for places in (wave, torn):
        corners = places(*rig.rest()[vertices, :2].T)
        add_map(rig, corners)
        press(rig.obj, "bind")
        assert rig.deformer.status_level == "INFO", rig.deformer.status
        assert not close(rig.points(), flat, 1e-4)
        at_vertices = corners.astype(np.float32)[first].astype(float)
        assert close(rig.points(), expected(rig, degree=2, uv_map=at_vertices), 1e-5)
    rig.deformer.parameters.uv_map = "Gone"
    assert close(rig.points(), flat)
    assert notes_of(rig.deformer) == [
        "UV Map 'Gone' is not on the mesh: a plane is used instead - pick another"
    ]
    rig.deformer.parameters.uv_map = ""
    assert close(rig.points(), flat)
    assert not notes_of(rig.deformer)


@rig_with("multiresolution")
def test_a_method_is_put_around_another_whose_settings_count(rig: HandleRig):
    values, rows = rig.deformer.multiresolution, inner.methods
    families = rows.BY_ID["multiresolution"].wraps
    for row in rows.METHODS:
        if row.family in families and not row.keyed:
            values.base = row.id
        else:
            with pytest.raises(TypeError):
                values.base = row.id
    values.base = "thin_shell"
    before, factor = rig.points(), factor_of(rig.deformer)
    rig.deformer.thin_shell.laplacian = "uniform"
    assert np.abs(rig.points() - before).max() > 1e-6
    assert factor_of(rig.deformer) is not factor
    assert not rig.deformer.is_iterative
    values.base = "arap"
    assert rig.deformer.is_iterative
    assert rig.points().shape == before.shape
    assert rig.deformer.status_level == "INFO", rig.deformer.status
