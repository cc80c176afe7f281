# SPDX-License-Identifier: GPL-3.0-or-later
"""What the size and the connections of the code are, counted, each with a limit that it may not pass."""

import ast
import re
import subprocess
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from itertools import combinations_with_replacement
from pathlib import Path

from .native_layers import INCLUDE
from .tree import ROOT

CODE = {".py", ".pyi", ".cpp", ".h", ".inl", ".cmake", ".sh", ".toml", ""}  # a script has no suffix
SOURCES = {".py", ".cpp", ".h", ".inl"}
YARD = ("tests", "benchmarks", "blend_samples", "examples", "tools")  # what is not the product
RUN = 6  # lines that make a repetition
COMMON = 8  # places in which a run stands too often to be one
# Words for which the field has others.
PRIVATE = re.compile(
    r"rider|\b[Ss]eats?\b|_seats?\b|\bseat_|[Ee]nclosure|\bcures\b|upkeep|\bkeeper\b|take_along|several\.py",
    re.I,
)
LIST_OF_IMPORTS = re.compile(r"^from .* import \([^)]*\)", re.M)
TOKENS = re.compile(r"\"[^\"]*\"|'[^']*'|[A-Za-z_]\w*|\d[\w.]*|\S")


@dataclass(frozen=True)
class Count:
    name: str
    find: Callable[[], float]
    limit: float


@cache
def tracked(*folders: str) -> tuple[Path, ...]:
    """The files that git knows, below these folders of the checkout."""
    listed = subprocess.run(
        ["git", "ls-files", "-z", "--", *folders], cwd=ROOT, capture_output=True, text=True, check=True
    )
    return tuple(ROOT / name for name in listed.stdout.split("\0") if name and (ROOT / name).is_file())


@cache
def text(path: Path) -> str:
    return path.read_text(encoding="utf-8")


@cache
def parsed(path: Path) -> ast.Module:
    return ast.parse(text(path))


def of_kind(suffixes: set[str], *folders: str) -> Iterator[Path]:
    return (path for path in tracked(*folders) if path.suffix in suffixes)


def length(*folders: str) -> int:
    return sum(text(path).count("\n") for path in of_kind(CODE, *folders))


def found(pattern: str, *folders: str, outside: str = "") -> int:
    """Lines of Python below the folders, and not in the one ``outside``, in which the pattern stands."""
    kept = [path for path in of_kind({".py"}, *folders) if not outside or outside not in path.as_posix()]
    return sum(bool(re.search(pattern, line)) for path in kept for line in text(path).splitlines())


def crowded_folders() -> int:
    sizes = Counter(path.parent for path in of_kind(SOURCES, "native", "addon", *YARD))
    return sum(size > 20 for size in sizes.values())


def native_arrows() -> set[tuple[str, str]]:
    """Which room, a folder of native/, includes headers of which other one."""
    arrows = set()
    for path in of_kind(SOURCES, "native"):
        room = path.relative_to(ROOT / "native").parts[0]
        for line in text(path).splitlines():
            include = INCLUDE.match(line)
            if include and include[2].startswith("native/"):
                arrows.add((room, include[2].split("/")[1]))
    return {(one, other) for one, other in arrows if one != other}


def native_floors() -> int:
    """The rooms of the longest way down the arrows."""
    below = defaultdict(set)
    for one, other in native_arrows():
        below[one].add(other)

    def floors(room: str) -> int:
        return 1 + max(map(floors, below[room]), default=0)

    return max(map(floors, list(below)))


def functions(*folders: str) -> Iterator[ast.FunctionDef]:
    for path in of_kind({".py"}, *folders):
        yield from (node for node in ast.walk(parsed(path)) if isinstance(node, ast.FunctionDef))


def long_signatures() -> int:
    arguments = (function.args for function in functions("addon/session"))
    return sum(len(each.posonlyargs + each.args + each.kwonlyargs) > 6 for each in arguments)


