# SPDX-License-Identifier: GPL-3.0-or-later
"""Counts the instructions of the per-frame loops with callgrind and compares them with table.json.

Unlike times, they do not depend on other load on the machine. They depend on the compiler and on whether the
processor has AVX2, so a table from another compiler or processor is not compared (status 77). Binds are
listed without a comparison, since they consist mostly of BLAS, which differs between processors.

    python benchmarks/instructions/count.py [--check | --store]
"""

import argparse
import json
import re
import subprocess
import sys
import tempfile
from functools import partial
from pathlib import Path

TABLE = Path(__file__).with_name("table.json")
FRAMES = Path(__file__).resolve().parents[2] / ".build" / "native" / "benchmarks" / "sinew_frames"
MOST_GROWTH = 10.0  # per cent: far more than the effect of a harmless edit, far less than a lost optimisation
SKIPPED = 77

# Loop -> the runs of sinew_frames; of two, which differ by ITERATIONS, the second is subtracted.
ITERATIONS = 10
LOOPS = {
    "ThinShell.solve": ["thin_shell"],
    "AffineBasis.solve, 4 handles": ["affine_basis"],
    "Attachments.move, 196 parts": ["attachments"],
    "Attachments.move, 196 parts, incoming pose": ["attachments_incoming"],
    "Arap iteration": ["arap 5e-4 12", "arap 5e-4 2"],
    "Arap iteration, smoothness 0": ["arap 0 12", "arap 0 2"],
    "MeanValue.warp, 296 vertices": ["mean_value"],
    "Green.warp, 296 vertices": ["green"],
}
BINDS = {
    "ThinShell.set_handles": ["thin_shell_bind"],
    "Arap.set_handles": ["arap_bind"],
    "MeanValue.bind, 296 vertices": ["mean_value_bind"],
    "Green.bind, 296 vertices": ["green_bind"],
}


def about(frames: Path) -> dict[str, object]:
    """The compiler of the loops, and whether this processor runs their AVX2 variants."""
    return json.loads(subprocess.run([frames, "about"], check=True, capture_output=True, text=True).stdout)


def instructions(frames: Path, valgrind: str, words: list[str]) -> int:
    """The instructions within frame()."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "out"
        options = [f"--callgrind-out-file={out}", "--collect-atstart=no", "--toggle-collect=frame"]
        command = [valgrind, "--tool=callgrind", *options, frames, *words]
        subprocess.run(command, check=True, capture_output=True)
        return int(re.search(r"^totals: (\d+)", out.read_text(encoding="utf-8"), re.MULTILINE)[1])


def count(frames: Path, valgrind: str, loops: dict) -> dict[str, int]:
    counted = partial(instructions, frames, valgrind)
    runs = {loop: [counted(run.split()) for run in runs] for loop, runs in loops.items()}
    return {loop: (each[0] - sum(each[1:])) // (ITERATIONS if each[1:] else 1) for loop, each in runs.items()}


def compare(counts: dict[str, int], stored: dict[str, int]) -> tuple[list[str], list[str]]:
    """One line per loop with its change in per cent, and the loops of a frame that grew too much."""
    lines, grown = [], []
    for loop, now in counts.items():
        if loop not in stored:
            lines.append(f"{loop:40}{now:>16,}  new")
            continue
        change = 100.0 * (now / stored[loop] - 1.0)
        lines.append(f"{loop:40}{now:>16,}{change:>+9.2f} %")
        if change > MOST_GROWTH and loop not in BINDS:
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
        print(f"The stored table is from elsewhere: {stored.get('compiler')}, AVX2 {stored.get('avx2')}")
        sys.exit(SKIPPED)
    counts = count(options.frames, options.valgrind, LOOPS if options.check else LOOPS | BINDS)
    lines, grown = compare(counts, stored.get("instructions", {}) if same else {})
    print("\n".join(lines))
    if options.store:
        table = made_by | {"vertices": 10_000, "instructions": counts}
        TABLE.write_text(json.dumps(table, indent=1) + "\n", encoding="utf-8")
    if options.check and grown:
        sys.exit(f"more than {MOST_GROWTH:g} % dearer: {', '.join(grown)}")


if __name__ == "__main__":
    main()
