"""Renders what `make test-long` recorded in build/release/extremes as README.md and long_runs.png.

    /usr/bin/python3 tests/extremes/report.py [build/release/extremes] [--short]

With --short the records are those of the short form, `extremes_test --short FILE`.
"""

import argparse
import json
import math
import os
import pathlib
import re
import subprocess
from collections import defaultdict

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

HERE = pathlib.Path(__file__).parent
ORDER = ["separatrix", "inertia", "momentum", "steps", "sizes", "frames", "long_runs", "reversibility", "chaos",
         "energy", "service"]
CURVE = re.compile(r"(energy|momentum|orthogonality|phase) at (\d+)$")
PANELS = ["energy", "momentum", "orthogonality", "phase"]
INTRODUCTIONS = {
    "separatrix": "m = G(δ, 1, δ′) next to the unstable axis, on the separatrix and on both sides of it.",
    "inertia": "Bodies near symmetry, thin plates and rods, Λ spread over many decades, λ_i + λ_j next to 0.",
    "momentum": "‖M‖_op towards 2 and beyond where Ψ⁻¹ ends, units from 1e-150 to 1e150, denormal numbers, rest, "
                "principal axes.",
    "steps": "h‖Ω‖ = 0.5, 0.9, 0.99, 1, 1.2 and 3, forth and back, for every implicit method on every system: solved "
             "to rounding on the branch that starts at the identity, or LEFT_DOMAIN with the largest step.",
    "sizes": "The smallest and the largest frames and groups. The large scenes are small ones side by side, rotated "
             "among axes of equal λ so that nothing of it shows; so their truth is known.",
    "frames": "Frames off orthogonality, reflections, clustered eigenvalues of K = QΛ⁻¹Qᵀ.",
    "long_runs": "The variational method at h‖Ω‖ = 0.1, the root of the mean square over seeded scenes.",
    "reversibility": "By step, and from there by −step, without the solver's history: back to the start.",
    "chaos": "V(2,5) with Λ over 1 : 16: from some time on the state means nothing, though what the map keeps is kept.",
    "energy": "On V(n, N) the variational step keeps a modified energy: E moves by (h²/24) tr(BKB) and no further, "
              "while (h‖Q̇‖)² λ_max/λ_min is small.",
    "service": "Requests of 10⁹ steps, a million samples, 10⁴ sessions, every limit that Describe lists and one past "
               "it. Counts and outcomes are asserted there; a figure without a bound is for the reader.",
}


def read(folder):
    records = []
    for path in sorted(folder.glob("*.jsonl")):
        for line in path.read_text().splitlines():
            record = json.loads(line)
            record["value"] = float(record["value"])
            record["bound"] = math.inf if record["bound"] is None else float(record["bound"])
            records.append(record)
    return records


def ratio(record):
    """How much of its bound a record uses; a bound of 0 is met or not."""
    value, bound = record["value"], record["bound"]
    if bound == 0:
        return 0 if value <= 0 else math.inf
    return value / bound if not math.isnan(value) else math.inf


def number(x):
    if x == int(x) and abs(x) < 1e6:
        return str(int(x))
    return f"{x:.1e}"


def cell(records):
    if not records:
        return ""
    if len({r["outcome"] for r in records}) == 1 and records[0]["outcome"] != "REACHED":
        return records[0]["outcome"]
    worst = max(records, key=ratio)
    if worst["bound"] == 0:
        return "yes" if worst["value"] <= 0 else "no"
    relation = "≤" if worst["value"] <= worst["bound"] else ">"
    text = f"{worst['measure']} {number(worst['value'])} {relation} {number(worst['bound'])}"
    if any(r["outcome"] != "REACHED" for r in records):
        text += ", some " + ", ".join(sorted({r["outcome"] for r in records} - {"REACHED"}))
    return text


def method(record):
    name = record["method"] or record["system"]
    return f"`{name}`" if name else ""


