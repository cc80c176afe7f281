# SPDX-License-Identifier: GPL-3.0-or-later
"""deform() and warp() give what the classes give, and name what is wrong."""

import re
import textwrap

import numpy as np
import pytest

import sinew_native as sn

from . import methods
from .cages import CUBE, QUADS
from .meshes import BENT, ends, grid

POINTS, FACES = grid(8)
INSIDE, CAGE = methods.inside(CUBE), (CUBE, QUADS)
OTHERS = (sn.EmbeddedDeformation, sn.RigidCells, sn.MultiresolutionSpace)  # made of more than a control
WARPING = [method for method in methods.SPACE_METHODS if method not in OTHERS]
DEFORM = {"points": POINTS, "faces": FACES, "handles": ends(POINTS), "poses": BENT}
WARP = {"points": INSIDE, "cage": CAGE, "posed_cage": CUBE}


def id_of(method: type) -> str:
    return re.sub(r"(?<=[a-z])(?=[A-Z])", "_", method.__name__).lower()


@pytest.mark.parametrize(("method", "options"), methods.EVERY_SURFACE_METHOD, ids=methods.called)
def test_deform_gives_what_the_class_gives(method: type, options: dict) -> None:
    expected, _report = methods.bound(method, **options)[0].solve(BENT)
    np.testing.assert_array_equal(sn.deform(**DEFORM, method=id_of(method), **options), expected)


@pytest.mark.parametrize("method", WARPING, ids=methods.called)
def test_warp_gives_what_the_class_gives(method: type) -> None:
    control = methods.control(method, sn.SurfaceMesh(*CAGE))
    posed, cage = control * (1.0, 1.1, 1.3), CAGE if method in methods.CAGE_METHODS else control
    expected = methods.bound_to(methods.made(method, sn.SurfaceMesh(*CAGE)), INSIDE).warp(posed)
    np.testing.assert_array_equal(sn.warp(INSIDE, cage, posed, method=id_of(method)), expected)


def test_the_base_of_another_method_is_chosen_by_its_id() -> None:
    mesh = sn.SurfaceMesh(POINTS, FACES)
    around = methods.bound_to(sn.Multiresolution(mesh, sn.Propagation(mesh)), ends(POINTS))
    positions = sn.deform(**DEFORM, method="multiresolution", base="propagation")
    np.testing.assert_array_equal(positions, around.solve(BENT)[0])


@pytest.mark.parametrize(
    ("function", "first", "last"), [(sn.deform, (0, 0, 0), (2, 2, 1)), (sn.warp, (0, 0, 1), (0.2, 0, 0))]
)
def test_the_example_of_the_docstring_runs(function, first: tuple, last: tuple) -> None:
    (example,) = re.findall(r"(?:^ {4}import numpy.*\n)(?:^(?: {4}.*)?\n)+", function.__doc__, re.MULTILINE)
    exec(textwrap.dedent(example), names := {})
    np.testing.assert_allclose(names["positions"][[0, -1]], [first, last], atol=1e-12)


@pytest.mark.parametrize(
    ("given", "wrong", "error", "says"),
    [
        (
            DEFORM,
            {"smothness": 1.0},
            sn.InvalidOption,
            "smothness: 'arap' has no such option; its options are 'cells', 'm",
        ),
        (DEFORM, {"mesh": 1}, sn.InvalidOption, "mesh: 'arap' has no such option"),
        (
            DEFORM,
            {"method": "multiresolution", "base": 3},
            sn.InvalidOption,
            "base: '3' is not one of 'arap', ",
        ),
        (DEFORM, {"smoothness": -1.0}, sn.InvalidOption, "smoothness: -1"),
        (DEFORM, {"points": POINTS[:, :2]}, sn.InvalidMesh, r"points: shape \(81, 2\) is not \(n, 3\)"),
        (DEFORM, {"poses": BENT[:1]}, sn.InvalidConstraint, "poses: 1 given for 2 handles"),
        (
            WARP,
            {"exits": 1},
            sn.InvalidOption,
            "exits: 'green' has no such option; its options are 'boundary_smooth', ",
        ),
        (WARP, {"cage": CUBE}, sn.InvalidConstraint, r"cage: 'green' takes a tuple \(points, faces\)"),
        (WARP, {"cage": CAGE, "method": "rbf"}, TypeError, "cage: cannot be read"),
        (WARP, {"posed_cage": CUBE[1:]}, sn.InvalidConstraint, "bound with 8 vertices, and posed with 7"),
        (WARP, {"points": CUBE * 9, "method": "harmonic"}, sn.PointsOutside, "outside the cage"),
    ],
)
def test_what_is_wrong_is_refused_by_its_name(given: dict, wrong: dict, error: type, says: str) -> None:
    with pytest.raises(error, match=says):
        (sn.deform if given is DEFORM else sn.warp)(**given | wrong)


MINE = type("Mine", (sn.Green,), {})  # a class of a user is no method, and its base stays one


@pytest.mark.parametrize(("given", "known"), [(DEFORM, methods.SURFACE_METHODS), (WARP, WARPING)])
def test_an_unknown_method_is_refused_with_the_known_ones_in_order(given: dict, known: list[type]) -> None:
    listed = ", ".join(f"'{method}'" for method in sorted(map(id_of, known)))
    for name in ("nothing", "Arap", "mine", *map(id_of, OTHERS)):
        with pytest.raises(sn.InvalidOption) as refused:
            (sn.deform if given is DEFORM else sn.warp)(**given, method=name)
        assert str(refused.value) == f"method: '{name}' is not one of {listed}"
