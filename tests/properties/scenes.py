"""Strategies of hypothesis for scenes of every system and method that Describe lists.

The numbers are multiples of 1/16, so that failures are readable after shrinking. Frames are Cayley
transforms of skew matrices, and the rate of the motion is at most 1.
"""
from __future__ import annotations

import functools
from typing import NamedTuple

import numpy as np
from hypothesis import strategies as st

import stiefel


class Pair(NamedTuple):
    system: str
    method: str = ""  # empty for a discrete system
    order: int = 0  # 0 for a method without an order
    where: str = ""
    in_float: bool = False

    def __str__(self):
        return "-".join([self.system, *([self.method] if self.method else []), *([str(self.order)] if self.order else [])])


@functools.cache
def catalogue():
    with stiefel.Server.start() as server, stiefel.Client(server.address) as client:
        return client.describe()


@functools.cache
def every_pair():
    orders = {method.name: method.orders or [0] for method in catalogue().methods} | {"": [0]}
    return [Pair(system.name, on.method, order, on.where, on.in_float)
            for system in catalogue().systems for on in system.methods for order in orders[on.method]]


def preserved(pair):
    """Returns what the method declares about each family of invariants."""
    system = next(s for s in catalogue().systems if s.name == pair.system)
    on = next(m for m in system.methods if m.method == pair.method)
    return {p.invariant: stiefel.Conservation(p.conservation) for p in on.preserves}


def sixteenths(low, high):
    return st.integers(16 * low, 16 * high).map(lambda k: k / 16)


def matrices(rows, cols):
    return st.lists(sixteenths(-1, 1), min_size=rows * cols, max_size=rows * cols).map(
        lambda values: np.reshape(values, (rows, cols)))


def skew(n):
    return matrices(n, n).map(lambda A: (A - A.T) / 2)


def cayley(A):
    one = np.eye(len(A))
    return np.linalg.solve(one - A / 2, one + A / 2)


def rotations(n):
    return skew(n).map(lambda A: cayley(2 * A))


def at_most_one(A):
    return A / max(1, np.linalg.norm(A, 2))


def inertia_of(draw, where, N):
    if "multiple of the identity" in where:
        return np.full(N, draw(sixteenths(1, 3)))
    values = draw(st.lists(sixteenths(1, 4), min_size=N, max_size=N))
    if "two values" in where and N > 3:
        values = [values[k % 2] for k in range(N)]
    return np.array(values)


def momentum(inertia, Omega):
    """Returns M = ΛΩ + ΩΛ."""
    return inertia[:, None] * Omega + Omega * inertia


def moved(Q, U, h):
    """Returns a frame on the manifold that lies about one step h after Q."""
    return Q @ cayley(h * U)


def parametric_P(Q, inertia, M, mu):
    """Returns the P with G - G^-1 = M + mu Lambda^2 for G = Q^-1 P: G = W + (1 + W^2)^(1/2), W half of that sum."""
    W = (M + mu * np.diag(inertia**2)) / 2
    one = np.eye(len(W))
    root = one
    for _ in range(40):
        root = (root + np.linalg.solve(root, one + W @ W)) / 2
    return Q @ (W + root)


def frame_blocks(system, inertia, Q, U, h):
    """Returns the blocks of a geodesic through the frame Q with Q' = QU."""
    S = (Q @ U) * inertia
    return {
        "stiefel": lambda: {"Q": Q, "S": S},
        "stiefel_momentum": lambda: {"Q": Q, "M": Q.T @ S - S.T @ Q},
        "stiefel_costate": lambda: {"Q": Q, "P": S + Q / 4},
        "ellipsoid": lambda: {"q": Q, "qdot": Q @ U},
        "discrete_stiefel": lambda: {"Q_prev": Q, "Q": moved(Q, U, h)},
    }[system]()


def body_blocks(system, inertia, Q, Omega, h):
    if system == "moser_veselov_pair":
        return {"Q_prev": Q, "Q": moved(Q, Omega, h)}
    return {"Q": Q, "M": momentum(inertia, Omega)}


@st.composite
def scenes(draw, pair, sizes=(3, 4, 5), rows=None):
    """Draws a scene as its author would write it: method, order and arithmetic, blocks as arrays. `rows`: the rows of a
    frame; None: any number."""
    h = draw(st.sampled_from([1 / 16, 1 / 8, -1 / 16, 1 / 32]))
    scene = {"system": pair.system, "step": h}
    if pair.method:
        scene["method"] = {"name": pair.method, "arithmetic": draw(st.sampled_from(["compensated", "plain"])),
                           "substeps": draw(st.sampled_from([1, 2]))}
        if pair.order and pair.method != "adaptive":
            scene["method"]["order"] = pair.order
        if pair.in_float:
            scene["method"]["scalar"] = draw(st.sampled_from(["double", "float"]))
    if pair.system == "double_bracket":
        return scene | double_bracket(draw)
    single = scene.get("method", {}).get("scalar") == "float"
    N = 3 if pair.where == "N = 3" or single else draw(st.sampled_from(sizes))
    inertia = inertia_of(draw, pair.where, N)
    Q, U = draw(rotations(N)), at_most_one(draw(skew(N)))
    scene["inertia"] = inertia
    if pair.system.startswith("parametric"):
        mu, rate = 1 / 4096, h if pair.system == "parametric_moser_veselov" else 1 / 4
        scene["parameter"] = mu
        scene["initial"] = {"Q": Q, "P": parametric_P(Q, inertia, rate * momentum(inertia, U), mu)}
    elif "stiefel" in pair.system or pair.system == "ellipsoid":
        n = 1 if pair.system == "ellipsoid" else rows or draw(st.integers(1, N - 1))
        scene["initial"] = frame_blocks(pair.system, inertia, Q[:n], U, h)
    else:
        scene["initial"] = body_blocks(pair.system, inertia, Q, U, h)
    return scene


def double_bracket(draw):
    blocks = {name: (draw(matrices(2, 3)) + 1j * draw(matrices(2, 3))) / 2 for name in "QP"}
    return {"inertia_u": draw(st.lists(sixteenths(1, 2), min_size=2, max_size=2)),
            "inertia_v": draw(st.lists(sixteenths(1, 2), min_size=3, max_size=3)), "initial": blocks}


@st.composite
def ensembles(draw, pair):
    """Draws scenes of one shape, method and step, and an ensemble of the same scenes."""
    size, rows = draw(st.sampled_from([3, 4, 5])), draw(st.integers(1, 2))
    alone = draw(st.lists(scenes(pair, (size,), rows), min_size=2, max_size=9))
    together = dict(alone[0], members=len(alone))
    for scene in alone[1:]:
        scene.update({name: together[name] for name in ("method", "step") if name in together})
    for name in together.keys() & {"inertia", "inertia_u", "inertia_v"}:
        together[name] = np.stack([scene[name] for scene in alone])
    together["initial"] = {name: np.stack([scene["initial"][name] for scene in alone]) for name in together["initial"]}
    return alone, together


def first_block(scene):
    """Returns the name of the frame, or of the first block of a system without a frame."""
    return next((name for name in ("Q", "q") if name in scene["initial"]), next(iter(scene["initial"])))


def unit(scene):
    """Returns the rounding unit of the scene's numbers."""
    return 2**-24 if scene.get("method", {}).get("scalar") == "float" else 2**-53


def any_scenes(**options):
    """Returns a strategy for scenes of any system and method."""
    return st.sampled_from(every_pair()).flatmap(lambda pair: scenes(pair, **options))
