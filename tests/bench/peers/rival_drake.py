"""Drake: a continuous MultibodyPlant with one free body without gravity, advanced by Simulator.

runge_kutta5, Drake's highest order, is used with error control and with fixed steps. The largest step turns the body by
one radian: Drake starts with a tenth of it, and its error control does not recover from a first step of many rotations.
"""
import math
from importlib.metadata import version

from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import SpatialInertia, UnitInertia
from pydrake.systems.analysis import ApplySimulatorConfig, Simulator, SimulatorConfig

from rival import Body, Contestant, End, Run, Task, serve


def plant_of(body: Body) -> MultibodyPlant:
    plant = MultibodyPlant(time_step=0.0)
    plant.AddRigidBody("body", SpatialInertia(mass=1.0, p_PScm_E=[0, 0, 0], G_SP_E=UnitInertia(*body.moments)))
    plant.mutable_gravity_field().set_gravity_vector([0, 0, 0])
    plant.Finalize()
    return plant


def integrator(scheme: str, fixed: bool) -> Contestant:
    def prepare(task: Task) -> Run:
        plant = plant_of(task.body)
        simulator = Simulator(plant)
        choice = SimulatorConfig(integration_scheme=scheme, use_error_control=not fixed)
        choice.max_step_size = task.time / task.steps if fixed else 1 / math.hypot(*task.body.angular_velocity)
        if not fixed:
            choice.accuracy = task.setting
        ApplySimulatorConfig(choice, simulator)
        context = simulator.get_mutable_context()
        # Attitude and position; then ω and velocity in space axes, which at the start are the body axes.
        plant.SetPositionsAndVelocities(context, [1, 0, 0, 0, 0, 0, 0, *task.body.angular_velocity, 0, 0, 0])
        simulator.Initialize()
        body = plant.GetBodyByName("body")

        def ends() -> list[End]:
            pose = body.EvalPoseInWorld(context).rotation()
            in_space = body.EvalSpatialVelocityInWorld(context).rotational()
            return [End(plant.GetPositions(context)[:4].tolist(), (pose.inverse() @ in_space).tolist())]

        return Run(advance=lambda: simulator.AdvanceTo(task.time),
                   work=lambda: simulator.get_integrator().get_num_derivative_evaluations(), ends=ends)

    name, setting = (f"{scheme}, fixed", "steps") if fixed else (scheme, "tolerance")
    return Contestant(name, setting, "evaluations", prepare)


if __name__ == "__main__":
    serve("Drake", version("drake"), [integrator("runge_kutta5", fixed) for fixed in (False, True)])
