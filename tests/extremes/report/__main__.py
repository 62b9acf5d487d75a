"""Renders what `make test-long` recorded in build/release/extremes as REPORT.md and long_runs.png.

    /usr/bin/python3 tests/extremes/report [build/release/extremes] [--short] [--output FOLDER]

With --short the records are those of the short form, `extremes_test --short FILE`.
"""
from __future__ import annotations

import argparse
import os
import pathlib
import re
import subprocess
from collections import defaultdict

from long_runs import draw, long_runs
from records import counted, method, read
from tables import table

HERE = pathlib.Path(__file__).resolve().parent.parent
INTRODUCTIONS = {
    "separatrix": "m = G(δ, 1, δ′) next to the unstable axis, on the separatrix and on both sides of it.",
    "inertia": "Bodies near symmetry, thin plates and rods, Λ spread over many decades, λ_i + λ_j next to 0.",
    "momentum": "‖M‖_op towards 2 and beyond where Ψ⁻¹ ends, units from 1e-150 to 1e150, denormal numbers, rest, "
                "principal axes.",
    "steps": "h‖Ω‖ from 0.5 to 1e9, forth and back, for every implicit method on every system. A step is solved to "
             "rounding on the branch that starts at the identity, or it is LEFT_DOMAIN with the largest step.",
    "sizes": "The smallest and the largest frames and groups. The large scenes are small ones side by side, rotated "
             "among axes of equal λ, so that their truth is known and no block of them is zero.",
    "frames": "Frames off orthogonality, reflections, clustered eigenvalues of K = QΛ⁻¹Qᵀ.",
    "long_runs": "The variational method at h‖Ω‖ = 0.1, the root of the mean square over seeded scenes.",
    "reversibility": "By step, and from there by −step, without the solver's history: back to the start.",
    "chaos": "V(2,5) with Λ over 1 : 16. The motion is chaotic: after the time shown the state has no digit, while "
             "the momentum and QQᵀ = I hold to rounding.",
    "energy": "On V(n, N) the variational step keeps a modified energy: E moves by (h²/24) tr(BKB) and no further, "
              "while (h‖Q̇‖)² λ_max/λ_min is small.",
    "service": "Requests of 10⁹ steps, a million samples, 10⁴ sessions, every limit that Describe lists and one past "
               "it. The tests assert counts and outcomes; figures without a bound are for information.",
}


def machine():
    model = re.search(r"model name\s*:\s*(.*)", pathlib.Path("/proc/cpuinfo").read_text())
    return f"{model[1] if model else 'unknown CPU'}, {os.cpu_count()} cores"


def commit():
    return subprocess.run(["git", "-C", HERE, "log", "-1", "--format=%h"], capture_output=True, text=True,
                          check=True).stdout.strip()


def folded(lines):
    if len(lines) <= 40:
        return [*lines, ""]
    return [f"<details><summary>{len(lines) - 2} lines</summary>", "", *lines, "", "</details>", ""]


def section(extreme, records, output):
    out = [f"## {extreme.replace('_', ' ').capitalize()}", "", INTRODUCTIONS.get(extreme, ""), "", counted(records), ""]
    if extreme != "long_runs":
        return out + folded(table(extreme, records))
    lines, curves = long_runs(records)
    draw(curves, output / "long_runs.png")
    return out + ["![Energy, momentum, orthogonality and phase over the number of steps](long_runs.png)", "",
                  *folded(lines)]


def known_limits(records):
    sentences = defaultdict(list)
    for record in records:
        if record["limit"]:
            sentences[record["limit"]].append(record)
    out = ["## Known limits", ""]
    for sentence, of_it in sentences.items():
        where = list(dict.fromkeys(f"{r['extreme']}, {r['row']}" for r in of_it))
        methods = ", ".join(sorted({method(r) for r in of_it}))
        shown = "; ".join(where[:4]) + (f"; and {len(where) - 4} more" if len(where) > 4 else "")
        out.append(f"- {sentence} ({methods}: {shown}).")
    return out


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", nargs="?", type=pathlib.Path, default="build/release/extremes")
    parser.add_argument("--short", action="store_true")
    parser.add_argument("--output", type=pathlib.Path, help="by default the folder of the records")
    arguments = parser.parse_args()
    output = arguments.output or arguments.folder
    made_by = "the short form, `extremes_test --short FILE`," if arguments.short else "`make test-long`"
    records = read(arguments.folder)
    if not records:
        parser.error(f"{arguments.folder} holds no records: make test-long")
    by_extreme = defaultdict(list)
    for record in records:
        by_extreme[record["extreme"]].append(record)
    out = ["# At the extremes: the report", "", "`tests/extremes/README.md` says how to read it.", "", counted(records), "",
           f"Made by {made_by} and `python3 tests/extremes/report` on {machine()}, commit {commit()}.", ""]
    for extreme in [*INTRODUCTIONS, *sorted(set(by_extreme) - set(INTRODUCTIONS))]:
        if by_extreme[extreme]:
            out += section(extreme, by_extreme[extreme], output)
    out += known_limits(records)
    (output / "REPORT.md").write_text("\n".join(out).rstrip() + "\n")


if __name__ == "__main__":
    main()
