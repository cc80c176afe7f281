# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs the layers of the tests that are named, or all that do not only run by name, and prints a summary.

Layers that use one core run beside each other, and print when they have ended. A layer that fails does not
stop the next one. The last line counts all tests; the status is 1 if any failed.
"""

import argparse
import multiprocessing
import os
import sys
import time
from collections.abc import Iterable
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from itertools import groupby

from .layers import LAYERS, Layer
from .results import Outcome, closing_line
from .shell import jobs, say
from .suites import RESULTS

_beside: list[Layer] = []  # the layers that run beside each other; the processes for them inherit this


def run_layer(layer: Layer) -> tuple[Outcome, float]:
    """Runs one layer. Returns its results and its seconds."""
    start = time.monotonic()
    say(f"\n==== {layer.name} " + "=" * (72 - len(layer.name)))
    try:
        found = layer.run(layer.timeout)
    except SystemExit as stop:  # the tool that failed has printed the reason
        say(str(stop.code))
        found = Outcome(failed=1, note=f"could not be set up: {str(stop.code).partition(chr(10))[0]}")
    return found, time.monotonic() - start


def run_beside_each_other(layers: list[Layer]) -> dict[str, tuple[Outcome, float]]:
    """Runs as many layers at a time as there are cores, and begins with the longest."""
    RESULTS.mkdir(parents=True, exist_ok=True)
    _beside[:] = sorted(layers, key=lambda layer: layer.timeout, reverse=True)
    say("\nThese run beside each other: " + ", ".join(layer.name for layer in _beside))
    results = {}
    with ProcessPoolExecutor(jobs(), multiprocessing.get_context("fork")) as pool:
        running: dict[Future, Layer] = {pool.submit(_run_apart, i): layer for i, layer in enumerate(_beside)}
        for future in as_completed(running):
            name = running[future].name
            results[name] = future.result()
            say((RESULTS / f"{name}.log").read_text(encoding="utf-8", errors="replace"))
    return results


def _run_apart(number: int) -> tuple[Outcome, float]:
    """Runs a layer in a process of its own, which writes into a file what the layer prints."""
    layer = _beside[number]
    with (RESULTS / f"{layer.name}.log").open("w", encoding="utf-8") as log:
        os.dup2(log.fileno(), 1)
        os.dup2(log.fileno(), 2)
        sys.stdout = sys.stderr = log
        return run_layer(layer)


def run_layers(layers: Iterable[Layer]) -> int:
    """Runs the layers in their order and prints a table. Returns how many tests failed."""
    rows = {}
    for one_process, group in groupby(layers, key=lambda layer: layer.one_process):
        chain = list(group)
        if one_process and len(chain) > 1:
            results = run_beside_each_other(chain)
            rows |= {layer.name: results[layer.name] for layer in chain}
        else:
            rows |= {layer.name: run_layer(layer) for layer in chain}

    say(f"\n{'layer':<18}{'passed':>8}{'failed':>8}{'skipped':>9}{'seconds':>9}")
    for name, (found, seconds) in rows.items():
        line = f"{name:<18}{found.passed:>8}{found.failed:>8}{found.skipped:>9}{seconds:>9.0f}  {found.note}"
        say(line.rstrip())
    total = sum((found for found, _ in rows.values()), Outcome())
    say("\n" + closing_line(total))
    return total.failed


def chosen(names: list[str], whole: bool = False) -> list[Layer]:
    """The layers of these names, or whose names begin with such a word.

    Without a name, all but those that only run when they are named. ``whole`` takes all tests where a layer
    is a core of them.
    """
    layers = [
        layer
        for layer in LAYERS
        if not {layer.name, first_word(layer.name)}.isdisjoint(names)
        or (not names and not layer.only_by_name)
    ]
    return [layer.whole or layer for layer in layers] if whole else layers


def first_word(name: str) -> str:
    return name.partition("-")[0]


def main() -> None:
    names = [layer.name for layer in LAYERS]
    parser = argparse.ArgumentParser(prog="tests/run", description=__doc__)
    parser.add_argument(
        "layers", nargs="*", metavar="LAYER", help=f"{', '.join(names)}; or a first word of them"
    )
    parser.add_argument("--list", action="store_true", help="name the layers and stop")
    parser.add_argument(
        "--all", action="store_true", help="all tests also on Windows, which else runs a core"
    )
    options = parser.parse_args()
    if options.list:
        print(*names, sep="\n")
        return
    unknown = sorted(set(options.layers) - {*names, *map(first_word, names)})
    if unknown:
        parser.error(f"no layer {', '.join(unknown)}; the layers are {', '.join(names)}")
    sys.exit(1 if run_layers(chosen(options.layers, options.all)) else 0)


if __name__ == "__main__":
    main()
