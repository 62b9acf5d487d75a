"""Basilisk: a Spacecraft that consists of its hub alone, with Basilisk's integrators, all in C++.

The attitude is a set of modified Rodrigues parameters, which may be switched to the shadow set only between the steps
of a task. Therefore a task's period is an eighth of a rotation, and adaptive integrators take their steps within it.
"""
from __future__ import annotations

import math
from importlib.metadata import version

from Basilisk.architecture import bskLogging
from Basilisk.simulation import spacecraft, svIntegrators
from Basilisk.utilities import RigidBodyKinematics, SimulationBaseClass

from rival import Contestant, End, Run, Task, serve

_TASKS_A_ROTATION = 8
_NANOSECONDS = 10**9


def integrator(name: str, stages: int, adaptive: bool) -> Contestant:
    def prepare(task: Task) -> Run:
        rate = math.hypot(*task.body.angular_velocity)
        steps = round(_TASKS_A_ROTATION * task.time * rate / (2 * math.pi)) if adaptive else task.steps
        # Basilisk counts time in whole nanoseconds: time is stretched so that a period is a whole number of them.
        period = max(1, round(task.time / steps * _NANOSECONDS))
        stretch = period * steps / (task.time * _NANOSECONDS)
        simulation = SimulationBaseClass.SimBaseClass()
        simulation.CreateNewProcess("process").addTask(simulation.CreateNewTask("task", period))
        craft = spacecraft.Spacecraft()
        craft.hub.mHub = 1.0
        craft.hub.IHubPntBc_B = [[I if i == j else 0.0 for j in range(3)] for i, I in enumerate(task.body.moments)]
        craft.hub.sigma_BNInit = [[0.0]] * 3
        craft.hub.omega_BN_BInit = [[x / stretch] for x in task.body.angular_velocity]
        scheme = getattr(svIntegrators, f"svIntegrator{name}")(craft)
        if adaptive:
            scheme.relTol = scheme.absTol = task.setting
        craft.setIntegrator(scheme)
        simulation.AddModelToTask("task", craft)
        simulation.InitializeSimulation()
        simulation.ConfigureStopTime(period * steps)

        def ends() -> list[End]:
            state = craft.scStateOutMsg.read()
            attitude = RigidBodyKinematics.MRP2EP(state.sigma_BN)
            if not math.isfinite(attitude[0]):
                raise RuntimeError("not finite")
            return [End([float(x) for x in attitude], [x * stretch for x in state.omega_BN_B])]

        # These objects must stay alive, because C++ holds their addresses.
        kept = (craft, scheme)
        return Run(advance=simulation.ExecuteSimulation, work=lambda: stages * steps if kept and not adaptive else 0,
                   ends=ends)

    return Contestant(name, "tolerance" if adaptive else "steps", "evaluations", prepare)


if __name__ == "__main__":
    bskLogging.setDefaultLogLevel(bskLogging.BSK_ERROR)
    serve("Basilisk", version("bsk"), [integrator("RKF78", 13, True), integrator("RKF45", 6, True),
                                       integrator("RK4", 4, False)])
