# SPDX-License-Identifier: GPL-3.0-or-later
"""The state of the sources: licence lines, sizes, door-plates, versions, and words that do not belong."""

import ast
import re
import tomllib
from collections.abc import Iterator
from pathlib import Path

from .tree import files, lines

SOURCES = {".h", ".cpp", ".inl", ".in", ".py", ".pyi", ".cmake", ".sh", ".toml", ".yml", ".yaml"}
SOURCE_NAMES = {"CMakeLists.txt", "run", "setup", ".clang-format", ".clang-tidy"}
LONGEST = 600
LICENCE = "SPDX-License-Identifier: GPL-3.0-or-later"
# One-letter classes, so that this file holds none of them.
FORBIDDEN = {
    "a path of one machine": r"/(?:wor[k]|roo[t]|hom[e]/\w+)/(?!\*)",
    "a registry host": r"\b(?:pyp[i]\.org|pythonhoste[d]\.org|deb\.debia[n]\.org|registry\.npmj[s])",
    "an unfinished mark": r"\b(?:TOD[O]|FIXM[E]|XX[X]|NotImplementedErro[r])\b",
    "a wide catch": r"\bexcept(?:\s+(?:Base)?Exceptio[n]\b[^:]*)?\s*:|catch\s*\(\s*\.\.\.",
    # Those that destroy something crash on Windows where a thread ends: see native/core/kept.h.
    "a thread_local object that is no number or pointer": r"^\s*thread_loca[l] (?!(?:int|bool)\b|\w+\*)",
}

# Former names of what artists see; files and scripts keep their identifiers.
FORMER = re.compile(
    r"\b(?:Add (?:Handle|Fixed|Cage|Automatic Cage)|Set (?:Support|Rest)|Use Selected as|Change Faces|"
    r"(?:Field|Puppet) Drag|Drag Surface|Grab Region|Silhouette Sketch|Handles from Bones|Pin Bones|"
    r"Key (?:the Present|without an) Edit|Transfer Deformation|Morph to Mesh|Select Problems|Part Regions|"
    r"X-Axis Mirror|Smooth Rotations|Point Handles|Quads As)\b"
)

# What a compiler defines for one operating system, or for its C library.
SYSTEM = r"\b(?:_WIN(?:32|64)|_MSC_VER|__MINGW\w+|__APPLE__|__linux__|__unix__|__GLIBC__)\b"


def sources(root: Path) -> Iterator[Path]:
    """Everything that a person wrote for a machine to read."""
    for path in files(root):
        script = not path.suffix and path.parent.name in (
            "tools",
            "workshop",
            "tests",
            ".ci",
            "blend_samples",
        )
        if path.suffix in SOURCES or path.name in SOURCE_NAMES or (script and _has_shebang(path)):
            yield path


def licence_offences(root: Path) -> list[str]:
    """The licence stands in the first three lines (a shebang or an empty comment may come before)."""
    offences = []
    for path in sources(root):
        head = [line for number, line in lines(path) if number <= 3]
        if not any(LICENCE in line for line in head):
            offences.append(f"{path.relative_to(root)}:1: does not name its licence")
    return offences


def size_offences(root: Path) -> list[str]:
    counted = ((path, len(list(lines(path)))) for path in sources(root))
    return [f"{path.relative_to(root)}: {count} lines" for path, count in counted if count > LONGEST]


def word_offences(root: Path) -> list[str]:
    return [
        f"{path.relative_to(root)}:{number}: {what}: {line.strip()}"
        for path in [*sources(root), *files(root, ".", ".md", ".json", ".cff")]
        for number, line in lines(path)
        for what, pattern in FORBIDDEN.items()
        if re.search(pattern, line)
    ]


