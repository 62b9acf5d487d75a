"""Counts the instructions of a step of every method on every system by callgrind, for its price.

    /usr/bin/python3 tests/bench/weights.py build/release                          (compares prices with counts, as make bench)
    /usr/bin/python3 tests/bench/weights.py build/release --fit rigid_body exact   (prints lines for step_prices.inc)

The prices are in engine/motion/step_prices.inc; step_weight.cc in that folder tells how they are read. A line with
an empty arithmetic holds for both. Factors at other h‖Ω‖, of methods that iterate, are the counts there over that at 0.1.
"""
from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
from collections import defaultdict
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import NamedTuple

import callgrind
import numpy as np
from scipy.optimize import linprog

STAGES = {4: 5, 6: 9, 8: 17}  # steps of order 2 in a composed one
WARM = 0.93  # the start of a stage is close to its solution


class Count(NamedTuple):
    """A counted step: n, N, h‖Ω‖, its instructions, and the price that the engine has for it."""
    n: int
    N: int
    rate: float
    instructions: float
    price: float


Key = tuple[str, str, int, str, str]  # system, method, order, arithmetic, scalar
Counts = dict[Key, list[Count]]


def count(program: Path, system: str = "", method: str = "") -> Counts:
    """Counts every entry, or those of a system or method, with a process for each system, as many at a time as there are
    cores."""
    systems = [system] if system else subprocess.run([program], check=True, capture_output=True, text=True).stdout.split()
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        found: Counts = {}
        for one in pool.map(lambda of: count_system([program, of, *([method] if method else [])]), systems):
            found |= one
    return found


def count_system(command: list) -> Counts:
    lines, totals = callgrind.of_calls(command[0], "measured_steps", *command[1:])
    found: Counts = defaultdict(list)
    for line, total in zip(lines, totals):
        name, method, order, arithmetic, scalar, n, N, steps, rate, price = line.split()
        key = name, "" if method == "-" else method, int(order), arithmetic, scalar
        found[key].append(Count(int(n), int(N), float(rate), total / int(steps), float(price)))
    return found


def least_worst(rows: list[list[float]], counts: list[float]) -> tuple[list[float], float]:
    """Returns the coefficients >= 0 whose combination of each row differs least from its count, and the largest relative
    difference."""
    share = np.array(rows) / np.array(counts)[:, None]
    bound = -np.ones((len(counts), 1))
    found = linprog([0.0] * len(rows[0]) + [1.0], A_ub=np.block([[share, bound], [-share, bound]]),
                    b_ub=np.concatenate([np.ones(len(counts)), -np.ones(len(counts))]))
    return list(found.x[:-1]), found.x[-1]


def fitted(key: Key, counts: list[Count]) -> str:
    """Returns a line of step_prices.inc for one order and arithmetic, from the steps at h‖Ω‖ = 0.1."""
    system, method, order, arithmetic, _ = key
    composed = method == "variational"
    scale = WARM * STAGES[order] if composed and order > 2 else 1
    at = [(c.n, c.N, c.instructions / scale) for c in counts if 0.06 < c.rate < 0.2]
    if len({(c.n, c.N) for c in counts}) == 1:  # a system's example, at whatever rate: proportional to n²N
        a_product = counts[0].n ** 2 * counts[0].N
        mean = sum(c.instructions for c in counts) / len(counts) / scale
        return f'{{"{system}", "{method}", "{arithmetic}", {str(composed).lower()}, {{}}, {{}}, ' \
               f"{{0, 0, 0, {mean / a_product:.3g}, 0}}}},  // of one size"
    small = [w for n, N, w in at if n == N in (3, 4)]
    row, of_row = least_worst([[1, N] for n, N, _ in at if n == 1], [w for n, _, w in at if n == 1]) \
        if any(n == 1 for n, *_ in at) else ([], 0)
    rest = [one for one in at if one[0] > 1 and not one[0] == one[1] <= 4]
    large, of_large = least_worst([[1, n * n, n * N, n * n * N, (n if order else min(2 * n, N)) ** 3] for n, N, _ in rest],
                                  [w for *_, w in rest]) if len(rest) > 1 else ([], 0)
    lists = ["{" + ", ".join(f"{x:.3g}" for x in numbers) + "}" for numbers in (small, row, large)]
    return f'{{"{system}", "{method}", "{arithmetic}", {str(composed).lower()}, {", ".join(lists)}}},  ' \
           f"// {100 * max(of_row, of_large):.0f} %"


def measure(program: Path) -> list[dict]:
    """Returns a row for the table of make bench: how far the prices are from counted steps at h‖Ω‖ = 0.1."""
    if not shutil.which("valgrind"):
        print("  no valgrind: the prices are not compared", file=sys.stderr)
        return []
    print("  callgrind weights", file=sys.stderr)
    ratios = [max(c.instructions / c.price, c.price / c.instructions)
              for key, counts in count(program).items() if key[4] == "double" for c in counts if 0.06 < c.rate < 0.2 and c.price]
    return [{"name": "prices of steps, against a count", "unit": "x", "bound": 1.35, "values": ratios}]


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("build", type=Path, help="the build directory")
    parser.add_argument("--fit", nargs=2, metavar=("SYSTEM", "METHOD"), help="count these steps and print the fitted lines")
    arguments = parser.parse_args()
    program = arguments.build / "tests/bench/bench_weights"
    if not program.exists():
        parser.error(f"{program} is not built: cmake --build {arguments.build} --target {program.name}")
    if not shutil.which("valgrind"):
        parser.error("valgrind is not installed: docker/packages.sh bench")
    if arguments.fit:
        for key, counts in count(program, *arguments.fit).items():
            print(fitted(key, counts))
    else:
        for row in measure(program):
            print(row["name"], f"worst {max(row['values']):.3f}")
