# SPDX-License-Identifier: GPL-3.0-or-later
"""What a wheel says about the libraries inside: their licences, and a bill of materials in CycloneDX."""

import json
import re
from collections.abc import Collection, Mapping
from pathlib import Path

from .cross_libraries import LIBRARIES, pinned
from .environments import REQUIREMENTS, Environment
from .places import version
from .shell import said

# The packages of this machine that hold what is compiled in, or come from the same sources.
COMPILED_IN = (
    "libboost-dev",
    "libcgal-dev",
    "libeigen3-dev",
    "libosd-dev",
    "libsuitesparse-dev",
    "libtbb-dev",
)
NAME = "licenses/THIRD_PARTY.txt"
BILL = "sboms/sinew_native.cdx.json"  # where PEP 770 looks for it
# By the name of the licence's file: what the library is called, and the licence of what is linked of it.
KNOWN = {
    "libboost-dev": ("Boost", "BSL-1.0"),
    "libc++": ("libc++ of zig", "Apache-2.0 WITH LLVM-exception"),
    "libcgal-dev": ("CGAL", "GPL-3.0-or-later AND LGPL-3.0-or-later"),
    "libeigen3-dev": ("Eigen", "MPL-2.0"),
    "libosd-dev": ("opensubdiv", "LicenseRef-Pixar-Modified-Apache-2.0"),
    "libsuitesparse-dev": ("suitesparse", "LGPL-2.1-or-later AND GPL-2.0-or-later AND BSD-3-Clause"),
    "libtbb-dev": ("onetbb", "Apache-2.0"),
    "mingw-w64": ("mingw-w64 of zig", "ZPL-2.1"),
    "pybind11": ("pybind11", "BSD-3-Clause"),
    "zig": ("zig", "MIT"),
}
NUMBER = re.compile(r"\d+(?:\.\d+){1,2}")
METIS = ("METIS", "5.1.0", "Apache-2.0 AND LGPL-2.1-or-later")  # in SuiteSparse; the latter for its sort


def notices(files: dict[str, bytes], licences: Mapping[str, Path], builder: Environment) -> dict[str, bytes]:
    """These licences, those of the packages, and that of pybind11, as one text; and the bill."""
    folder = next(name for name in files if name.endswith(".dist-info/RECORD")).removesuffix("RECORD")
    pybind11 = next(builder.site_packages.glob("pybind11-*.dist-info/**/LICENSE"))
    packages = {name: Path("/usr/share/doc") / name / "copyright" for name in COMPILED_IN}
    inside = {**licences, **packages, "pybind11": pybind11}
    return {folder + NAME: _text(inside).encode(), folder + BILL: bill(inside).encode()}


def bill(names: Collection[str]) -> str:
    """The libraries with their versions and licences, as CycloneDX 1.6."""
    parts = [_component(name) for name in sorted(names)]
    if "libsuitesparse-dev" in names:  # whose sources hold it
        parts.append(_library(*METIS))
    whole = {"bom-ref": "sinew_native", **_library("sinew_native", version(), "GPL-3.0-or-later")}
    stated = {"bomFormat": "CycloneDX", "specVersion": "1.6", "version": 1}
    return json.dumps({**stated, "metadata": {"component": whole}, "components": parts}, indent=1) + "\n"


def _component(name: str) -> dict[str, object]:
    if name not in KNOWN:
        raise SystemExit(f"{name} is linked, and tools/workshop/notices.py knows no licence of it")
    title, licence = KNOWN[name]
    return _library(title, _version(name, title), licence)


def _library(name: str, of_version: str, licence: str) -> dict[str, object]:
    stated = {"type": "library", "name": name, "version": of_version}
    return stated | {"licenses": [{"expression": licence}]}


def _version(name: str, title: str) -> str:
    """That of the pinned sources or packages of Python; else of Debian's package, which has the headers."""
    for row in pinned(LIBRARIES / "sources.txt"):
        if row.package == title:
            return NUMBER.search(row.archive)[0]
    pins = "".join(path.read_text(encoding="utf-8") for path in sorted(REQUIREMENTS.glob("*.txt")))
    python = "ziglang" if name in ("libc++", "mingw-w64", "zig") else name  # zig brings the others along
    if found := re.search(rf"^{re.escape(python)}==(\S+)", pins, flags=re.M):
        return found[1]
    return NUMBER.search(said(["dpkg-query", "--show", "--showformat=${Version}", name]))[0]


def _text(files: dict[str, Path]) -> str:
    """Each licence once, with the names of all libraries that it covers."""
    covers: dict[str, list[str]] = {}
    for name in sorted(files):
        if not files[name].is_file():
            raise SystemExit(f"{files[name]} is missing, and the wheel must not be distributed without it")
        covers.setdefault(files[name].read_text(encoding="utf-8"), []).append(name)
    parts = [f"{', '.join(names)}\n{'=' * 78}\n\n{text.strip()}\n" for text, names in covers.items()]
    return "Sinew's compiled module contains these libraries.\n\n" + "\n\n".join(parts)
