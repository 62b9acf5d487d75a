"""Compares the search for geodesics with Λ = I to two published methods, in our own numpy and SciPy: p-shooting (Zimmermann
and Hüper 2022) and the forward iteration with first-order steps (Mataigne, Zimmermann and Miolane 2024). The faster of the
two counts. Both work in the span of the two frames, to a miss of 1e-13; processor time, on one thread. Pairs are also joined
from Python, in batches of 16 (wall-clock time), and in the canonical metric beside the logarithm of geomstats, where stiefel
and geomstats can be imported.

    OMP_NUM_THREADS=1 python3 tests/bench/peers/geodesics.py build/release/tests/bench/bench_geodesics [repeats]
"""
from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import time
from importlib.util import find_spec
from pathlib import Path

import numpy as np
from scipy.linalg import expm, qr, schur, solve_sylvester

SIZES = [(3, 8), (4, 12), (5, 20), (7, 15), (10, 15), (10, 100), (30, 90), (20, 1000), (4, 100_000)]
MISS, MOST = 1e-13, 200


def geodesic(A: np.ndarray, B: np.ndarray, beta: float = 1) -> np.ndarray:
    """The frame at time 1 in the span, (n + p) x n: exp(W) [I; 0] exp((1 - 2 beta) A), W = [[2 beta A, -B'], [B, 0]]."""
    n = len(A)
    W = np.block([[2 * beta * A, -B.T], [B, np.zeros((len(B), len(B)))]])
    return expm(W)[:, :n] @ expm((1 - 2 * beta) * A)


