# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs a quick selection of the tests, all layers, or those that are named, and prints a summary.

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

from .layers import LAYERS, QUICK, Layer
from .results import Outcome, closing_line
from .shell import jobs, say
from .suites import RESULTS, only_named

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
    """Runs as many layers at a time as there are cores, and one more for each that mostly waits. These come
    first, then the longest."""
    RESULTS.mkdir(parents=True, exist_ok=True)
    _beside[:] = sorted(layers, key=lambda layer: (layer.waits, layer.timeout), reverse=True)
    processes = jobs() + sum(layer.waits for layer in layers)
    say("\nThese run beside each other: " + ", ".join(layer.name for layer in _beside))
    results = {}
    with ProcessPoolExecutor(processes, multiprocessing.get_context("fork")) as pool:
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


def run_layers(layers: Iterable[Layer], remark: str = "") -> int:
    """Runs the layers in their order and prints a table, then a remark. Returns how many tests failed."""
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
    if remark:
        say("\n" + remark)
    say("\n" + closing_line(total))
    return total.failed


def chosen(names: list[str], whole: bool = False) -> list[Layer]:
    """The layers of these names, or whose names begin with such a word. Without a name, all but those that
    only run when they are named. ``whole`` takes all tests where a layer is a core of them."""
    if names:
        layers = [layer for layer in LAYERS if not {layer.name, first_word(layer.name)}.isdisjoint(names)]
    else:
        layers = [layer for layer in LAYERS if not layer.only_by_name]
    return [layer.whole or layer for layer in layers] if whole else layers


def left_out() -> str:
    """What the quick selection leaves out, and the commands for it."""
    quick = {layer.name for layer in QUICK}
    absent = [layer.name for layer in chosen([]) if layer.name not in quick]
    parts = [f"{layer.name} ({layer.without})" for layer in QUICK if layer.without]
    return (
        f"Left out: {', '.join(absent)}; of {', of '.join(parts)}.\n"
        f"tests/run --all runs all of this, tests/run LAYER all of one layer.\n{by_name()}"
    )


def by_name() -> str:
    names = sorted({layer.name for layer in LAYERS} - {layer.name for layer in chosen([])})
    return f"Run by name alone: {', '.join(names)}."


def first_word(name: str) -> str:
    return name.partition("-")[0]


def main() -> None:
    names = [layer.name for layer in LAYERS]
    parser = argparse.ArgumentParser(prog="tests/run", description=__doc__)
    add, flag = parser.add_argument, "store_true"
    add("layers", nargs="*", metavar="LAYER", help=f"{', '.join(names)}; or a first word of them")
    add("--list", action=flag, help="name the layers and stop")
    add("--all", action=flag, help="all layers but those that only run where they are named")
    add("--whole", action=flag, help="all tests also on Windows, whose layers else run a core of them")
    add("-k", dest="tests", metavar="NAME", help="of the named layers only the tests whose names hold this")
    options = parser.parse_args()
    if options.list:
        print(*names, sep="\n")
        return
    unknown = sorted(set(options.layers) - {*names, *map(first_word, names)})
    if unknown:
        parser.error(f"no layer {', '.join(unknown)}; the layers are {', '.join(names)}")
    if options.all and options.layers:
        parser.error("--all names all layers; --whole asks for all tests of those for Windows")
    if options.tests and not options.layers:
        parser.error("-k needs the name of a layer")
    if options.tests:
        only_named(options.tests)
    quick = not (options.layers or options.all or options.whole)
    layers = QUICK if quick else chosen(options.layers, options.whole)
    remark = left_out() if quick else "" if options.layers else by_name()
    sys.exit(1 if run_layers(layers, remark) else 0)
