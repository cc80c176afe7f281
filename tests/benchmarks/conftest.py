# SPDX-License-Identifier: GPL-3.0-or-later
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / folder) for folder in ("tools", "benchmarks", "benchmarks/instructions")]
