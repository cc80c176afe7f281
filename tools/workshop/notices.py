# SPDX-License-Identifier: GPL-3.0-or-later
"""Collects the licences of the libraries inside a wheel, which must be distributed with it."""

from collections.abc import Iterable, Mapping
from pathlib import Path

from .environments import Environment

COMPILED_IN = ("libeigen3-dev", "libcgal-dev", "libboost-dev")
NAME = "licenses/THIRD_PARTY.txt"


def notices(files: dict[str, bytes], licences: Mapping[str, Path], builder: Environment) -> dict[str, bytes]:
    """These licences, those of the packages with headers, and that of pybind11, as one text."""
    folder = next(name for name in files if name.endswith(".dist-info/RECORD")).removesuffix("RECORD")
    pybind11 = next(builder.site_packages.glob("pybind11-*.dist-info/**/LICENSE"))
    return {folder + NAME: _text({**licences, **of_packages(COMPILED_IN), "pybind11": pybind11}).encode()}


def of_packages(names: Iterable[str]) -> dict[str, Path]:
    return {name: Path("/usr/share/doc") / name / "copyright" for name in names}


def _text(files: dict[str, Path]) -> str:
    """Each licence once, with the names of all libraries that it covers."""
    covers: dict[str, list[str]] = {}
    for name in sorted(files):
        if not files[name].is_file():
            raise SystemExit(f"{files[name]} is missing, and the wheel must not be distributed without it")
        covers.setdefault(files[name].read_text(encoding="utf-8"), []).append(name)
    parts = [f"{', '.join(names)}\n{'=' * 78}\n\n{text.strip()}\n" for text, names in covers.items()]
    return "Sinew's compiled module contains these libraries.\n\n" + "\n\n".join(parts)
