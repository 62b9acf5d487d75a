"""The scenes of the suite, as dicts: small scenes of every kind that the server must distinguish."""
import numpy as np

M3 = [[0, -0.01, 3], [0.01, 0, -0.001], [-3, 0.001, 0]]


def rigid_body(**changes):
    """Returns a rigid body in three dimensions with `changes`, where None leaves a field out."""
    scene = {
        "system": "rigid_body",
        "method": {"name": "variational"},
        "inertia": [2.5, 1.5, 0.5],
        "initial": {"Q": np.eye(3), "M": M3},
        "step": 0.01,
    }
    return {name: value for name, value in {**scene, **changes}.items() if value is not None}


def moser_veselov():
    return rigid_body(system="moser_veselov", method=None)


def body(**changes):
    """Returns a body in three dimensions as engineers describe it, with `changes`, where None leaves a field out."""
    description = {"moments": [1, 2, 3], "attitude": [1, 0, 0, 0], "angular_velocity": [0.1, 2, 0.1], **changes}
    return {"system": "rigid_body", "method": {"name": "variational"}, "step": 0.01,
            "body": {name: value for name, value in description.items() if value is not None}}


def free(n, seed=1, method="variational", step=0.02):
    """Returns a body in n dimensions with a seeded random state and h ‖Ω‖ well inside the domain."""
    random = np.random.default_rng(seed)
    frame, _ = np.linalg.qr(random.standard_normal((n, n)))
    omega = random.standard_normal((n, n))
    omega -= omega.T
    omega *= 2 / np.linalg.norm(omega, 2)
    inertia = np.linspace(1, 2, n)
    momentum = inertia[:, None] * omega + omega * inertia
    return {"system": "rigid_body", "method": {"name": method}, "inertia": inertia,
            "initial": {"Q": frame, "M": momentum}, "step": step}


def frame(n, N, seed=1, method="variational", step=0.02):
    """Returns a geodesic on V(n, N) with a seeded random state."""
    random = np.random.default_rng(seed)
    Q = np.linalg.qr(random.standard_normal((N, n)))[0].T
    U = random.standard_normal((N, N))
    U -= U.T
    inertia = np.linspace(1, 2, N)
    return {"system": "stiefel", "method": {"name": method}, "inertia": inertia,
            "initial": {"Q": Q, "S": Q @ (U / np.linalg.norm(U, 2)) * inertia}, "step": step}


def left_domain():
    """Returns a scene whose step is so long that there is no solution on the principal branch."""
    return rigid_body(step=5.0)


BIT_SCENES = {
    "variational": rigid_body(),
    "moser_veselov": moser_veselov(),
    "body": body(),
    "momentum only": rigid_body(initial={"M": M3}),
    "rk4": rigid_body(method={"name": "rk4"}),
    "munthe_kaas4": rigid_body(method={"name": "munthe_kaas4"}),
    "splitting": rigid_body(method={"name": "splitting"}),
    "order 10": rigid_body(method={"name": "preprocessed_variational", "order": 10}),
    "plain": rigid_body(method={"name": "variational", "arithmetic": "plain"}),
    "substeps": rigid_body(method={"name": "variational", "substeps": 3}),
    "backwards": rigid_body(step=-0.01),
    "N = 5": free(5),
    "long step": free(4, step=0.25),
    "ensemble": rigid_body(members=5, initial={"Q": np.stack([np.eye(3)] * 5),
                                               "M": np.asarray(M3) * np.arange(1, 6)[:, None, None] / 5}),
}
