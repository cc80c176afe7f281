# SPDX-License-Identifier: GPL-3.0-or-later
"""Run pytest inside Blender: ``blender -b --factory-startup -P tests/blender/run_pytest.py -- ARGS``.

Of the files below this folder those that ARGS name run, or all of them.
"""

import os
import sys
from pathlib import Path

import pytest

arguments = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else []
folder = Path(__file__).parent
sys.path.insert(0, str(folder / "support"))  # what tests share
files = [word for word in arguments if word.endswith(".py")]
chosen = [str(next(folder.rglob(file))) for file in files] or [str(folder)]
code = pytest.main(["-p", "no:cacheprovider", *chosen, *(word for word in arguments if word not in files)])
sys.stdout.flush()
sys.stderr.flush()
os._exit(code)  # Blender as a module may hang or crash on its way out
