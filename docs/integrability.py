"""Asks which geodesic flows of V(n, N) in the metric of Lambda are chaotic: exponents and sections of many random motions.

    integrability.py [--scenes N] [--steps N] [--seed N] [--on WHERE] [--output FOLDER]

A scene has Lambda between 1 and a ratio of 1.1 ... 100, a random frame and a random velocity of energy 1/2. LyapunovSpectrum
gives the largest exponent of each, its error, GALI_2, GALI_3 and a verdict (docs/lyapunov.md). N is 100 scenes of 100 000
steps by default, a quarter of them controls. WHERE tells what computes them; the bytes of the result do not depend on it:

    here               this process, the default
    cores              a process for each core
    dask:ADDRESS       a Dask cluster by its scheduler: dask:tcp://10.0.0.1:8786

Writes integrability.json and integrability.png. docs/integrability.md says what follows.
"""
from __future__ import annotations

import argparse
import hashlib
import json
import multiprocessing
import time
from concurrent.futures import ProcessPoolExecutor
from contextlib import suppress
from pathlib import Path
from typing import Any, Iterator

import numpy as np

import stiefel
from stiefel.simulation import own_client

#: A frame turns by less than 1 rad a unit of time, and by less than 2.5 rad between two orthonormalisations. The fastest
#: oscillation beside a motion, sqrt(ratio) rad a unit of time, takes at least 12 steps.
STEP, INTERVAL = 0.05, 50
SIZES = [(2, 3), (2, 4), (3, 4), (2, 5), (3, 5), (3, 6)]
#: Controls and open cases by name: n, and the pattern of Lambda, in which equal letters are equal numbers.
OTHERS = {"N > 3, two values": [(2, "aabb"), (2, "aaab"), (3, "aaab"), (2, "aabbb"), (3, "aabbb"), (3, "aaaab")],
          "sphere n=1": [(1, "abc"), (1, "abcd"), (1, "abcde")], "body n=N": [(3, "abc"), (4, "abcd"), (5, "abcde")],
          "round": [(2, "aaa"), (2, "aaaa"), (3, "aaaaa")], "V(2,3) two values": [(2, "aab"), (2, "abb")],
          "reduced (8.2)": [(3, "abc"), (4, "abcd"), (5, "abcde")], "chaotic control": [(3, "abcde")]}
#: The chaotic control is one motion, whose neighbours part at the rate of its exponent: V(3, 5) with these numbers, by this seed.
CONTROL, CONTROL_SEED = (1.0, 2.0, 4.0, 7.0, 12.0), 1


