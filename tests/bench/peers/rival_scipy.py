"""SciPy: DOP853 of solve_ivp, which its documentation recommends, and the compiled dop853 of the older class `ode`.

The right-hand side is written in Python, because neither takes a compiled one. It uses floats instead of arrays.
"""
import warnings

import scipy
from scipy.integrate import ode, solve_ivp

from rival import Body, Contestant, End, Run, Task, serve

_LEAST_TOLERANCE = 2.3e-14  # the smallest tolerance of solve_ivp


class EulerEquations:
    """The equations q̇ = ½ q∘(0, ω), I₁ω̇₁ = (I₂ − I₃)ω₂ω₃ and cyclic. Counts its evaluations."""

    def __init__(self, body: Body):
        I1, I2, I3 = body.moments
        self._k = (I2 - I3) / I1, (I3 - I1) / I2, (I1 - I2) / I3
        self.evaluations = 0

    def __call__(self, t: float, state: object) -> tuple[float, ...]:
        self.evaluations += 1
        w, x, y, z, a, b, c = state.tolist()
        k1, k2, k3 = self._k
        return (-0.5 * (x * a + y * b + z * c), 0.5 * (w * a + y * c - z * b), 0.5 * (w * b + z * a - x * c),
                0.5 * (w * c + x * b - y * a), k1 * b * c, k2 * c * a, k3 * a * b)


def prepare_solve_ivp(task: Task) -> Run:
    if task.setting < _LEAST_TOLERANCE:
        raise ValueError("rtol is too small")
    equations, solutions = EulerEquations(task.body), []

    def advance() -> None:
        solutions.append(solve_ivp(equations, (0.0, task.time), [1.0, 0, 0, 0, *task.body.angular_velocity],
                                   method="DOP853", rtol=task.setting, atol=task.setting, t_eval=[task.time]))

    return Run(advance, lambda: equations.evaluations, lambda: [_end(solutions[0].y[:, -1])])


def prepare_ode(task: Task) -> Run:
    equations = EulerEquations(task.body)
    solver = ode(equations).set_integrator("dop853", rtol=task.setting, atol=task.setting, nsteps=10**8)
    solver.set_initial_value([1.0, 0, 0, 0, *task.body.angular_velocity], 0.0)

    def advance() -> None:
        with warnings.catch_warnings():
            warnings.simplefilter("error", UserWarning)
            try:
                solver.integrate(task.time)
            except UserWarning as warning:
                raise RuntimeError(str(warning)) from None

    return Run(advance, lambda: equations.evaluations, lambda: [_end(solver.y)])


def _end(y: object) -> End:
    return End(y[:4].tolist(), y[4:].tolist())


if __name__ == "__main__":
    serve("SciPy", scipy.__version__, [Contestant("ode dop853", "tolerance", "evaluations", prepare_ode),
                                       Contestant("solve_ivp DOP853", "tolerance", "evaluations", prepare_solve_ivp)])