def spanned(Y: np.ndarray, Z: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """R, K and M with Z = YM + KR; K has orthonormal columns."""
    N, n = Y.shape
    M = Y.T @ Z
    if N >= 2 * n:
        K, R = qr(Z - Y @ M, mode="economic", overwrite_a=True, check_finite=False)
        return R, K, M
    K = qr(Y)[0][:, n:]
    return K.T @ Z, K, M


def p_shooting(Y: np.ndarray, Z: np.ndarray, points: int = 4) -> np.ndarray | None:
    R, K, M = spanned(Y, Z)
    n, target = len(M), np.vstack([M, R])
    chord = target - np.eye(*target.shape)
    D = np.vstack([(M - M.T) / 2, R])
    D *= np.linalg.norm(chord) / np.linalg.norm(D)
    for _ in range(MOST):
        A, B = D[:n], D[n:]
        W = np.block([[2 * A, -B.T], [B, np.zeros((len(B), len(B)))]]) / points
        turn, back = expm(W), expm(-A / points)
        frames = [np.eye(*target.shape)]
        for _ in range(points):
            frames.append(turn @ frames[-1] @ back)
        gap = frames[-1] - target
        if np.abs(gap).max() <= MISS:
            return Y @ A + K @ B
        size = np.linalg.norm(gap)
        for frame in reversed(frames):
            S = frame.T @ gap
            gap = gap - frame @ ((S + S.T) / 2)
            gap *= size / np.linalg.norm(gap)
        D = D - np.vstack([(gap[:n] - gap[:n].T) / 2, gap[n:]])
    return None


def logarithm(V: np.ndarray) -> np.ndarray:
    """The logarithm of a rotation from its real Schur form."""
    T, Z = schur(V)
    L = np.zeros_like(T)
    i = 0
    while i + 1 < len(T):
        if abs(T[i + 1, i]) > 1e-300:
            angle = np.arctan2((T[i + 1, i] - T[i, i + 1]) / 2, (T[i, i] + T[i + 1, i + 1]) / 2)
            L[i + 1, i], L[i, i + 1] = angle, -angle
            i += 2
        else:
            i += 1
    return Z @ L @ Z.T


def forward_iteration(Y: np.ndarray, Z: np.ndarray) -> np.ndarray | None:
    R, K, M = spanned(Y, Z)
    n, p = len(M), len(R)
    target = np.vstack([M, R])
    V = qr(target)[0]
    V[:, :n] = target
    # The completion whose lower right block is nearest to a positive symmetric one.
    left, _, right = np.linalg.svd(V[n:, n:])
    V[:, n:] = V[:, n:] @ (right.T @ left.T)
    if np.linalg.det(V) < 0:
        left[:, -1] *= -1
        V[:, n:] = V[:, n:] @ (right.T @ left.T)
    A = np.zeros((n, n))
    for _ in range(MOST):
        L = logarithm(V)
        step, B, C = L[:n, :n] - 2 * A, L[n:, :n], L[n:, n:]
        if max(np.abs(step).max(), np.abs(C).max(initial=0)) <= MISS:
            return Y @ A + K @ B
        S = B @ B.T / 12 - np.eye(p) / 2
        gamma = solve_sylvester(S, S, C)
        A = A + step
        V[:, :n] = target @ expm(A)
        V[:, n:] = V[:, n:] @ expm((gamma - gamma.T) / 2)
    return None


def drawn(n: int, N: int, length: float, random: np.random.Generator,
          beta: float = 1) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    Y, H = np.linalg.qr(random.standard_normal((N, n)))[0], random.standard_normal((N, n))
    S = Y.T @ H
    H -= Y @ (S + S.T) / 2
    A = Y.T @ H
    H *= length / np.sqrt(np.sum(H**2) - (1 - beta) * np.sum(A**2))
    A = Y.T @ H
    K = np.linalg.qr(np.hstack([Y, H - Y @ A]))[0][:, n:min(2 * n, N)]
    return Y, np.hstack([Y, K]) @ geodesic((A - A.T) / 2, K.T @ H, beta), H


def processor_seconds(work) -> tuple[float, object]:
    start = time.process_time()
    result = work()
    return time.process_time() - start, result


def measure(program: Path, repeats: int, beta: float, metric: str, rivals: list) -> list[dict]:
    rows = []
    for n, N in SIZES:
        for length in (0.5, 0.8):
            random = np.random.default_rng(n * N)
            pairs = [drawn(n, N, length * np.pi, random, beta) for _ in range(1 if N > 10_000 else 4)]
            name = f"geodesic on V({n},{N}), {length} pi, {metric}"
            bound = 1 / 20 if beta != 1 else 1 / 5 if n <= 10 else 1 / 3
            row = {"name": name, "unit": "ms", "ours": [], "theirs": [], "bound": bound, "rival": rivals[0].__name__}
            worst, errors = 0.0, {}
            with tempfile.NamedTemporaryFile() as file:
                for pair in pairs:
                    for block in pair:
                        file.write(np.ascontiguousarray(block.T).tobytes())
                file.flush()
                ours = subprocess.Popen([program, str(n), str(N), str(beta), file.name], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                        text=True)
                for repeat in range(repeats + 1):  # the first one warms up
                    mine, theirs = 0.0, dict.fromkeys(rivals, 0.0)
                    for index, (Y, Z, H) in enumerate(pairs):
                        ours.stdin.write(f"{index}\n")
                        ours.stdin.flush()
                        seconds, error = map(float, ours.stdout.readline().split())
                        mine += seconds
                        worst = max(worst, error)
                        for rival in theirs:
                            spent, V = processor_seconds(lambda: rival(Y, Z))
                            good = V is not None and np.abs(V - H).max() < 1e-8
                            theirs[rival] += spent if good else np.inf
                            if good:
                                errors[rival.__name__] = max(errors.get(rival.__name__, 0), float(np.abs(V - H).max()))
                    if repeat > 0:
                        best = min(theirs, key=theirs.get)
                        row["ours"].append(1e3 * mine / len(pairs))
                        row["theirs"].append(1e3 * theirs[best] / len(pairs))
                        row["rival"] = best.__name__
                ours.stdin.close()
                ours.wait()
            rows.append({"name": name + ", error", "unit": "1", "values": [worst], "bound": 1e-13 if beta == 1 else 1e-12})
            if np.all(np.isfinite(row["theirs"])):
                rows.append(row)
            print(name, f"{np.median(row['ours']):.3f} ms, {row['rival']} {np.median(row['theirs']):.2f} ms,"
                  f" ratio {np.median(np.divide(row['theirs'], row['ours'])):.1f}, error {worst:.1e},", errors, file=sys.stderr)
    return rows


def batches(repeats: int) -> list[dict]:
    """Batches of 16 pairs from Python, by a server of the process, beside the faster of the two methods; time of a pair."""
    from stiefel.manifold import Stiefel

    rows = []
    for n, N in SIZES:
        for length in (0.5, 0.8):
            random = np.random.default_rng(n * N)
            few = [drawn(n, N, length * np.pi, random) for _ in range(2 if N > 10_000 else 16)]
            Y, Z, H = (np.stack([(few * (16 // len(few)))[i][k].T for i in range(16)]) for k in range(3))
            manifold = Stiefel(n, N)
            bound = 1 / 1 if N > 10_000 else 1 / 2.5 if n <= 10 else 1 / 1.5
            row = {"name": f"geodesic on V({n},{N}), {length} pi, Lambda = I, from Python", "unit": "ms", "ours": [],
                   "theirs": [], "bound": bound, "rival": "p_shooting or forward_iteration"}
            for repeat in range(repeats + 1):  # the first one warms up
                start = time.perf_counter()
                V = manifold.log(Y, Z)
                mine = time.perf_counter() - start
                spent = []
                for rival in (p_shooting, forward_iteration):
                    start = time.perf_counter()
                    good = all(rival(y, z) is not None for y, z, _ in few)
                    spent.append((time.perf_counter() - start) / len(few) if good else np.inf)
                if repeat > 0:
                    row["ours"].append(1e3 * mine / 16)
                    row["theirs"].append(1e3 * min(spent))
            rows.append(row)
            print(row["name"], f"{np.median(row['ours']):.3f} ms, rival {np.median(row['theirs']):.2f} ms,"
                  f" ratio {np.median(np.divide(row['theirs'], row['ours'])):.1f}, error {np.abs(V - H).max():.1e}", file=sys.stderr)
    return rows


def geomstats_log(Y: np.ndarray, Z: np.ndarray) -> np.ndarray:
    from geomstats.geometry.stiefel import Stiefel

    found: np.ndarray = Stiefel(*Y.shape).metric.log(Z, Y)
    return found


def main() -> None:
    program, repeats = Path(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 7
    rows = measure(program, repeats, 1, "Lambda = I", [p_shooting, forward_iteration])
    if find_spec("stiefel") and find_spec("grpc"):
        rows += batches(repeats)
    if find_spec("geomstats"):
        rows += measure(program, repeats, 0.5, "canonical", [geomstats_log])
    for row in rows:
        print(json.dumps(row))


if __name__ == "__main__":
    main()
