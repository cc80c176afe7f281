# SPDX-License-Identifier: GPL-3.0-or-later
"""What the pages about the C++ headers are made from."""

from pathlib import Path

from workshop import native_pages
from workshop.places import ROOT


def test_every_room_of_methods_is_on_the_first_page() -> None:
    page = native_pages.first_page()
    for room in ("native/core", "native/mesh", "native/methods/surface/linear", "native/methods/space/cage"):
        assert f"| `{room}` | {(ROOT / room / 'README.md').read_text().strip()} |" in page
    assert "bindings" not in page


def test_doxygen_reads_the_headers_and_leaves_the_bindings_out(tmp_path: Path) -> None:
    text = native_pages.settings(tmp_path / "rooms.md", tmp_path / "pages")
    assert f'INPUT = "{ROOT / "native"}" "{tmp_path / "rooms.md"}"' in text
    assert f'"{ROOT / "native" / "bindings"}"' in text
