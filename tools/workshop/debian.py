# SPDX-License-Identifier: GPL-3.0-or-later
"""The Debian 12 packages that each kind of work needs."""

from pathlib import Path

from .shell import must

PYTHON = ("python3.11", "python3.11-venv")
BUILD = (
    *PYTHON,
    "python3.11-dev",
    "g++",
    "cmake",
    "ninja-build",
    "ccache",
    "binutils",
    "libsuitesparse-dev",
    "libopenblas-pthread-dev",  # the serial build is not thread-safe, the OpenMP build collapses
    "libtbb-dev",
    "libeigen3-dev",
    "libgtest-dev",
    "libosd-dev",
    "libcgal-dev",  # headers alone, as Boost's
)
API = ("doxygen",)
BENCHMARKS = ("valgrind",)  # counts instructions
# Blender does not pull NumPy although its add-ons need it; without libegl1 Workbench aborts.
BLENDER = ("blender", "python3-numpy", "libegl1", "libgl1")
BLENDER_TESTS = (*BLENDER, "python3-pytest", "python3-hypothesis")
GUI = (*BLENDER_TESTS, "xvfb", "xauth", "xdotool", "imagemagick")
# What Blender as a Python module opens on a bare machine.
BPY = (
    *PYTHON,
    "libx11-6",
    "libxrender1",
    "libxxf86vm1",
    "libxfixes3",
    "libxi6",
    "libxkbcommon0",
    "libsm6",
    "libgl1",
    "libegl1",
    "libgomp1",
)


def install(*sets: tuple[str, ...]) -> None:
    wanted = dict.fromkeys(package for packages in sets for package in packages)
    must([Path(__file__).with_name("apt_install"), *wanted])
