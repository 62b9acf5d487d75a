"""The weight of a step of every method on every system: instructions, counted by callgrind.

    /usr/bin/python3 tests/bench/weights.py build/release            (compares; make bench does)
    /usr/bin/python3 tests/bench/weights.py build/release --write    (adds the rows that the table lacks)
    /usr/bin/python3 tests/bench/weights.py build/release --rewrite  (counts every row anew)

The table is engine/simulation/catalogue/methods/step_weights.inc; engine/simulation/catalogue/methods/step_weight.h says how it is read.
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

TABLE = Path(__file__).parents[2] / "engine/simulation/catalogue/methods/step_weights.inc"
Key = tuple[str, str, int, str, str]


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
        system, method, order, arithmetic, scalar, n, N, steps = line.split()
        found[system, method, int(order), arithmetic, scalar].append((int(n), int(N), total / int(steps)))
    return found


def table(counts: dict[Key, list[tuple[int, int, float]]]) -> str:
    lines = ["// Written by tests/bench/weights.py: instructions a step at sizes n, N."]
    for (system, method, order, arithmetic, scalar), sizes in counts.items():
        numbers = ", ".join(f"{{{n}, {N}, {w:.4g}}}" for n, N, w in sizes)
        lines.append(f'{{"{system}", "{method}", {order}, "{arithmetic}", "{scalar}", {{{{{numbers}}}}}}},')
    return "\n".join(lines) + "\n"


def read(text: str) -> dict[Key, list[tuple[int, int, float]]]:
    """The inverse of `table`."""
    found = {}
    for line in text.splitlines()[1:]:
        system, method, order, arithmetic, scalar = re.match(
            r'\{"(\w+)", "(\w+)", (\d+), "(\w+)", "(\w+)"', line).groups()
        sizes = re.findall(r"\{(\d+), (\d+), ([\d.e+]+)\}", line)
        found[system, method, int(order), arithmetic, scalar] = [(int(n), int(N), float(w)) for n, N, w in sizes]
    return found


def with_missing(used: dict[Key, list[tuple[int, int, float]]],
                 counted: dict[Key, list[tuple[int, int, float]]]) -> str:
    """The table with the rows in use as they are, and those that were counted and are not in it."""
    merged = {key: used.get(key, sizes) for key, sizes in counted.items()}
    return table(merged | {key: sizes for key, sizes in used.items() if key not in merged})


def measure(program: Path) -> list[dict]:
    """A row for the table of make bench: how far the weights in use are from a new count."""
    if not shutil.which("valgrind"):
        print("  no valgrind: the weights are not compared", file=sys.stderr)
        return []
    print("  callgrind weights", file=sys.stderr)
    used = read(TABLE.read_text())
    ratios = [max(now / then, then / now)
              for key, sizes in count(program).items()
              for (*_, now), (*_, then) in zip(sizes, used.get(key, []))]
    return [{"name": "weights of the methods, against a new count", "unit": "x", "bound": 1.25, "values": ratios}]


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("build", type=Path, help="the build directory")
    parser.add_argument("--write", action="store_true", help="add the rows that the table lacks")
    parser.add_argument("--rewrite", action="store_true", help="count every row anew")
    arguments = parser.parse_args()
    program = arguments.build / "tests/bench/bench_weights"
    if arguments.rewrite:
        TABLE.write_text(table(count(program)))
    elif arguments.write:
        TABLE.write_text(with_missing(read(TABLE.read_text()), count(program)))
    else:
        for row in measure(program):
            print(row["name"], f"worst {max(row['values']):.3f}")
