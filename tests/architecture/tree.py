# SPDX-License-Identifier: GPL-3.0-or-later
"""Reading a checkout, or a made-up one."""

from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
GENERATED = {".git", ".build", "dist", "output", "__pycache__", ".venv", "build", "node_modules"}


def files(root: Path, folder: str = ".", *suffixes: str) -> Iterator[Path]:
    """The files below a folder of the tree, generated ones left out, in a fixed order."""
    if not (root / folder).is_dir():
        return
    for path in sorted((root / folder).iterdir()):
        if path.is_dir():
            if path.name not in GENERATED and not path.name.endswith("_cache"):
                yield from files(root, path.relative_to(root).as_posix(), *suffixes)
        elif not suffixes or path.suffix in suffixes:
            yield path


def lines(path: Path) -> Iterator[tuple[int, str]]:
    yield from enumerate(path.read_text(encoding="utf-8").splitlines(), start=1)


def grow(root: Path, tree: dict[str, str]) -> Path:
    """Writes a made-up checkout: path -> content."""
    for name, content in tree.items():
        path = root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(content, encoding="utf-8")
    return root


def listed(offences: list[str]) -> str:
    """The message of a failed test: all offences, one a line."""
    return "\n".join([f"{len(offences)} to mend", *offences])


def ranked(*rooms: str) -> dict[str, int]:
    """The rank of each room: words of one text have one rank, from 0 upwards."""
    return {room: rank for rank, words in enumerate(rooms) for room in words.split()}
