# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes pages about the C++ headers, by Doxygen."""

import tempfile
from pathlib import Path

from . import debian
from .places import ROOT, version
from .shell import must

NATIVE = ROOT / "native"
STYLE = Path(__file__).parent / "pages" / "native.css"
# The Python pages describe the bindings, so the C++ pages leave them out.
LEFT_OUT = ("bindings", "cmake")
YES = "EXTRACT_ALL FULL_PATH_NAMES JAVADOC_AUTOBRIEF QUIET RECURSIVE"
NO = "GENERATE_LATEX HAVE_DOT REPEAT_BRIEF SORT_MEMBER_DOCS WARN_IF_INCOMPLETE_DOC WARN_IF_UNDOCUMENTED"
SETTINGS = {
    **dict.fromkeys(YES.split(), "YES"),
    **dict.fromkeys(NO.split(), "NO"),
    "EXCLUDE_SYMBOLS": "std Eigen",
    "FILE_PATTERNS": "*.h",
    "HTML_OUTPUT": ".",
    "PROJECT_NAME": "Sinew",
    "TOC_INCLUDE_HEADINGS": "0",
}
# Tables in comments are indented by three spaces. Markdown keeps their columns from five spaces on.
KEEP_TABLES = "sed -E 's|^( *///)   |\\1     |'"


def rooms() -> dict[str, str]:
    """The path of each room of the library, with the sentence in its README."""
    readmes = sorted(NATIVE.rglob("README.md"))
    found = {path.parent.relative_to(ROOT).as_posix(): path.read_text("utf-8").strip() for path in readmes}
    return {room: text for room, text in found.items() if not set(LEFT_OUT) & set(room.split("/"))}


def first_page() -> str:
    """Markdown for Doxygen's first page: one row per room."""
    rows = [f"| `{room}` | {text} |" for room, text in rooms().items()]
    back = "[Manual, methods and the Python module](../../index.html)"
    return "\n".join(["# The C++ library", "", back, "", "| room | what it holds |", "|---|---|", *rows, ""])


def settings(main_page: Path, target: Path) -> str:
    values = SETTINGS | {
        "EXCLUDE": " ".join(f'"{NATIVE / room}"' for room in LEFT_OUT),
        "HTML_EXTRA_STYLESHEET": f'"{STYLE}"',
        "INPUT_FILTER": f'"{KEEP_TABLES}"',
        "INPUT": f'"{NATIVE}" "{main_page}"',
        "OUTPUT_DIRECTORY": f'"{target}"',
        "PROJECT_NUMBER": version(),
        "STRIP_FROM_PATH": f'"{ROOT}"',
        "USE_MDFILE_AS_MAINPAGE": f'"{main_page}"',
    }
    return "".join(f"{name} = {value}\n" for name, value in sorted(values.items()))


def write_native_pages(target: Path) -> None:
    debian.install(debian.API)
    target.mkdir(parents=True)
    with tempfile.TemporaryDirectory() as folder:
        main_page, configuration = Path(folder) / "rooms.md", Path(folder) / "Doxyfile"
        main_page.write_text(first_page(), encoding="utf-8")
        configuration.write_text(settings(main_page, target), encoding="utf-8")
        must(["doxygen", configuration], quiet=True)
