# SPDX-License-Identifier: GPL-3.0-or-later
"""The registry: complete rows, stable numbers, and keywords the native module really takes."""

import ast
import re
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from rows import default_options

from sinew.core import methods
from sinew.core.methods import (
    HANDLE_PARAMETERS,
    METHODS,
    Choice,
    Control,
    Family,
    Float,
    Int,
    Moved,
    Posed,
    group_property,
)


def test_ids_and_numbers_are_unique():
    assert len({method.id for method in METHODS}) == len(METHODS)
    assert len({method.number for method in METHODS}) == len(METHODS)


def test_numbers_in_files_never_change():
    """Files store the number: extend this table, never edit it."""
    known = {"thin_shell": 1, "arap": 2, "mean_value": 3, "positive_mean_value": 4, "harmonic": 5, "green": 6}
    known |= {"gradient_editing": 7, "rotation_invariant_coordinates": 8, "propagation": 9}
    known |= {"laplacian_editing": 10, "hierarchical_smoothing": 11, "volumetric_graph_laplacian": 12}
    known |= {"subdivision_editing": 13, "spline_surface": 14, "multiresolution": 20, "mesh_puppetry": 29}
    known |= {"handle_aware_isolines": 33, "subspace_laplacian": 34}
    assert known.items() <= {method.id: method.number for method in METHODS}.items()


@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.id)
def test_a_row_is_complete(method: methods.Method):
    assert re.fullmatch(r"[a-z][a-z0-9_]*", method.id)
    assert isinstance(method.family, Family)
    assert isinstance(method.control, Control)
    assert method.paper
    assert method.section
    assert method.picture
    assert method.search == method.search.lower()
    assert method.cost in (1, 2, 3)
    assert method.moves
    assert all(isinstance(moved, Moved) for moved in method.moves)
    assert all(isinstance(family, Family) for family in method.wraps)
    known = {parameter.id for parameter in (*method.parameters, *method.control_parameters)}
    assert len(method.main) <= 2, "what the panel shows before the other settings"
    assert set(method.main) <= known


AUTHORS = {
    name for method in METHODS for name in re.findall(r"[A-Z][a-zö-]+", method.paper) if name != "Green"
}


@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.id)
def test_what_a_method_does_and_where_it_fails_is_one_plain_sentence_each(method: methods.Method):
    for text in (method.summary, method.fails):
        assert re.match(r"[A-Z][a-z]+(s|h) ", f"{text.split()[0].rstrip(',')} "), "a verb comes first"
        assert not re.search(r"[.!?]|\b(et al|papers?|section|k_[sb])\b", text)
        assert not AUTHORS & set(re.findall(r"\w+", text))
        assert len(text) < 100
    assert not method.needs or re.match(r"(a|an) ", method.needs)


def test_labels_are_told_apart_and_so_are_the_names_of_the_literature():
    """Both switches of details have one name: a surface and what has none are never offered together."""
    labels = [method.label for method in METHODS if not method.wraps]
    assert len(set(labels)) == len(labels)
    assert {method.label for method in METHODS if method.wraps} == {"Keep Details"}
    assert len({method.known_as for method in METHODS}) == len(METHODS)


@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.id)
def test_parameters_teach(method: methods.Method):
    names = [parameter.id for parameter in method.parameters]
    names += [group_property(parameter) for parameter in method.paintable]
    assert len(set(names)) == len(names)
    for parameter in (*method.parameters, *method.handle_parameters, *method.control_parameters):
        assert parameter.label
        assert len(parameter.description) > 10
        assert not parameter.description.endswith(".")
        if isinstance(parameter, Choice):
            items = [item[0] for item in parameter.items]
            assert parameter.default in items
            assert all(len(item) == 3 and item[1] and item[2] for item in parameter.items)
        if isinstance(parameter, (Float, Int)):
            assert parameter.span.minimum <= parameter.default <= parameter.span.soft
            assert parameter.span.soft <= parameter.span.maximum


def test_an_iterative_method_can_show_an_early_step():
    """A drag asks for fewer of its ``max_iterations``."""
    for method in METHODS:
        solving = [parameter.id for parameter in method.parameters if not parameter.rebinds]
        assert ("max_iterations" in solving) == method.iterative, method.id


def test_handle_parameters_of_one_name_are_one():
    """Each handle stores a value once, whichever method reads it."""
    rows = {parameter for method in METHODS for parameter in method.handle_parameters}
    assert rows == set(HANDLE_PARAMETERS)
    assert len({parameter.id for parameter in rows}) == len(rows)


def test_the_menu_keeps_families_together_in_the_order_of_the_tutorial():
    families = [method.family for method in METHODS]
    assert families == sorted(families, key=list(Family).index)


@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.id)
def test_a_bind_costs_more_where_there_is_more_to_bind(method: methods.Method):
    """With every choice that a bind depends on."""
    plain = {row.id: row.default for row in method.parameters if row.rebinds}
    choices = [
        (row.id, item[0]) for row in method.parameters if isinstance(row, Choice) for item in row.items
    ]
    for name, value in [*choices, ("", None)]:
        options = {**plain, **({name: value} if name in plain else {})}
        small, large = (method.bind_seconds(points, 50, options) for points in (1000, 50_000))
        assert 0.0 < small < large
        by_control = [method.bind_seconds(50_000, size, options) for size in (50, 500, 5000)]
        assert by_control == sorted(by_control)
        if method.control is Control.CAGE:
            assert len(set(by_control)) == 3
        if not method.is_space:
            assert len(set(by_control)) == 1, "it has no such control"


