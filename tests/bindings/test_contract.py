# SPDX-License-Identifier: GPL-3.0-or-later
"""The module is what its stub says, and says itself what it is."""

import ast
import inspect
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

import sinew_native as sn

STUB = Path(__file__).resolve().parents[2] / "native" / "bindings" / "sinew_native.pyi"
TREE = ast.parse(STUB.read_text(encoding="utf-8"))
CLASSES = {node.name: node for node in TREE.body if isinstance(node, ast.ClassDef)}
FUNCTIONS = {node.name: node for node in TREE.body if isinstance(node, ast.FunctionDef)}


def members(node: ast.ClassDef) -> Iterator[ast.FunctionDef]:
    return (child for child in node.body if isinstance(child, ast.FunctionDef))


def is_property(node: ast.FunctionDef) -> bool:
    return any(isinstance(d, ast.Name) and d.id == "property" for d in node.decorator_list)


def callables() -> Iterator[tuple[str, ast.FunctionDef, object]]:
    """Every function and method of the stub with its counterpart."""
    for name, node in FUNCTIONS.items():
        yield name, node, getattr(sn, name, None)
    for owner, node in CLASSES.items():
        for child in members(node):
            if not is_property(child):
                yield f"{owner}.{child.name}", child, getattr(getattr(sn, owner, None), child.name, None)


def parameters(node: ast.FunctionDef) -> list[str]:
    named = [a.arg for a in node.args.posonlyargs + node.args.args if a.arg != "self"]
    return named + (["*"] if node.args.kwonlyargs else []) + [a.arg for a in node.args.kwonlyargs]


def stated_parameters(function: object) -> list[str]:
    """Of pybind11's first docstring line."""
    line = inspect.getdoc(function).splitlines()[0]
    inside = line[line.index("(") + 1 : line.rindex(")")]
    inside = re.sub(r"\[[^\[\]]*(?:\[[^\[\]]*\])*[^\[\]]*\]", "", inside)  # type[a, b] has commas of its own
    names = [part.split(":")[0].split("=")[0].strip() for part in inside.split(",")]
    return [name for name in names if name and name != "self"]


EVERY_CALLABLE = pytest.mark.parametrize(
    ("name", "node", "function"), list(callables()), ids=lambda v: v if isinstance(v, str) else ""
)
SHAPE = re.compile(r"\((?:[a-z]|\d[a-z])(?:_i)?,(?: ?[\w ]+,?)*\)")  # (n, 3), (k,), (3t, n)
CALLED_BY_THEIR_NAME = {"clean", "vertex_count", "face_count", "component_count", "handle_count", "size"}


def test_stub_names_everything_public() -> None:
    public = {name for name in vars(sn) if not name.startswith("_")}
    assert public == CLASSES.keys() | FUNCTIONS.keys()


@pytest.mark.parametrize("name", CLASSES)
def test_stub_names_every_public_member(name: str) -> None:
    stated = {child.name for child in members(CLASSES[name]) if not child.name.startswith("_")}
    fields = {child.target.id for child in CLASSES[name].body if isinstance(child, ast.AnnAssign)}
    there = {member for member in vars(getattr(sn, name)) if not member.startswith("_")}
    if issubclass(getattr(sn, name), Exception):
        there = {member for member in there if member in ("elements", "element_kind")}
    assert there == stated | fields


@EVERY_CALLABLE
def test_stub_and_module_agree_on_parameters(name: str, node: ast.FunctionDef, function: object) -> None:
    assert stated_parameters(function) == parameters(node)


def test_every_error_is_an_error() -> None:
    for name in ("InvalidMesh", "InvalidConstraint", "InvalidOption", "FactorizationFailed", "Cancelled"):
        error = getattr(sn, name)
        assert issubclass(error, sn.Error)
        assert error.__doc__
        assert error("x").elements == []
        assert error("x").element_kind == ""
    assert issubclass(sn.Error, Exception)


def test_version_is_three_numbers() -> None:
    assert re.fullmatch(r"\d+\.\d+\.\d+", sn.__version__)


@EVERY_CALLABLE
def test_every_function_tells_what_it_does(name: str, node: ast.FunctionDef, function: object) -> None:
    text = inspect.getdoc(function)
    told = text.split("\n", 1)[1].strip() if "\n" in text else ""
    assert len(told) > 15, f"{name} has no docstring"


@pytest.mark.parametrize(
    "name",
    [
        "SurfaceMesh.__init__",
        "ThinShell.__init__",
        "ThinShell.set_handles",
        "ThinShell.solve",
        "Arap.__init__",
        "Arap.set_handles",
        "Arap.solve",
        "Arap.energy",
        "AffineBasis.solve",
        "SpdFactor.__init__",
        "SpdFactor.solve",
        "laplacian",
        "mass",
        "laplacian_power",
        "gradient",
        "divergence",
        "fit_rotations",
    ],
)
def test_docstrings_give_shapes(name: str) -> None:
    function = sn
    for part in name.split("."):
        function = getattr(function, part)
    assert SHAPE.search(inspect.getdoc(function).split("\n", 1)[1])


@pytest.mark.parametrize(
    "name", ["ThinShell.set_handles", "ThinShell.solve", "Arap.set_handles", "Arap.solve"]
)
def test_docstrings_give_errors(name: str) -> None:
    owner, method = name.split(".")
    assert "Raises" in inspect.getdoc(getattr(getattr(sn, owner), method))


@pytest.mark.parametrize("name", CLASSES)
def test_every_property_tells_what_it_is(name: str) -> None:
    for child in members(CLASSES[name]):
        if is_property(child) and child.name not in CALLED_BY_THEIR_NAME:
            assert getattr(sn, name).__dict__[child.name].__doc__, f"{name}.{child.name}"


def test_surface_methods_take_the_same_keywords() -> None:
    common = {"poses", "incoming", "from_rest", "start", "max_iterations", "progress"}
    for method in (sn.ThinShell, sn.Arap):
        assert common <= set(stated_parameters(method.solve))
        assert {"handles", "weights", "progress"} <= set(stated_parameters(method.set_handles))
