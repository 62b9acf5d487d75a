"""Asks which geodesic flows of V(n, N) in the metric of Lambda are chaotic: exponents and sections of many random motions.

    integrability.py [--scenes N] [--steps N] [--seed N] [--compare] [--on WHERE] [--output FOLDER]

A scene has Lambda between 1 and a ratio of 1.1 ... 100, a random frame and a random velocity of energy 1/2. Two tangent
vectors move with it. They give the largest Lyapunov exponent, with an error from the means of 20 batches, and GALI_2, the area
that the vectors span when each has length 1. N is 100 scenes of 100 000 steps by default, a quarter of them controls. With
--compare the service's LyapunovSpectrum judges each motion too, by a rule of its own. WHERE
tells what computes them; the bytes of the result do not depend on it:

    here               this process, the default
    cores              a process for each core
    dask:ADDRESS       a Dask cluster by its scheduler: dask:tcp://10.0.0.1:8786

Writes integrability.json and integrability.png. docs/integrability.md says what follows.
"""
from __future__ import annotations

import argparse
import hashlib
import json
import math
import multiprocessing
import time
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from contextlib import suppress
from pathlib import Path
from typing import Any, Generator, Iterator, Optional

import numpy as np

import stiefel
from stiefel.simulation import own_client

STEP, CHUNK, BATCHES = 0.05, 100, 20  # a chunk of steps lies between two orthonormalisations
STUDENT = 2.093  # of 95 % and 19 degrees of freedom
#: Growth of t lambda(t) over the last decade of time. That of a regular motion is k ln 10 where its vectors grow like t^k.
REGULAR, CHAOTIC = 3 * math.log(10), 20.0
SIZES = [(2, 3), (2, 4), (3, 4), (2, 5), (3, 5), (3, 6)]
#: Controls and open cases by name: n, and the pattern of Lambda, in which equal letters are equal numbers.
OTHERS = {"N > 3, two values": [(2, "aabb"), (2, "aaab"), (3, "aaab"), (2, "aabbb"), (3, "aabbb"), (3, "aaaab")],
          "sphere n=1": [(1, "abc"), (1, "abcd"), (1, "abcde")], "body n=N": [(3, "abc"), (4, "abcd"), (5, "abcde")],
          "round": [(2, "aaa"), (2, "aaaa"), (3, "aaaaa")], "V(2,3) two values": [(2, "aab"), (2, "abb")],
          "reduced (8.2)": [(3, "abc"), (4, "abcd"), (5, "abcde")], "Henon-Heiles E=1/8": [(0, "")]}


