# SPDX-License-Identifier: GPL-3.0-or-later
"""The native module on emulated processors: without AVX2, and on those that lack what all of it needs."""

import os
import platform
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

QEMU = shutil.which("qemu-x86_64-static")
HERE = Path(__file__).parents[1]
# The layer of the tests for Windows names a Python there, the folder of its native module, and its drive.
PYTHON = shlex.split(os.environ.get("SINEW_EMULATED_PYTHON", shlex.quote(sys.executable)))
MODULE = os.environ.get("SINEW_EMULATED_MODULE")
DRIVE = "Z:" if MODULE else ""

pytestmark = pytest.mark.skipif(
    QEMU is None or platform.machine() != "x86_64", reason="there is no qemu-x86_64-static for this processor"
)

# Each method once, with its defaults: emulated, all options take a minute.
KNOWN_ANSWERS = """
import conftest, io
from sinew import backend
module = backend.availability().module
assert module is not None, backend.availability()
rigs = backend.known_answers.rigs
backend.known_answers.rigs = lambda method: list(rigs(method))[:1]
report = io.StringIO()
found = backend.check_installation(report, "an emulated processor")
print(module.instructions(), found.asked)
assert found.is_right, report.getvalue()
"""
# Without NumPy, whose wheels ask for more than these processors have.
REMEDY = """
import sys
from types import ModuleType
for name, folder in (("sinew", ""), ("sinew.backend", "backend")):
    sys.modules[name] = ModuleType(name)
    sys.modules[name].__path__ = [f"{ADDON}/{folder}"]
from sinew.backend import loader
found = loader.load()
assert found.module is None
print(found.remedy)
"""


def run_on(processor: str, script: str) -> str:
    """What a script prints on this processor, with the module that the other tests use."""
    module = MODULE or Path(pytest.importorskip("sinew_native").__file__).parent
    folders, addon = [f"{DRIVE}{HERE}", f"{DRIVE}{module}"], f"{DRIVE}{HERE.parents[1] / 'addon'}"
    head = f"import sys; sys.path[:0] = {folders}; ADDON = {addon!r}\n"
    command = [QEMU, "-cpu", processor, *PYTHON, "-c", head + script]
    # NumPy's OpenBLAS would use the instructions that such a variable asks for, whatever the processor has.
    env = {name: value for name, value in os.environ.items() if not name.startswith("OPENBLAS_")}
    streams = {"stdin": subprocess.DEVNULL, "capture_output": True, "text": True}
    done = subprocess.run(command, env=env, timeout=300, **streams)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_every_method_is_right_without_avx():
    instructions, asked = run_on("Nehalem", KNOWN_ANSWERS).split()
    assert instructions == "SSE4.2"
    assert int(asked) > 40


@pytest.mark.parametrize("processor", ["Penryn", "Conroe", "qemu64"])
def test_a_processor_that_is_too_old_gets_a_message(processor: str):
    """The first has SSE4.1, the second SSSE3, the third SSE3."""
    remedy = run_on(processor, REMEDY)
    assert "the processor of this computer lacks SSE4.2" in remedy
    assert "Use another computer" in remedy
