# SPDX-License-Identifier: GPL-3.0-or-later
"""A factor that becomes another one: what that asks of the native module, and that nothing else differs."""

from collections import Counter

import numpy as np
import pytest
from rows import ON_SURFACE, WITH_HANDLES, base_option, default_options, other_options

from sinew.core import errors
from sinew.core.methods import BY_ID

SIDE = 8
POINTS = np.array([(x, y, 0.1 * np.sin(x * y)) for y in range(SIDE) for x in range(SIDE)])
CORNERS = np.array(
    [i + j * SIDE + k for j in range(SIDE - 1) for i in range(SIDE - 1) for k in (0, 1, SIDE + 1, SIDE)],
    dtype=np.int32,
)
FACES = (np.full(len(CORNERS) // 4, 4, dtype=np.int32), CORNERS)
ENDS = (np.arange(SIDE), np.arange(SIDE * (SIDE - 1), SIDE * SIDE))
MIDDLE = np.array([3 * SIDE + 3, 3 * SIDE + 4])


@pytest.fixture
def calls(backend, count_native) -> Counter:
    """How often the native module was asked to build or bind something."""
    return count_native(backend.availability().module)


def recipe(backend, method: str, handles=ENDS, points=POINTS, faces=FACES, **options):
    row = BY_ID[method]
    if row.is_space:
        control = backend.HandlePoints(points[np.concatenate(handles)], tuple(map(len, handles)))
    else:
        control = backend.Regions(
            tuple(members.copy() for members in handles),
            (None,) * len(handles),
            {parameter.id: (parameter.default,) * len(handles) for parameter in row.handle_parameters},
        )
    given = default_options(row) | base_option(backend, row) | options
    return backend.Recipe(row, backend.Shape(points.copy(), faces), given, control)


def rebuilt(backend, factor, wanted, progress=None):
    return backend.build_factor(wanted, progress, factor.prepare_rebind(wanted))


def solved(factor, count: int, **keywords) -> np.ndarray:
    poses = np.stack([np.eye(4)[:3]] * count)
    poses[1, :, 3] = 0.3, -0.2, 1.0
    return factor.solve(poses, **keywords)[0]


def same_as_new(backend, factor, wanted) -> None:
    """To rounding: another order of elimination is allowed."""
    new = backend.build_factor(wanted)
    count = len(wanted.control.counts if wanted.method.is_space else wanted.control.vertices)
    np.testing.assert_allclose(solved(factor, count), solved(new, count), rtol=0.0, atol=1e-6)
    if not wanted.method.is_space:
        assert factor.report.free_parts == new.report.free_parts


@pytest.mark.parametrize("method", ON_SURFACE)
def test_a_handle_more_or_less_is_one_native_call(backend, calls: Counter, method: str):
    factor = backend.build_factor(recipe(backend, method))
    for handles in ((*ENDS, MIDDLE), ENDS):
        wanted = recipe(backend, method, handles)
        calls.clear()
        held, factor = factor, rebuilt(backend, factor, wanted)
        assert calls == {"rebind": 1}
        assert (factor.report.reuse, factor.report.changed) == ("updated", "handles")
        assert held.is_released
        assert not factor.is_released
        same_as_new(backend, factor, wanted)


@pytest.mark.parametrize(("handles", "changed"), [(ENDS, "bending"), ((*ENDS, MIDDLE), "bending, handles")])
def test_a_painted_stiffness_with_or_without_a_handle_is_one_native_call(
    backend, calls: Counter, handles: tuple, changed: str
):
    wanted = recipe(backend, "thin_shell", handles, bending=np.linspace(0.5, 1.0, len(POINTS)))
    factor = backend.build_factor(recipe(backend, "thin_shell"))
    calls.clear()
    factor = rebuilt(backend, factor, wanted)
    assert calls == {"rebind": 1}
    assert (factor.report.reuse, factor.report.changed) == ("updated", changed)
    same_as_new(backend, factor, wanted)


@pytest.mark.parametrize("method", WITH_HANDLES)
def test_an_equal_recipe_costs_nothing(backend, calls: Counter, method: str):
    factor = backend.build_factor(recipe(backend, method))
    before = solved(factor, 2)
    calls.clear()
    again = rebuilt(backend, factor, recipe(backend, method))
    assert calls == {"rebind": 1}
    assert (again.report.reuse, again.report.changed) == ("kept", "")
    np.testing.assert_array_equal(solved(again, 2), before)
    with pytest.raises(errors.CancelledError):
        rebuilt(backend, again, recipe(backend, method), lambda _fraction, _stage: False)


@pytest.mark.parametrize("method", WITH_HANDLES)
def test_what_needs_a_new_solver_leaves_the_factor_as_it_is(backend, method: str):
    factor = backend.build_factor(recipe(backend, method))
    before = solved(factor, 2)
    other = next(name for name in WITH_HANDLES if name != method)
    for wanted in (
        recipe(backend, other),
        recipe(backend, method, points=POINTS + 1e-9),
        recipe(backend, method, faces=(FACES[0][1:], FACES[1][4:])),
    ):
        assert factor.prepare_rebind(wanted) is None
        assert not factor.is_released
    np.testing.assert_array_equal(solved(factor, 2), before)


@pytest.mark.parametrize(
    ("method", "option"),
    [(method, option) for method in WITH_HANDLES for option in other_options(BY_ID[method], len(POINTS))],
)
def test_another_option_updates_the_factor_or_leaves_it_as_it_is(backend, method: str, option: tuple):
    """The native method decides which; what it only says, it would have computed anew."""
    factor, (name, value) = backend.build_factor(recipe(backend, method)), option
    before = solved(factor, 2)
    wanted = recipe(backend, method, **{name: value})
    prepared = factor.prepare_rebind(wanted)
    if prepared is None:
        assert factor.prepare_rebind(recipe(backend, method, (*ENDS, MIDDLE), **{name: value})) is None
        assert not factor.is_released
        np.testing.assert_array_equal(solved(factor, 2), before)
    else:
        updated = backend.build_factor(wanted, None, prepared)
        assert factor.is_released
        # What a space method reads in each warp alone is no part of its weights.
        kept = ("kept", "") if BY_ID[method].is_space else None
        assert (updated.report.reuse, updated.report.changed) in (("updated", name), kept)
        same_as_new(backend, updated, wanted)


@pytest.mark.parametrize(
    ("method", "name", "value", "updates"),
    [
        ("thin_shell", "bending", np.linspace(0.5, 1.0, len(POINTS)), True),
        ("thin_shell", "laplacian", "uniform", False),
        ("arap", "rigidity", np.linspace(0.5, 1.0, len(POINTS)), False),
    ],
)
def test_which_options_update_a_factor(backend, method: str, name: str, value: object, updates: bool):
    factor = backend.build_factor(recipe(backend, method))
    assert (factor.prepare_rebind(recipe(backend, method, **{name: value})) is not None) is updates


def test_nobody_takes_a_factor_from_under_a_solve(backend):
    wanted = recipe(backend, "arap", (*ENDS, MIDDLE))
    factor = backend.build_factor(recipe(backend, "arap"))
    asked = []

    def progress(_fraction: float, _stage: str) -> bool:
        asked.append(factor.prepare_rebind(wanted))
        return True

    solved(factor, 2, progress=progress)
    assert asked
    assert set(asked) == {None}
    assert factor.prepare_rebind(wanted) is not None


def test_a_spent_factor_answers_nobody(backend):
    factor = backend.build_factor(recipe(backend, "thin_shell"))
    wanted = recipe(backend, "thin_shell", (*ENDS, MIDDLE))
    assert factor.prepare_rebind(wanted) is not None
    assert factor.prepare_rebind(wanted) is None
    with pytest.raises(errors.CancelledError):
        solved(factor, 2)


@pytest.mark.parametrize("method", ON_SURFACE)
def test_refusals_are_those_of_a_new_solver(backend, method: str):
    handles = (*ENDS, np.array([len(POINTS)]))
    with pytest.raises(errors.ConstraintError) as new:
        backend.build_factor(recipe(backend, method, handles))
    held = backend.build_factor(recipe(backend, method))
    with pytest.raises(errors.ConstraintError) as again:
        rebuilt(backend, held, recipe(backend, method, handles))
    assert str(again.value) == str(new.value)
    assert again.value.elements == new.value.elements
    held = backend.build_factor(recipe(backend, method))
    with pytest.raises(errors.CancelledError):
        rebuilt(backend, held, recipe(backend, method, (*ENDS, MIDDLE)), lambda _fraction, _stage: False)
