# SPDX-License-Identifier: GPL-3.0-or-later
"""What is checked of a module for Linux, on small ones that this machine's compiler makes."""

import subprocess
from pathlib import Path

import pytest
from workshop import linux_wheels

MODULE = """
#include <string.h>
#define SHOWN __attribute__((visibility("default")))
void *PyLong_FromLong(long);
SHOWN void *PyInit_sinew_native(void) { return PyLong_FromLong(1); }
void *copied(void *a, void *b, size_t n) { return memcpy(a, b, n); }
"""
HIDDEN = "int hidden(void) { return 1; }"


def made(folder: Path, more: str, *options: str) -> Path:
    (folder / "module.c").write_text(MODULE + more)
    command = ["gcc", "-shared", "-fPIC", "-fvisibility=hidden", *options, "module.c", "-o", "module.so"]
    subprocess.run(command, cwd=folder, check=True)
    return folder / "module.so"


def test_a_module_that_every_linux_of_blender_loads_passes(tmp_path: Path) -> None:
    linux_wheels.check_module(made(tmp_path, HIDDEN), 11)


@pytest.mark.parametrize(
    ("more", "options", "says"),
    [
        # Since 2.34 threads are a part of the C library, and the version of their symbols tells.
        ("int pthread_join(); int joins(void) { return pthread_join(); }", (), "it needs glibc 2.34"),
        (
            HIDDEN,
            ("-Wl,--no-as-needed", "-lstdc++"),
            "it needs libstdc++.so.6, which the wheel does not hold",
        ),
        (HIDDEN, ("-Wl,-rpath,/opt/lib",), "it looks in /opt/lib"),
        (f"SHOWN {HIDDEN}", (), "it shows PyInit_sinew_native, hidden"),
        ("void *memcpy(void *a, const void *, size_t) { return a; }", (), "it has a memcpy of its own"),
        ("int dgemm_(); int calls(void) { return dgemm_(); }", (), "nothing defines dgemm_"),
    ],
)
def test_what_such_a_linux_could_not_load_is_named(
    tmp_path: Path, more: str, options: tuple[str, ...], says: str
) -> None:
    with pytest.raises(SystemExit) as refused:
        linux_wheels.check_module(made(tmp_path, more, *options), 11)
    assert str(refused.value) == f"module.so: {says}"
