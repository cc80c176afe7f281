# SPDX-License-Identifier: GPL-3.0-or-later
"""Run pytest inside Blender: ``blender -b --factory-startup -P tests/blender/run_pytest.py -- ARGS``."""

import os
import sys
from pathlib import Path

import pytest

arguments = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else []
code = pytest.main(["-p", "no:cacheprovider", str(Path(__file__).parent), *arguments])
sys.stdout.flush()
sys.stderr.flush()
os._exit(code)  # Blender as a module may hang or crash on its way out
