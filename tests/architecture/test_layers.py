# SPDX-License-Identifier: GPL-3.0-or-later
from pathlib import Path

import pytest

from .layers import ADDON_RANKS, INNER_RANKS, addon_offences
from .native_layers import NATIVE_RANKS, SUB_RANKS, SUFFIXES, native_offences, room_of, sub_room_of
from .tree import ROOT, files, grow


@pytest.mark.parametrize(
    ("path", "line", "reason"),
    [
        ("native/core/a.h", '#include "native/mesh/b.h"', "of higher rank"),
        ("native/mesh/a.h", '#include "native/solvers/b.h"', "of the same rank"),
        (
            "native/methods/space/cage/a.cpp",
            '#include "native/methods/surface/linear/b.h"',
            "of the same rank",
        ),
        (
            "native/methods/surface/linear/a.cpp",
            '#include "native/methods/surface/nonlinear/b.h"',
            "of higher rank",
        ),
        ("native/methods/surface/linear/a.cpp", '#include "b.h"', "from the repository root"),
        ("native/mesh/a.h", '#include "native/gizmos/b.h"', "no room that has a rank"),
        ("native/gizmos/a.h", "", "no room that has a rank"),
        ("native/mesh/a.cpp", "#include <pybind11/numpy.h>", "only bindings may include"),
        ("native/mesh/a.cpp", "#  include <Python.h>", "only bindings may include"),
        ("native/bindings/a.cpp", "#include <opensubdiv/far/stencilTable.h>", "only subdivision may include"),
        ("native/operators/a.cpp", "#include <tbb/parallel_for.h>", "only core may include"),
        ("native/operators/a.cpp", "#pragma omp parallel for", "never OpenMP"),
        ("native/core/simd/a.inl", '#include "native/mesh/b.h"', "of higher rank"),
        ("native/solvers/dense/a.h", '#include "native/solvers/b.h"', "of higher rank"),
        ("native/solvers/dense/a.h", '#include "native/solvers/optimization/b.h"', "of the same rank"),
        (
            "native/methods/space/cage/cage.h",
            '#include "native/methods/space/cage/inside/b.h"',
            "of higher rank",
        ),
        (
            "native/methods/space/cage/harmonic/a.h",
            '#include "native/methods/space/cage/harmonic.h"',
            "of higher rank",
        ),
        (
            "native/methods/space/cage/a.h",
            '#include "native/solvers/engines/b.h"',
            "from outside native/solvers",
        ),
        (
            "native/bindings/a.cpp",
            '#include "native/methods/space/cage/inside/b.h"',
            "from outside native/methods/space/cage",
        ),
        ("native/solvers/a.h", '#include "native/solvers/gizmos/b.h"', "no room that has a rank"),
        ("native/mesh/a.h", '#include "native/core/gizmos/b.h"', "no room that has a rank"),
        ("native/mesh/gizmos/a.h", "", "no room that has a rank"),
    ],
)
def test_native_offence_is_found(tmp_path: Path, path: str, line: str, reason: str) -> None:
    grow(tmp_path, {path: f"// first line\n{line}\n"})
    (offence,) = native_offences(tmp_path)
    assert offence.startswith(path)
    assert reason in offence
    assert line.strip() in offence


@pytest.mark.parametrize(
    ("path", "line"),
    [
        ("native/methods/surface/nonlinear/a.cpp", '#include "native/methods/surface/linear/b.h"'),
        ("native/methods/surface/nonlinear/a.cpp", '#include "native/methods/surface/nonlinear/b.h"'),
        ("native/bindings/a.cpp", "#include <pybind11/numpy.h>"),
        ("native/subdivision/a.cpp", "#include <opensubdiv/far/stencilTable.h>"),
        ("native/core/a.cpp", "#include <vector>"),
        ("native/solvers/a.h", '#include "native/solvers/engines/b.h"'),
        ("native/solvers/engines/a.h", '#include "native/solvers/supernodal/b.h"'),
        ("native/methods/space/cage/inside/a.h", '#include "native/methods/space/cage/cage.h"'),
        ("native/methods/space/cage/harmonic.h", '#include "native/methods/space/cage/harmonic/b.h"'),
        ("native/methods/space/cage/a.inl", '#include "native/core/simd/b.inl"'),
        ("native/methods/surface/linear/a.cpp", '#include "native/solvers/b.h"'),
    ],
)
def test_native_step_down_is_allowed(tmp_path: Path, path: str, line: str) -> None:
    assert native_offences(grow(tmp_path, {path: line})) == []


