# SPDX-License-Identifier: GPL-3.0-or-later
"""The module says itself what it is, and keeps the names that scripts use. Nothing here names a method."""

import ast
import inspect
import os
import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import sinew_native as sn

from . import cages, meshes, methods

NAMES = Path(__file__).parents[1] / "names" / "python.txt"
TYPES = Path(sn.__file__).with_name("sinew_native.pyi")  # by the build, from the signatures of the module
NODES = ast.parse(TYPES.read_text(encoding="utf-8")).body
CLASSES = {node.name: node for node in NODES if isinstance(node, ast.ClassDef)}
FUNCTIONS = {node.name: node for node in NODES if isinstance(node, ast.FunctionDef)}
PUBLIC = {name: value for name, value in vars(sn).items() if not name.startswith("_")}
SURFACE, SPACE = (
    [method.__name__ for method in every] for every in (methods.SURFACE_METHODS, methods.SPACE_METHODS)
)
ERRORS = {name: v for name, v in PUBLIC.items() if inspect.isclass(v) and issubclass(v, Exception)}


def members(node: ast.ClassDef) -> Iterator[ast.FunctionDef]:
    return (c for c in node.body if isinstance(c, ast.FunctionDef) and c.name != "__repr__")


def is_property(node: ast.FunctionDef) -> bool:
    return any(isinstance(d, ast.Name) and d.id == "property" for d in node.decorator_list)


def callables() -> Iterator[tuple[str, ast.FunctionDef, object]]:
    """Every function and method of the types with its counterpart."""
    for name, node in FUNCTIONS.items():
        yield name, node, getattr(sn, name, None)
    for owner, node in CLASSES.items():
        for child in members(node):
            if not is_property(child):
                yield f"{owner}.{child.name}", child, getattr(getattr(sn, owner, None), child.name, None)


def stated_parameters(function: object) -> list[str]:
    return [argument.split()[0] for argument in methods.arguments(function)]


def told(function: object) -> str:
    """The docstring after the signature."""
    text = inspect.getdoc(function)
    return text.split("\n", 1)[1].strip() if "\n" in text else ""


SHAPE = re.compile(r"\((?:[a-z]|\d[a-z]?)(?:_i)?,(?: ?[\w +]+,?)*\)")  # (n, 3), (k,), (3t, n), (3,)
ARRAYS = re.compile(r"\b(ArrayLike|Floats|Singles|Ints|NDArray|csc_matrix|csr_matrix)\b")
REFUSES = re.compile(r"\b(ArrayLike|spmatrix|SurfaceMethod|SpaceMethod)\b")


def test_types_name_everything_public_and_are_known() -> None:
    """An object whose type no editor is told would be `typing.Any`, or `object`."""
    assert PUBLIC.keys() == CLASSES.keys() | FUNCTIONS.keys()
    unknown = [
        f"{name}({argument.arg})"
        for name, node, _ in callables()
        for argument in [*node.args.args, *node.args.kwonlyargs]
        if argument.annotation and ast.unparse(argument.annotation) in ("typing.Any", "object")
    ]
    assert set(unknown) == {"SurfaceMethod.can_reuse(former)", "SpaceMethod.can_reuse(former)"}


@pytest.mark.parametrize("name", ERRORS)
def test_every_error_is_an_error_and_says_when_it_is_raised(name: str) -> None:
    error = ERRORS[name]
    assert issubclass(error, sn.Error)
    assert error("x").elements == []
    assert error("x").element_kind == ""
    assert name == "Error" or vars(error)["__doc__"].startswith("Raised when ")


def test_version_is_three_numbers_and_instructions_are_those_of_the_processor() -> None:
    assert re.fullmatch(r"\d+\.\d+\.\d+", sn.__version__)
    assert sn.instructions() in ("SSE4.2", "AVX2", "AVX-512", "NEON")
    if os.path.exists("/proc/cpuinfo") and sn.instructions() != "NEON":
        with open("/proc/cpuinfo", encoding="utf-8") as info:
            flags = next(line for line in info if line.startswith("flags")).split()
        wide = "avx512dq" in flags and "avx512vl" in flags
        assert sn.instructions() == ("AVX-512" if wide else "AVX2" if "avx2" in flags else "SSE4.2")


@pytest.mark.parametrize("name", PUBLIC)
def test_every_public_name_has_a_docstring_of_its_own(name: str) -> None:
    """A class does not count the docstring of its base."""
    value = PUBLIC[name]
    assert len((vars(value).get("__doc__") if inspect.isclass(value) else value.__doc__) or "") > 15, name


