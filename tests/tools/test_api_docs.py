# SPDX-License-Identifier: GPL-3.0-or-later
"""What the pages about the Python module and the C++ headers are made from."""

from pathlib import Path

from workshop import api_docs
from workshop.places import ROOT


def test_every_room_of_methods_is_on_the_first_page() -> None:
    page = api_docs.first_page()
    for room in ("native/core", "native/mesh", "native/methods/surface/linear", "native/methods/space/cage"):
        assert f"| `{room}` | {(ROOT / room / 'README.md').read_text().strip()} |" in page
    assert "bindings" not in page


def test_the_stubs_become_one_module_with_names_for_array_types(tmp_path: Path) -> None:
    (tmp_path / "__init__.pyi").write_text(
        "import numpy as np\nfrom numpy.typing import NDArray\nFloats = NDArray[np.float64]\n"
        "from ._cage import (\n    Green,\n)\nfrom ._cage import Cage\n"
    )
    (tmp_path / "_cage.pyi").write_text("class Cage: ...\nclass Green:\n    def warp(self) -> Floats: ...\n")
    names: dict = {}
    exec(api_docs.one_stub(sorted(tmp_path.glob("*.pyi"))), names)
    assert {"Floats", "Cage", "Green", "ArrayLike"} <= set(names)
    assert repr(names["Floats"]) == "<class 'Floats'>"


def test_the_modules_own_stubs_are_one_valid_source() -> None:
    compile(api_docs.one_stub(api_docs.stubs()), "sinew_native.pyi", "exec")


def test_doxygen_reads_the_headers_and_leaves_the_bindings_out(tmp_path: Path) -> None:
    text = api_docs.settings(tmp_path / "rooms.md", tmp_path / "pages")
    assert f'INPUT = "{ROOT / "native"}" "{tmp_path / "rooms.md"}"' in text
    assert f'"{ROOT / "native" / "bindings"}"' in text
