# SPDX-License-Identifier: GPL-3.0-or-later
from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree

import pytest

from .layers import ADDON_RANKS, INNER_RANKS, addon_offences
from .native_layers import NATIVE_RANKS, SUB_RANKS, SUFFIXES, native_offences, room_of, sub_room_of
from .picture import PICTURE, draw
from .tree import ROOT, files, grow


def judge(find: Callable[[Path], list[str]], root: Path, path: str, line: str, reason: str) -> None:
    """One offence, for the reason; none where there is no reason."""
    found = find(grow(root, {path: line}))
    assert len(found) == bool(reason), found
    for offence in found:
        assert offence.startswith(path)
        assert reason in offence
        assert line.splitlines()[-1].strip() in offence if line else True


@pytest.mark.parametrize(
    ("path", "target", "reason"),
    [
        ("core/a.h", "mesh/b.h", "of higher rank"),
        ("mesh/a.h", "solvers/b.h", "of the same rank"),
        ("methods/space/cage/a.cpp", "methods/surface/linear/b.h", "of the same rank"),
        ("methods/surface/linear/a.cpp", "methods/surface/nonlinear/b.h", "of higher rank"),
        ("mesh/a.h", "gizmos/b.h", "no room that has a rank"),
        ("core/simd/a.inl", "mesh/b.h", "of higher rank"),
        ("solvers/dense/a.h", "solvers/b.h", "of higher rank"),
        ("solvers/dense/a.h", "solvers/optimization/b.h", "of the same rank"),
        ("methods/space/cage/cage.h", "methods/space/cage/inside/b.h", "of higher rank"),
        ("methods/space/cage/harmonic/a.h", "methods/space/cage/harmonic.h", "of higher rank"),
        ("methods/space/cage/a.h", "solvers/engines/b.h", "from outside native/solvers"),
        ("bindings/a.cpp", "methods/space/cage/inside/b.h", "from outside native/methods/space/cage"),
        ("solvers/a.h", "solvers/gizmos/b.h", "no room that has a rank"),
        ("mesh/a.h", "core/gizmos/b.h", "no room that has a rank"),
        ("methods/surface/nonlinear/a.cpp", "methods/surface/linear/b.h", ""),
        ("methods/surface/nonlinear/a.cpp", "methods/surface/nonlinear/b.h", ""),
        ("solvers/a.h", "solvers/engines/b.h", ""),
        ("solvers/engines/a.h", "solvers/supernodal/b.h", ""),
        ("methods/space/cage/inside/a.h", "methods/space/cage/cage.h", ""),
        ("methods/space/cage/harmonic.h", "methods/space/cage/harmonic/b.h", ""),
        ("methods/space/cage/a.inl", "core/simd/b.inl", ""),
        ("methods/surface/linear/a.cpp", "solvers/b.h", ""),
    ],
)
def test_native_rooms_see_what_lies_below(tmp_path: Path, path: str, target: str, reason: str) -> None:
    judge(native_offences, tmp_path, f"native/{path}", f'// first line\n#include "native/{target}"\n', reason)


@pytest.mark.parametrize(
    ("path", "line", "reason"),
    [
        ("methods/surface/linear/a.cpp", '#include "b.h"', "from the repository root"),
        ("gizmos/a.h", "", "no room that has a rank"),
        ("mesh/gizmos/a.h", "", "no room that has a rank"),
        ("mesh/a.cpp", "#include <pybind11/numpy.h>", "only bindings may include"),
        ("mesh/a.cpp", "#  include <Python.h>", "only bindings may include"),
        ("bindings/a.cpp", "#include <opensubdiv/far/stencilTable.h>", "only subdivision may include"),
        ("operators/a.cpp", "#include <tbb/parallel_for.h>", "only core may include"),
        ("operators/a.cpp", "#pragma omp parallel for", "never OpenMP"),
        ("bindings/a.cpp", "#include <pybind11/numpy.h>", ""),
        ("subdivision/a.cpp", "#include <opensubdiv/far/stencilTable.h>", ""),
        ("core/a.cpp", "#include <vector>", ""),
    ],
)
def test_native_lines_of_other_libraries(tmp_path: Path, path: str, line: str, reason: str) -> None:
    judge(native_offences, tmp_path, f"native/{path}", line, reason)


