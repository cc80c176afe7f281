# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes lines for the terminal and tables for the documents from the rows."""

import json
from collections import defaultdict
from collections.abc import Iterable
from pathlib import Path

import numpy as np
from record import Row
from works import ANY, BY_ID, CONVERGENCE_BUDGETS, OWN_TIMES, WORKS, Work, two_thread_rows

COUNTS = Path(__file__).parent / "instructions" / "table.json"


def short(count: int) -> str:
    """A rounded number of vertices: 10178 -> "10k"."""
    return (
        f"{count / 1e6:.3g}M" if count >= 1_000_000 else f"{count // 1000}k" if count >= 1000 else str(count)
    )


def amount(value: float, unit: str) -> str:
    if unit == "bytes":
        return f"{value / 1e6:.4g} MB"
    if unit == "faces":
        return f"{value:.0f} faces"
    if not unit:
        return f"{value:.2g}"
    return f"{value:.3g} s" if value >= 1.0 else f"{1e3 * value:.3g} ms"


def bare_ratio(work: Work, row: Row) -> str:
    """The ratio as a text, with ">" if the peer was stopped early, so that the true ratio is larger."""
    ratio = work.ratio(row)
    least = ">" if row.get("peer_arrived") is False else ""
    return least + (f"{ratio:.0f}" if ratio >= 99.5 else f"{ratio:.2g}" if ratio >= 9.95 else f"{ratio:.2f}")


def line(row: Row) -> str:
    """The line for a row in the terminal."""
    if row["work"] == "convergence":
        excess = " ".join(f"{value:9.4f}" for value in row["excess_percent"])
        over = "".join(f"  over {limit:g} %" for limit in row["over"])
        return f"{row['case']:18}{row['vertices']:>8}  {excess}  stops at {row['default_iterations']}{over}"
    if row["work"] == "handler_cost":
        return (
            f"handler in {row['case']}: {row['handler_ms']:.4f} ms of an update of {row['update_ms']:.3f} ms"
        )
    work = BY_ID[row["work"]]
    where = " ".join(str(row[name]) for name in ("case",) if row.get(name))
    threads = f"{row['threads']}T" if row.get("threads") else ""
    head = f"{work.id:20}{short(row['size']):>6} {threads:3}{where:16}{amount(row['ours'], row['unit']):>10}"
    if row.get("peer") is None:
        return head
    goal, met = work.goal(row), work.met(row)
    wanted = "" if goal is None else f"  wanted {'<=' if work.at_most else '>='} {goal:g}"
    tail = f"  {work.peer} {amount(row['peer'], row['unit'])}"
    return f"{head}  ratio {bare_ratio(work, row):>6}{wanted}{'  SHORT' if met is False else ''}{tail}"


def exponent(sizes: Iterable[float], values: Iterable[float]) -> float:
    """The exponent p of values ~ sizes^p, by least squares of logarithms."""
    return float(np.polyfit(np.log(list(sizes)), np.log(list(values)), 1)[0])


def series(rows: list[Row]) -> dict[tuple[str, int | None], list[Row]]:
    """The rows of each timed loop and number of threads, by rising size, if there are several sizes."""
    found = defaultdict(list)
    for row in rows:
        if row["work"] in OWN_TIMES or row["work"] == "memory":
            found[row["work"], row.get("threads")].append(row)
    grown = {key: sorted(some, key=lambda row: row["vertices"]) for key, some in found.items()}
    return {key: some for key, some in grown.items() if some[0]["vertices"] < some[-1]["vertices"]}


def exponents(rows: list[Row]) -> dict[tuple[str, int | None], float]:
    return {
        key: exponent([row["vertices"] for row in some], [row["ours"] for row in some])
        for key, some in series(rows).items()
    }


def summary(rows: list[Row]) -> list[str]:
    """Lines about several rows: two threads against one, exponents, and how many ratios fall short."""
    twos = two_thread_rows(rows)
    judged = [row for row in (*rows, *twos) if row["work"] in BY_ID and row.get("peer") is not None]
    verdicts = [BY_ID[row["work"]].met(row) for row in judged]
    powers = [
        f"{work} ({threads or '-'}T): time or memory grows with n^{power:.2f}"
        for (work, threads), power in exponents(rows).items()
    ]
    closing = f"{verdicts.count(True)} ratios as wanted, {verdicts.count(False)} fall short"
    return [*(line(row) for row in twos), *powers, closing]


def table(header: Iterable[str], lines: Iterable[Iterable[str]]) -> str:
    cells = [list(header), *map(list, lines)]
    rule = "|" + "---|" * len(cells[0])
    first, *others = (f"| {' | '.join(row)} |" for row in cells)
    return "\n".join([first, rule, *others])