def table(records):
    groups = defaultdict(list)
    for record in records:
        groups[record["row"], method(record)].append(record)
    lines = ["| row | method | compensated | plain | bound | s |", "| --- | --- | --- | --- | --- | --- |"]
    for (row, name), all_of_it in groups.items():
        plain = [r for r in all_of_it if r["arithmetic"] == "plain"]
        other = [r for r in all_of_it if r["arithmetic"] != "plain"]
        why = max(all_of_it, key=ratio)["why"].split(";")[0].replace("|", "\\|")
        runs = {(r["system"], r["order"], r["arithmetic"]): r["seconds"] for r in all_of_it}
        lines.append(f"| {row} | {name} | {cell(other)} | {cell(plain)} | {why} | {sum(runs.values()):.2g} |")
    return lines


def service(records):
    lines = ["| row | measure | value | bound | because | outcome | s |",
             "| --- | --- | --- | --- | --- | --- | --- |"]
    for r in records:
        bound = "" if math.isinf(r["bound"]) else number(r["bound"])
        lines.append(f"| {r['row']} | {r['measure']} | {number(r['value'])} | {bound} | {r['why'] or ''} | "
                     f"{r['outcome']} | {r['seconds']:.2g} |")
    return lines


def long_runs(records):
    """One line a curve: where it ends, and how fast it grew."""
    curves = defaultdict(dict)
    exponents = {}
    others = []
    for r in records:
        key = r["row"], r["arithmetic"]
        if found := CURVE.match(r["measure"]):
            curves[(*key, found[1])][int(found[2])] = r
        elif r["measure"].startswith("exponent of "):
            exponents[(*key, r["measure"].removeprefix("exponent of "))] = r
        else:
            others.append(r)
    lines = ["| row | arithmetic | of | steps | at the end | bound | exponent, last three decades | bound | s |",
             "| --- | --- | --- | --- | --- | --- | --- | --- | --- |"]
    for (row, arithmetic, of), points in curves.items():
        last = max(points)
        exponent = exponents.pop((row, arithmetic, of), None)
        tail = f"{exponent['value']:.2f} | {exponent['bound']}" if exponent else f"{fit(points):.2f} | "
        lines.append(f"| {row} | {arithmetic} | {of} | {last:.0e} | {number(points[last]['value'])} | "
                     f"{number(points[last]['bound'])} | {tail} | {points[last]['seconds']:.0f} |")
    for (row, arithmetic, of), r in exponents.items():
        lines.append(f"| {row} | {arithmetic} | {of} | | | | {r['value']:.2f} | {r['bound']} | {r['seconds']:.0f} |")
    return lines, curves


def fit(points):
    last = math.log10(max(points))
    xy = [(math.log10(k), math.log10(r["value"])) for k, r in points.items()
          if r["value"] > 0 and math.log10(k) >= last - 3.01]
    if len(xy) < 2:
        return math.nan
    x, y = (sum(v) / len(xy) for v in zip(*xy))
    return sum((a - x) * (b - y) for a, b in xy) / sum((a - x) ** 2 for a, _ in xy)


def draw(curves, path):
    figure, axes = plt.subplots(2, 2, figsize=(11, 8), sharex=True, constrained_layout=True)
    rows = list(dict.fromkeys(row for row, _, _ in curves))
    colours = {row: f"C{i}" for i, row in enumerate(rows)}
    for panel, axis in zip(PANELS, axes.flat):
        for (row, arithmetic, of), points in curves.items():
            if of != panel:
                continue
            steps = sorted(points)
            axis.loglog(steps, [points[k]["value"] for k in steps], "-" if arithmetic == "compensated" else "--",
                        color=colours[row], label=f"{row}, {arithmetic}", linewidth=1.4)
        least, most = 1e1, 1e8
        power = 1.5 if panel == "phase" else 0.5
        steps = [least, most if panel != "phase" else 1e6]
        base = axis.get_ylim()[0]
        axis.loglog(steps, [base * (k / least) ** power for k in steps], ":", color="0.6", linewidth=1)
        axis.annotate(f"steps$^{{{power}}}$", (steps[-1], base * (steps[-1] / least) ** power), color="0.4",
                      ha="right", va="bottom", fontsize=9)
        axis.set_title(panel if panel != "phase" else "phase, against the same map in quadruple precision",
                       fontsize=10)
        axis.grid(True, which="major", color="0.92")
        for side in ("top", "right"):
            axis.spines[side].set_visible(False)
    for axis in axes[1]:
        axis.set_xlabel("steps")
        axis.tick_params(labelbottom=True)
    for axis in axes[:, 0]:
        axis.set_ylabel("error, root mean square")
    handles, labels = axes[0, 0].get_legend_handles_labels()
    more, names = axes[0, 1].get_legend_handles_labels()
    for handle, label in zip(more, names):
        if label not in labels:
            handles.append(handle)
            labels.append(label)
    figure.legend(handles, labels, loc="upper center", bbox_to_anchor=(0.5, 0), ncol=3, frameon=False, fontsize=9)
    figure.savefig(path, dpi=110, bbox_inches="tight")