@pytest.mark.parametrize(
    ("name", "node", "function"), list(callables()), ids=lambda v: v if isinstance(v, str) else ""
)
def test_docstrings_tell_what_a_function_does_with_shapes_and_errors(name: str, node, function) -> None:
    """Wherever an array goes in or comes out, and wherever input may be refused; with progress, cancelled."""
    text, inputs = told(function), ast.unparse(node.args)
    assert len(text) > 15, "no docstring"
    assert not ARRAYS.search(inputs + ast.unparse(node.returns)) or SHAPE.search(text), "no shape"
    assert not REFUSES.search(inputs) or "Raises" in text, "it does not say what it refuses"
    assert "progress" not in inputs or "Cancelled" in text


@pytest.mark.parametrize("name", CLASSES)
def test_every_property_tells_what_it_is(name: str) -> None:
    for child in members(CLASSES[name]):
        if is_property(child):
            text = vars(PUBLIC[name])[child.name].__doc__
            assert text, f"{name}.{child.name}"
            assert not ARRAYS.search(ast.unparse(child.returns)) or SHAPE.search(text), f"{name}.{child.name}"


@pytest.mark.parametrize("name", [*SURFACE, *SPACE])
def test_a_method_is_its_constructor_and_its_own_words(name: str) -> None:
    """What all methods of a level can do is bound once: signatures cannot drift apart."""
    level = sn.SurfaceMethod if issubclass(PUBLIC[name], sn.SurfaceMethod) else sn.SpaceMethod
    common = {member for member in vars(level) if not member.startswith("_")}
    assert not common & vars(PUBLIC[name]).keys()
    assert all(inspect.getattr_static(PUBLIC[name], member) is vars(level)[member] for member in common)


CUBE = sn.SurfaceMesh(cages.CUBE, cages.QUADS)


def made(name: str) -> object:
    """A method on the cube, or moved by its vertices."""
    return methods.made(PUBLIC[name], CUBE)


@pytest.mark.parametrize("name", SURFACE)
def test_surface_methods_agree_on_shapes_and_refusals(name: str) -> None:
    method = made(name)
    assert method.rest.vertex_count == 8
    report = method.set_handles([[0, 1], [6, 7]])
    assert (report.reuse, report.changed, report.handle_count) == ("anew", "", 2)
    poses = np.stack([np.eye(3, 4)] * 2)
    out = np.empty((8, 3), dtype=np.float32)
    positions, solved = method.solve(poses, incoming=CUBE.points, from_rest=[True, False], start=CUBE.points)
    assert (positions.shape, positions.dtype, solved.converged) == ((8, 3), np.float64, True)
    assert method.solve(poses, out=out)[0] is out
    for wrong in ({"poses": poses[:1]}, {"incoming": CUBE.points[1:]}, {"start": [[0.0]]}):
        with pytest.raises(sn.InvalidConstraint):
            method.solve(**{"poses": poses} | wrong)
    for wrong in ({"max_iterations": -1}, {"tolerance": np.nan}):
        with pytest.raises(sn.InvalidOption):
            method.solve(poses, **wrong)
    with pytest.raises(sn.InvalidConstraint) as refused:
        method.set_handles([[0, 1], [1, 2]])
    assert (refused.value.elements, refused.value.element_kind) == ([1], "vertex")
    with pytest.raises(sn.Cancelled):
        method.set_handles([[0]], progress=lambda _share, _stage: False)
    again = made(name)
    assert again.can_reuse(method)
    assert again.rebind(method, [[0, 1], [6, 7]]).reuse == "kept"
    assert not made(name).can_reuse(method), "it has no handles any more"
    assert not again.can_reuse(object())


