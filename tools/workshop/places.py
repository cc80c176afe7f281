# SPDX-License-Identifier: GPL-3.0-or-later
"""The folders of a checkout, and its version."""

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
BUILD = ROOT / ".build"
DIST = ROOT / "dist"
ADDON = ROOT / "addon"
MANUAL = ROOT / "docs" / "manual"
METHODS = ROOT / "docs" / "methods"
NATIVE_TREE = BUILD / "native"
DEV_MODULE = BUILD / "dev"
WHEELS = BUILD / "wheels"
PYTHON311 = Path("/usr/bin/python3.11")
# What every wheel is made from, beside the tools that make it.
WHEEL_SOURCES = (
    "native",
    "CMakeLists.txt",
    "pyproject.toml",
    "README.md",
    "LICENSE",
    "tools/requirements/build.txt",
)


def version(root: Path = ROOT) -> str:
    """The version of the project, which CMakeLists.txt states."""
    text = (root / "CMakeLists.txt").read_text(encoding="utf-8")
    found = re.search(r"project\(sinew\s+VERSION\s+(\d+\.\d+\.\d+)", text)
    if found is None:
        raise SystemExit("CMakeLists.txt states no project(sinew VERSION x.y.z)")
    return found.group(1)
