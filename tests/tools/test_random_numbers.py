# SPDX-License-Identifier: GPL-3.0-or-later
"""The random numbers of METIS on systems that this machine is not."""

import ctypes
import shutil
import subprocess
from pathlib import Path

import pytest
from workshop.cross_libraries import LIBRARIES


@pytest.fixture
def built(tmp_path: Path) -> ctypes.CDLL:
    compiler = shutil.which("gcc") or pytest.skip("no compiler here")
    library = tmp_path / "random.so"
    source = LIBRARIES / "suitesparse" / "random.c"
    subprocess.run([compiler, "-O1", "-shared", "-fPIC", "-o", library, source], check=True)
    return ctypes.CDLL(str(library))


@pytest.mark.parametrize("seed", [None, 0, 1, 4321, 2**31, 2**32 - 1])
def test_they_are_those_of_linux(built: ctypes.CDLL, seed: int | None) -> None:
    """METIS seeds them with 4321; None is a program that never did."""
    here = ctypes.CDLL(None)
    for seeded, value in ((here.srand, seed or 0), (built.sinew_srand, seed)):
        if value is not None:
            seeded(ctypes.c_uint(value))
    assert [built.sinew_rand() for _ in range(1000)] == [here.rand() for _ in range(1000)]
