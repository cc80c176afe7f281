# SPDX-License-Identifier: GPL-3.0-or-later
"""The folders of a checkout, and its version."""

import re
import tomllib
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
PACKAGES = ROOT / "native" / "python"  # in Python, beside the module
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


def address() -> str:
    """Where people get Sinew, as pyproject.toml states; empty if it states no place."""
    stated = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    return stated["project"].get("urls", {}).get("Homepage", "").rstrip("/")


def exists(address: str) -> bool:
    """Whether this is an address on the web. Names that end in ``.invalid`` never lead anywhere."""
    found = re.fullmatch(r"https?://([\w.-]+)(:\d+)?(/[^\s\"\\]*)?", address)
    return bool(found) and not found[1].endswith(".invalid")