@pytest.mark.parametrize("name", SPACE)
def test_space_methods_agree_on_shapes_and_refusals(name: str) -> None:
    method, points = made(name), np.random.default_rng(1).uniform(0.2, 0.8, (20, 3))
    control = methods.control(PUBLIC[name], CUBE)
    if "base" in methods.required(type(method)):  # the vertices of its mesh alone can be bound
        points = CUBE.points[np.arange(20) % 8]
    with pytest.raises(sn.InvalidConstraint):
        method.warp(control)
    report = method.bind(points)
    assert (report.reuse, report.changed, report.point_count) == ("anew", "", 20)
    entering, out = points + [1.0, 2.0, 3.0], np.empty((20, 3), dtype=np.float32)
    np.testing.assert_array_equal(method.warp(control), points)
    np.testing.assert_array_equal(method.warp(control, incoming=entering), entering)
    moved = control * 1.1
    way = method.warp(moved, incoming=entering) - entering
    np.testing.assert_allclose(way, method.warp(moved) - points, atol=1e-15)
    assert method.warp(moved, out, incoming=entering) is out
    np.testing.assert_array_equal(out, method.warp(moved, incoming=entering).astype(np.float32))
    for wrong in ({"cage_points": moved[1:]}, {"cage_points": moved, "incoming": points[1:]}):
        with pytest.raises(sn.InvalidConstraint):
            method.warp(**wrong)
    entering[3] = np.nan
    with pytest.raises(sn.InvalidConstraint) as refused:
        method.warp(moved, incoming=entering)
    assert (refused.value.elements, refused.value.element_kind) == ([3], "vertex")
    again, before = made(name), method.warp(moved)
    assert again.can_reuse(method, points)
    assert not again.can_reuse(method, points[1:])
    assert not again.can_reuse(object(), points)
    with pytest.raises(sn.Cancelled):
        again.rebind(method, points, lambda _share, _stage: False)
    assert again.rebind(method, points).reuse == "kept"
    np.testing.assert_array_equal(again.warp(moved), before)
    with pytest.raises(sn.InvalidConstraint):
        method.warp(moved)
    report = method.rebind(again, points[1:])
    assert (report.reuse, report.changed) == ("anew", "points")
    np.testing.assert_array_equal(again.warp(moved), before)


def options(name: str) -> Iterator[tuple[str, object, list[object]]]:
    """The keywords of a constructor that have a default, with this and values that may be another one."""
    (made_by,) = (node for node in members(CLASSES[name]) if node.name == "__init__")
    for argument, value in zip(made_by.args.kwonlyargs, made_by.args.kw_defaults, strict=True):
        default = ast.literal_eval(value)
        if isinstance(default, str):
            names = re.findall(r"'(\w+)'", ast.unparse(argument.annotation))
            yield argument.arg, default, [other for other in names if other != default]
        elif isinstance(default, bool):
            yield argument.arg, default, [not default]
        elif isinstance(default, int):
            yield argument.arg, default, [default + 1, default - 1, default - 2, default + 24]
        elif default is not None:
            yield argument.arg, default, [0.5 * default or 0.25, 1.5 * default]


LATTICES = ("Ffd", "InverseFfd")  # of which the lattice counts as a whole
OPTIONS = [(name, *option) for name in (*SURFACE, *SPACE) for option in options(name) if option[2]]
REBOUND = [option for option in OPTIONS if option[0] not in LATTICES]


@pytest.mark.parametrize(
    ("name", "option", "default", "others"), REBOUND, ids=[f"{name}-{option}" for name, option, *_ in REBOUND]
)
def test_a_rebind_names_an_option_that_changed(name: str, option: str, default: object, others: list) -> None:
    """Where only solves read an option, all is taken over."""
    for other in others:
        try:
            changed = methods.made(PUBLIC[name], CUBE, **{option: other})
        except sn.InvalidOption:
            continue
        break
    bound = [[0, 1], [6, 7]] if issubclass(PUBLIC[name], sn.SurfaceMethod) else CUBE.points
    if issubclass(PUBLIC[name], sn.CageCoordinates):
        bound = 0.3 + 0.4 * bound  # inside the smooth surface, too
    former, same = made(name), methods.made(PUBLIC[name], CUBE, **{option: default})
    (former.set_handles if isinstance(former, sn.SurfaceMethod) else former.bind)(bound)
    assert same.rebind(former, bound).reuse == "kept"
    report = changed.rebind(same, bound)
    of_binds = ("Rbf", "VectorField")
    is_read_by_solves = option == "max_iterations" or (option == "tolerance" and name not in of_binds)
    assert (report.reuse == "kept") == is_read_by_solves
    assert report.changed == ("" if is_read_by_solves else option)


@pytest.mark.parametrize(
    ("name", "option"), [(name, option) for name, option, default, _ in OPTIONS if isinstance(default, str)]
)
def test_a_choice_that_nobody_knows_is_refused_by_name(name: str, option: str) -> None:
    with pytest.raises(sn.InvalidOption, match=f"{option}.*'no choice' is not one of"):
        methods.made(PUBLIC[name], CUBE, **{option: "no choice"})


def described(name: str) -> dict[str, str]:
    """What the docstring of a constructor says about its options."""
    text = inspect.getdoc(PUBLIC[name].__init__)
    return dict(re.findall(r"^(\w+) {2,}(.*(?:\n {4,}.*)*)", text, re.MULTILINE))


def beyond(words: str) -> list[float]:
    """Numbers outside the range that these words state first, if any."""
    number = r"(-?\d+(?:\.\d+)?)"
    ranges = rf">= {number}|> {number}|in \[{number}, {number}([\])])|(?<!\S){number} to {number}\b"
    stated = re.search(ranges, words)
    if not stated:
        return []
    least, bound, low, high, end, first, last = stated.groups()
    if low:
        return [float(low) - 0.1, float(high) + (0.1 if end == "]" else 0.0)]
    return [float(bound)] if bound else [float(first) - 1, float(last) + 1] if first else [float(least) - 1]


