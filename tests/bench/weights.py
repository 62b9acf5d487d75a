"""Counts the weight of a step of every method on every system: its instructions, by callgrind.

    /usr/bin/python3 tests/bench/weights.py build/release            (compares with the table, as make bench does)
    /usr/bin/python3 tests/bench/weights.py build/release --write    (adds rows that are missing in the table)
    /usr/bin/python3 tests/bench/weights.py build/release --write --method exact   (counts this method alone)
    /usr/bin/python3 tests/bench/weights.py build/release --rewrite  (replaces every row by a new count)

The table is engine/catalogue/methods/step_weights.inc; step_weight.h in that folder tells how it is read.
"""
from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import sys
from collections import defaultdict
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import NamedTuple

import callgrind

TABLE = Path(__file__).parents[2] / "engine/catalogue/methods/step_weights.inc"
Key = tuple[str, str, int, str, str]


class Row(NamedTuple):
    """A row of the table. `sizes`: (n, N, instructions per step) at h‖Ω‖ = 0.1. `rates`, for methods that iterate: (N,
    h‖Ω‖, instructions relative to those at 0.1)."""
    sizes: list[tuple[int, int, float]]
    rates: list[tuple[int, float, float]] = []


Table = dict[Key, Row]


def count(program: Path, method: str = "") -> Table:
    """Counts every entry, or those of a method, with a process for each system, as many at a time as there are cores."""
    systems = subprocess.run([program], check=True, capture_output=True, text=True).stdout.split()
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        found = {}
        for one in pool.map(lambda system: count_system([program, system, *([method] if method else [])]), systems):
            found |= one
    return found


def count_system(command: list) -> Table:
    lines, totals = callgrind.of_calls(command[0], "measured_steps", *command[1:])
    runs = defaultdict(lambda: defaultdict(list))
    for line, total in zip(lines, totals):
        name, method, order, arithmetic, scalar, n, N, steps, rate = line.split()
        key = name, "" if method == "-" else method, int(order), arithmetic, scalar
        runs[key][int(n), int(N)].append((float(rate), total / int(steps)))
    return {key: row_of(of_sizes) for key, of_sizes in runs.items()}


def row_of(of_sizes: dict[tuple[int, int], list[tuple[float, float]]]) -> Row:
    """Makes a row from the list of (h‖Ω‖, instructions) of each size, in which 0.1 comes first."""
    row = Row([], [])
    for (n, N), counts in sorted(of_sizes.items()):
        row.sizes.append((n, N, counts[0][1]))
        if len(counts) > 1:
            row.rates.extend((N, rate, w / counts[0][1]) for rate, w in sorted(counts))
    return row


def braced(numbers: list[tuple]) -> str:
    return "{" + ", ".join("{" + ", ".join(f"{x:.4g}" for x in one) + "}" for one in numbers) + "}"


def table(counts: Table) -> str:
    lines = ["// Written by tests/bench/weights.py: instructions a step at sizes n, N, and factors at N, h‖Ω‖."]
    for (system, method, order, arithmetic, scalar), (sizes, rates) in counts.items():
        more = f", {braced(rates)}" if rates else ""
        lines.append(f'{{"{system}", "{method}", {order}, "{arithmetic}", "{scalar}", {braced(sizes)}{more}}},')
    return "\n".join(lines) + "\n"


def read(text: str) -> Table:
    """Reads the text that `table` writes."""
    found = {}
    for line in text.splitlines()[1:]:
        system, method, order, arithmetic, scalar, lists = re.match(
            r'\{"(\w+)", "(\w*)", (\d+), "(\w+)", "(\w+)", (.*)\},$', line).groups()
        row = Row([], [])
        for numbers, into in zip(re.findall(r"\{(\{.*?\})\}", lists), row):
            into.extend(tuple(map(float, one.split(", "))) for one in re.findall(r"\{(.*?)\}", numbers))
        found[system, method, int(order), arithmetic, scalar] = Row([(int(n), int(N), w) for n, N, w in row.sizes],
                                                                    [(int(N), h, x) for N, h, x in row.rates])
    return found


def with_missing(used: Table, counted: Table) -> str:
    """Returns the text of the table `used` with the rows of `counted` that it lacks, each after the last row of its
    system. Rows in use keep their numbers and their order."""
    keys = list(used)
    for key in counted:
        if key not in used:
            keys.insert(max((k + 1 for k, other in enumerate(keys) if other[0] == key[0]), default=len(keys)), key)
    return table({key: used.get(key) or counted[key] for key in keys})


def measure(program: Path) -> list[dict]:
    """Returns a row for the table of make bench: how far the weights in use are from a new count."""
    if not shutil.which("valgrind"):
        print("  no valgrind: the weights are not compared", file=sys.stderr)
        return []
    print("  callgrind weights", file=sys.stderr)
    used = read(TABLE.read_text())
    then = {(key, n, N): w for key, row in used.items() for n, N, w in row.sizes}
    ratios = [max(now / then[key, n, N], then[key, n, N] / now)
              for key, row in count(program).items() for n, N, now in row.sizes if (key, n, N) in then]
    return [{"name": "weights of the methods, against a new count", "unit": "x", "bound": 1.25, "values": ratios}]


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("build", type=Path, help="the build directory")
    parser.add_argument("--write", action="store_true", help="add the rows that the table lacks")
    parser.add_argument("--method", default="", help="with --write: count this method alone")
    parser.add_argument("--rewrite", action="store_true", help="count every row anew")
    arguments = parser.parse_args()
    program = arguments.build / "tests/bench/bench_weights"
    if not program.exists():
        parser.error(f"{program} is not built: cmake --build {arguments.build} --target {program.name}")
    if not shutil.which("valgrind"):
        parser.error("valgrind is not installed: docker/packages.sh bench")
    if arguments.rewrite:
        TABLE.write_text(table(count(program)))
    elif arguments.write:
        TABLE.write_text(with_missing(read(TABLE.read_text()), count(program, arguments.method)))
    else:
        for row in measure(program):
            print(row["name"], f"worst {max(row['values']):.3f}")