def former_name_offences(root: Path) -> list[str]:
    """What artists see has one name, in the add-on and on their pages."""
    pages = [*files(root, "docs/manual", ".md"), *files(root, "docs/methods", ".md"), root / "README.md"]
    return [
        f"{path.relative_to(root)}:{number}: a former name: {line.strip()}"
        for path in [*files(root, "addon", ".py"), *pages]
        if path.is_file()
        for number, line in lines(path)
        if FORMER.search(line)
    ]


def system_offences(root: Path) -> list[str]:
    """The same C++ compiles for every system; what differs between systems stands in ``core``."""
    return [
        f"{path.relative_to(root)}:{number}: only native/core may ask for a system: {line.strip()}"
        for path in files(root, "native", ".h", ".cpp", ".inl", ".in")
        if path.relative_to(root).parts[1] != "core"
        for number, line in lines(path)
        if re.search(SYSTEM, line)
    ]


def class_name_offences(root: Path) -> list[str]:
    """No two classes of one namespace share a name, as the linker would mix their functions."""
    first: dict[str, str] = {}
    offences = []
    for path in files(root, "native", ".h", ".cpp"):
        inside: list[str] = []  # the namespaces around a line
        for number, line in lines(path):
            if opened := re.match(r"namespace ?([\w:]*) ?\{", line):
                inside.append(opened[1])
            elif line.startswith("} // namespace"):
                inside.pop()
            elif "" not in inside and (found := re.match(r"(?:class|struct) (\w+)\b(?!::|.*[;<])", line)):
                place = f"{path.relative_to(root)}:{number}"
                name = "::".join([*inside, found[1]])
                if (other := first.setdefault(name, place)) != place:
                    offences.append(f"{place}: {name} is defined at {other}, too")
    return offences


def door_plate_offences(root: Path) -> list[str]:
    """Each room says in a README.md of one sentence what it is for."""
    offences = []
    rooms = [
        p for part in ("native", "addon") for p in [root / part, *(root / part).rglob("*")] if p.is_dir()
    ]
    for room in sorted(rooms):
        if not any(path.is_file() for path in files(root, room.relative_to(root).as_posix())):
            continue
        plate = room / "README.md"
        text = plate.read_text(encoding="utf-8").strip() if plate.is_file() else ""
        # A point inside a word (e.g. a file name) ends no sentence.
        if not text or not text.endswith(".") or len(re.findall(r"[.!?](?=\s|$)", text)) != 1:
            offences.append(f"{plate.relative_to(root)}: must be one sentence")
    return offences


def versions(root: Path) -> dict[str, str]:
    """Every place that states a version -> the version it states."""
    cmake = (root / "CMakeLists.txt").read_text(encoding="utf-8")
    manifest = tomllib.loads((root / "addon/blender_manifest.toml").read_text(encoding="utf-8"))
    citation = (root / "CITATION.cff").read_text(encoding="utf-8")
    changes = (root / "CHANGELOG.md").read_text(encoding="utf-8")
    return {
        "CMakeLists.txt": _first(r"project\(sinew\s+VERSION\s+([\d.]+)", cmake),
        "addon/blender_manifest.toml": manifest["version"],
        "addon/__init__.py (bl_info)": _bl_info_version(root / "addon/__init__.py"),
        "addon/ids.py (VERSION)": _first(
            r'^VERSION\s*(?::[^=]*)?=\s*"([\d.]+)"', (root / "addon/ids.py").read_text()
        ),
        "CITATION.cff": _first(r'^version:\s*"?([\d.]+)', citation),
        "CHANGELOG.md": _first(r"^## \[(\d[\d.]*)\]", changes),
    }


def _first(pattern: str, text: str) -> str:
    found = re.search(pattern, text, re.MULTILINE)
    return found.group(1) if found else "none"


def _bl_info_version(path: Path) -> str:
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.Assign) and getattr(node.targets[0], "id", "") == "bl_info":
            return ".".join(str(number) for number in ast.literal_eval(node.value)["version"])
    return "none"


def _has_shebang(path: Path) -> bool:
    with path.open("rb") as file:
        return file.read(2) == b"#!"
