# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes lines for the terminal and tables for the documents from the rows."""

import json
from collections import defaultdict
from collections.abc import Iterable
from pathlib import Path

import numpy as np
from record import Row
from works import ANY, BY_ID, WORKS, Work

COUNTS = Path(__file__).parent / "instructions" / "table.json"
TIE = 0.97  # of two equal measurements, one may look this much faster than the other


def short(count: int) -> str:
    """A rounded number of vertices: 10178 -> "10k"."""
    millions, thousands = f"{count / 1e6:.3g}M", f"{count // 1000}k"
    return millions if count >= 1_000_000 else thousands if count >= 1000 else str(count)


def amount(value: float, unit: str) -> str:
    if unit == "bytes":
        return f"{value / 1e6:.4g} MB"
    if unit != "s":
        return f"{value:.2g}"
    return f"{value:.3g} s" if value >= 1.0 else f"{1e3 * value:.3g} ms"


def bare_ratio(work: Work, row: Row) -> str:
    """The ratio as a text, with ">" if the peer was stopped early, so that the true ratio is larger."""
    ratio = work.ratio(row)
    least = ">" if row.get("peer_arrived") is False else ""
    return least + (f"{ratio:.0f}" if ratio >= 99.5 else f"{ratio:.2g}" if ratio >= 9.95 else f"{ratio:.2f}")


def line(row: Row) -> str:
    work = BY_ID[row["work"]]
    threads = f"{row['threads']}T" if row.get("threads") else ""
    head = f"{work.id:22}{short(row['size']):>6} {threads:3}{row.get('case') or '':26}"
    if "excess_percent" in row:
        return head + " / ".join(map(_percent, row["excess_percent"]))
    head += f"{amount(row['ours'], row['unit']):>10}"
    if row.get("peer") is None:
        return head
    goal = work.goal(row)
    wanted = "" if goal is None else f"  wanted {'<=' if work.at_most else '>='} {goal:g}"
    verdict = "  MISSED" if work.met(row) is False else ""
    peer = f"{work.peer} {amount(row['peer'], row['unit'])}"
    return f"{head}  ratio {bare_ratio(work, row):>6}{wanted}{verdict}  {peer}"


def by_work(rows: list[Row]) -> list[tuple[Work, list[Row]]]:
    """The works that were compared with a peer, each with its rows."""
    found = defaultdict(list)
    for row in rows:
        if row.get("peer") is not None:
            found[row["work"]].append(row)
    return [(work, found[work.id]) for work in WORKS if work.id in found]


def missed(rows: list[Row]) -> int:
    """The number of works with ratios that are not as wanted."""
    return sum(any(work.met(row) is False for row in some) for work, some in by_work(rows))


def summary(rows: list[Row]) -> str:
    verdicts = [work.met(row) for work, some in by_work(rows) for row in some]
    return f"{verdicts.count(True)} ratios as wanted, {verdicts.count(False)} missed"


def table(header: Iterable[str], lines: Iterable[Iterable[str]]) -> str:
    cells = [list(header), *map(list, lines)]
    rule = "|" + "---|" * len(cells[0])
    first, *others = (f"| {' | '.join(row)} |" for row in cells)
    return "\n".join([first, rule, *others])


def wanted(work: Work) -> str:
    """ "at least 8, 12; 200k: 7, 11", or nothing."""
    sizes = defaultdict(list)
    for size, goal in work.wanted.items():
        pair = goal if isinstance(goal, tuple) else (goal,)
        sizes[", ".join(f"{value:g}" for value in pair)].append(size)
    at = {goal: "" if some == [ANY] else f"{'/'.join(map(short, some))}: " for goal, some in sizes.items()}
    parts = [place + goal for goal, place in at.items()]
    return f"{'at most' if work.at_most else 'at least'} {'; '.join(parts)}" if parts else ""


def reached(work: Work, rows: list[Row]) -> str:
    """ "10k: 9.1, 14 · 50k: *7.9*, *11*": on one and on two threads, in italics if it is not as wanted."""
    places = defaultdict(list)
    for row in sorted(rows, key=lambda row: (row.get("case") or "", row["size"], row.get("threads") or 0)):
        ratio = bare_ratio(work, row)
        place = row.get("case") or short(row["size"])
        places[place].append(f"*{ratio}*" if work.met(row) is False else ratio)
    return " · ".join(f"{place}: {', '.join(ratios)}" for place, ratios in places.items())


