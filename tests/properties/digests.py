"""Prints a digest of the states and the outcome of 500 seeded scenes: every system, method, order, arithmetic, scalar.

    PYTHONPATH=build/release/python STIEFEL_SERVER=build/release/bin/stiefel-server \\
        /usr/bin/python3 tests/properties/digests.py > digests.txt

Two builds on one machine print the same lines if their states have the same bits. The line of a scene names it.
"""
from __future__ import annotations

import hashlib
import itertools
import sys

import numpy as np

import scenes
import stiefel

STEPS = [1, 7, 40]
LEAST_SCENES = 500


def ways():
    """Returns triples (pair, the scene's `method`, seed): every way to compute, with as many seeds as give enough."""
    kinds = []
    for pair in scenes.every_pair():
        if not pair.method:
            kinds.append((pair, None))
            continue
        for arithmetic, scalar in itertools.product(["compensated", "plain"], ["double", "float"][:1 + pair.in_float]):
            method = {"name": pair.method, "arithmetic": arithmetic, "scalar": scalar}
            kinds.append((pair, method | ({"order": pair.order} if pair.order and pair.method != "adaptive" else {})))
    rounds = -(-LEAST_SCENES // len(kinds))
    return [(pair, method, seed) for seed in range(rounds) for pair, method in kinds
            if not method or method["scalar"] == "double" or dimension(pair, seed) == 3]


def dimension(pair, seed):
    return 3 if pair.where == "N = 3" else 3 + seed % 4


def inertia_of(random, where, N):
    if "multiple of the identity" in where:
        return np.full(N, random.uniform(1, 3))
    values = random.uniform(1, 4, N)
    return values[np.arange(N) % 2] if "two values" in where and N > 3 else values


def scene_of(pair, method, seed):
    """Returns a seeded scene. Its size depends on the seed: N = 3, 4, 5, 6."""
    random = np.random.default_rng([seed, *pair.system.encode(), *pair.method.encode()])
    h = [1 / 16, -1 / 8, 1 / 32][seed % 3]
    scene = {"system": pair.system, "step": h} | ({"method": method} if method else {})
    N = dimension(pair, seed)
    skew = np.triu(random.uniform(-1, 1, (N, N)), 1)
    Q = scenes.cayley(2 * (skew - skew.T))
    skew = np.triu(random.uniform(-1, 1, (N, N)), 1)
    U = scenes.at_most_one(skew - skew.T)
    if pair.system == "double_bracket":
        blocks = {name: random.uniform(-0.5, 0.5, (2, N)) + 0.5j * random.uniform(-1, 1, (2, N)) for name in "QP"}
        return scene | {"inertia_u": random.uniform(1, 3, 2), "inertia_v": random.uniform(1, 3, N), "initial": blocks}
    inertia = scene["inertia"] = inertia_of(random, pair.where, N)
    if pair.system.startswith("parametric"):
        mu, rate = 1 / 4096, h if pair.system == "parametric_moser_veselov" else 1 / 4
        P = scenes.parametric_P(Q, inertia, rate * scenes.momentum(inertia, U), mu)
        return scene | {"parameter": mu, "initial": {"Q": Q, "P": P}}
    if "stiefel" in pair.system or pair.system == "ellipsoid":
        n = 1 if pair.system == "ellipsoid" else 1 + seed % (N - 1)
        return scene | {"initial": scenes.frame_blocks(pair.system, inertia, Q[:n], U, h)}
    return scene | {"initial": scenes.body_blocks(pair.system, inertia, Q, U, h)}


def numbers(field, scene):
    """Returns the numbers of a field in the precision of its scene, float32 if its scalar is `float`."""
    narrow = (scene.get("method") or {}).get("scalar") == "float"
    return np.ascontiguousarray(field, dtype=complex if np.iscomplexobj(field) else np.float32 if narrow else float)


def digest(client, scene):
    """Returns the digest of the blocks at the steps, with the last good state of a run that stops."""
    hashed = hashlib.sha256()
    try:
        with client.create(scene) as session:
            for step in STEPS:
                state = session.step(step)
                hashed.update(f"{step} {state.step} {state.outcome}".encode())
                for name in sorted(state.fields):
                    hashed.update(name.encode() + numbers(state.fields[name], scene).tobytes())
    except stiefel.InvalidArgument:
        return "refused"
    return hashed.hexdigest()[:16]


def main():
    with stiefel.Server.start() as server, stiefel.Client(server.address) as client:
        for pair, method, seed in ways():
            how = " ".join(str(value) for value in (method or {}).values())
            print(f"{pair.system} {how} seed {seed}: {digest(client, scene_of(pair, method, seed))}")
            sys.stdout.flush()


if __name__ == "__main__":
    main()
