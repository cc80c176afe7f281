# SPDX-License-Identifier: GPL-3.0-or-later
"""The state of the sources: licence lines, sizes, door-plates, versions, and words that do not belong."""

import re
from collections.abc import Iterable, Iterator
from pathlib import Path

from .tree import files, lines

SOURCES = {".h", ".cpp", ".inl", ".in", ".py", ".pyi", ".cmake", ".sh", ".toml", ".yml", ".yaml"}
SOURCE_NAMES = {"CMakeLists.txt", "run", "setup", ".clang-format", ".clang-tidy"}
SCRIPT_FOLDERS = ("tools", "workshop", "tests", ".ci", "blend_samples")
LONGEST = 600
LICENCE = "SPDX-License-Identifier: GPL-3.0-or-later"
# One-letter classes, so that this file holds none of them.
FORBIDDEN = {
    "a path of one machine": r"/(?:wor[k]|roo[t]|hom[e]/\w+)/(?!\*)",
    "a registry host": r"\b(?:pyp[i]\.org|pythonhoste[d]\.org|deb\.debia[n]\.org|registry\.npmj[s])",
    "an unfinished mark": r"\b(?:TOD[O]|FIXM[E]|XX[X]|NotImplementedErro[r])\b",
    # Clang takes it for granted that the memory is aligned for the type: see core/simd/lane_types.inl.
    "numbers read as another type": r"\breinterpret_cas[t]<(?!void|std::uintptr_t)",
    "a wide catch": r"\bexcept(?:\s+(?:Base)?Exceptio[n]\b[^:]*)?\s*:|catch\s*\(\s*\.\.\.",
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
        script = not path.suffix and path.parent.name in SCRIPT_FOLDERS
        if path.suffix in SOURCES or path.name in SOURCE_NAMES or (script and path.read_bytes()[:2] == b"#!"):
            yield path


def licence_offences(root: Path) -> list[str]:
    """The licence stands in the first three lines (a shebang or an empty comment may come before)."""
    heads = {path: path.read_text(encoding="utf-8").splitlines()[:3] for path in sources(root)}
    lacking = [path for path, head in heads.items() if not any(LICENCE in line for line in head)]
    return [f"{path.relative_to(root)}:1: does not name its licence" for path in lacking]


def size_offences(root: Path) -> list[str]:
    counted = ((path, len(list(lines(path)))) for path in sources(root))
    return [f"{path.relative_to(root)}: {count} lines" for path, count in counted if count > LONGEST]


def matching(root: Path, paths: Iterable[Path], patterns: dict[str, str | re.Pattern]) -> list[str]:
    """The lines in which a pattern stands, with what that is."""
    return [
        f"{path.relative_to(root)}:{number}: {what}: {line.strip()}"
        for path in paths
        for number, line in lines(path)
        for what, pattern in patterns.items()
        if re.search(pattern, line)
    ]


def word_offences(root: Path) -> list[str]:
    return matching(root, [*sources(root), *files(root, ".", ".md", ".json", ".cff")], FORBIDDEN)


def former_name_offences(root: Path) -> list[str]:
    """What artists see has one name, in the add-on and on their pages."""
    pages = [*files(root, "docs/manual", ".md"), *files(root, "docs/methods", ".md"), root / "README.md"]
    paths = filter(Path.is_file, [*files(root, "addon", ".py"), *pages])
    return matching(root, paths, {"a former name": FORMER})


def system_offences(root: Path) -> list[str]:
    """The same C++ compiles for every system; what differs between systems stands in ``core``."""
    paths = files(root, "native", ".h", ".cpp", ".inl", ".in")
    others = (path for path in paths if path.relative_to(root).parts[1] != "core")
    return matching(root, others, {"only native/core may ask for a system": SYSTEM})


def last_bit_offences(root: Path) -> list[str]:
    """The same motion gives the same bits: see ``circle`` in the frames of the add-on. Colours need not."""
    function = r"\bnp\.(?:sin|cos|tan|arc\w+|exp\w*|log\w*|cbrt|\w*power)\("
    rooms = (root / "addon/ui", root / "addon/core/geometry/distortion.py")
    paths = (path for path in files(root, "addon", ".py") if not {path, *path.parents}.intersection(rooms))
    return matching(root, paths, {"the last bit depends on where arrays lie": function})


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
    rooms = {path.parent for part in ("native", "addon") for path in files(root, part)}
    for room in sorted(rooms | {above for each in rooms for above in each.parents if root in above.parents}):
        plate = room / "README.md"
        text = plate.read_text(encoding="utf-8").strip() if plate.is_file() else ""
        # A point inside a word (e.g. a file name) ends no sentence.
        if not text.endswith(".") or len(re.findall(r"[.!?](?=\s|$)", text)) != 1:
            offences.append(f"{plate.relative_to(root)}: must be one sentence")
    return offences


VERSIONS = {
    "CMakeLists.txt": r"project\(sinew\s+VERSION\s+([\d.]+)",
    "addon/blender_manifest.toml": r'^version\s*=\s*"([\d.]+)"',
    "addon/__init__.py": r'^bl_info(?:.|\n)*?"version": \(([\d, ]+)\)',
    "addon/ids.py": r'^VERSION\s*(?::[^=]*)?=\s*"([\d.]+)"',
    "CITATION.cff": r'^version:\s*"?([\d.]+)',
    "CHANGELOG.md": r"^## \[(\d[\d.]*)\]",
}


def versions(root: Path) -> dict[str, str]:
    """Every place that states a version -> the version it states."""
    found = {}
    for name, pattern in VERSIONS.items():
        stated = re.search(pattern, (root / name).read_text(encoding="utf-8"), re.MULTILINE)
        found[name] = stated[1].replace(", ", ".") if stated else "none"
    return found
