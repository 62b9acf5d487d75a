"""Compares the predicted prices of random scenes and calls with the instructions that callgrind counts.

    /usr/bin/python3 tests/bench/prices.py build/release                (300 scenes; make bench does)
    /usr/bin/python3 tests/bench/prices.py build/release --scenes 1000 --seed 7

Every pair of system and method occurs equally often. Half of the bodies that can advance together in vector registers
are ensembles of 2 to 64 members. Order, arithmetic, scalar, substeps, size (N from 3 to 64 and n from 1 to N) and h‖Ω‖
(0.01 to 0.3) are random, size and h‖Ω‖ uniform in their logarithms. Scenes whose method does not apply to their size
are left out. valgrind has no AVX-512, so that the code for AVX2 is counted.
"""
from __future__ import annotations

import argparse
import math
import os
import random
import shutil
import subprocess
import sys
from collections import defaultdict
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import NamedTuple

import callgrind

# The kinds of methods as prices.cc lists them, and as they are reported. All steps of an explicit method or of a closed
# form take the same instructions, so that their price is a count.
REPORTED = {"explicit": "explicit methods and closed forms", "closed_form": "explicit methods and closed forms",
            "implicit": "implicit methods", "discrete": "implicit methods",
            "own_steps": "methods that choose their steps"}
STEPS = 4
# Steps of an ensemble: so many that the rest of a call weighs as little as in a slice of the server.
STEPS_OF_PACKS = 256
# (ratio, share): this share of the prices must be within this ratio of the count. Caps may be exceeded by a tenth.
BOUNDS = {"explicit methods and closed forms": (1.1, 0.95), "implicit methods": (1.5, 0.95)}


class Priced(NamedTuple):
    line: str  # the line that the program got
    kind: str
    price: float
    counted: float

    @property
    def ratio(self) -> float:
        return self.price / self.counted


def log_uniform(draw: random.Random, low: float, high: float) -> float:
    return math.exp(draw.uniform(math.log(low), math.log(high)))


def whole(draw: random.Random, low: int, high: int) -> int:
    return min(high, int(log_uniform(draw, low, high + 1)))


def scenes(program: Path, count: int, seed: int) -> list[tuple[str, str]]:
    """Returns (kind, line for the program) of random scenes."""
    draw = random.Random(seed)
    pairs = [line.split(maxsplit=6) for line in
             subprocess.run([program, "--list"], check=True, capture_output=True, text=True).stdout.splitlines()]
    found = []
    for _ in range(count):
        system, method, kind, orders, in_float, packed, where = draw.choice(pairs)
        together = packed == "packed" and draw.random() < 0.5
        N = 3 if where.strip() == "N = 3" else draw.choice([3, 4]) if together else whole(draw, 3, 64)
        n = whole(draw, 1, N)
        members = whole(draw, 2, 64) if together else 0
        order = draw.choice(orders.split(","))
        scalar = draw.choice(["double", "float"]) if in_float == "float" and N == 3 else "double"
        arithmetic = draw.choice(["compensated", "plain"]) if kind in ("explicit", "implicit") else "compensated"
        substeps = draw.choice([1, 1, 2, 3]) if kind in ("explicit", "implicit") else 1
        h = log_uniform(draw, 0.01, 0.3)
        # More steps before the count would take gigabytes of instructions and make no difference.
        first = 2 if kind in ("explicit", "closed_form") else 12 if N <= 24 else 5
        found.append((REPORTED[kind], f"{system} {method} {order} {arithmetic} {scalar} {n} {N} {substeps} "
                                      f"{draw.randrange(1, 10**6)} {h:.4g} {first} "
                                      f"{STEPS_OF_PACKS if together else STEPS} {members}"))
    return found


def count_scenes(program: Path, asked: list[tuple[str, str]]) -> list[Priced]:
    """Counts the scenes with one process per core."""
    kinds = {line: kind for kind, line in asked}
    cores = os.cpu_count() or 1
    shares = ["".join(line + "\n" for _, line in asked[k::cores]) for k in range(cores)]
    with ThreadPoolExecutor(cores) as pool:
        done = list(pool.map(lambda share: callgrind.of_calls(program, "measured_steps", lines=share), shares))
    found = []
    for answers, totals in done:
        for answer, total in zip(answers, totals):
            line, said = answer.split(" : ")
            if said == "stopped":
                continue
            n, N, price, _, h, how = said.split()
            found.append(Priced(f"{line} (n = {n}, N = {N}, h‖Ω‖ = {h}, {how})", kinds[line], float(price), total))
    return found


def count_caps(program: Path, which: str = "--caps") -> list[Priced]:
    answers, totals = callgrind.of_calls(program, "measured_call", which)
    return [Priced(answer, "caps", float(answer.split()[1]), total) for answer, total in zip(answers, totals)]


def table(priced: list[Priced], worst: int) -> str:
    of = defaultdict(list)
    for one in priced:
        of[one.kind].append(one)
    lines = []
    for kind, all_of in sorted(of.items()):
        share = {x: sum(1 / x <= one.ratio <= x for one in all_of) / len(all_of) for x in (1.1, 1.5, 2)}
        lines.append(f"{kind}: {len(all_of)}; within 10 %: {share[1.1]:.0%}, 1.5x: {share[1.5]:.0%}, 2x: {share[2]:.0%}")
        for one in sorted(all_of, key=lambda one: -abs(math.log(one.ratio)))[:worst]:
            lines.append(f"  price / count {one.ratio:.3f}: {one.line}")
    return "\n".join(lines)


def measure(program: Path, count: int = 300, seed: int = 1) -> list[dict]:
    """Returns rows for the table of make bench: the ratio that 5 % of the prices exceed, and the worst cap."""
    if not shutil.which("valgrind"):
        print("  no valgrind: the prices are not compared", file=sys.stderr)
        return []
    print("  callgrind prices", file=sys.stderr)
    priced = count_scenes(program, scenes(program, count, seed))
    rows = []
    for kind, (bound, share) in BOUNDS.items():
        ratios = sorted(max(one.ratio, 1 / one.ratio) for one in priced if one.kind == kind)
        rows.append({"name": f"price of {kind}, {share:.0%} of {len(ratios)} scenes", "unit": "x", "bound": bound,
                     "values": [ratios[math.ceil(share * len(ratios)) - 1]]})
    rows.append({"name": "work of capped searches of Connect over their cap, the worst", "unit": "x", "bound": 1.1,
                 "values": [max(1 / one.ratio for one in count_caps(program, "--connect"))]})
    return rows


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=Path, help="the build directory")
    parser.add_argument("--scenes", type=int, default=300, help="random scenes")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--worst", type=int, default=5, help="scenes of each kind that are printed")
    parser.add_argument("--caps", action="store_true", help="count calls whose price is a cap as well: minutes")
    arguments = parser.parse_args()
    binary = arguments.build / "tests/bench/bench_prices"
    results = count_scenes(binary, scenes(binary, arguments.scenes, arguments.seed))
    if arguments.caps:
        results += count_caps(binary)
    print(table(results, arguments.worst))