def tasks(count: int, steps: int, seed: int, compare: bool = False) -> list[dict[str, Any]]:
    """Returns `count` scenes, three quarters of them of the six sizes. The scenes are made here, so that the workers' libraries of
    linear algebra have no say."""
    kinds = [(f"V({n},{N})", n, "abcdefgh"[:N]) for n, N in SIZES for _ in range(count // 8)]
    others = [(name, n, pattern) for name, patterns in OTHERS.items() for n, pattern in patterns]
    kinds += [others[k % len(others)] for k in range(count - len(kinds))]
    return [{"group": name, "seed": [seed, k], "steps": steps, "compare": compare,
             "scene": scene_of(name, n, pattern, np.random.default_rng([seed, k])) if n else None}
            for k, (name, n, pattern) in enumerate(kinds)]


def scene_of(group: str, n: int, pattern: str, rng: np.random.Generator) -> dict[str, Any]:
    N = len(pattern)
    ratio = np.exp(rng.uniform(np.log(1.1), np.log(100)))
    letters = sorted(set(pattern))
    values = np.append([1.0, ratio][:len(letters)], ratio ** rng.uniform(size=max(0, len(letters) - 2)))
    number = dict(zip(letters, rng.permutation(values)))
    inertia = np.array([number[letter] for letter in pattern])
    Q = np.linalg.qr(rng.normal(size=(N, n)))[0].T
    V = rng.normal(size=(n, N))
    V = V - (V @ Q.T + Q @ V.T) / 2 @ Q
    V /= np.sqrt(np.sum(V * inertia * V))  # energy 1/2
    system, method, blocks = "stiefel", {"name": "variational", "order": 2}, {"Q": Q, "Qdot": V}
    if n == 1:
        system, blocks = "ellipsoid", {"q": Q, "qdot": V}
    elif n == N:
        X = Q.T @ V
        system, blocks = "rigid_body", {"Q": Q, "Qdot": Q @ (X - X.T) / 2}
        if group.startswith("reduced"):
            system, method = "reduced_rigid_body", {"name": "gauss4"}
    return {"system": system, "inertia": inertia.tolist(), "step": STEP, "method": method,
            "initial": {name: block.tolist() for name, block in blocks.items()}}


class Growth:
    """The growth of two tangent vectors: sums that are rounded once, so that no library of linear algebra has a say."""

    def __init__(self) -> None:
        self.logs: list[float] = []  # of the first vector, one for each chunk
        self.slope, self.log_area, self.areas = 0.0, 0.0, [0.0]

    def orthonormal(self, pair: Any) -> Any:
        """Takes the vectors after a chunk; returns the orthonormal pair that the next one moves."""
        def product(x: Any, y: Any) -> float:
            return math.fsum((x * y).ravel().tolist())
        a = math.sqrt(product(pair[0], pair[0]))
        first = pair[0] / a
        b = product(first, pair[1])
        rest = pair[1] - b * first
        rest = rest - product(first, rest) * first
        c = math.sqrt(product(rest, rest))
        return np.stack([first, rest / c]), a, b, c

    def add(self, pair: Any) -> Any:
        pair, a, b, c = self.orthonormal(pair)
        self.logs.append(math.log(a))
        # Without orthonormalisation the second vector is proportional to slope * first + second.
        if abs(self.slope) < 1e100:
            self.slope = (a * self.slope + b) / c
            self.log_area = -0.5 * math.log1p(self.slope**2)
        else:
            self.log_area -= math.log(a / c)
        self.areas.append(self.log_area)
        return pair


def chunks_of(task: dict[str, Any]) -> Generator[Any, Any, None]:
    """Yields a pair of vectors, and for each pair that is sent what a chunk of steps makes of it."""
    rng = np.random.default_rng([*task["seed"], 1])
    if task["scene"] is None:
        yield from henon_heiles(rng, task["steps"])
        return
    with own_client().create(task["scene"]) as session:
        basis = np.asarray(session.state_transition(to=1).start_basis)
        pair = yield np.einsum("kd,dij->kij", rng.normal(size=(2, len(basis))), basis)
        for start in range(0, task["steps"], CHUNK):
            moved = session.state_transition(to=start + CHUNK, start=start, vectors=pair)
            if moved.outcome != stiefel.Outcome.REACHED:
                return
            pair = yield moved.vectors


def henon_heiles(rng: np.random.Generator, steps: int) -> Generator[Any, Any, None]:
    """The chaotic control: H = (p^2 + q^2) / 2 + x^2 y - y^3 / 3 at the energy 1/8, by leapfrog steps and their derivative."""
    y = -0.25
    x, px, py = 0.0, math.sqrt(2 * (0.125 - y * y / 2 + y**3 / 3)), 0.0
    pair = yield rng.normal(size=(2, 4))
    for _ in range(steps // CHUNK):
        vectors = pair.T.copy()
        for _ in range(CHUNK):
            x, y = x + STEP / 2 * px, y + STEP / 2 * py
            vectors[:2] += STEP / 2 * vectors[2:]
            px, py = px - STEP * (x + 2 * x * y), py - STEP * (y + x * x - y * y)
            vectors[2], vectors[3] = (vectors[2] - STEP * ((1 + 2 * y) * vectors[0] + 2 * x * vectors[1]),
                                      vectors[3] - STEP * (2 * x * vectors[0] + (1 - 2 * y) * vectors[1]))
            x, y = x + STEP / 2 * px, y + STEP / 2 * py
            vectors[:2] += STEP / 2 * vectors[2:]
        pair = yield vectors.T.copy()


def measured(task: dict[str, Any]) -> dict[str, Any]:
    """Runs a scene and returns its exponent, GALI_2 and their course at times that double."""
    growth, running = Growth(), chunks_of(task)
    pair = growth.orthonormal(next(running))[0]
    try:
        for _ in range(task["steps"] // CHUNK):
            pair = growth.add(running.send(pair))
    except StopIteration:
        pass  # the motion left the domain of its method
    running.close()
    logs = np.array(growth.logs)
    sums = np.cumsum(logs)
    count, unit = len(logs), CHUNK * STEP
    at = sorted({min(count, round(2 ** (k / 2))) for k in range(2 * count.bit_length() + 1)}) if count else []
    batches = np.array([part.sum() / (len(part) * unit) for part in np.array_split(logs[count // 10:], BATCHES)]) if count >= 40 else np.zeros(1)
    last = float(sums[-1] - sums[max(0, count // 10 - 1)]) if count else 0.0
    area = growth.log_area
    done = count * CHUNK == task["steps"] and count >= 100  # shorter runs decide nothing
    verdict = ("chaotic" if done and last > CHAOTIC and area < -CHAOTIC else
               "regular" if done and last < REGULAR and area > -2 * REGULAR else "undecided")
    return {**task, "service": service(task), "steps_done": count * CHUNK, "exponent": float(batches.mean()),
            "error": float(STUDENT * batches.std(ddof=1) / math.sqrt(BATCHES)) if len(batches) > 1 else math.inf,
            "last_decade": last, "log_gali": area, "verdict": verdict, "times": [k * unit for k in at],
            "growth": [float(sums[k - 1]) for k in at], "log_areas": [growth.areas[k] for k in at]}


def service(task: dict[str, Any]) -> Optional[dict[str, Any]]:
    """Returns what LyapunovSpectrum says of the scene, if that is asked."""
    if not task["compare"] or task["scene"] is None:
        return None
    with own_client().create(task["scene"]) as session:
        found = session.lyapunov(to=task["steps"], count=2)
    return {"verdict": str(found.verdict), "exponent": float(found.exponents[0]), "error": float(found.errors[0]),
            "log_gali": float(found.log_gali[0])}


def study(work: list[dict[str, Any]], where: str = "here") -> list[dict[str, Any]]:
    """Returns what `measured` makes of every task, in the order of the tasks."""
    kind, _, address = where.partition(":")
    if kind == "here":
        return [measured(task) for task in work]
    if kind == "cores":
        with ProcessPoolExecutor(mp_context=multiprocessing.get_context("spawn")) as executor:
            return list(executor.map(measured, work))
    if kind != "dask":
        raise SystemExit(f"--on {where}: must be here, cores or dask:ADDRESS")
    from distributed import Client

    with Client(address) as cluster:
        cluster.upload_file(__file__)
        return list(cluster.gather(cluster.map(measured, work, pure=False)))


def digest(rows: list[dict[str, Any]]) -> str:
    return hashlib.sha256(json.dumps(rows, sort_keys=True).encode()).hexdigest()


def summary(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Returns a row of the table for each group."""
    table = []
    for group in dict.fromkeys(row["group"] for row in rows):
        some = [row for row in rows if row["group"] == group]
        counts = {verdict: sum(row["verdict"] == verdict for row in some) for verdict in ("regular", "chaotic", "undecided")}
        chaotic = sorted((row["exponent"] for row in some if row["verdict"] == "chaotic"))
        table.append({"group": group, "scenes": len(some), **counts, "largest": max((row["exponent"] for row in some)),
                      "median": float(np.median(chaotic)) if chaotic else None})
    return table


def crossings(inertia: Any, momentum: float, orbits: int, steps: int, seed: int = 0) -> Iterator[tuple[Any, Any]]:
    """Yields, for motions of V(2, 3) of the energy 1/2 and one momentum, where they cross M_13 = 0: the azimuth of the normal
    of the frame's plane about the second axis, and its height along that axis."""
    manifold, rng = stiefel.manifold.Stiefel(2, 3, inertia), np.random.default_rng(seed)

    def normal(section: stiefel.Events) -> Any:
        return np.cross(section["Q"][:, 0], section["Q"][:, 1])

    for _ in range(orbits):
        while True:
            Q = manifold.random(seed=rng)
            with suppress(ValueError):  # at some frames the momentum needs more energy
                velocity = manifold.velocity(Q, manifold.random_tangent(Q, seed=rng), 0.5, [[0, momentum], [-momentum, 0]])
                break
        scene: stiefel.Scene = {"system": "stiefel", "inertia": list(inertia), "step": 2 * STEP,
                                "method": {"name": "variational", "order": 2}, "initial": {"Q": Q, "Qdot": velocity}}
        with own_client().create(scene) as session:
            section = session.poincare({"M": [[0, 0, 1], [0, 0, 0], [0, 0, 0]]}, to=steps, fields=["Q", "M"], coordinates=[
                lambda s: np.arctan2(normal(s)[:, 0], normal(s)[:, 2]), lambda s: normal(s)[:, 1]])
        yield section.points[:, 0], section.points[:, 1]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", type=int, default=100)
    parser.add_argument("--steps", type=int, default=100_000, help="of every scene, a multiple of 100")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--compare", action="store_true", help="asks the service's verdict too")
    parser.add_argument("--orbits", type=int, default=14, help="of each section")
    parser.add_argument("--on", default="here", help="what computes")
    parser.add_argument("--output", type=Path, default=Path("build/run"), help="folder for the results")
    arguments = parser.parse_args()
    arguments.output.mkdir(parents=True, exist_ok=True)

    begun = time.perf_counter()
    rows = study(tasks(arguments.scenes, arguments.steps, arguments.seed, arguments.compare), arguments.on)
    seconds = time.perf_counter() - begun
    (arguments.output / "integrability.json").write_text(json.dumps(rows), encoding="utf-8")
    for row in summary(rows):
        print("{group:26} {scenes:4} scenes: {regular:3} regular, {chaotic:3} chaotic, {undecided:3} undecided; "
              "largest exponent {largest:.4f}, median of the chaotic {median}".format(**row))
    pairs = Counter((row["verdict"], row["service"]["verdict"]) for row in rows if row["service"])
    for (own, other), count in sorted(pairs.items()):
        print(f"{count:4} {own} here, {other} by LyapunovSpectrum")
    print(f"{len(rows)} scenes of {arguments.steps} steps in {seconds:.0f} s; SHA-256 of the result: {digest(rows)}")

    import picture

    sections = [(inertia, list(crossings(inertia, momentum, arguments.orbits, arguments.steps)))
                for inertia, momentum in (((1, 1, 4), 0.3), ((1, 4, 12), 0.3))]
    picture.integrability(arguments.output / "integrability.png", rows, sections)
    print(f"wrote {arguments.output}/integrability.json and .png")


if __name__ == "__main__":
    main()