def _pair(values: float | tuple[float, float]) -> str:
    return ", ".join(f"{value:g}" for value in (values if isinstance(values, tuple) else (values,)))


def wanted(work: Work) -> str:
    """ "at least 8, 12; 200k: 7, 11"."""
    sizes = defaultdict(list)
    for size, goal in work.wanted.items():
        sizes[goal].append(size)
    parts = [
        _pair(goal) if some == [ANY] else f"{'/'.join(short(size) for size in some)}: {_pair(goal)}"
        for goal, some in sizes.items()
    ]
    return f"{'at most' if work.at_most else 'at least'} {'; '.join(parts)}"


def reached(work: Work, rows: list[Row]) -> str:
    """ "10k: 9.1, 14 · 50k: *7.9*, *11*": on one and on two threads, in italics if it falls short."""
    places = defaultdict(list)
    for row in sorted(
        rows, key=lambda row: (str(row.get("case") or ""), row["size"], row.get("threads") or 0)
    ):
        places[row.get("case") or short(row["size"])].append(row)
    cells = []
    for place, some in places.items():
        ratios = (
            f"*{bare_ratio(work, row)}*" if work.met(row) is False else bare_ratio(work, row) for row in some
        )
        cells.append(f"{place}: {', '.join(ratios)}")
    return " · ".join(cells)


def least_two_threads(rows: list[Row]) -> str:
    work = BY_ID["two_threads"]
    worst = min(rows, key=work.ratio)
    place = f"{bare_ratio(work, worst)} ({OWN_TIMES[worst['case']]}, {short(worst['size'])})"
    lost = sum(work.met(row) is False for row in rows)
    return f"least {f'*{place}*' if lost else place}; {lost} of {len(rows)} slower"


def by_work(rows: list[Row]) -> list[tuple[Work, list[Row]]]:
    """The works that were compared with a peer, each with its rows."""
    found = defaultdict(list)
    for row in (*rows, *two_thread_rows(rows)):
        if row["work"] in BY_ID and row.get("peer") is not None:
            found[row["work"]].append(row)
    return [(work, found[work.id]) for work in WORKS if work.id in found]


def ratios(rows: list[Row]) -> str:
    """A table of all works with all ratios that were reached."""
    lines = []
    for work, some in by_work(rows):
        found = least_two_threads(some) if work.id == "two_threads" else reached(work, some)
        lines.append((work.what, work.peer, wanted(work), found))
    return table(("measured", "next to", "wanted", "reached: vertices, one thread, two threads"), lines)


def shortfalls(rows: list[Row]) -> list[tuple[Work, list[Row]]]:
    """The works with ratios that fall short, each with these rows."""
    short_of = [(work, [row for row in some if work.met(row) is False]) for work, some in by_work(rows)]
    return [(work, some) for work, some in short_of if some]


def shortfall_table(rows: list[Row]) -> str:
    """A table of the works that fall short, each with its worst ratio and the case of this ratio."""
    lines = []
    for work, some in shortfalls(rows):
        worst = (max if work.at_most else min)(some, key=work.ratio)
        case = OWN_TIMES.get(worst.get("case"), worst.get("case"))
        size = None if worst.get("case") and work.id != "two_threads" else short(worst["size"])
        threads = {1: "one thread", 2: "two threads"}.get(worst.get("threads"))
        place = ", ".join(part for part in (case, size, threads) if part)
        ratio, goal = bare_ratio(work, worst), f"{work.goal(worst):g}"
        lines.append(
            (work.what, work.peer, goal, ratio, place, f"{len(some)} of {_count_wanted(work, rows)}")
        )
    return table(
        ("measured", "next to", "wanted there", "worst ratio", "where", "ratios that fall short"), lines
    )


def _count_wanted(work: Work, rows: list[Row]) -> int:
    """The number of rows of a work for which a ratio is wanted."""
    return sum(work.met(row) is not None for other, some in by_work(rows) if other is work for row in some)


def own_times(rows: list[Row]) -> str:
    """A table of Sinew's own times by size, on two threads, with their growth."""
    sizes = sorted({row["size"] for some in series(rows).values() for row in some})
    powers = exponents(rows)
    lines = []
    for (work, threads), some in series(rows).items():
        if threads == 1:
            continue  # the table holds times on two threads, and memory, which does not depend on threads
        cells = {row["size"]: amount(row["ours"], row["unit"]) for row in some}
        name = OWN_TIMES.get(work, "memory, bound")
        lines.append((name, *(cells.get(size, "") for size in sizes), f"n^{powers[work, threads]:.2f}"))
    return table(("", *map(short, sizes), "grows with"), lines)


