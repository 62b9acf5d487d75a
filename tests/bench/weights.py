"""What a step of every method on every system weighs: instructions, as callgrind counts them.

    /usr/bin/python3 tests/bench/weights.py build/release            (compares; make bench does)
    /usr/bin/python3 tests/bench/weights.py build/release --write    (rewrites the table)

The table is engine/simulation/step_weights.inc; engine/simulation/step_weight.h has the formula.
"""
from __future__ import annotations

import argparse
import re
import shutil
import subprocess
import sys
import tempfile
from collections import defaultdict
from pathlib import Path

import numpy as np

TABLE = Path(__file__).parents[2] / "engine/simulation/step_weights.inc"
Key = tuple[str, str, int, str]


def count(program: Path) -> dict[Key, list[tuple[int, int, float]]]:
    """(n, N, instructions a step) of every entry."""
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run(["valgrind", "--tool=callgrind", f"--callgrind-out-file={folder}/out",
                               "--toggle-collect=measured_steps", "--dump-after=measured_steps", str(program)],
                              check=True, capture_output=True, text=True)
        lines = done.stdout.splitlines()
        totals = [int(re.search(r"^totals: (\d+)", (Path(folder) / f"out.{k + 1}").read_text(), re.M)[1])
                  for k in range(len(lines))]
    found = defaultdict(list)
    for line, total in zip(lines, totals):
        system, method, order, arithmetic, n, N, steps = line.split()
        found[system, method, int(order), arithmetic].append((int(n), int(N), total / int(steps)))
    return found


def fit(counts: list[tuple[int, int, float]]) -> tuple[float, float, float, float]:
    """The count at n = N = 3, and a, b, c >= 0 that are relatively nearest to the others."""
    at_3 = next((w for n, N, w in counts if (n, N) == (3, 3)), 0.0)
    rest = [(n, N, w) for n, N, w in counts if (n, N) != (3, 3)]
    if not rest:
        return at_3, at_3, 0.0, 0.0
    rows = np.array([[1, n * N, n * n * N + n**3] for n, N, _ in rest], float)
    w = np.array([w for *_, w in rest])
    if len(rest) == 1:  # in proportion to the products
        return at_3, 0.0, 0.0, w[0] / rows[0, 2]
    best = None
    for columns in ([0, 1, 2], [0, 2], [0, 1], [1, 2], [2], [1], [0]):
        scaled = rows[:, columns] / w[:, None]
        x, *_ = np.linalg.lstsq(scaled, np.ones(len(w)), rcond=None)
        error = np.linalg.norm(scaled @ x - 1)
        if (x >= 0).all() and (best is None or error < best[0]):
            best = error, dict(zip(columns, x))
    return (at_3, *(best[1].get(k, 0.0) for k in range(3)))


def table(counts: dict[Key, list]) -> str:
    lines = ["// Written by tests/bench/weights.py: at n = N = 3, a, b, c."]
    for (system, method, order, arithmetic), sizes in counts.items():
        numbers = ", ".join(f"{x:.4g}" for x in fit(sizes))
        lines.append(f'{{"{system}", "{method}", {order}, "{arithmetic}", {numbers}}},')
    return "\n".join(lines) + "\n"


def measure(program: Path) -> list[dict]:
    """For the table of make bench: how far the weights in use are from what is counted now."""
    if not shutil.which("valgrind"):
        print("  no valgrind: the weights are not compared", file=sys.stderr)
        return []
    print("  callgrind weights", file=sys.stderr)
    used = {tuple(line.split(", ")[:4]): line for line in TABLE.read_text().splitlines()[1:]}
    ratios = []
    for line in table(count(program)).splitlines()[1:]:
        now, then = ([float(x) for x in re.findall(r"[\d.e+]+", text.rstrip("},").split('", ')[-1])]
                     for text in (line, used.get(tuple(line.split(", ")[:4]), line)))
        at = lambda x: x[0] or sum(x)  # noqa: E731
        ratios.append(max(at(now) / at(then), at(then) / at(now)))
    return [{"name": "weights of the methods, against a new count", "unit": "x", "bound": 1.25, "values": ratios}]


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("build", type=Path, help="the build directory")
    parser.add_argument("--write", action="store_true", help="rewrite the table")
    arguments = parser.parse_args()
    program = arguments.build / "tests/bench/bench_weights"
    if arguments.write:
        TABLE.write_text(table(count(program)))
    else:
        for row in measure(program):
            print(row["name"], f"worst {max(row['values']):.3f}")
