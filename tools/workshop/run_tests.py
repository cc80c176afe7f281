# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs all layers of the tests, or those that are named, and prints a summary.

A layer that fails does not stop the next one. The last line counts all tests; the status is 1 if any failed.
"""

import argparse
import sys
import time
from collections.abc import Iterable

from .layers import LAYERS, Layer
from .results import Outcome, closing_line
from .shell import say


def run_layer(layer: Layer) -> Outcome:
    say(f"\n==== {layer.name} " + "=" * (72 - len(layer.name)))
    try:
        return layer.run(layer.timeout)
    except SystemExit as stop:  # the tool that failed has printed the reason
        say(str(stop.code))
        return Outcome(failed=1, note="could not be set up")


def run_layers(layers: Iterable[Layer]) -> int:
    """Runs one layer after the other and prints a table. Returns how many tests failed."""
    rows = []
    for layer in layers:
        start = time.monotonic()
        rows.append((layer.name, run_layer(layer), time.monotonic() - start))

    say(f"\n{'layer':<14}{'passed':>8}{'failed':>8}{'skipped':>9}{'seconds':>9}")
    for name, found, seconds in rows:
        line = f"{name:<14}{found.passed:>8}{found.failed:>8}{found.skipped:>9}{seconds:>9.0f}  {found.note}"
        say(line.rstrip())
    total = sum((found for _, found, _ in rows), Outcome())
    say("\n" + closing_line(total))
    return total.failed


def main() -> None:
    names = [layer.name for layer in LAYERS]
    parser = argparse.ArgumentParser(prog="tests/run", description=__doc__)
    parser.add_argument("layers", nargs="*", metavar="LAYER", help=", ".join(names))
    parser.add_argument("--list", action="store_true", help="name the layers and stop")
    options = parser.parse_args()
    if options.list:
        print(*names, sep="\n")
        return
    unknown = sorted(set(options.layers) - set(names))
    if unknown:
        parser.error(f"no layer {', '.join(unknown)}; the layers are {', '.join(names)}")
    chosen = [layer for layer in LAYERS if not options.layers or layer.name in options.layers]
    sys.exit(1 if run_layers(chosen) else 0)


if __name__ == "__main__":
    main()
