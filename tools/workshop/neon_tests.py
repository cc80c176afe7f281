# SPDX-License-Identifier: GPL-3.0-or-later
"""The native tests of the kernels on 64-bit ARM, as zig compiles them for Apple's processors, under QEMU."""

from pathlib import Path

from . import debian, zig
from .cross_libraries import libraries
from .results import Outcome
from .shell import jobs, must, one_at_a_time
from .suites import googletest

# With a C library of its own, as this machine has none for this processor.
SYSTEM = zig.system("neon", "Linux on ARM", "aarch64-linux-musl")
# The files of tests/native that compare kernels with an oracle.
KERNELS = (
    "/(simd|dense|optimization)/|supernodal/test_solve|kernels|test_(layers|products|quad_patches|stencils)"
)


def neon(timeout: float) -> Outcome:
    debian.install(debian.QEMU)
    return googletest("neon", ["qemu-aarch64-static", test_program()], timeout)


@one_at_a_time()
def test_program() -> Path:
    debian.install(debian.GOOGLETEST)
    libraries(SYSTEM, ("onetbb",))
    tree = SYSTEM.tree / "tests"
    settings = [*SYSTEM.configuration(), f"-DSINEW_TESTED={KERNELS}"]
    must(["cmake", "-S", SYSTEM.files, "-B", tree, *settings], quiet=True)
    must(["cmake", "--build", tree, "--target", "sinew_tests", "-j", str(jobs())], quiet=True)
    return tree / "sinew_tests"
