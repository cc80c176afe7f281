# SPDX-License-Identifier: GPL-3.0-or-later
"""Collects the licences of the libraries inside a repaired wheel, which must be distributed with it."""

import json
from pathlib import Path

from .environments import Environment

COMPILED_IN = ("libeigen3-dev", "libcgal-dev", "libboost-dev")
NAME = "licenses/THIRD_PARTY.txt"


def notices(files: dict[str, bytes], builder: Environment) -> dict[str, bytes]:
    """The copyright files of all libraries in the wheel, as one text.

    These are the Debian packages that auditwheel names, the packages of headers, and pybind11.
    """
    folder = next(name for name in files if name.endswith(".dist-info/RECORD")).removesuffix("RECORD")
    bill = next(content for name, content in files.items() if name.endswith("/sboms/auditwheel.cdx.json"))
    parts = json.loads(bill)["components"]
    packages = {part["name"] for part in parts if part.get("purl", "").startswith("pkg:deb/")}
    return {folder + NAME: _text(packages, builder).encode()}


def _text(packages: set[str], builder: Environment) -> str:
    """Each licence once, with the names of all libraries that it covers."""
    files = {name: Path("/usr/share/doc") / name / "copyright" for name in (*packages, *COMPILED_IN)}
    files["pybind11"] = next(builder.site_packages.glob("pybind11-*.dist-info/**/LICENSE"))
    covers: dict[str, list[str]] = {}
    for name in sorted(files):
        if not files[name].is_file():
            raise SystemExit(f"{files[name]} is missing, and the wheel must not be distributed without it")
        covers.setdefault(files[name].read_text(encoding="utf-8"), []).append(name)
    parts = [f"{', '.join(names)}\n{'=' * 78}\n\n{text.strip()}\n" for text, names in covers.items()]
    return "Sinew's compiled module contains these libraries.\n\n" + "\n\n".join(parts)