@pytest.mark.parametrize(
    ("path", "line", "reason"),
    [
        ("addon/core/a.py", "import bpy", "does without Blender"),
        ("addon/core/a.py", "from mathutils import Matrix", "does without Blender"),
        ("addon/backend/a.py", "from bpy.types import Object", "does without Blender"),
        ("addon/core/a.py", "from ..compat import nodes", "of the same rank"),
        ("addon/bake/a.py", "from ..operators.bind import run", "of higher rank"),
        ("addon/bake/a.py", "from .. import ui", "of higher rank"),
        ("addon/bake/a.py", "from ..gizmos import draw", "no room that has a rank"),
        ("addon/bake/a.py", "from ... import sinew", "no room that has a rank"),
        ("addon/core/methods/a.py", "from ..geometry import frames", "of the same rank"),
        ("addon/core/status.py", "from .errors import SinewError", "of higher rank"),
        ("addon/session/datablocks/a.py", "from ...ui import panel", "of higher rank"),
        ("addon/session/datablocks/a.py", "from ..evaluation import evaluate", "of higher rank"),
        ("addon/session/evaluation/a.py", "from ..results.result import shape_shown", "of the same rank"),
        ("addon/session/evaluation/a.py", "from .. import bind", "no room that has a rank"),
        ("addon/session/a.py", "from .live import evaluate", "is no room of session"),
        ("addon/preferences.py", "from .session import cache", "of higher rank"),
        ("addon/gizmos/a.py", "", "no room that has a rank"),
        ("addon/ui/a.py", "def f():\n    from ..session import cache", "at the top of the file"),
        ("addon/session/a.py", "import sinew_native", "only backend may import sinew_native"),
        ("addon/session/a.py", "from .._native import sinew_native", "only backend may import sinew_native"),
        ("addon/session/a.py", "importlib.import_module('sinew_native')", "only backend may import"),
        ("addon/ui/a.py", "from sinew.session import cache", "imports itself relatively"),
        ("addon/ui/a.py", "import bl_ext.user_default.sinew", "imports itself relatively"),
    ],
)
def test_addon_offence_is_found(tmp_path: Path, path: str, line: str, reason: str) -> None:
    (offence,) = addon_offences(grow(tmp_path, {path: line}))
    assert offence.startswith(path)
    assert reason in offence
    assert line.splitlines()[-1].strip() in offence if line else True


@pytest.mark.parametrize(
    ("path", "line"),
    [
        ("addon/__init__.py", "from . import handlers, operators, ui"),
        ("addon/backend/a.py", "from .._native import sinew_native"),
        ("addon/backend/a.py", "def load():\n    import sinew_native"),
        (
            "addon/bake/a.py",
            "from .cache import entries\nfrom ..backend import load\nfrom ..core.errors import E",
        ),
        ("addon/ui/a.py", "from .. import ids, session"),
        ("addon/ui/a.py", "from ..session.results import result"),
        ("addon/session/__init__.py", "from .edit.bind import bind"),
        ("addon/session/evaluation/a.py", "from . import binding\nfrom ..controls.cage import kind"),
        (
            "addon/session/controls/cage/a.py",
            "from . import kind\nfrom .. import kinds\nfrom ..kinds import a",
        ),
        ("addon/session/controls/kinds.py", "from .cage import kind"),
        (
            "addon/ui/a.py",
            "try:\n    from ..session import a\nexcept ImportError:\n    from ..session import b",
        ),
        ("addon/ui/a.py", "def draw():\n    import gpu"),
    ],
)
def test_addon_step_down_is_allowed(tmp_path: Path, path: str, line: str) -> None:
    assert addon_offences(grow(tmp_path, {path: line})) == []


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
    assert rooms - {"README", "blender_manifest", "LICENSE"} <= set(ADDON_RANKS) | {
        "wheels",
        "icons",
        "pictures",
        "rigs",
    }
    for room, ranks in INNER_RANKS.items():
        inside = files(ROOT, f"addon/{room}", ".py")
        assert {path.relative_to(ROOT / "addon" / room).parts[0].removesuffix(".py") for path in inside} == {
            "__init__",
            *ranks,
        }