def tasks(count: int, steps: int, seed: int) -> list[dict[str, Any]]:
    """Returns `count` scenes, three quarters of them of the six sizes. The scenes are made here, so that the workers' libraries of
    linear algebra have no say."""
    kinds = [(f"V({n},{N})", n, "abcdefgh"[:N]) for n, N in SIZES for _ in range(count // 8)]
    others = [(name, n, pattern) for name, patterns in OTHERS.items() for n, pattern in patterns]
    kinds += [others[k % len(others)] for k in range(count - len(kinds))]
    return [{"group": name, "seed": [seed, k], "steps": steps,
             "scene": scene_of(name, n, pattern, np.random.default_rng([seed, k]))}
            for k, (name, n, pattern) in enumerate(kinds)]


def scene_of(group: str, n: int, pattern: str, rng: np.random.Generator) -> dict[str, Any]:
    N = len(pattern)
    ratio = np.exp(rng.uniform(np.log(1.1), np.log(100)))
    letters = sorted(set(pattern))
    values = np.append([1.0, ratio][:len(letters)], ratio ** rng.uniform(size=max(0, len(letters) - 2)))
    number = dict(zip(letters, rng.permutation(values)))
    inertia = np.array([number[letter] for letter in pattern])
    if group == "chaotic control":
        inertia, rng = np.array(CONTROL), np.random.default_rng(CONTROL_SEED)
    Q = np.linalg.qr(rng.normal(size=(N, n)))[0].T
    V = rng.normal(size=(n, N))
    V = V - (V @ Q.T + Q @ V.T) / 2 @ Q
    V /= np.sqrt(np.sum(V * inertia * V))  # energy 1/2
    system, method, blocks = "stiefel", {"name": "variational", "order": 2}, {"Q": Q, "Qdot": V}
    if n == N:
        X = Q.T @ V
        system, blocks = "rigid_body", {"Q": Q, "Qdot": Q @ (X - X.T) / 2}
    return {"system": system, "inertia": inertia.tolist(), "step": STEP, "method": method,
            "initial": {name: block.tolist() for name, block in blocks.items()}}


def measured(task: dict[str, Any]) -> dict[str, Any]:
    """Runs a scene and returns its exponent, GALI, their course at times of a ratio of sqrt(2), and the verdict."""
    with own_client().create(task["scene"]) as session:
        found = session.lyapunov(to=task["steps"], count=3, every=INTERVAL, interval=INTERVAL, seed=task["seed"][1])
    count = len(found.times)
    at = sorted({min(count, round(2 ** (k / 2))) - 1 for k in range(2 * count.bit_length() + 1)}) if count else []
    return {**task, "steps_done": found.step, "exponent": float(found.exponents[0]), "error": float(found.errors[0]),
            "log_gali": found.log_gali.tolist(), "verdict": str(found.verdict), "reason": found.reason,
            "times": found.times[at].tolist(), "growth": (found.times * found.history[:, 0])[at].tolist(),
            "log_gali_2": found.log_gali_history[at, 0].tolist()}


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
    """Returns a row of the table for each group; exponents, errors and GALI are those of its chaotic motions."""
    table = []
    for group in dict.fromkeys(row["group"] for row in rows):
        some = [row for row in rows if row["group"] == group]
        chaotic = [row for row in some if row["verdict"] == "chaotic"]
        numbers = {} if not chaotic else {
            "exponents": [float(f([row["exponent"] for row in chaotic])) for f in (np.median, min, max)],
            "error": max(row["error"] for row in chaotic),
            "log_gali": [float(np.median([row["log_gali"][k] for row in chaotic])) for k in (0, 1)]}
        counts = {verdict: sum(row["verdict"] == verdict for row in some) for verdict in ("regular", "chaotic", "undecided")}
        table.append({"group": group, "scenes": len(some), **counts, **numbers})
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
                velocity = manifold.velocity(Q, manifold.random_tangent(Q, seed=rng), energy=0.5, momentum=[[0, momentum], [-momentum, 0]])
                break
        scene: stiefel.Scene = {"system": "stiefel", "inertia": list(inertia), "step": 2 * STEP,
                                "method": {"name": "variational", "order": 2}, "initial": {"Q": Q, "Qdot": velocity}}
        with own_client().create(scene) as session:
            section = session.poincare({"M": [[0, 0, 1], [0, 0, 0], [0, 0, 0]]}, to=steps, fields=["Q", "M"], coordinates=[
                lambda s: np.arctan2(normal(s)[:, 0], normal(s)[:, 2]), lambda s: normal(s)[:, 1]])
        yield section.points[:, 0], section.points[:, 1]


def draw(file: Any, rows: list[dict[str, Any]], sections: Any) -> None:
    """Draws the growth of tangent vectors and GALI_2 by verdict, the exponents by group, and two sections of V(2, 3)."""
    import matplotlib.pyplot as plt  # the processes that only compute do without

    plt.switch_backend("Agg")
    plt.rcParams.update({"axes.spines.top": False, "axes.spines.right": False, "axes.grid": True, "grid.color": "#e2e8f0",
                         "axes.titlesize": 11, "axes.titlelocation": "left", "legend.frameon": False})
    # Dark, light and grey with a mark each, so that they can be told apart in grey.
    styles = {"regular": ("#004c7a", "o"), "chaotic": ("#E69F00", "^"), "undecided": ("#64748b", "s")}
    figure, axes = plt.subplot_mosaic([["growth", "area"], ["exponents", "exponents"], ["left", "right"]], figsize=(11, 12), layout="constrained")
    for row in rows:
        colour = styles[row["verdict"]][0]
        axes["growth"].loglog(row["times"], np.maximum(row["growth"], 0.3), lw=0.6, ls="-", color=colour, alpha=0.6)
        axes["area"].loglog(row["times"], np.maximum(-np.array(row["log_gali_2"]), 0.3), lw=0.6, ls="-", color=colour, alpha=0.6)
    times = np.array(max((row["times"] for row in rows), key=len, default=[1, 2]))
    axes["growth"].loglog(times, np.log(times), color="black", lw=1.5, ls="--")
    axes["growth"].set(title="growth t λ(t) of a tangent vector; dashed: ln t", xlabel="time t")
    axes["area"].set(title="−ln GALI₂(t), the area of two tangent vectors", xlabel="time t")
    groups = list(dict.fromkeys(row["group"] for row in rows))
    for row in rows:
        place, (colour, mark) = groups.index(row["group"]) + (row["seed"][1] % 12 - 6) / 20, styles[row["verdict"]]
        axes["exponents"].errorbar(place, row["exponent"], row["error"], fmt=mark, ms=3.5, lw=0.7, color=colour)
    axes["exponents"].set(title="largest exponent and its error, per unit of time")
    axes["exponents"].set_xticks(range(len(groups)), groups, rotation=30, ha="right", fontsize=9)
    for verdict, (colour, mark) in styles.items():
        axes["exponents"].plot([], [], ls="", marker=mark, color=colour, label=verdict)
    axes["growth"].legend(*axes["exponents"].get_legend_handles_labels(), loc="upper left")
    for axis, (inertia, orbits) in zip((axes["left"], axes["right"]), sections):
        for k, (azimuth, height) in enumerate(orbits):
            axis.plot(np.degrees(azimuth), height, ls="", marker=".", ms=2.5, mew=0, color=plt.get_cmap("tab10")(k % 10))
        axis.set(title=f"section of V(2, 3), Λ = {inertia}, where M₁₃ = 0", xlabel="azimuth of the plane's normal, °",
                 ylabel="its height along axis 2", xlim=(-180, 180), ylim=(-1, 1))
    figure.savefig(file, pil_kwargs={"optimize": True})


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", type=int, default=100)
    parser.add_argument("--steps", type=int, default=100_000, help="of every scene, 1000 or more")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--orbits", type=int, default=14, help="of each section")
    parser.add_argument("--on", default="here", help="what computes")
    parser.add_argument("--output", type=Path, default=Path("build/run"), help="folder for the results")
    arguments = parser.parse_args()
    arguments.output.mkdir(parents=True, exist_ok=True)

    begun = time.perf_counter()
    rows = study(tasks(arguments.scenes, arguments.steps, arguments.seed), arguments.on)
    seconds = time.perf_counter() - begun
    (arguments.output / "integrability.json").write_text(json.dumps(rows), encoding="utf-8")
    for row in summary(rows):
        print("{group:18} {scenes:4} scenes: {regular:3} regular, {chaotic:3} chaotic, {undecided:3} undecided".format(**row), end="")
        print("; lambda {:.3f} ({:.3f} ... {:.3f}), errors <= {:.3f}, ln GALI_2 {:.0f}, GALI_3 {:.0f}".format(
            *row["exponents"], row["error"], *row["log_gali"]) if row["chaotic"] else "")
    print(f"{len(rows)} scenes of {arguments.steps} steps in {seconds:.0f} s; SHA-256 of the result: {digest(rows)}")

    sections = [(inertia, list(crossings(inertia, momentum, arguments.orbits, arguments.steps)))
                for inertia, momentum in (((1, 1, 4), 0.3), ((1, 4, 12), 0.3))]
    draw(arguments.output / "integrability.png", rows, sections)
    print(f"wrote {arguments.output}/integrability.json and .png")


if __name__ == "__main__":
    main()
