"""Counts instructions per step with callgrind. The counts are the same in every run, whatever the machine's load."""
from __future__ import annotations

import math
import re
import shutil
import subprocess
import sys
from pathlib import Path


def measure(program: Path, steps: int) -> list[dict]:
    """Returns the rows of the table; none for steps = 0 or without valgrind."""
    if steps == 0:
        return []
    if not shutil.which("valgrind"):
        print("  no valgrind: instructions are not counted", file=sys.stderr)
        return []
    found = []
    for N in (3, 8):
        ours, theirs = (_per_step(program, method, N, steps) for method in ("variational", "rk4"))
        found.append({"name": f"variational, instructions, N = {N}", "unit": "a step", "rival": "rk4, the same",
                      "bound": None, "ours": [ours], "theirs": [theirs]})
    alone, stream = (_per_step(program, method, 3, steps) for method in ("exact_alone", "exact"))
    found.append({"name": "exact, instructions, N = 3, a state alone", "unit": "a state", "bound": 2200, "values": [alone]})
    found.append({"name": "exact, instructions, N = 3, every state", "unit": "a state", "rival": "alone",
                  "bound": 1 / 2.5, "ours": [stream], "theirs": [alone]})
    sizes = (1000, 10_000, 100_000)
    counts = [_per_step(program, "frames", N, 10) for N in sizes]
    growth = [math.log10(more / fewer) for fewer, more in zip(counts, counts[1:])]
    found.append({"name": "V(4, N), growth of the instructions a step", "unit": "power of N, 10³ … 10⁵",
                  "bound": 1.01, "values": growth})
    return found


def _per_step(program: Path, method: str, N: int, steps: int) -> float:
    """Returns instructions per step from the difference of two runs, so that the start does not count."""
    once, thrice = (_instructions(program, method, N, k * steps) for k in (1, 3))
    return (thrice - once) / (2 * steps)


def _instructions(program: Path, method: str, N: int, steps: int) -> int:
    print(f"  callgrind {method} N={N} steps={steps}", file=sys.stderr)
    command = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", str(program), method, str(N), str(steps)]
    output = subprocess.run(command, check=True, capture_output=True, text=True).stderr
    match = re.search(r"Collected\s*:\s*(\d+)", output)
    assert match, output
    return int(match[1])
