"""Writes the measurements as a table, a JSON file and a picture."""
from __future__ import annotations

import json
import os
import platform
import subprocess
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import Optional


@dataclass(frozen=True)
class Row:
    """A row of the table. `judged`: the median of the ratios of all repeats or, without a rival, the worst repeat."""
    name: str
    unit: str
    ours: float
    judged: float
    spread: tuple[float, float]
    repeats: int
    bound: Optional[float]
    rival: str = ""
    theirs: Optional[float] = None

    @staticmethod
    def of(entry: dict) -> Row:
        if "rival" not in entry:
            values = entry["values"]
            return Row(entry["name"], entry["unit"], median(values), max(values), (min(values), max(values)),
                       len(values), entry["bound"])
        ratios = [a / b for a, b in zip(entry["ours"], entry["theirs"], strict=True)]
        return Row(entry["name"], entry["unit"], median(entry["ours"]), median(ratios), (min(ratios), max(ratios)),
                   len(ratios), entry["bound"], entry["rival"], median(entry["theirs"]))

    @property
    def verdict(self) -> str:
        if self.bound is None:
            return ""
        return "kept" if self.judged <= self.bound else "MISSED"

    def cells(self) -> list[str]:
        rival, ratio = "", ""
        if self.theirs is not None:
            rival = f"{_number(self.theirs)} ({self.rival})"
            ratio = f"{self.judged:.2f} ×" if self.judged >= 0.1 else f"{_number(self.judged)} ×"
        elif self.repeats > 1:
            ratio = f"worst {_number(self.judged)}"
        spread = f"{_number(self.spread[0])} … {_number(self.spread[1])}" if self.repeats > 1 else ""
        bound = "" if self.bound is None else f"≤ {_number(self.bound)}"
        return [self.name, f"{_number(self.ours)} {self.unit}".strip(), rival, ratio, spread, bound, self.verdict]


_HEAD = ["what", "median", "rival's median", "judged", "spread", "bound", ""]


def _number(x: float) -> str:
    return f"{x:.3g}" if abs(x) < 1000 else f"{x:.0f}"


def table(rows: list[Row]) -> str:
    cells = [_HEAD, *(row.cells() for row in rows)]
    widths = [max(len(line[i]) for line in cells) for i in range(len(_HEAD))]
    lines = ["| " + " | ".join(cell.ljust(width) for cell, width in zip(line, widths)) + " |" for line in cells]
    lines.insert(1, "|" + "|".join("-" * (width + 2) for width in widths) + "|")
    return "\n".join(lines)


def circumstances(build: Path) -> dict[str, str]:
    """Returns the machine, the commit and the build of the measurement."""
    cpu = next((line.split(":", 1)[1].strip() for line in Path("/proc/cpuinfo").read_text().splitlines()
                if line.startswith("model name")), platform.processor())
    flags = dict(line.split("=", 1) for line in (build / "CMakeCache.txt").read_text().splitlines()
                 if line.startswith("CMAKE_") and "=" in line)
    kind = flags["CMAKE_BUILD_TYPE:STRING"]
    options = f"{flags['CMAKE_CXX_FLAGS:STRING']} {flags[f'CMAKE_CXX_FLAGS_{kind.upper()}:STRING']}".strip()
    compiler = subprocess.run(["c++", "--version"], capture_output=True, text=True).stdout.split("\n")[0]
    return {"machine": f"{cpu}, {os.cpu_count()} cores, Linux {platform.release()}", "commit": _commit(),
            "build": f"{kind} ({options}), {compiler}", "load": f"{os.getloadavg()[2]:.1f} over the last 15 minutes"}


def _commit() -> str:
    def git(*arguments: str) -> str:
        return subprocess.run(["git", "-C", Path(__file__).parent, *arguments], capture_output=True,
                              text=True).stdout.strip()
    changed = git("status", "--porcelain", "--untracked-files=no")
    return (git("rev-parse", "--short", "HEAD") or "unknown") + (" with changes" if changed else "")


def write(found: list[dict], build: Path, name: str, *, contest: dict, appendix: str) -> Path:
    """Writes NAME.md with the appendix, NAME.json and NAME.png into bench/ beside the build directory. Returns that
    folder."""
    folder = build.parent / "bench"
    folder.mkdir(exist_ok=True)
    facts = circumstances(build)
    rows = [Row.of(entry) for entry in found]
    text = "\n".join(f"{key}: {value}  " for key, value in facts.items()) + "\n\n" + table(rows) + "\n"
    (folder / f"{name}.md").write_text(f"{text}\n{appendix}\n")
    (folder / f"{name}.json").write_text(json.dumps({**facts, "results": found, "contest": contest}, indent=1) + "\n")
    picture(rows, facts, folder / f"{name}.png")
    return folder


def tell(found: list[dict], folder: Path, name: str) -> None:
    """Prints the table, which bounds are missed, and where the files are."""
    rows = [Row.of(entry) for entry in found]
    print(table(rows))
    missed = [row.name for row in rows if row.verdict == "MISSED"]
    print("MISSED: " + "; ".join(missed) if missed else "Every bound is kept.")
    print(f"Written to {os.path.relpath(folder)}: {name}.md, {name}.json, {name}.png.")


def picture(rows: list[Row], facts: dict[str, str], path: Path) -> None:
    import matplotlib
    matplotlib.use("Agg")
    from matplotlib import pyplot

    ratios = [row for row in rows if row.theirs is not None]
    figure, axes = pyplot.subplots(figsize=(9, 0.32 * len(ratios) + 1.2), constrained_layout=True)
    for place, row in enumerate(reversed(ratios)):
        axes.plot(row.spread, [place, place], color="#4878a8", linewidth=2, alpha=0.5)
        axes.plot(row.judged, place, "o", color="#4878a8")
        if row.bound is not None:
            axes.plot([row.bound] * 2, [place - 0.45, place + 0.45], color="#c03028", linewidth=2)
    axes.set_yticks(range(len(ratios)), [row.name for row in reversed(ratios)])
    axes.axvline(1, color="grey", linewidth=0.8)
    axes.set_xscale("log")
    axes.xaxis.set_major_formatter("{x:g}")
    axes.xaxis.set_minor_formatter("{x:.2g}")
    axes.tick_params(axis="x", which="both", labelsize=7)
    axes.grid(axis="x", alpha=0.3)
    axes.set_xlabel("ratio to the rival (dot: median, line: spread of the repeats, red: bound)")
    axes.set_title(f"{facts['machine']}, commit {facts['commit']}", fontsize=9)
    figure.savefig(path, dpi=130)
    pyplot.close(figure)