NUMBERS = [
    (name, option, type(default), beyond(described(name).get(option, "")))
    for name, option, default, _ in OPTIONS
    if type(default) in (int, float) and option not in ("exit_face", "smooth", "threshold")  # any number
]
PAINTED = [
    (name, option) for name in SURFACE for option, words in described(name).items() if "(n,) painted" in words
]


@pytest.mark.parametrize(("name", "option", "kind", "outside"), NUMBERS)
def test_numbers_outside_the_range_of_an_option_are_refused(name, option, kind, outside) -> None:
    assert outside or option in ("cut_off", "inner", "outer", "scale"), "the docstring states no range"
    for value in [*map(kind, outside), *((np.nan, np.inf) if kind is float else ())]:
        with pytest.raises(sn.InvalidOption, match=option):
            methods.made(PUBLIC[name], CUBE, **{option: value})
    if kind is float:
        with pytest.raises(TypeError):
            methods.made(PUBLIC[name], CUBE, **{option: None})


@pytest.mark.parametrize(("name", "option"), PAINTED)
def test_paint_that_means_nothing_is_refused_and_named_and_black_is_solved(name: str, option: str) -> None:
    for value in (-1.0, np.nan, np.inf, [], [1.0, 1.0], np.ones((8, 1))):
        with pytest.raises(sn.InvalidOption, match=option):
            methods.made(PUBLIC[name], CUBE, **{option: value})
    with pytest.raises(sn.InvalidOption) as refused:
        methods.made(PUBLIC[name], CUBE, **{option: [1, 1, -1, 1, 1, np.inf, 1, 1]})
    assert (refused.value.elements, refused.value.element_kind) == ([2, 5], "vertex")
    black = np.repeat([1.0, 0.0, 1.0], 27)
    for other in [{}] + [{"measure": "stiffness"}] * ("measure" in described(name)):
        surface, _points, _handles = methods.bound(PUBLIC[name], **{option: black}, **other)
        assert np.isfinite(surface.solve(meshes.BENT)[0]).all()


@pytest.mark.parametrize("name", sorted(CLASSES.keys() - ERRORS.keys()))
def test_every_class_prints_itself_and_a_report_in_words_of_its_own(name: str):
    """Errors print themselves as all exceptions do."""
    assert PUBLIC[name].__repr__ is not object.__repr__
    assert "__repr__" in vars(PUBLIC[name]) or not name.endswith(("Report", "Diagnosis"))


def test_objects_say_what_they_hold_and_a_derived_class_its_own_name():
    square = sn.SurfaceMesh(np.eye(4, 3), np.array([[0, 1, 2], [0, 2, 3]]))
    shell = sn.ThinShell(square)
    shell.set_handles([[0, 1, 2], [3]])
    assert repr(shell) == "<ThinShell: 4 vertices>"
    assert repr(sn.AffineBasis(shell)) == "<AffineBasis: 4 vertices, 2 handles>"
    for budget, says in ((1, "not converged"), (None, "converged")):
        report = methods.bound(sn.Arap, 12)[0].solve(meshes.BENT, max_iterations=budget)[1]
        assert repr(report).endswith(f", {says}>")
    assert repr(sn.Green(CUBE)) == "<Green: a cage of 8 vertices>"
    factor = sn.SpdFactor(pytest.importorskip("scipy.sparse").identity(3, format="csc"))
    assert re.fullmatch(r"<SpdFactor: 3 rows, \d+ entries>", repr(factor))

    class Mine(sn.Green):
        """A user's class."""

    assert repr(Mine(CUBE)) == "<Mine: a cage of 8 vertices>"


def named(path: str, thing: object) -> Iterator[str]:
    """A line for a thing, with its arguments in their order, and one for each of its public members."""
    if inspect.isclass(thing):
        made_by = stated_parameters(thing.__init__) if "__init__" in vars(thing) else []
        yield f"{path}({', '.join(made_by)})".removesuffix("(type(self))").removesuffix("()")
        for name, member in vars(thing).items():
            if not name.startswith("_"):
                yield from named(f"{path}.{name}", member)
    elif callable(thing):
        yield f"{path}({', '.join(stated_parameters(thing))})"
    else:
        yield path


def test_the_module_keeps_its_names() -> None:
    now = sorted(line for name, thing in PUBLIC.items() for line in named(name, thing))
    assert now == NAMES.read_text(encoding="utf-8").splitlines()
