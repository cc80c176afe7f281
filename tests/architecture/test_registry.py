# SPDX-License-Identifier: GPL-3.0-or-later
from pathlib import Path

import pytest

from .registry import registry_offences
from .tree import grow

ROWS = "addon/core/methods/surface_linear.py"
CONTRACT = "tests/native/methods/surface/linear/test_thin_shell.cpp"
WHOLE = {
    ROWS: 'Method(id="thin_shell", family=Family.SURFACE_LINEAR)\n',
    "native/methods/surface/linear/thin_shell.h": "",
    "native/methods/surface/linear/thin_shell.cpp": "",
    "native/methods/surface/linear/responses/affine_basis.h": "",
    "native/methods/surface/linear/linear_system.h": "",
    CONTRACT: "INSTANTIATE_TEST_SUITE_P(A, SurfaceContract, x);",
    "native/bindings/bind_surface.cpp": 'py::class_<ThinShell, Holder>(module, "ThinShell");\n',
    "blend_samples/plate.py": 'pose(method="thin_shell")\n',
}


def test_whole_method_is_accepted(tmp_path: Path) -> None:
    assert registry_offences(grow(tmp_path, WHOLE)) == []


@pytest.mark.parametrize("missing", [name for name in WHOLE if name != ROWS])
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
        (CONTRACT, "TEST(A, b)", "does not run SurfaceContract"),
        ("blend_samples/plate.py", "thin_shells = 1", "no sample"),
        (ROWS, WHOLE[ROWS] * 2, "two rows are called thin_shell"),
        (ROWS, WHOLE[ROWS].replace("SURFACE", "SPACE"), "no thin_shell.h in native/methods/space/lattice"),
    ],
)
def test_offence_is_found(tmp_path: Path, path: str, content: str, reason: str) -> None:
    offences = registry_offences(grow(tmp_path, WHOLE | {path: content}))
    assert any(reason in offence for offence in offences), offences
