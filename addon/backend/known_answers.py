# SPDX-License-Identifier: GPL-3.0-or-later
"""Shapes that are known without computing them, for every method of the registry.

They follow from what a method promises (rest gives rest, a motion of all controls moves the whole shape, a
handle is held) and from the symmetry of an octahedron. A new row is asked what it promises. A new kind of
control gives points; one of which more is known has a function in ``_RIGS``.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from ..core.methods import Bool, Choice, Control, Method, Parameter, Reproduced, wrapped
from .recipes import Base, ControlPoints, Faces, HandlePoints, Recipe, Regions, Shape

# Lengths, on shapes 4 units wide. Weights in single precision are wrong by 1e-7, and are multiplied by moves
# of up to 6 units.
_EXACT = 1e-5
# Of an iterative method: it stops when the energy falls by less than 1e-5, and the energy is flat around its
# minimum, so the shape is known to half of these digits.
_ITERATED = 2e-3
_LONGEST = 1.0  # seconds of a bind that nobody waits for here

_TURN = np.array(((2.0, -1.0, 2.0), (2.0, 2.0, -1.0), (-1.0, 2.0, 2.0))) / 3.0  # 60 degrees about (1, 1, 1)
_SHEAR = np.array(((1.2, 0.3, 0.0), (-0.4, 0.8, 0.1), (0.5, 0.2, 2.0)))
_OFFSET = np.array((0.3, -0.2, 0.5))
_MAPS: dict[Reproduced, np.ndarray] = {  # (3, 4), one of each
    kind: np.column_stack((linear, _OFFSET))
    for kind, linear in zip(list(Reproduced)[1:], (np.eye(3), _TURN, 1.5 * _TURN, _SHEAR), strict=True)
}
_STILL = np.eye(3, 4)
_MAPS[Reproduced.REST] = _STILL
_APART = 0.5  # how far two handles move apart


@dataclass(frozen=True)
class KnownAnswer:
    """``difference`` of the shape (n, 3) for a ``pose`` is 0 where all is right, and at most ``allowed``.

    ``claim`` is the answer in words.
    """

    claim: str
    pose: np.ndarray
    difference: Callable[[np.ndarray], np.ndarray]
    allowed: float = _EXACT


@dataclass(frozen=True)
class Rig:
    """What is bound, in words and as a recipe, keywords of ``solve``, and what is known about the shapes."""

    scene: str
    recipe: Recipe
    solve: dict[str, object]
    answers: tuple[KnownAnswer, ...]
    every_option: bool = True  # whether it is asked with other values of choices, too


def rigs(method: Method) -> Iterator[tuple[str, Rig]]:
    """What to ask a method: with the defaults of its row, and with each other value of each choice.

    Beside each stands what differs from the defaults, in words.
    """
    make = _RIGS.get(method.control, _among_points)
    for words, changed in _variants(method):
        for rig in make(method, values(method, True, changed), values(method, False, changed)):
            if rig.recipe.seconds < _LONGEST and (not words or rig.every_option):
                yield words, rig


def _variants(method: Method) -> Iterator[tuple[str, dict[str, object]]]:
    yield "", {}
    for parameter in method.parameters:
        for value in _others(parameter):
            yield f"{parameter.id}={value}", {parameter.id: value}


def _others(parameter: Parameter) -> list[object]:
    found: list[object] = []
    if isinstance(parameter, Choice):
        found = [identifier for identifier, _label, _description in parameter.items]
    elif isinstance(parameter, Bool):
        found = [False, True]
    return [value for value in found if value != parameter.default]


def values(
    method: Method, rebinds: bool, changed: Mapping[str, object] = MappingProxyType({})
) -> dict[str, object]:
    """The keywords of the native constructor, or of ``solve``: defaults of the row, but for ``changed``."""
    found = {
        parameter.id: changed.get(parameter.id, parameter.native_default)
        for parameter in method.parameters
        if parameter.rebinds == rebinds
    }
    bases = wrapped(method)
    if rebinds and bases:
        found["base"] = Base(bases[0], values(bases[0], True))
    return found


def _with_handles(method: Method, options: dict[str, object], solve: dict[str, object]) -> Iterator[Rig]:
    """An egg of 258 points, held at both ends. It is its own mirror image in the three planes."""
    points, faces = ball(3)
    points = points * (2.0, 1.0, 1.0)
    ends = [np.flatnonzero(points[:, 0] < -1.2), np.flatnonzero(points[:, 0] > 1.2)]
    middle = np.flatnonzero(points[:, 0] == 0.0)
    control: Regions | HandlePoints = HandlePoints(
        np.concatenate([points[end] for end in ends]), tuple(map(len, ends))
    )
    if not method.is_space:
        own: dict[str, Sequence[object]] = {
            parameter.id: [parameter.default] * 2 for parameter in method.handle_parameters
        }
        control = Regions(ends, [None, None], own)
    apart = np.stack((_STILL, _STILL))
    apart[1, 0, 3] = _APART
    bent = np.stack((_STILL, _MAPS[Reproduced.RIGID_MOTIONS]))
    answers = list(_motions(method, points, lambda matrix: np.stack((matrix, matrix))))
    if method.symmetric and method.reproduces is not Reproduced.REST:
        answers.append(
            KnownAnswer(
                "the middle between two handles",
                apart,
                lambda shape: shape[middle, 0] - 0.5 * _APART,
                _ITERATED if method.iterative else _EXACT,
            )
        )
    if not method.is_space:
        held, where = np.concatenate(ends), np.concatenate([_moved(p, points[e]) for p, e in zip(bent, ends)])
        answers.append(KnownAnswer("handles are held", bent, lambda shape: shape[held] - where))
    recipe = Recipe(method, Shape(points, faces), options, control)
    yield Rig("an egg held at both ends", recipe, solve, tuple(answers))


def _in_cage(method: Method, options: dict[str, object], solve: dict[str, object]) -> Iterator[Rig]:
    """Points in the core and in the spikes of a star; and the centre of an octahedron."""
    star, star_faces = ball(1)
    star[:6] *= 2.0
    star[6:] *= 0.8
    core, faces = ball(2)
    centre = len(core)
    inside = 0.65 if options.get("smooth", "off") == "off" else 0.3  # a smooth cage has blunt spikes
    target = Shape(np.concatenate((0.5 * core, np.zeros((1, 3)), inside * star[:6])), faces)
    motions = _motions(method, target.points, lambda matrix: _moved(matrix, star))
    recipe = Recipe(method, target, options, ControlPoints(star, faces=Faces(*star_faces)))
    yield Rig("points in a star", recipe, solve, tuple(motions))
    if method.reproduces is not Reproduced.AFFINE_MAPS:
        return
    corners, corner_faces = ball(0)
    lifted = 2.0 * corners
    lifted[4, 2] += 1.0
    sixth = KnownAnswer(
        "a sixth of each of six vertices",
        lifted,
        lambda shape: shape[centre] - (0.0, 0.0, 1.0 / 6.0),
    )
    recipe = Recipe(method, target, options, ControlPoints(2.0 * corners, faces=Faces(*corner_faces)))
    yield Rig("points in an octahedron", recipe, solve, (sixth,), every_option=False)


def _in_lattice(method: Method, options: dict[str, object], solve: dict[str, object]) -> Iterator[Rig]:
    """A ball in a lattice whose types, for Blender, are straight lines; and the middle of a quadratic one."""
    points, faces = ball(2)
    line = np.linspace(-2.0, 2.0, 5)
    control = np.stack(np.meshgrid(line, line, line, indexing="ij"), axis=-1)[..., ::-1].reshape(-1, 3)
    lattice = ControlPoints(control, {"resolution": (5, 5, 5), "interpolation": ("linear",) * 3})
    recipe = Recipe(method, Shape(points, faces), options, lattice)
    if options.get("outside") == "freeze":  # only the middle point moves, which holds nothing of the ball
        answers = [KnownAnswer("rest", control, lambda shape: shape - points)]
    else:
        answers = list(_motions(method, points, lambda matrix: _moved(matrix, control)))
    yield Rig("a ball in a lattice", recipe, solve, tuple(answers))
    cube = np.array([(x, y, z) for z in (-1.0, 0.0, 1.0) for y in (-1.0, 0.0, 1.0) for x in (-1.0, 0.0, 1.0)])
    lifted = cube.copy()
    lifted[13, 2] += 1.0
    eighth = KnownAnswer("an eighth of the middle point", lifted, lambda shape: shape[0] - (0.0, 0.0, 0.125))
    middle = Shape(np.zeros((1, 3)), (np.zeros(0, dtype=np.int32), np.zeros(0, dtype=np.int32)))
    quadratic = {**options, "basis": "bezier", "outside": "follow"}
    recipe = Recipe(method, middle, quadratic, ControlPoints(cube, {"resolution": (3, 3, 3)}))
    yield Rig("the middle of a quadratic lattice", recipe, solve, (eighth,), every_option=False)


def _among_points(method: Method, options: dict[str, object], solve: dict[str, object]) -> Iterator[Rig]:
    """A ball among six points that move it, such as those of a lattice."""
    points, faces = ball(2)
    control = 2.0 * ball(0)[0]
    motions = _motions(method, points, lambda matrix: _moved(matrix, control))
    recipe = Recipe(method, Shape(points, faces), options, ControlPoints(control))
    yield Rig("a ball among six points", recipe, solve, tuple(motions))


def _along_wires(method: Method, options: dict[str, object], solve: dict[str, object]) -> Iterator[Rig]:
    """A ball beside two wires that reach much farther than its size, so that they carry it as a whole."""
    points, faces = ball(2)
    line = np.linspace(-1.0, 1.0, 9)[:, None] * (2.0, 0.0, 0.0)
    control = np.concatenate((line + (0.0, 1.2, 0.3), line[:5] - (0.0, 1.2, 0.0)))
    own = {"counts": np.array((9, 5)), "radius": np.array((1e5, 1e5))}
    motions = _motions(method, points, lambda matrix: _moved(matrix, control))
    recipe = Recipe(method, Shape(points, faces), options, ControlPoints(control, own))
    yield Rig("a ball beside two wires", recipe, solve, tuple(motions))


def _with_tools(method: Method, options: dict[str, object], solve: dict[str, object]) -> Iterator[Rig]:
    """A ball within a tool, which carries it as a whole, and then one that a tool twists."""
    points, faces = ball(2)
    frame = np.concatenate((np.zeros((1, 3)), np.eye(3)))
    shape = Shape(points, faces)
    dragged = ControlPoints(frame, {"inner": np.array((1.5,)), "outer": np.array((3.0,))})
    motions = _motions(method, points, lambda matrix: _moved(matrix, frame))
    yield Rig("a ball in a tool", Recipe(method, shape, options, dragged), solve, tuple(motions))
    own = {"tools": ("twist",), "inner": (0.0,), "outer": (0.5,), "width": (2.0,)}
    quarter = np.array(((0.0, -1.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0)))
    half = np.where((points[:, 2] > 0.5)[:, None], _moved(quarter, points), points)
    sure = (points[:, 2] > 0.5) | (points[:, 2] <= 0.0)
    twisted = KnownAnswer(
        "one half turned by 90 degrees, the other one still",
        _moved(quarter, frame),
        lambda found: (found - half)[sure],
    )
    recipe = Recipe(method, shape, options, ControlPoints(frame, own))
    yield Rig("a ball that is twisted", recipe, solve, (twisted,))


_RIGS: dict[Control, Callable[[Method, dict[str, object], dict[str, object]], Iterator[Rig]]] = {
    Control.HANDLES: _with_handles,
    Control.CAGE: _in_cage,
    Control.LATTICE: _in_lattice,
    Control.CURVES: _along_wires,
    Control.TOOLS: _with_tools,
}


def _motions(
    method: Method, points: np.ndarray, pose: Callable[[np.ndarray], np.ndarray]
) -> Iterator[KnownAnswer]:
    """Rest, and all the maps that the method reproduces. ``pose`` moves its control by a map (3, 4)."""

    def away_from(expected: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
        return lambda shape: shape - expected

    kinds = list(Reproduced)
    for kind in kinds[: kinds.index(method.reproduces) + 1]:
        yield KnownAnswer(kind.value, pose(_MAPS[kind]), away_from(_moved(_MAPS[kind], points)))


def _moved(matrix: np.ndarray, points: np.ndarray) -> np.ndarray:
    return points @ matrix[:, :3].T + matrix[:, 3]


def ball(level: int) -> tuple[np.ndarray, tuple[np.ndarray, np.ndarray]]:
    """An octahedron whose triangles are cut in four ``level`` times, on the unit sphere: points and faces.

    The six corners come first.
    """
    points = [sign * axis for axis in np.eye(3) for sign in (1.0, -1.0)]
    triangles = [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)]
    for _ in range(level):
        middles: dict[tuple[int, int], int] = {}
        finer = []
        for triangle in triangles:
            between = []
            for i, j in zip(triangle, triangle[1:] + triangle[:1]):
                edge = (min(i, j), max(i, j))
                if edge not in middles:
                    middles[edge] = len(points)
                    points.append((points[i] + points[j]) / np.linalg.norm(points[i] + points[j]))
                between.append(middles[edge])
            (i, j, k), (a, b, c) = triangle, between
            finer += [(i, a, c), (a, j, b), (c, b, k), (a, b, c)]
        triangles = finer
    counts = np.full(len(triangles), 3, dtype=np.int32)
    return np.array(points), (counts, np.array(triangles, dtype=np.int32).ravel())