@pytest.mark.parametrize(
    ("path", "line", "reason"),
    [
        ("core/a.py", "import bpy", "does without Blender"),
        ("core/a.py", "from mathutils import Matrix", "does without Blender"),
        ("backend/a.py", "from bpy.types import Object", "does without Blender"),
        ("core/a.py", "from ..compat import nodes", "of the same rank"),
        ("bake/a.py", "from ..operators.bind import run", "of higher rank"),
        ("bake/a.py", "from .. import ui", "of higher rank"),
        ("bake/a.py", "from ..gizmos import draw", "no room that has a rank"),
        ("bake/a.py", "from ... import sinew", "no room that has a rank"),
        ("core/methods/a.py", "from ..geometry import frames", "of the same rank"),
        ("core/status.py", "from .errors import SinewError", "of higher rank"),
        ("session/datablocks/a.py", "from ...ui import panel", "of higher rank"),
        ("session/datablocks/a.py", "from ..evaluation import evaluate", "of higher rank"),
        ("session/evaluation/a.py", "from ..results.result import shape_shown", "of the same rank"),
        ("session/evaluation/a.py", "from .. import bind", "no room that has a rank"),
        ("session/a.py", "from .live import evaluate", "is no room of session"),
        ("preferences.py", "from .session import cache", "of higher rank"),
        ("gizmos/a.py", "", "no room that has a rank"),
        ("ui/a.py", "def f():\n    from ..session import cache", "at the top of the file"),
        ("session/a.py", "import sinew_native", "only backend may import sinew_native"),
        ("session/a.py", "from .._native import sinew_native", "only backend may import sinew_native"),
        ("session/a.py", "importlib.import_module('sinew_native')", "only backend may import"),
        ("ui/a.py", "from sinew.session import cache", "imports itself relatively"),
        ("ui/a.py", "import bl_ext.user_default.sinew", "imports itself relatively"),
        ("__init__.py", "from . import handlers, operators, ui", ""),
        ("backend/a.py", "from .._native import sinew_native", ""),
        ("backend/a.py", "def load():\n    import sinew_native", ""),
        ("bake/a.py", "from .cache import a\nfrom ..backend import b\nfrom ..core.errors import E", ""),
        ("ui/a.py", "from .. import ids, session", ""),
        ("ui/a.py", "from ..session.results import result", ""),
        ("session/__init__.py", "from .edit.bind import bind", ""),
        ("session/evaluation/a.py", "from . import binding\nfrom ..controls.cage import kind", ""),
        ("session/controls/cage/a.py", "from . import kind\nfrom .. import kinds\nfrom ..kinds import a", ""),
        ("session/controls/kinds.py", "from .cage import kind", ""),
        ("ui/a.py", "try:\n    from ..session import a\nexcept E:\n    from ..session import b", ""),
        ("ui/a.py", "def draw():\n    import gpu", ""),
    ],
)
def test_addon_rooms_see_what_lies_below(tmp_path: Path, path: str, line: str, reason: str) -> None:
    judge(addon_offences, tmp_path, f"addon/{path}", line, reason)


@pytest.mark.parametrize("line", ["from ..handles import poses", "from ..handles.poses import pose"])
def test_kinds_of_control_stand_apart(tmp_path: Path, line: str) -> None:
    sources = {"addon/session/controls/handles/poses.py": "", "addon/session/controls/cage/a.py": line}
    (offence,) = addon_offences(grow(tmp_path, sources))
    assert "stand apart" in offence


def test_one_place_gives_operators_a_modal_handler() -> None:
    """Blender frees an operator with its first handler that ends: a second one would call what is freed."""
    adding = [path for path in files(ROOT, "addon", ".py") if "modal_handler_add" in path.read_text("utf-8")]
    assert [path.relative_to(ROOT).as_posix() for path in adding] == ["addon/operators/modal/staying.py"]


def test_every_room_that_exists_has_a_rank() -> None:
    """Also where a room holds no source yet."""
    sources = [p.relative_to(ROOT / "native").as_posix() for p in files(ROOT, "native", *SUFFIXES)]
    assert all((room := room_of(path)) and sub_room_of(path, room) is not None for path in sources)
    assert set(SUB_RANKS) <= set(NATIVE_RANKS)
    rooms = {
        p.stem if p.is_file() else p.name
        for p in (ROOT / "addon").iterdir()
        if not p.name.startswith(("_", "."))
    }
    no_code = {"README", "blender_manifest", "LICENSE", "wheels", "icons", "pictures", "rigs"}
    assert rooms - no_code <= set(ADDON_RANKS)
    for room, ranks in INNER_RANKS.items():
        inside = [path.relative_to(ROOT / "addon" / room) for path in files(ROOT, f"addon/{room}", ".py")]
        assert {path.parts[0].removesuffix(".py") for path in inside} == {"__init__", *ranks}


def test_the_picture_shows_every_room() -> None:
    shown = {"".join(node.itertext()) for node in ElementTree.fromstring(draw()).iter() if node.text}
    for room in (*ADDON_RANKS, *NATIVE_RANKS, *INNER_RANKS["session"]):
        assert room in shown


def test_the_picture_is_that_of_the_ranks() -> None:
    assert (ROOT / PICTURE).read_text(encoding="utf-8") == draw(), "renew it: tools/draw_architecture"
