# SPDX-License-Identifier: GPL-3.0-or-later
"""deform() and warp() give what the classes give, and refuse what they refuse; nothing here names a method
but in examples of errors."""

import re
import textwrap

import numpy as np
import pytest

import sinew_native as sn

from . import methods
from .cages import CUBE, QUADS
from .meshes import BENT, ends, grid

POINTS, FACES = grid(8)
INSIDE = methods.inside(CUBE)
CAGE = CUBE, QUADS
CUBE_MESH = sn.SurfaceMesh(*CAGE)
# Their constructors take more than a control.
OTHERS = (sn.EmbeddedDeformation, sn.RigidCells, sn.MultiresolutionSpace)
WARPING = [method for method in methods.SPACE_METHODS if method not in OTHERS]


def id_of(method: type) -> str:
    return re.sub(r"(?<=[a-z])(?=[A-Z])", "_", method.__name__).lower()


@pytest.mark.parametrize(("method", "options"), methods.EVERY_SURFACE_METHOD, ids=methods.called)
def test_deform_gives_what_the_class_gives(method: type, options: dict) -> None:
    surface, points, handles = methods.bound(method, **options)
    positions = sn.deform(points, FACES, handles, BENT, method=id_of(method), **options)
    np.testing.assert_array_equal(positions, surface.solve(BENT)[0])


@pytest.mark.parametrize("method", WARPING, ids=methods.called)
def test_warp_gives_what_the_class_gives(method: type) -> None:
    control = methods.control(method, CUBE_MESH)
    posed = control * (1.0, 1.1, 1.3)
    space = methods.bound_to(methods.made(method, CUBE_MESH), INSIDE)
    cage = CAGE if method in methods.CAGE_METHODS else control
    np.testing.assert_array_equal(sn.warp(INSIDE, cage, posed, method=id_of(method)), space.warp(posed))


def test_the_base_of_another_method_is_chosen_by_its_id() -> None:
    mesh, handles = sn.SurfaceMesh(POINTS, FACES), ends(POINTS)
    around = sn.Multiresolution(mesh, sn.Propagation(mesh), bands=2)
    around.set_handles(handles)
    positions = sn.deform(POINTS, FACES, handles, BENT, "multiresolution", base="propagation", bands=2)
    np.testing.assert_array_equal(positions, around.solve(BENT)[0])


@pytest.mark.parametrize(
    ("function", "start", "end"),
    [
        (sn.deform, np.array([(x, 0.0, 0.0) for x in range(3)]), np.array([(x, 2.0, 1.0) for x in range(3)])),
        (sn.warp, np.array([(0.0, 0.0, 1.0)]), np.array([(0.2, 0.0, 0.0)])),  # twice as high
    ],
)
def test_the_example_of_the_docstring_runs(function, start: np.ndarray, end: np.ndarray) -> None:
    (example,) = re.findall(r"(?:^ {4}import numpy.*\n)(?:^(?: {4}.*)?\n)+", function.__doc__, re.MULTILINE)
    names: dict = {}
    exec(textwrap.dedent(example), names)
    for seen, expected in ((names["positions"][: len(start)], start), (names["positions"][-len(end) :], end)):
        np.testing.assert_allclose(seen, expected, atol=1e-12)


DEFORM = {"points": POINTS, "faces": FACES, "handles": ends(POINTS), "poses": BENT}
WARP = {"points": INSIDE, "cage": CAGE, "posed_cage": CUBE}


@pytest.mark.parametrize(
    ("given", "wrong", "error", "says"),
    [
        (
            DEFORM,
            {"smothness": 1.0},
            sn.InvalidOption,
            "smothness: 'arap' has no such option, but 'cells', 'm",
        ),
        (DEFORM, {"mesh": 1}, sn.InvalidOption, "mesh: 'arap' has no such option"),
        (DEFORM, {"base": "arap"}, sn.InvalidOption, "base: 'arap' has no such option"),
        (
            DEFORM,
            {"method": "multiresolution", "base": 3},
            sn.InvalidOption,
            "base: '3' is not one of 'arap', ",
        ),
        (DEFORM, {"smoothness": -1.0}, sn.InvalidOption, "smoothness: -1"),
        (DEFORM, {"points": POINTS[:, :2]}, sn.InvalidMesh, r"points: shape \(81, 2\) is not \(n, 3\)"),
        (DEFORM, {"faces": [[0, 1, 81]]}, sn.InvalidMesh, "faces: .* out of range"),
        (DEFORM, {"poses": BENT[:1]}, sn.InvalidConstraint, "poses: 1 given for 2 handles"),
        (DEFORM, {"handles": [0, 1]}, TypeError, "handles: handle 0 is a plain number"),
        (WARP, {"exits": 1}, sn.InvalidOption, "exits: 'green' has no such option, but 'exit_face', 'f"),
        (WARP, {"cage": CUBE}, sn.InvalidConstraint, r"cage: 'green' takes a tuple \(points, faces\)"),
        (WARP, {"cage": CAGE, "method": "rbf"}, TypeError, "cage: cannot be read"),
        (WARP, {"posed_cage": CUBE[1:]}, sn.InvalidConstraint, "bound with 8 vertices, and posed with 7"),
        (WARP, {"points": CUBE * 9, "method": "harmonic"}, sn.PointsOutside, "outside the cage"),
        (WARP, {"cage": (CUBE, QUADS[1:])}, sn.InvalidMesh, "cage is open"),
    ],
)
def test_what_is_wrong_is_refused_by_its_name(given: dict, wrong: dict, error: type, says: str) -> None:
    function = sn.deform if given is DEFORM else sn.warp
    with pytest.raises(error, match=says):
        function(**given | wrong)


@pytest.mark.parametrize(("given", "known"), [(DEFORM, methods.SURFACE_METHODS), (WARP, WARPING)])
def test_an_unknown_method_is_refused_with_the_known_ones_in_order(given: dict, known: list[type]) -> None:
    """A class that a user derived neither counts as one nor takes the place of its base."""
    mine = type("Mine", (sn.Green,), {"__init__": sn.Green.__init__})
    function = sn.deform if given is DEFORM else sn.warp
    for name in ("nothing", "Arap", "mine", *map(id_of, OTHERS)):
        with pytest.raises(sn.InvalidOption) as refused:
            function(**given, method=name)
        listed = ", ".join(f"'{method}'" for method in sorted(map(id_of, known)))
        assert str(refused.value) == f"method: '{name}' is not one of {listed}"
    assert function(**given).shape == given["points"].shape
    del mine
