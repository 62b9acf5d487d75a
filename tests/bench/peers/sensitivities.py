"""Compares the state transition matrix of a box over many rotations with heyoka's variational equations, at the same accuracy.

Both give the derivative of the attitude and of m by those at the start (6 x 6), and by the moments too (6 x 9). heyoka has
the largest tolerance of those tried, apart by factors of the square root of ten, with which its matrix is right to 1e-10 of
its norm; compiled not in compact mode, in which it is slower, and without the time of its compiler. The reference is heyoka
in extended precision. Processor time.

    build/peers/bin/python tests/bench/peers/sensitivities.py build/release/tests/bench/bench_sensitivities [repeats]
"""
from __future__ import annotations

import json
import subprocess
import sys
import time
from pathlib import Path

import heyoka
import numpy as np

MOMENTS, OMEGA = np.array((0.52 / 12, 0.4 / 12, 0.2 / 12)), np.array((1.0, 2.0, 3.0))
ROTATIONS, TARGET, BOUND = 100, 1e-10, 1 / 5


class Variational:
    """The variational equations of q and omega by x, y, z of q and omega at the start, and by the moments."""

    def __init__(self, by_moments: bool, tolerance: float, compact: bool, number: type = float):
        self.by_moments, self.number = by_moments, number
        w, x, y, z, a, b, c = heyoka.make_vars(*"wxyzabc")
        I1, I2, I3 = (heyoka.par[k] if by_moments else number(MOMENTS[k]) for k in range(3))
        half = heyoka.expression(number(0.5))
        equations = [(w, -half * (x * a + y * b + z * c)), (x, half * (w * a + y * c - z * b)),
                     (y, half * (w * b + z * a - x * c)), (z, half * (w * c + x * b - y * a)),
                     (a, (I2 - I3) / I1 * b * c), (b, (I3 - I1) / I2 * c * a), (c, (I1 - I2) / I3 * a * b)]
        along = [x, y, z, a, b, c] + ([heyoka.par[k] for k in range(3)] if by_moments else [])
        system = heyoka.var_ode_sys(equations, along, order=1)
        extended = {} if number is float else {"fp_type": number}
        pars = {"pars": [number(moment) for moment in MOMENTS]} if by_moments else {}
        start = np.array([1, 0, 0, 0, *OMEGA], dtype=number)
        self.solver = heyoka.taylor_adaptive(system, start, tol=number(tolerance), compact_mode=compact, **pars,
                                             **extended)
        self.start = self.solver.state.copy()

    def matrix(self, duration: float) -> tuple[float, np.ndarray]:
        """The seconds, and the derivative of (eta, m) by (eta, m) and by the moments at a constant m."""
        solver = self.solver
        solver.time = self.number(0)
        solver.state[:] = self.start
        began = time.process_time()
        solver.propagate_until(self.number(duration))
        seconds = time.process_time() - began
        q, omega, columns = solver.state[:4], solver.state[4:7], 9 if self.by_moments else 6
        # Element (i, k) of the derivatives is that of variable i by argument k.
        D = np.array([[solver.state[solver.get_vslice(order=1, component=i)][k] for k in range(columns)] for i in range(7)])
        w, x, y, z = q
        eta = 2 * np.array([[-x, w, z, -y], [-y, -z, w, x], [-z, y, -x, w]]) @ D[:4]  # of 2 q* dq
        dm = MOMENTS[:, None] * D[4:]
        Phi = np.vstack([eta, dm])
        Phi[:, :3] /= 2
        Phi[:, 3:6] /= MOMENTS
        if self.by_moments:
            # At a constant m, omega at the start moves by -omega dI / I.
            Phi[3:, 6:] += np.diag(omega)
            Phi[:, 6:] -= Phi[:, 3:6] * OMEGA
        return seconds, Phi


def measure(program: Path, repeats: int) -> list[dict]:
    duration, rows = float(ROTATIONS * 2 * np.pi / np.linalg.norm(OMEGA)), []
    for by_moments in (False, True):
        reference = Variational(by_moments, 1e-19, True, np.longdouble).matrix(duration)[1]

        def error(Phi: np.ndarray) -> float:
            return float(np.linalg.norm(Phi - reference) / np.linalg.norm(reference))

        command = [str(program), *map(repr, map(float, (*MOMENTS, *OMEGA, duration))), str(int(by_moments))]
        ours = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

        def our() -> tuple[float, np.ndarray]:
            ours.stdin.write("\n")
            ours.stdin.flush()
            seconds, *numbers = map(float, ours.stdout.readline().split())
            return seconds, np.array(numbers).reshape(6, -1)

        # The compiler takes minutes over the form that is not compact.
        tolerances = (10 ** (-k / 2) for k in range(16, 33))
        enough = next((t for t in tolerances if error(Variational(by_moments, t, True).matrix(duration)[1]) <= TARGET), None)
        rival = enough and Variational(by_moments, enough, False)
        mine, theirs = [], []
        for _ in range(repeats):
            seconds, Phi = our()
            mine.append(1e3 * seconds)
            if rival:
                theirs.append(1e3 * rival.matrix(duration)[0])
        ours.stdin.close()
        ours.wait()
        name = f"state transition matrix, 6 x {9 if by_moments else 6}, {ROTATIONS} rotations, box"
        rows.append({"name": name + ", error", "unit": "1", "values": [error(Phi)], "bound": TARGET})
        if rival:
            rows.append({"name": name, "unit": "ms", "rival": f"heyoka {heyoka.__version__}", "bound": BOUND,
                         "ours": mine, "theirs": theirs})
            print(f"{name}: {np.median(mine):.3f} ms, heyoka {np.median(theirs):.3f} ms at tolerance {rival.solver.tol:.1e}, "
                  f"ratio {np.median(np.divide(theirs, mine)):.1f}, errors {error(Phi):.1e} and "
                  f"{error(rival.matrix(duration)[1]):.1e}", file=sys.stderr)
    return rows


if __name__ == "__main__":
    for row in measure(Path(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 7):
        print(json.dumps(row))
