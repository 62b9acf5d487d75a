"""MuJoCo: free joints without gravity, advanced by mj_step. Several bodies are one model, or run by rollout.

All features that the bodies do not need are disabled, as the documentation advises for speed.
"""
import mujoco
import mujoco.rollout
import numpy as np

from rival import Body, Contestant, End, Run, Task, serve

_IDLE = " ".join(f'{flag}="disable"' for flag in ("constraint", "contact", "gravity", "spring", "damper", "actuation",
                                                   "sensor", "eulerdamp", "island", "autoreset"))


def model_of(bodies: list[Body], integrator: str, step: float) -> mujoco.MjModel:
    def element(body: Body) -> str:
        moments = " ".join(map(repr, body.moments))
        return f'<body><freejoint/><inertial pos="0 0 0" mass="1" diaginertia="{moments}"/></body>'
    return mujoco.MjModel.from_xml_string(
        f'<mujoco><compiler boundmass="0" boundinertia="0" balanceinertia="false"/>'
        f'<option timestep="{step!r}" integrator="{integrator}"><flag {_IDLE}/></option>'
        f'<worldbody>{"".join(map(element, bodies))}</worldbody></mujoco>')


def start_of(model: mujoco.MjModel, bodies: list[Body]) -> mujoco.MjData:
    data = mujoco.MjData(model)
    data.qvel.reshape(-1, 6)[:, 3:] = [body.angular_velocity for body in bodies]
    return data


def ends_of(qpos: np.ndarray, qvel: np.ndarray) -> list[End]:
    return [End(q[3:].tolist(), v[3:].tolist()) for q, v in zip(qpos.reshape(-1, 7), qvel.reshape(-1, 6))]


def one_model(integrator: str, stages: int) -> Contestant:
    def prepare(task: Task) -> Run:
        model = model_of(task.bodies, integrator, task.time / task.steps)
        data = start_of(model, task.bodies)
        return Run(advance=lambda: mujoco.mj_step(model, data, task.steps),
                   work=lambda: stages * task.steps * len(task.bodies),
                   ends=lambda: ends_of(data.qpos, data.qvel))
    return Contestant(integrator, "steps", "evaluations", prepare)


def rollout(integrator: str, stages: int) -> Contestant:
    """Returns a contestant in which each body is a separate model, as for samples of a controller."""
    def prepare(task: Task) -> Run:
        models = [model_of([body], integrator, task.time / task.steps) for body in task.bodies]
        full = mujoco.mjtState.mjSTATE_FULLPHYSICS
        starts = np.empty((len(models), mujoco.mj_stateSize(models[0], full)))
        for start, model, body in zip(starts, models, task.bodies):
            mujoco.mj_getState(model, start_of(model, [body]), start, full)
        scratch = mujoco.MjData(models[0])
        states = np.empty((len(models), task.steps, starts.shape[1]))

        def ends() -> list[End]:
            _, qpos, qvel = np.split(states[:, -1], [1, 8], axis=1)
            return ends_of(qpos, qvel[:, :6])

        return Run(advance=lambda: mujoco.rollout.rollout(models, scratch, starts, nstep=task.steps, state=states),
                   work=lambda: stages * task.steps * len(task.bodies), ends=ends)
    return Contestant(f"{integrator}, rollout", "steps", "evaluations", prepare)


if __name__ == "__main__":
    serve("MuJoCo", mujoco.__version__, [contestant(*integrator) for contestant in (one_model, rollout)
                                         for integrator in (("Euler", 1), ("implicitfast", 1), ("RK4", 4))])