def machine():
    model = re.search(r"model name\s*:\s*(.*)", pathlib.Path("/proc/cpuinfo").read_text())
    return f"{model[1] if model else 'unknown CPU'}, {os.cpu_count()} cores"


def commit():
    return subprocess.run(["git", "-C", HERE, "log", "-1", "--format=%h"], capture_output=True, text=True,
                          check=True).stdout.strip()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", nargs="?", type=pathlib.Path, default="build/release/extremes")
    parser.add_argument("--short", action="store_true")
    arguments = parser.parse_args()
    made_by = "the short form, `extremes_test --short FILE`," if arguments.short else "`make test-long`"
    records = read(arguments.folder)
    if not records:
        parser.error(f"{arguments.folder} holds no records: make test-long")
    by_extreme = defaultdict(list)
    for record in records:
        by_extreme[record["extreme"]].append(record)
    limits = [r for r in records if r["limit"]]
    missed = [r for r in records if not r["limit"] and ratio(r) > 1]
    out = ["# At the extremes", "",
           "Whatever a scene asks, the answer is right to the accuracy that the problem allows, or it is a typed refusal",
           "that says what would work. Each row is run by every method, order and arithmetic that takes it, and compared",
           "with the same map in quadruple precision, with the exact motion, or with what must be kept. u = 2⁻⁵³; κ is the",
           "condition of the problem: how far the end moves, in quadruple precision, when every number of the start moves",
           "by one part. A cell is the measure that uses most of its bound; where a method has several orders, or a row",
           "several systems, the worst of them.", "",
           f"{len(records)} measurements: {len(records) - len(limits) - len(missed)} within their bounds, "
           f"{len(limits)} known limits" + (f", **{len(missed)} missed**" if missed else "") + ".", "",
           f"Made by {made_by} and `python3 tests/extremes/report.py` on {machine()}, commit {commit()}.", ""]
    for extreme in ORDER + sorted(set(by_extreme) - set(ORDER)):
        of_it = by_extreme.get(extreme)
        if not of_it:
            continue
        out += [f"## {extreme.replace('_', ' ').capitalize()}", "", INTRODUCTIONS.get(extreme, ""), ""]
        if extreme == "long_runs":
            lines, curves = long_runs(of_it)
            draw(curves, HERE / "long_runs.png")
            out += ["![Energy, momentum, orthogonality and phase over the number of steps](long_runs.png)", ""]
        else:
            lines = service(of_it) if extreme == "service" else table(of_it)
        if len(lines) > 40:
            out += [f"<details><summary>{len(lines) - 2} lines</summary>", "", *lines, "", "</details>", ""]
        else:
            out += [*lines, ""]
    out += ["## Known limits", ""]
    sentences = defaultdict(list)
    for record in limits:
        sentences[record["limit"]].append(record)
    for sentence, of_it in sentences.items():
        where = list(dict.fromkeys(f"{r['extreme']}, {r['row']}" for r in of_it))
        methods = ", ".join(sorted({method(r) for r in of_it}))
        shown = "; ".join(where[:4]) + (f"; and {len(where) - 4} more" if len(where) > 4 else "")
        out.append(f"- {sentence} ({methods}: {shown}).")
    (HERE / "README.md").write_text("\n".join(out).rstrip() + "\n")


if __name__ == "__main__":
    main()
