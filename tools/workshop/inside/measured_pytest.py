# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs tests/blender/run_pytest.py in Blender, while coverage.py records the installed add-on.

SINEW_COVERAGE names the file to write and the folder that holds coverage.py, apart from Blender's packages.
"""

import os
import runpy
import sys
from pathlib import Path

data_file, packages = os.environ["SINEW_COVERAGE"].split(os.pathsep)
sys.path.append(packages)

import coverage  # noqa: E402

measured = coverage.Coverage(data_file=data_file, include=["*/addons/sinew/*"])
leave = os._exit


def save_and_leave(status: int) -> None:
    measured.stop()
    measured.save()
    leave(status)


# Run_pytest.py ends by os._exit, which skips everything that Python does at its end.
os._exit = save_and_leave
measured.start()
runpy.run_path(str(Path(__file__).resolve().parents[3] / "tests" / "blender" / "run_pytest.py"))
