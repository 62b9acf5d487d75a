"""Counts instructions per step with callgrind. The counts are the same in every run, whatever the machine's load."""
from __future__ import annotations

import math
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Sequence

# glibc clears and copies more than 2 kB by an instruction that repeats itself, which callgrind counts once a byte. With
# these limits it does so by a loop.
ENVIRONMENT = os.environ | {"GLIBC_TUNABLES": "glibc.cpu.x86_rep_stosb_threshold=0x7fffffff:"
                                              "glibc.cpu.x86_rep_movsb_threshold=0x7fffffff"}


def of_calls(program: Path | str, function: str, *arguments: str, lines: str = "") -> tuple[list[str], list[int]]:
    """Runs the program under callgrind. Returns its output lines and the instructions of each call of `function`."""
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run(["valgrind", "--tool=callgrind", f"--callgrind-out-file={folder}/out",
                               f"--toggle-collect={function}", f"--dump-after={function}", program, *arguments],
                              check=True, capture_output=True, text=True, input=lines, env=ENVIRONMENT)
        answers = [line for line in done.stdout.splitlines() if not line.endswith("refused")]
        totals = [int(re.search(r"^totals: (\d+)", (Path(folder) / f"out.{k + 1}").read_text(), re.M)[1])
                  for k in range(len(answers))]
    return answers, totals


def measure(program: Path, steps: int) -> list[dict]:
    """Returns the rows of the table; none for steps = 0 or without valgrind."""
    if steps == 0:
        return []
    if not shutil.which("valgrind"):
        print("  no valgrind: instructions are not counted", file=sys.stderr)
        return []
    found = []
    for N in (3, 8):
        ours, theirs = (_per_step(program, method, N, steps=steps) for method in ("variational", "rk4"))
        found.append({"name": f"variational, instructions, N = {N}", "unit": "a step", "rival": "rk4, the same",
                      "bound": None, "ours": [ours], "theirs": [theirs]})
    alone, stream = (_per_step(program, method, 3, steps=steps) for method in ("exact_alone", "exact"))
    found.append({"name": "exact, instructions, N = 3, a state alone", "unit": "a state", "bound": 2200, "values": [alone]})
    found.append({"name": "exact, instructions, N = 3, every state", "unit": "a state", "rival": "alone",
                  "bound": 1 / 2.5, "ours": [stream], "theirs": [alone]})
    sizes = (1000, 10_000, 100_000)
    counts = [_per_step(program, "frames", N, steps=10) for N in sizes]
    growth = [math.log10(more / fewer) for fewer, more in zip(counts, counts[1:])]
    found.append({"name": "V(4, N), growth of the instructions a step", "unit": "power of N, 10³ … 10⁵",
                  "bound": 1.01, "values": growth})
    return found


# Method, N or n,N, order, tangent vectors: those of the whole tangent space, but for V(4, 10^5); and one vector, which has no bound.
_TANGENTS = [("variational", "3", 2, 6), ("rk4", "3", 0, 6), ("variational", "4", 2, 12), ("variational", "5", 4, 20),
             ("variational", "8", 2, 56), ("rk4", "8", 0, 56), ("variational", "2,3", 2, 6), ("variational", "2,5", 2, 14),
             ("variational", "3,6", 2, 24), ("variational", "4,100000", 2, 2),
             ("variational", "4,100000", 2, 4), ("variational", "3", 2, 1), ("variational", "8", 2, 1)]


def tangents(program: Path, steps: int) -> list[dict]:
    """The instructions of a step with tangent vectors over those of the step alone."""
    if steps == 0 or not shutil.which("valgrind"):
        return []
    found = []
    for method, shape, order, vectors in _TANGENTS:
        count = 2 if "000" in shape else steps
        alone, with_vectors = (_per_step(program, method, shape, order, m, steps=count) for m in (0, vectors))
        name = f"V({shape})" if "," in shape else f"N = {shape}"
        bound = 2 + 8 * vectors
        found.append({"name": f"step with {vectors} tangent vectors, instructions, {method}{order or ''}, {name}", "unit": "a step",
                      "bound": None if vectors == 1 else bound, "rival": "the step alone",
                      "ours": [with_vectors], "theirs": [alone]})
    return found


def undivided(program: Path, largest: int, columns: int) -> list[dict]:
    """The part of the instructions of a step that is outside the pieces which threads share."""
    if not shutil.which("valgrind"):
        return []
    found = []
    for name, *what in [(f"N = {largest}, h|Omega| = {h}", largest, h) for h in (0.05, 0.2)] + [(f"V(4, {columns})", "frames", columns)]:
        pieces, all_steps = (_instructions(program, *what, 4, 2, options=[f"--toggle-collect={function}"])
                             for function in ("divided_piece", "counted_steps"))
        found.append({"name": f"variational, plain, {name}, instructions that threads do not share", "unit": "of a step",
                      "bound": 0.03, "values": [1 - pieces / all_steps]})
    return found


def _per_step(program: Path, *what: object, steps: int) -> float:
    """Returns instructions per step from the difference of two runs, so that the start does not count."""
    once, thrice = (_instructions(program, *what, k * steps) for k in (1, 3))
    return (thrice - once) / (2 * steps)


def _instructions(program: Path, *arguments: object, options: Sequence[str] = ()) -> int:
    print("  callgrind", *arguments, file=sys.stderr)
    command = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", *options, str(program), *map(str, arguments)]
    output = subprocess.run(command, check=True, capture_output=True, text=True, env=ENVIRONMENT).stderr
    match = re.search(r"Collected\s*:\s*(\d+)", output)
    assert match, output
    return int(match[1])
