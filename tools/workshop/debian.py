# SPDX-License-Identifier: GPL-3.0-or-later
"""The Debian 12 packages that each purpose needs."""

from pathlib import Path

from .shell import must, one_at_a_time

PYTHON = ("python3.11", "python3.11-venv")
COMPILERS = (*PYTHON, "python3.11-dev", "g++", "cmake", "ninja-build", "ccache", "binutils")
# The serial build of OpenBLAS is not thread-safe, and its OpenMP build is far too slow.
ALGEBRA = ("libsuitesparse-dev", "libopenblas-pthread-dev", "libeigen3-dev")
BUILD = (*COMPILERS, *ALGEBRA, "libtbb-dev", "libgtest-dev", "libosd-dev", "libcgal-dev")
WINE = ("wine", "wine64")  # runs Windows' programs
SSH = ("openssh-client", "openssh-server")  # what workers of a cluster are started by
QEMU = ("qemu-user-static",)  # runs Linux's programs for other processors
GOOGLETEST = ("googletest",)  # its sources
API = ("doxygen",)
BROWSER = ("chromium",)  # reads the site
NODE = ("nodejs",)  # reads the job type of Flamenco
BENCHMARKS = ("valgrind",)  # counts instructions
# Blender does not depend on NumPy, although its add-ons need it. Without libegl1, Workbench aborts.
BLENDER = ("blender", "python3-numpy", "libegl1", "libgl1")
BLENDER_TESTS = (*BLENDER, "python3-pytest", "python3-hypothesis")
GUI = (*BLENDER_TESTS, "xvfb", "xauth", "xdotool", "imagemagick")
# The libraries that Blender as a Python module needs.
X11 = ("libx11-6", "libxrender1", "libxxf86vm1", "libxfixes3", "libxi6", "libxkbcommon0", "libsm6")
BPY = (*PYTHON, *X11, "libgl1", "libegl1", "libgomp1")


@one_at_a_time()
def install(*sets: tuple[str, ...]) -> None:
    wanted = dict.fromkeys(package for packages in sets for package in packages)
    lacking = f"Debian's packages {', '.join(wanted)} are not all here, and could not be installed"
    must([Path(__file__).with_name("apt_install"), *wanted], lacking=lacking)