def control_classes() -> int:
    """Classes of recipes that solve a control, or are derived from one that does."""
    found: set[str] = set()
    for node in parsed(ROOT / "addon/backend/recipes.py").body:
        if isinstance(node, ast.ClassDef):
            methods = {part.name for part in node.body if isinstance(part, ast.FunctionDef)}
            if "solve" in methods or found & {getattr(base, "id", "") for base in node.bases}:
                found.add(node.name)
    return len(found)


def handed_on() -> int:
    tree = parsed(ROOT / "addon/session/__init__.py")
    return sum(len(node.names) for node in tree.body if isinstance(node, ast.ImportFrom))


def repetitions() -> int:
    """Pairs of files, or files with themselves, that share six lines of the same shape, but for imports."""
    places: dict[tuple[str, ...], list[tuple[Path, int]]] = defaultdict(list)
    for path in of_kind(SOURCES, "native", "addon", *YARD):
        lines = LIST_OF_IMPORTS.sub("", text(path)).splitlines()
        shapes = [shape for line in lines if (shape := shape_of(line))]
        for start in range(len(shapes) - RUN + 1):
            places[tuple(shapes[start : start + RUN])].append((path, start))
    pairs = set()
    for stands in places.values():
        if 1 < len(stands) <= COMMON:
            for (one, at), (other, there) in combinations_with_replacement(stands, 2):
                if one != other or there - at >= RUN:
                    pairs.add((one, other))
    return len(pairs)


def naming(word: str) -> int:
    return sum(bool(re.search(rf"\b{word}\b", text(path))) for path in of_kind(CODE, "native", "addon"))


def private_words() -> int:
    """Files of code with words that the field has others for."""
    code = (path for path in of_kind(SOURCES, "native", "addon", *YARD) if path != Path(__file__))
    return sum(bool(PRIVATE.search(text(path))) for path in code)


def words_alone() -> int:
    """Lines of the methods' pages that are one word: a table that was broken."""
    pages = (path for path in tracked("docs/methods") if path.suffix == ".md")
    return sum(bool(re.fullmatch("[a-z]+", line)) for path in pages for line in text(path).splitlines())


def shape_of(line: str) -> str:
    """A line without its own names and numbers; nothing for imports, comments and single signs."""
    line = line.strip()
    if not line or line.startswith(("#", "//", "import ", "from ", "using ", '"""')) or len(line) < 4:
        return ""
    kept = {"def", "class", "return", "if", "for", "else", "assert", "const", "auto", "struct", "namespace"}
    return " ".join(
        word
        if word in kept or not (word[0].isalnum() or word[0] in "_\"'")
        else "s"
        if word[0] == '"'
        else "n"
        for word in TOKENS.findall(line)
    )


COUNTS = (
    Count("lines outside the product", lambda: length(*YARD), 77_000),
    Count("lines of tests / of product", lambda: length("tests") / length("native", "addon"), 0.65),
    Count("folders with more than 20 sources", crowded_folders, 2),
    Count("rooms of native", lambda: len({room for arrow in native_arrows() for room in arrow}), 13),
    Count("floors of native", native_floors, 6),
    Count("arrows between rooms of native", lambda: len(native_arrows()), 45),
    Count("files that name the parameter point_handles", lambda: naming("point_handles"), 3),
    Count("files that name the parameter relaxations", lambda: naming("relaxations"), 3),
    Count("stubs written by hand", lambda: len(list(of_kind({".pyi"}, "native"))), 0),
    Count("is_lattice( elsewhere", lambda: found(r"is_lattice\(", "addon", outside="session/targets"), 0),
    Count("hasattr(method in backend", lambda: found(r"hasattr\(method", "addon/backend"), 0),
    Count("control classes in backend/recipes.py", control_classes, 3),
    Count("functions of the session with more than 6 parameters", long_signatures, 0),
    Count("names handed on by session/__init__.py", handed_on, 0),
    Count("pairs of files that share 6 lines of one shape", repetitions, 260),
    Count("files with private words", private_words, 0),
    Count("lines of docs/methods that are one word", words_alone, 0),
    Count("inner modules by path", lambda: found(r"\broom\(\"", "tests/blender", outside="inside.py"), 20),
    Count("lines of README.md", lambda: text(ROOT / "README.md").count("\n"), 110),
)
