# SPDX-License-Identifier: GPL-3.0-or-later
"""Rewrites the benchmark tables of the README from the stored results."""

import json
from pathlib import Path

HERE = Path(__file__).resolve().parent
README = HERE.parents[1] / "README.md"
NAMES = {
    "supernodal": "supernodal factor of CHOLMOD, own solve",
    "simplicial": "CHOLMOD simplicial",
    "ldlt": "Eigen LDLT",
    "scipy splu": "SciPy splu (SuperLU)",
    "ThinShell, full solve": "`thin_shell`, full solve",
    "ThinShell, affine basis": "`thin_shell`, affine basis",
}
BEGIN, END = "<!-- benchmarks -->", "<!-- end of benchmarks -->"


def _rows(name: str) -> tuple[dict, list[dict]]:
    stored = json.loads((HERE / "results" / f"{name}.json").read_text(encoding="utf-8"))
    return stored["machine"], stored["rows"]


def _table(header: str, lines: list[str]) -> str:
    columns = header.count("|") - 1
    return "\n".join([header, "|" + "---|" * columns, *lines])


def _thin_shell() -> str:
    _, rows = _rows("thin_shell_bind")
    largest = max(row["vertices"] for row in rows)
    lines = [
        f"| {NAMES[row['backend']]} | {row['bind_s']:.2f} s | {1e3 * row['solve3_s']:.3g} ms |"
        for row in rows
        if row["vertices"] == largest
    ]
    text = f"Bi-Laplacian of {largest:,} vertices, two handles; each factor gets the same matrix.\n\n"
    return text + _table("| | bind (ordering + factor) | a frame (x, y, z) |", lines)


def _percent(value: float) -> str:
    return f"{value:.2f}" if value >= 0.005 else "<.01"


def _arap() -> str:
    _, rows = _rows("arap_convergence")
    lines = []
    for row in rows:
        excess = " / ".join(map(_percent, row["excess_percent"]))
        lines.append(
            f"| {row['case']} | {row['vertices']:,} | {excess} | {row['default_iterations']} "
            f"| {row['ms_per_iteration']:.3g} ms |"
        )
    text = (
        "Energy of `arap` above the lowest that a long run from the same start found. The 179 degree bend\n"
        "has two mirrored minima and, 0.4 % above them, a symmetric saddle, where the default stops.\n\n"
    )
    return text + _table(
        "| case | vertices | % after 0 / 4 / 10 / 20 / 40 | default stops at | iteration |", lines
    )


def main() -> None:
    machine, _ = _rows("arap_convergence")
    on = f"Measured on {machine['system']}, {machine['processor']}, {machine['cores']} cores."
    before, _, rest = README.read_text(encoding="utf-8").partition(BEGIN)
    _, _, after = rest.partition(END)
    README.write_text(
        f"{before}{BEGIN}\n{on}\n\n{_thin_shell()}\n\n{_arap()}\n{END}{after}", encoding="utf-8"
    )


if __name__ == "__main__":
    main()
