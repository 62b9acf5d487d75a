"""heyoka: Taylor's method with equations compiled for this processor, not in compact mode, as suits few equations.

The form of the equations takes the least work of those tried: ω instead of m as the variable, and the moments as
constants instead of parameters.
"""
import heyoka

from rival import Contestant, End, Run, Task, serve


def equations(moments: list[float]) -> list:
    """Returns the equations q̇ = ½ q∘(0, ω), I₁ω̇₁ = (I₂ − I₃)ω₂ω₃ and cyclic."""
    w, x, y, z, a, b, c = heyoka.make_vars(*"wxyzabc")
    I1, I2, I3 = moments
    return [(w, -0.5 * (x * a + y * b + z * c)), (x, 0.5 * (w * a + y * c - z * b)),
            (y, 0.5 * (w * b + z * a - x * c)), (z, 0.5 * (w * c + x * b - y * a)),
            (a, (I2 - I3) / I1 * b * c), (b, (I3 - I1) / I2 * c * a), (c, (I1 - I2) / I3 * a * b)]


def taylor(name: str, **options: bool) -> Contestant:
    compiled = {}

    def integrator(task: Task) -> heyoka.taylor_adaptive:
        key = (tuple(task.body.moments), task.setting)
        if key not in compiled:
            compiled[key] = heyoka.taylor_adaptive(equations(task.body.moments), [0.0] * 7, tol=task.setting, **options)
        return compiled[key]

    def prepare(task: Task) -> Run:
        solver, steps = integrator(task), []
        solver.time = 0.0
        solver.state[:] = [1, 0, 0, 0, *task.body.angular_velocity]
        return Run(advance=lambda: steps.append(solver.propagate_until(task.time)[3]),
                   work=lambda: steps[0],
                   ends=lambda: [End(list(solver.state[:4]), list(solver.state[4:]))])

    return Contestant(name, "tolerance", "steps", prepare)


if __name__ == "__main__":
    serve("heyoka", heyoka.__version__, [taylor("taylor"), taylor("taylor, fast_math", fast_math=True)])