def bound_shares(rows: list[Row]) -> str:
    """A table of the times as shares of the least time that the measured memory bandwidth allows."""
    lines = []
    for row in rows:
        if row["work"] in ("solve_bound", "basis_bound"):
            rate = row["bytes"] / row["peer"] / 1e9
            share = 100.0 * row["peer"] / row["ours"]
            cells = f"{row['bytes'] / 1e6:.4g} MB", f"{rate:.3g} GB/s", f"{share:.0f} %"
            name = "solve" if row["work"] == "solve_bound" else "affine basis"
            lines.append((name, short(row["size"]), str(row["threads"]), *cells))
    return table(
        ("", "vertices", "threads", "bytes read", "memory bandwidth", "share of the bandwidth"),
        sorted_by_size(lines),
    )


def sorted_by_size(lines: list[tuple[str, ...]]) -> list[tuple[str, ...]]:
    return sorted(
        lines, key=lambda cells: (cells[0], float(cells[1][:-1]) * (1e3 if "M" in cells[1] else 1), cells[2])
    )


def _percent(value: float) -> str:
    return f"{value:.2f}" if value >= 0.005 else "<.01"


def convergence(rows: list[Row]) -> str:
    lines = [
        (
            row["case"],
            f"{row['vertices']:,}",
            " / ".join(map(_percent, row["excess_percent"])),
            str(row["default_iterations"]),
        )
        for row in rows
        if row["work"] == "convergence"
    ]
    heading = f"% after {' / '.join(map(str, CONVERGENCE_BUDGETS))}"
    return table(("case", "vertices", heading, "default stops at"), lines)


def bend(rows: list[Row]) -> str:
    """A table of the iterations and times behind the row about the bent bar."""
    lines = []
    for row in rows:
        if row["work"] == "arap_bend":
            extrapolated = row.get("peer_extrapolated")
            after = f"{row['peer_iterations']} iterations, {amount(row['peer'], 's')}"
            if not row["peer_arrived"]:
                on = f", extrapolated to 1 % after {extrapolated:.0f} s" if extrapolated else ""
                after += f", still {row['peer_excess_percent']:.3g} % above{on}"
            ours = f"{row['iterations']} iterations, {amount(row['ours'], 's')}"
            lines.append((f"{row['vertices']:,}", str(row["threads"]), ours, after))
    return table(("vertices", "threads", "`Arap`", "libigl"), lines)


def instructions() -> str:
    stored = json.loads(COUNTS.read_text(encoding="utf-8"))
    lines = [
        (loop, f"{count:,}", f"{count / stored['vertices']:,.0f}")
        for loop, count in stored["instructions"].items()
    ]
    avx2 = "with" if stored["avx2"] else "without"
    return f"Compiler {stored['compiler']}, {avx2} AVX2, {stored['vertices']:,} vertices.\n\n" + table(
        ("loop", "instructions", "per vertex"), lines
    )


def profiles() -> str:
    """A table of the functions in which the instructions of each loop are."""
    stored = json.loads(COUNTS.read_text(encoding="utf-8"))
    lines = [
        (f"`{loop}`", ", ".join(f"{name} {100 * share:.0f} %" for name, share in places.items()))
        for loop, places in stored["profiles"].items()
    ]
    return table(("loop", "functions, and their share of its instructions"), lines)


def frames(rows: list[Row]) -> str:
    """A table of the parts of a frame in Blender."""
    lines = [
        (
            row["case"],
            row["work"].partition("_")[2],
            f"{row['vertices']:,}",
            amount(row["ours"], "s"),
            amount(row["native_ms"] / 1000.0, "s"),
            amount(row["around_ms"] / 1000.0, "s"),
            amount(row["peer"], "s"),
        )
        for row in rows
        if str(row["work"]).startswith("frame_")
    ]
    header = ("Blender", "method", "vertices", "frame", "native solve", "the rest", "Laplacian Deform")
    return table(header, lines)


def handler_cost(rows: list[Row]) -> str:
    lines = [
        (
            row["blender"],
            str(row["deformers"]),
            f"{row['vertices']:,}",
            f"{row['handler_ms']:.3f} ms",
            f"{row['update_ms']:.3f} ms",
        )
        for row in rows
        if row["work"] == "handler_cost"
    ]
    return table(("Blender", "deformers", "vertices", "our handler", "whole update"), lines)
