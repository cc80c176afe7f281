# SPDX-License-Identifier: GPL-3.0-or-later
"""Bad cages, and bad meshes in good ones: a status with its elements, no jump, and a way on."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from inside import inner
from registry import WITH_CAGE
from rigs import rig as scenes
from rigs.cages import assert_goes_on, assert_rests, ball, box, motion_of, place, selected, set_rest, surround

NOWHERE = (float("nan"), float("inf"), -float("inf"))


@pytest.mark.parametrize("value", NOWHERE)
def test_a_cage_that_is_nowhere_at_bind_or_later_leaves_the_rest_and_comes_back(value: float) -> None:
    status = inner.status
    target, cage = ball(), box()
    cage.data.vertices[3].co.x = value
    deformer = surround(target, cage)
    assert status.current(deformer.uid).remedy is status.Remedy.CAGE_REST
    for posed in (False, True):
        if posed:
            cage.location.z = 0.5
            shown = scenes.evaluated_points(target)
            cage.data.vertices[3].co.x = value
            cage.data.update()
        assert_rests(target)
        said = status.current(deformer.uid)
        assert said.level is status.Level.ERROR
        assert "invalid coordinates" in said.text
        assert said.elements.indices == (3,)
        assert selected(target, "vertex") == (cage, {3})
        cage.data.vertices[3].co.x = scenes.CORNERS[3][0]
        cage.data.update()
        if posed:
            assert scenes.close(scenes.evaluated_points(target), shown)
        else:
            set_rest(target)
        assert_goes_on(target, cage)


def test_a_cage_object_that_is_nowhere_is_the_cages_fault() -> None:
    target, cage = ball(), box()
    deformer = surround(target, cage)
    cage.location.y = 0.5
    posed = scenes.evaluated_points(target)
    cage.delta_location.y = float("nan")
    assert_rests(target)
    assert "invalid coordinates" in deformer.status
    elements = inner.status.current(deformer.uid).elements
    assert (elements.owner.name, elements.element) == ("CONTROL", "vertex")
    cage.delta_location.y = 0.0
    assert scenes.close(scenes.evaluated_points(target), posed)
    assert_goes_on(target, cage)


@pytest.mark.parametrize("method", WITH_CAGE)
def test_a_mesh_without_vertices_is_said_and_waits_for_some(method: str) -> None:
    target, cage = scenes.new_object("Ball", []), box()
    scenes.refused(r"has no (vertices|points)", "cage_add", target, source="AUTO", method=method)
    assert target.sinew.active is None
    deformer = surround(target, cage, method)
    assert deformer.status_level == "ERROR"
    assert "The mesh has no vertices" in deformer.status
    scenes.update()
    target.data.from_pydata(scenes.base_points(ball()).tolist(), [], [])
    target.data.update()
    scenes.press(target, "bind")
    assert_goes_on(target, cage)


@pytest.mark.parametrize("after_bind", [False, True])
def test_a_mesh_that_a_modifier_empties_comes_back(after_bind: bool) -> None:
    """Before it is bound, Bind takes the vertices; afterwards they are still bound."""
    target, cage = ball(), box()
    target.vertex_groups.new(name="Nobody")
    if after_bind:
        surround(target, cage)
    mask = target.modifiers.new("Mask", "MASK")
    mask.vertex_group = "Nobody"
    scenes.make_active(target)
    bpy.ops.object.modifier_move_to_index(modifier="Mask", index=0)
    if not after_bind:
        deformer = surround(target, cage)
        assert deformer.status_level == "ERROR"
        assert "check the modifiers before Sinew" in deformer.status
    for height in (0.0, 0.5):
        cage.location.z = height
        assert len(scenes.evaluated_points(target)) == 0
    mask.show_viewport = mask.show_render = False
    cage.location.z = 0.0
    assert_rests(target)
    if not after_bind:
        scenes.press(target, "bind")
    assert_goes_on(target, cage)


FIN = (scenes.CORNERS + [(-2.0, -2.0, 0.0)], scenes.SIDES + [(0, 1, 8)])
DOUBLED = (scenes.CORNERS + [scenes.CORNERS[0]], [(8, 1, 3, 2), *scenes.SIDES[1:]])


@pytest.mark.parametrize(
    ("points", "faces", "said", "bad"),
    [
        ([], [], "The cage has no vertices", None),
        (scenes.CORNERS, [], "the cage has no faces", None),
        (scenes.CORNERS[:4], [(0, 1, 3, 2), (2, 3, 1, 0)], "encloses no volume", ("face", {0, 1})),
        ([scenes.CORNERS[0]] * 8, scenes.SIDES, "encloses no volume", ("face", {0, 1, 2, 3, 4, 5})),
        (scenes.CORNERS, scenes.SIDES[1:], "open", ("vertex", {0, 1, 2, 3})),
        (*FIN, "open", ("vertex", {0, 1, 8})),
        (*DOUBLED, "open", ("vertex", {0, 1, 2, 8})),
    ],
    ids=["empty", "loose", "flat", "point", "hole", "fin", "doubled vertex"],
)
def test_a_cage_that_holds_nothing_is_refused_until_it_does(points, faces, said: str, bad) -> None:
    target, cage = ball(), scenes.new_object("Cage", points, faces)
    deformer = surround(target, cage)
    found = inner.status.current(deformer.uid)
    assert found.level.name == "ERROR"
    assert said in found.text
    assert said == "open" or found.remedy.name == "CAGE_REST", "no other button helps"
    assert_rests(target)
    assert bool(found.elements) == bool(bad)
    if bad:
        kind, indices = bad
        assert selected(target, kind) == (cage, indices)
    cage.data = box().data
    set_rest(target)
    assert_goes_on(target, cage)


@pytest.mark.parametrize("method", WITH_CAGE)
def test_a_cage_in_one_place_takes_the_mesh_there_and_gives_it_back_but_is_no_rest(method: str) -> None:
    target, cage = ball(), box()
    deformer = surround(target, cage, method)
    spot = np.array((0.1, 0.2, -0.3))
    place(cage, [spot] * 8)
    assert np.abs(scenes.evaluated_points(target) - spot).max() < scenes.FLOAT32
    place(cage, scenes.CORNERS)
    cage.scale, cage.location = (0.0, 0.0, 0.0), spot
    assert np.abs(scenes.evaluated_points(target) - spot).max() < scenes.FLOAT32
    assert deformer.status_level == "INFO", deformer.status
    scenes.refused("encloses no volume", "cage_set_rest", target)
    assert inner.status.current(deformer.uid).remedy.name == "CAGE_REST"
    assert_rests(target)
    cage.scale, cage.location = (1.0, 1.0, 1.0), (0.0, 0.0, 0.0)
    set_rest(target)
    assert np.abs(motion_of(target)).max() < scenes.FLOAT32
    assert_goes_on(target, cage)


LOOSE = (scenes.CORNERS + [(9.0, 9.0, 9.0), (8.0, 8.0, 8.0), (7.0, 7.0, 7.0)], scenes.SIDES, [(8, 9)])
ELSEWHERE = [
    (x - 2.0, y - 2.0, z) for x, y, z in scenes.CORNERS
]  # corners 6 and 7 are 0 and 1 of the other cube
SHARED = {6: 0, 7: 1}
TWO_CUBES = (
    scenes.CORNERS + ELSEWHERE,
    scenes.SIDES + [tuple(SHARED.get(corner, corner + 8) for corner in side) for side in scenes.SIDES],
)


@pytest.mark.parametrize("method", WITH_CAGE)
@pytest.mark.parametrize("cage", [LOOSE, TWO_CUBES], ids=["loose", "edge of four faces"])
def test_a_closed_cage_may_have_loose_vertices_and_edges_of_four_faces(cage, method: str) -> None:
    target, cage = ball(), scenes.new_object("Cage", *cage)
    surround(target, cage, method)
    assert np.abs(motion_of(target)).max() < scenes.FLOAT32
    if len(cage.data.polygons) == len(scenes.SIDES):
        place(cage, scenes.CORNERS + [(50.0, 0.0, 0.0)] * 3)  # loose vertices carry nothing
        assert np.abs(motion_of(target)).max() < scenes.FLOAT32
    assert_goes_on(target, cage)


FLAT = (
    scenes.CORNERS + [(-1.0, -1.0, 0.0)],
    scenes.SIDES + [(0, 1, 8), (8, 1, 0)],
)  # along an edge, there and back


@pytest.mark.parametrize("method", WITH_CAGE)
def test_faces_without_area_do_no_harm_or_are_shown(method: str) -> None:
    target, cage = ball(), scenes.new_object("Cage", *FLAT)
    deformer = surround(target, cage, method)
    if method == "harmonic":  # an equation a face
        said = inner.status.current(deformer.uid)
        assert "no area" in said.text
        assert said.remedy.name == "CAGE_REST", "Repair mends the mesh, which is well"
        assert_rests(target)
        shown, faces = selected(target, "face")
        assert shown == cage
        assert faces >= {6, 7}
        deformer.method = "mean_value"
        scenes.press(target, "bind")
    assert np.abs(motion_of(target)).max() < scenes.FLOAT32
    assert_goes_on(target, cage)
