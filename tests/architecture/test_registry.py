# SPDX-License-Identifier: GPL-3.0-or-later
from pathlib import Path

import pytest

from .registry import camel_case, registry_offences
from .tree import grow

WHOLE = {
    "addon/core/methods/surface_linear.py": 'Method(id="thin_shell", native="ThinShell", '
    "family=Family.SURFACE_LINEAR)\n",
    "native/methods/surface/linear/thin_shell.h": "",
    "native/methods/surface/linear/thin_shell.cpp": "",
    "native/methods/surface/linear/responses/affine_basis.h": "",
    "native/methods/surface/linear/linear_system.h": "",
    "tests/native/methods/surface/linear/test_thin_shell.cpp": (
        "INSTANTIATE_TEST_SUITE_P(A, SurfaceContract, x);"
    ),
    "native/bindings/bind_surface.cpp": 'py::class_<ThinShell, Holder>(module, "ThinShell");\n',
    "blend_samples/plate.py": 'pose(method="thin_shell")\n',
}


def test_whole_method_is_accepted(tmp_path: Path) -> None:
    assert registry_offences(grow(tmp_path, WHOLE)) == []


@pytest.mark.parametrize(
    "missing", [name for name in WHOLE if name != "addon/core/methods/surface_linear.py"]
)
def test_missing_piece_is_found(tmp_path: Path, missing: str) -> None:
    tree = {name: content for name, content in WHOLE.items() if name != missing}
    if Path(missing).stem in ("affine_basis", "linear_system"):
        assert registry_offences(grow(tmp_path, tree)) == []  # parts and what a room shares are free
    else:
        assert registry_offences(grow(tmp_path, tree))


@pytest.mark.parametrize(
    ("path", "content", "reason"),
    [
        ("native/methods/surface/linear/propagation.h", "", "neither a row of the registry"),
        ("native/methods/surface/nonlinear/primo.cpp", "", "no header beside it"),
        ("native/methods/surface/linear/thin_shell_terms.h", "", "neither a row"),
        ("native/methods/surface/linear/responses/affine.cpp", "", "no header beside it"),
        ("native/bindings/bind_surface.cpp", 'py::class_<X>(m, "Shell");', "binds no class ThinShell"),
        (
            "tests/native/methods/surface/linear/test_thin_shell.cpp",
            "TEST(A, b)",
            "does not run SurfaceContract",
        ),
        ("blend_samples/plate.py", "thin_shells = 1", "no sample"),
        (
            "addon/core/methods/surface_linear.py",
            WHOLE["addon/core/methods/surface_linear.py"].replace("ThinShell", "Shell"),
            "must be ThinShell",
        ),
        (
            "addon/core/methods/surface_linear.py",
            WHOLE["addon/core/methods/surface_linear.py"] * 2,
            "two rows are called thin_shell",
        ),
        (
            "addon/core/methods/surface_linear.py",
            WHOLE["addon/core/methods/surface_linear.py"].replace("SURFACE_LINEAR", "SPACE_LINEAR"),
            "no thin_shell.h in native/methods/space/lattice",
        ),
    ],
)
def test_offence_is_found(tmp_path: Path, path: str, content: str, reason: str) -> None:
    offences = registry_offences(grow(tmp_path, WHOLE | {path: content}))
    assert any(reason in offence for offence in offences), offences


def test_class_names_follow_from_ids() -> None:
    assert [camel_case(name) for name in ("arap", "thin_shell", "positive_mean_value")] == [
        "Arap",
        "ThinShell",
        "PositiveMeanValue",
    ]
