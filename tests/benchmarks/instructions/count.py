# SPDX-License-Identifier: GPL-3.0-or-later
"""Counts the instructions of the per-frame loops with callgrind and compares them with table.json.

Unlike times they do not depend on what else the machine does; they do on the compiler and on whether the
processor has AVX2, so a table from elsewhere is not compared with (status 77).

    python tests/benchmarks/instructions/count.py [--check | --store]
"""

import argparse
import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path

TABLE = Path(__file__).with_name("table.json")
FRAMES = Path(__file__).resolve().parents[3] / ".build" / "native" / "tests" / "benchmarks" / "sinew_frames"
MOST_GROWTH = 10.0  # per cent: far more than an innocent edit gives, far less than a lost trick
SKIPPED = 77

# Loop -> the runs whose counts are subtracted (second from first), and by what the rest is divided.
LOOPS = {
    "ThinShell.solve": ((("thin_shell",),), 1),
    "AffineBasis.solve, 4 handles": ((("affine_basis",),), 1),
    "Arap iteration": ((("arap", "5e-4", "12"), ("arap", "5e-4", "2")), 10),
    "Arap iteration, smoothness 0": ((("arap", "0", "12"), ("arap", "0", "2")), 10),
}


def about(frames: Path) -> dict[str, object]:
    """The compiler that made the loops, and whether this processor takes their AVX2 twins."""
    return json.loads(subprocess.run([frames, "about"], check=True, capture_output=True, text=True).stdout)


def instructions(frames: Path, valgrind: str, words: tuple[str, ...]) -> int:
    with tempfile.TemporaryDirectory() as folder:
        options = [f"--callgrind-out-file={folder}/out", "--collect-atstart=no", "--toggle-collect=frame"]
        command = [valgrind, "--tool=callgrind", *options, frames, *words]
        done = subprocess.run(command, check=True, capture_output=True, text=True)
    return int(re.search(r"Collected : (\d+)", done.stderr).group(1))


def count(frames: Path, valgrind: str) -> dict[str, int]:
    counts = {}
    for loop, (runs, divisor) in LOOPS.items():
        first, *rest = (instructions(frames, valgrind, words) for words in runs)
        counts[loop] = (first - sum(rest)) // divisor
    return counts


def compare(counts: dict[str, int], stored: dict[str, int]) -> tuple[list[str], list[str]]:
    """One line a loop with its change in per cent, and those that grew too much."""
    lines, grown = [], []
    for loop, now in counts.items():
        if loop not in stored:
            lines.append(f"{loop:32}{now:>14,}  new")
            continue
        change = 100.0 * (now / stored[loop] - 1.0)
        lines.append(f"{loop:32}{now:>14,}{change:>+9.2f} %")
        if change > MOST_GROWTH:
            grown.append(loop)
    return lines, grown


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--frames", type=Path, default=FRAMES)
    parser.add_argument("--valgrind", default="valgrind")
    parser.add_argument("--check", action="store_true", help=f"fail where a loop grew by {MOST_GROWTH:g} %%")
    parser.add_argument("--store", action="store_true", help="make these the table")
    options = parser.parse_args()

    stored = json.loads(TABLE.read_text(encoding="utf-8")) if TABLE.is_file() else {}
    made_by = about(options.frames)
    same = all(stored.get(key) == value for key, value in made_by.items())
    if options.check and not same:
        print(f"The table was counted elsewhere: {stored.get('compiler')}, AVX2 {stored.get('avx2')}")
        sys.exit(SKIPPED)
    counts = count(options.frames, options.valgrind)
    lines, grown = compare(counts, stored.get("instructions", {}) if same else {})
    print("\n".join(lines))
    if options.store:
        text = json.dumps(made_by | {"vertices": 10_000, "instructions": counts}, indent=1)
        TABLE.write_text(text + "\n", encoding="utf-8")
    if options.check and grown:
        sys.exit(f"more than {MOST_GROWTH:g} % dearer: {', '.join(grown)}")


if __name__ == "__main__":
    main()
