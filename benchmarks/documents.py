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
    "Each ratio is from one run, in which Sinew and the peer ran by turns: the peer's time (or memory, or\n"
    "error) divided by Sinew's. Where *at most* is wanted, it is Sinew's divided by the peer's. *Italic*:\n"
    "not as wanted. Rows for which nothing is wanted are plain figures."
)
FASTER = "{0} times as fast"
# The rows of the README: what was measured, the peer, the result in words, and the stored rows of the result
# (work, size, case, threads), whose ratios go into the words.
KNOWN_PEERS = (
    ("an iteration of `arap`, 50,000 vertices", "libigl", FASTER, [("arap_iteration", 50_000, None, 2)]),
    ("binding `thin_shell`, 200,000 vertices", "CHOLMOD", FASTER, [("bind", 200_000, None, 2)]),
    ("a frame of `thin_shell` in Blender 5.2, 100,000 vertices", "Laplacian Deform",
     FASTER, [("frame_thin_shell", 100_000, "5.2", None)]),
    ("a frame while `arap` is dragged in Blender 5.2, 100,000 vertices", "Laplacian Deform, repeat 3",
     FASTER, [("drag_arap", 100_000, "5.2", None)]),
    ("binding `harmonic`, a cage of 150 faces around a cow", "Mesh Deform, precision 5",
     FASTER + ", errors {1} times smaller",
     [(work, 10_000, "cow, 150 faces", None) for work in ("harmonic", "harmonic_error")]),
    ("subdividing to a million vertices", "OpenSubdiv's CPU evaluator",
     FASTER, [("subdivision", 1_000_000, None, 2)]),
)  # fmt: skip


def known_peers(rows: list[Row]) -> str:
    """The rows of the README, as far as they are stored."""
    stored = {tuple(row.get(name) for name in ("work", "size", "case", "threads")): row for row in rows}
    lines = []
    for what, peer, words, keys in KNOWN_PEERS:
        if all(key in stored for key in keys):
            ratios = [BY_ID[stored[key]["work"]].ratio(stored[key]) for key in keys]
            rounded = [f"{ratio:.0f}" if ratio >= 9.95 else f"{ratio:.1f}" for ratio in ratios]
            lines.append((what, peer, words.format(*rounded)))
    return report.table(("measured", "next to", "Sinew is"), lines)


def in_short(rows: list[Row], page: str) -> str:
    """The sentences about the number of rows, and about those that are not as wanted."""
    return (
        f"Sinew ran on two threads, by turns with its peer. These are six of {len(report.by_work(rows))} "
        f"rows, of which {report.missed(rows)} miss their target in some case: [every row]({page}), measured "
        "by `benchmarks/run`."
    )


def measured_on(machines: list[Mapping[str, object]]) -> str:
    words = "{system}, {processor}, {cores} cores, {memory_gib} GiB"
    described = [words.format_map(machine) for machine in machines]
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
        "times": f"{report.own_times(rows)}\n\n{report.two_threads(rows)}",
        "bend": report.bend(rows),
        "convergence": report.convergence(rows),
        "settled": report.settled(rows),
        "instructions": report.instructions(),
        "frames": report.frames(rows),
    }
    text = page.read_text(encoding="utf-8")
    for name, content in blocks.items():
        text = replaced(text, name, content)
    six = f"{on} {in_short(rows, link)}\n\n{known_peers(rows)}"
    return {readme: replaced(readme.read_text(encoding="utf-8"), "benchmarks", six), page: text}


def render(folder: Path = record.RESULTS, readme: Path = README, page: Path = PAGE) -> None:
    for path, text in renewed(folder, readme, page).items():
        path.write_text(text, encoding="utf-8")