def ratios(rows: list[Row]) -> str:
    """A table of all works with all ratios that were reached."""
    lines = [(work.what, work.peer, wanted(work), reached(work, some)) for work, some in by_work(rows)]
    return table(("measured", "next to", "wanted", "reached: vertices, one thread, two threads"), lines)


def two_threads(rows: list[Row]) -> str:
    """A sentence about the least that a second thread gives."""
    ours = defaultdict(dict)
    for row in rows:
        if row.get("threads"):
            ours[row["work"], row["size"], row.get("case")][row["threads"]] = row["ours"]
    gains = {key: times[1] / times[2] for key, times in ours.items() if {1, 2} <= times.keys()}
    if not gains:
        return ""
    worst = min(gains, key=gains.get)
    slower = sum(gain < TIE for gain in gains.values())
    return (
        f"Of {len(gains)} measurements on one and on two threads, {slower} took over 3 % longer on two. "
        f"The least gain is a factor of {gains[worst]:.2f} ({BY_ID[worst[0]].what}, {short(worst[1])})."
    )


def exponent(sizes: Iterable[float], values: Iterable[float]) -> float:
    """The exponent p of values ~ sizes^p, by least squares of logarithms."""
    return float(np.polyfit(np.log(list(sizes)), np.log(list(values)), 1)[0])


def own_times(rows: list[Row]) -> str:
    """A table of Sinew's own times by size, on two threads, with their growth, of works with many sizes."""
    found = defaultdict(dict)
    for row in rows:
        if row.get("threads") != 1 and not row.get("case") and "ours" in row:
            found[row["work"]][row["size"]] = row
    found = {work.id: found[work.id] for work in WORKS if len(found[work.id]) > 2}
    sizes = sorted({size for some in found.values() for size in some})
    lines = []
    for work, some in found.items():
        cells = [amount(some[size]["ours"], some[size]["unit"]) if size in some else "" for size in sizes]
        power = exponent(*zip(*((row["vertices"], row["ours"]) for row in some.values())))
        lines.append((BY_ID[work].what, *cells, f"n^{power:.2f}"))
    return table(("", *map(short, sizes), "grows with"), lines)


def _percent(value: float) -> str:
    return f"{value:.2f}" if value >= 0.005 else "<.01"


def convergence(rows: list[Row]) -> str:
    lines = []
    for row in rows:
        if row["work"] == "convergence":
            excess = " / ".join(map(_percent, row["excess_percent"]))
            lines.append((row["case"], f"{row['vertices']:,}", excess, str(row["default_iterations"])))
    return table(("case", "vertices", "% after 0 / 4 / 10 / 20 / 40", "default stops at"), lines)


def settled(rows: list[Row]) -> str:
    found = defaultdict(dict)
    for row in rows:
        if row["work"] == "settled":
            found[row["case"]][row["size"]] = row["ours"]
    sizes = sorted({size for some in found.values() for size in some})
    lines = [(f"`{name}`", *(str(some.get(size, "")) for size in sizes)) for name, some in found.items()]
    return table(("", *map(short, sizes)), sorted(lines))


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
    counts, vertices = stored["instructions"].items(), stored["vertices"]
    lines = [(loop, f"{count:,}", f"{count / vertices:,.0f}") for loop, count in counts]
    avx2 = "with" if stored["avx2"] else "without"
    head = f"Compiler {stored['compiler']}, {avx2} AVX2, {vertices:,} vertices.\n\n"
    return head + table(("loop", "instructions", "per vertex"), lines)


def frames(rows: list[Row]) -> str:
    """A table of the parts of a frame in Blender."""
    lines = []
    for row in rows:
        if "native_ms" in row:
            parts = row["ours"], row["native_ms"] / 1000.0, row["around_ms"] / 1000.0, row["peer"]
            times = (amount(part, "s") for part in parts)
            lines.append((row["case"], row["work"], f"{row['vertices']:,}", *times))
    header = ("Blender", "row", "vertices", "frame", "native solve", "the rest", "Blender's deformer")
    return table(header, sorted(lines, key=lambda cells: cells[1::-1]))
