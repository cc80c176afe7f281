# SPDX-License-Identifier: GPL-3.0-or-later
"""Installs the two zips in Blenders, each in a user folder of its own, and runs tests there."""

import os
import zlib
from collections.abc import Mapping
from pathlib import Path

from .environments import LONG_TERM_BLENDERS, Environment
from .package import package, package_for_this_machine, validate
from .places import BUILD, ROOT
from .results import Outcome, outcome
from .shell import must, one_at_a_time, run
from .suites import OPTIONS, RESULTS, emptied, new_junit

INSIDE = Path(__file__).parent / "inside"
RUN_PYTEST = ROOT / "tests" / "blender" / "run_pytest.py"
HEADLESS = ("blender", "--background", "--factory-startup", "--python-exit-code", "1", "--python")
RANDOM_SEQUENCES = 50  # in the oldest and in the newest release, and half as many in those between


def blender_module(
    name: str,
    blender: Environment,
    tests: tuple[str, ...],
    timeout: float,
    further: Mapping[str, str | Path] | None = None,
) -> Outcome:
    """Runs ``tests``, or all, on the installed extension in a Blender that is a Python module. ``further``
    are environment variables for the tests."""
    env = install_extension(blender.make(), name) | dict(further or {})
    junit = new_junit(name)
    command = [blender.python, RUN_PYTEST, "--", *tests, *OPTIONS, f"--junitxml={junit}"]
    return outcome(junit, run(command, env=env | conditions(name), timeout=timeout))


def layer_of(version: str) -> str:
    """The name of the layer of a release, which is that of its series."""
    return f"blender-{version.rpartition('.')[0]}"


def conditions(name: str) -> dict[str, str]:
    """Lets freed memory be overwritten, which finds dangling pointers, and gives each layer its own seed.
    Debian's Blender takes memory from jemalloc, where MALLOC_CONF=junk:true by hand does so."""
    between = any(name == layer_of(version) for version in LONG_TERM_BLENDERS)
    wanted = {
        "MALLOC_PERTURB_": "165",
        "SINEW_RANDOM_SEQUENCES": str(RANDOM_SEQUENCES // 2 if between else RANDOM_SEQUENCES),
        "SINEW_RANDOM_SEED": str(zlib.crc32(name.encode())),
    }
    return {key: os.environ.get(key, value) for key, value in wanted.items()}


@one_at_a_time()
def install_legacy(name: str, from_wheel: bool = True) -> dict[str, str | Path]:
    """Installs the legacy zip in Debian's Blender, in a new user folder. Returns the environment variables.
    Without a wheel, the zip has the module of the developer's tree."""
    zip_file = package()[1] if from_wheel else package_for_this_machine()
    user = emptied(BUILD / "blender-users" / name)
    env = {
        "BLENDER_USER_CONFIG": user / "config",
        "BLENDER_USER_SCRIPTS": user / "scripts",
        "SINEW_ADDON_MODULE": "sinew",
        "SINEW_TEST_OUTPUT": emptied(RESULTS / name),
    }
    must([*HEADLESS, INSIDE / "install_zip.py", "--", zip_file], env=env, timeout=120, quiet=True)
    return env


@one_at_a_time()
def install_extension(blender: Environment, name: str) -> dict[str, str | Path]:
    """Installs the extension in a Blender that is a Python module, in the same way."""
    zip_file, _ = package()
    validate(zip_file, blender)
    env = {
        "BLENDER_USER_RESOURCES": emptied(BUILD / "blender-users" / name),
        "SINEW_ADDON_MODULE": "bl_ext.user_default.sinew",
        "SINEW_TEST_OUTPUT": emptied(RESULTS / name),
    }
    command = [blender.python, INSIDE / "install_zip.py", "--", zip_file]
    must(command, env=env, timeout=120, quiet=True)
    return env
