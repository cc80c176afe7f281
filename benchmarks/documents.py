# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes the figures in README.md and docs/developer/performance.md from the stored results."""

from collections.abc import Mapping
from pathlib import Path

import record
import report
from record import Row
from works import BY_ID

ROOT = Path(__file__).resolve().parents[1]
README = ROOT / "README.md"
PAGE = ROOT / "docs" / "developer" / "performance.md"

READING = (
    "Each ratio is from one run, in which Sinew and the peer ran by turns.\n"
    "Where *at least* is wanted, the ratio is the peer's time (or memory, or error) divided by Sinew's;\n"
    "where *at most* is wanted, it is Sinew's divided by the peer's. *Italic*: the target is missed."
)
# The rows of the README: what was measured, the peer, the result in words, and the stored rows of the result
# (work, size, case, threads). In the words, {0} is the ratio of the first stored row.
KNOWN_PEERS = (
    (
        "an iteration of `arap`, 50,000 vertices",
        "libigl",
        "{0} times as fast",
        [("arap_iteration", 50_000, None, 2)],
    ),
    (
        "binding `thin_shell`, 200,000 vertices",
        "CHOLMOD",
        "{0} times as fast",
        [("bind", 200_000, None, 2)],
    ),
    (
        "a frame of `thin_shell` in Blender 5.2, 100,000 vertices",
        "Laplacian Deform",
        "{0} times as fast",
        [("frame_thin_shell", 100_000, "5.2", None)],
    ),
    (
        "binding `harmonic`, a cage of 150 faces around a cow",
        "Mesh Deform, precision 5",
        "{0} times as fast, errors {1} times smaller",
        [
            ("harmonic_5", 10_000, "cow, 150 faces", None),
            ("harmonic_error_5", 10_000, "cow, 150 faces", None),
        ],
    ),
    (
        "subdividing to a million vertices",
        "OpenSubdiv's CPU evaluator",
        "{0} times as fast",
        [("subdivision", 1_000_000, None, 2)],
    ),
    (
        "faces of a scan that meet its automatic cage",
        "Blender's remesh, displace, decimate",
        "{0.ours:.0f} instead of {0.peer:,.0f}",
        [("cage_poking", 43_000, None, None)],
    ),
)


class Ratio:
    """The ratio of a row, for ``format``; ``ours`` and ``peer`` are the measured values."""

    def __init__(self, row: Row) -> None:
        self._row, self.ours, self.peer = row, row["ours"], row["peer"]

    def __format__(self, _spec: str) -> str:
        ratio = BY_ID[self._row["work"]].ratio(self._row)
        return f"{ratio:.0f}" if ratio >= 9.95 else f"{ratio:.1f}"


def known_peers(rows: list[Row]) -> str:
    """The six rows of the README, as far as they are stored."""
    stored = {tuple(row.get(name) for name in ("work", "size", "case", "threads")): row for row in rows}
    lines = [
        (what, peer, words.format(*(Ratio(stored[key]) for key in keys)))
        for what, peer, words, keys in KNOWN_PEERS
        if all(key in stored for key in keys)
    ]
    return report.table(("measured", "next to", "Sinew is"), lines)


def in_short(rows: list[Row], page: str) -> str:
    """The sentences about the number of rows, and about those that fall short."""
    measured, short = len(report.by_work(rows)), len(report.shortfalls(rows))
    return (
        f"Sinew ran on two threads, by turns with its peer. These are six of {measured} rows. Of all rows, "
        f"{short} miss their target in some case: [every row]({page}), measured by `benchmarks/run`."
    )


def measured_on(machines: list[Mapping[str, object]]) -> str:
    described = []
    for machine in machines:
        memory = f", {machine['memory_gib']} GiB" if machine.get("memory_gib") else ""
        described.append(f"{machine['system']}, {machine['processor']}, {machine['cores']} cores{memory}")
    return f"Measured on {'; '.join(dict.fromkeys(described))}."


def replaced(text: str, name: str, content: str) -> str:
    """The text with new ``content`` between <!-- name --> and <!-- end of name -->."""
    begin, end = f"<!-- {name} -->", f"<!-- end of {name} -->"
    before, found, rest = text.partition(begin)
    _, closed, after = rest.partition(end)
    if not found or not closed:
        raise SystemExit(f"the document has no {begin} ... {end}")
    return f"{before}{begin}\n{content}\n{end}{after}"


def renewed(folder: Path = record.RESULTS, readme: Path = README, page: Path = PAGE) -> dict[Path, str]:
    """The texts of both documents with the stored figures."""
    machines, rows = record.load(folder)
    on = measured_on(machines)
    link = PAGE.relative_to(ROOT).as_posix()
    blocks = {
        "machine": on,
        "ratios": f"{READING}\n\n{report.ratios(rows)}",
        "shortfalls": report.shortfall_table(rows),
        "times": report.own_times(rows),
        "bounds": report.bound_shares(rows),
        "bend": report.bend(rows),
        "convergence": report.convergence(rows),
        "instructions": report.instructions(),
        "profiles": report.profiles(),
        "frames": report.frames(rows),
        "handlers": report.handler_cost(rows),
    }
    text = page.read_text(encoding="utf-8")
    for name, content in blocks.items():
        text = replaced(text, name, content)
    six = f"{on} {in_short(rows, link)}\n\n{known_peers(rows)}"
    return {readme: replaced(readme.read_text(encoding="utf-8"), "benchmarks", six), page: text}


def render(folder: Path = record.RESULTS, readme: Path = README, page: Path = PAGE) -> None:
    """Rewrite the figures of both documents, and draw the plots."""
    import plots

    for path, text in renewed(folder, readme, page).items():
        path.write_text(text, encoding="utf-8")
    plots.draw(record.load(folder)[1], page.parent / "images")
