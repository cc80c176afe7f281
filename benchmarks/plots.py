# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws time and memory over size on logarithmic axes, and the share of the memory bandwidth."""

from pathlib import Path

import matplotlib
from record import Row
from report import exponents, series, short
from works import OWN_TIMES

matplotlib.use("Agg")
import matplotlib.pyplot as plt

DPI = 80
SOFTWARE = {"Software": None}  # without the version of the software, the same rows give the same file


def draw(rows: list[Row], folder: Path) -> None:
    _growth(rows, folder / "performance-size.png")
    _shares(rows, folder / "performance-bound.png")


def _growth(rows: list[Row], path: Path) -> None:
    figure, (times, memory) = plt.subplots(1, 2, figsize=(11, 4.6), layout="constrained")
    powers = exponents(rows)
    for (work, threads), some in series(rows).items():
        if threads == 1:
            continue
        axes = memory if work == "memory" else times
        unit = 1e-9 if work == "memory" else 1e3
        sizes = [row["vertices"] for row in some]
        label = f"{OWN_TIMES.get(work, 'bound ThinShell').replace('`', '')}: n^{powers[work, threads]:.2f}"
        (drawn,) = axes.loglog(sizes, [unit * row["ours"] for row in some], "o-", markersize=4, label=label)
        peers = [(row["vertices"], unit * row["peer"]) for row in some if row.get("peer") is not None]
        if peers and work != "arap_smooth":  # its peer has a line of its own
            axes.loglog(*zip(*peers), ":", color=drawn.get_color(), linewidth=1.2)
    times.set(xlabel="vertices", ylabel="ms", title="two threads; dotted: its peer, or its bound")
    memory.set(xlabel="vertices", ylabel="GB", title="memory; dotted: CHOLMOD's factor alone")
    for axes in (times, memory):
        axes.grid(alpha=0.3)
        if axes.lines:
            axes.legend(fontsize=7, loc="lower right")
    figure.savefig(path, dpi=DPI, metadata=SOFTWARE)
    plt.close(figure)


def _shares(rows: list[Row], path: Path) -> None:
    figure, axes = plt.subplots(figsize=(6.5, 3.6), layout="constrained")
    for work, name in (("solve_bound", "solve"), ("basis_bound", "affine basis")):
        for threads, style in ((1, "--"), (2, "-")):
            some = [row for row in rows if row["work"] == work and row["threads"] == threads]
            some.sort(key=lambda row: row["vertices"])
            if some:
                share = [100 * row["peer"] / row["ours"] for row in some]
                colour = "C0" if work == "solve_bound" else "C1"
                label = f"{name}, {threads} thread{'s' * (threads > 1)}"
                axes.semilogx(
                    [row["vertices"] for row in some], share, f"o{style}", color=colour, label=label
                )
    ticks = sorted({row["size"] for row in rows if row["work"] == "solve_bound"})
    axes.set_xticks(ticks, [short(size) for size in ticks])
    axes.minorticks_off()
    axes.set(xlabel="vertices", ylabel="% of the bandwidth bound", ylim=(0, None))
    axes.grid(alpha=0.3)
    if axes.lines:
        axes.legend(fontsize=8)
    figure.savefig(path, dpi=DPI, metadata=SOFTWARE)
    plt.close(figure)