CONDITIONAL = [(method, row) for method in METHODS for row in method.parameters if row.only_with]


@pytest.mark.parametrize(("method", "row"), CONDITIONAL, ids=lambda entry: entry.id)
def test_a_parameter_is_hidden_where_it_changes_nothing(method: methods.Method, row: methods.Parameter):
    """And shown where it does."""
    native = pytest.importorskip("sinew_native")
    x, y = (w.ravel() for w in np.meshgrid(np.arange(9.0), np.arange(5.0)))
    a = (np.arange(4)[:, None] * 9 + np.arange(8)).ravel()
    mesh = native.SurfaceMesh(np.column_stack([x, y, 0.1 * x * y]), np.stack([a, a + 1, a + 10, a + 9], 1))
    turned = [[0.6, 0.0, 0.8, 1.0], [0.0, 1.0, 0.0, 0.5], [-0.8, 0.0, 0.6, 2.0]]
    poses = np.stack([np.eye(4)[:3], turned])
    name, values = row.only_with
    (choice,) = [other for other in method.parameters if other.id == name]
    changes = {row.id: row.items[1][0] if isinstance(row, Choice) else not row.default}
    if isinstance(row, Float | Int):
        changes = {row.id: row.default + 1}
    solving = {} if row.rebinds else changes

    def shape(options: dict[str, object], keywords: dict[str, object]) -> np.ndarray:
        if method.control is Control.CAGE:
            return _in_cube(native, method, options)
        if method.is_space:
            return _in_space(native, method, mesh.points, options)
        surface = getattr(native, method.native)(mesh, **options)
        surface.set_handles([np.flatnonzero(x < 1), np.flatnonzero(x > 7)])
        return surface.solve(poses, **keywords)[0]

    assert set(values) < {item[0] for item in choice.items}
    for value, *_ in choice.items:
        options = {**default_options(method), name: value}
        changed = {**options, **changes} if row.rebinds else options
        moved = np.abs(shape(changed, solving) - shape(options, {})).max()
        assert (moved > 1e-6) == (value in values), value
        assert row.is_used(SimpleNamespace(**{name: value})) == (value in values)


def _in_space(native, method: methods.Method, points: np.ndarray, options: dict[str, object]) -> np.ndarray:
    """What the points of a lattice, or some of the points themselves, make of others when they move."""
    control = points[::7]
    if method.posed is Posed.CONTROL:  # whose handles are the points themselves
        made = getattr(native, method.native)(points, **options)
        made.bind(points + 0.2)
        return made.warp(points + np.sin(3.0 * points))
    if method.control is Control.LATTICE:
        w, v, u = np.meshgrid(*3 * [np.linspace(-1.0, 9.0, 7)], indexing="ij")
        control = np.stack((u, v, w), axis=-1).reshape(-1, 3)
    made = getattr(native, method.native)(control, **options)
    made.bind(points)
    return made.warp(control + np.random.default_rng(1).uniform(-0.5, 0.5, control.shape))


def _in_cube(native, method: methods.Method, options: dict[str, object]) -> np.ndarray:
    """What a twisted cube makes of points in its middle."""
    cube = np.stack(np.meshgrid(*3 * [[-1.0, 1.0]], indexing="ij"), -1).reshape(-1, 3)
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    made = getattr(native, method.native)(native.SurfaceMesh(cube, faces), **options)
    made.bind(0.2 * cube)
    return made.warp(cube * [1.0, 2.0, 0.5] + cube[:, [1, 2, 0]] * cube[:, [2, 0, 1]])


def test_what_is_painted_and_all_of_a_space_method_goes_into_the_factor():
    assert all(parameter.rebinds for method in METHODS for parameter in method.paintable)
    assert all(parameter.rebinds for method in METHODS if method.is_space for parameter in method.parameters)


@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.id)
def test_the_defaults_are_those_of_the_native_class(method: methods.Method):
    """An artist and a programmer who change nothing get the same shape."""
    types = Path(pytest.importorskip("sinew_native").__file__).with_name("sinew_native.pyi")
    parsed = ast.parse(types.read_text(encoding="utf-8")).body
    classes = {node.name: node for node in parsed if isinstance(node, ast.ClassDef)}
    native = classes[method.native]
    calls = [node for node in native.body if getattr(node, "name", "") == "__init__"]
    if not method.is_space:
        calls += [node for node in classes["SurfaceMethod"].body if getattr(node, "name", "") == "solve"]
    defaults = {}
    for call in reversed(calls):  # where both have a keyword, that of solve() is None: as for the constructor
        names = [argument.arg for argument in call.args.kwonlyargs]
        defaults |= dict(zip(names, map(ast.literal_eval, call.args.kw_defaults), strict=True))
    straight = ((0.0, 0.0), (1.0, 1.0))  # of a curve, which is None there
    assert {
        parameter.id: None if parameter.default == straight else parameter.default
        for parameter in method.parameters
    } == {parameter.id: defaults[parameter.id] for parameter in method.parameters}


@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.id)
def test_a_row_says_what_an_overlay_draws(method: methods.Method):
    native = pytest.importorskip("sinew_native")
    drawn = {"GRID": "control_grids", "GRAPH": "network", "BANDS": "bands"}
    has = {kind for kind, name in drawn.items() if hasattr(getattr(native, method.native), name)}
    assert has == ({method.draws} if method.draws else set())
