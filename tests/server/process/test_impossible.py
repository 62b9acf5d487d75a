"""A request that can never be valid is told so, and not that its memory, which nobody will take, is not there."""
import grpc
import numpy as np
import pytest

import stiefel
from conftest import BODY
from stiefel import v1 as pb
from stiefel._wire.failures import from_rpc_error
from stiefel.v1 import simulation_pb2_grpc

MEMBERS = 10_000
DOUBLE = pb.DATA_TYPE_FLOAT64


def frame(*values, **more):
    return pb.Matrix(rows=1, cols=3, values=values, **more)


def tensor(*shape, data=b""):
    return pb.Tensor(shape=shape, data_type=DOUBLE, data=data)


Q_0, Q_T = frame(1, 0, 0), frame(0, 1, 0)
PAIR = pb.FramePair(q_0=Q_0, q_t=Q_T)
NO_NUMBERS = pb.FramePair(q_0_tensor=tensor(1000, 4000), q_t_tensor=tensor(1000, 4000))
ENDLESS = pb.FramePair(q_0_tensor=tensor(2**40, 4), q_t_tensor=tensor(2**40, 4))
TWO_ROWS = pb.FramePair(q_0=pb.Matrix(rows=2, cols=3, values=[1, 0, 0, 0, 1, 0]), q_t=pb.Matrix(rows=2, cols=3, values=[0, 1, 0, 0, 0, 1]))


def connect(*pairs, **more):
    return "Connect", pb.ConnectRequest(inertia=[1, 2, 3], pairs=pairs or [PAIR], time=1, **more)


def points(**changed):
    given = {"q": Q_0, "qdot": frame(0, 1, 0.5), **changed}
    return "ConjugatePoints", pb.ConjugatePointsRequest(inertia=[1, 2, 3], time=6, **given)


def scene(system="rigid_body", **momentum):
    made = pb.Scene(system=system, step=0.01, inertia=[1, 2, 3], tolerance=1e-6, horizon=1)
    made.initial_tensors["M"].CopyFrom(tensor(*momentum.pop("shape", (3000, 3000)), **momentum))
    return made


def of_scene(method, **more):
    return {"CreateSession": ("CreateSession", pb.CreateSessionRequest(session_id="new", scene=scene(**more))),
            "Convert": ("Convert", pb.ConvertRequest(scene=scene(**more), to="velocity")),
            "MeasureTradeoff": ("MeasureTradeoff", pb.MeasureTradeoffRequest(scene=scene(**more), horizon=1))}[method]


def of_members(method, **more):
    kind = {"Linearize": pb.LinearizeRequest, "LyapunovSpectrum": pb.LyapunovSpectrumRequest, "Diagnose": pb.DiagnoseRequest}[method]
    return method, kind(session_id="many", to=100, **more)


IMPOSSIBLE = {  # what is asked for, and the field that is wrong
    "steps": (connect(steps=2**31), "steps"),
    "samples": (connect(samples=2**31), "samples"),
    "restarts": (connect(restarts=2**31), "restarts"),
    "a frame of 2^40 rows": (connect(ENDLESS), "pairs[0].Q_0_tensor.shape"),
    "a frame without its numbers": (connect(NO_NUMBERS), "pairs[0].Q_0_tensor.data"),
    "a frame of 2^31 rows": (connect(pb.FramePair(q_0=pb.Matrix(rows=2**31, cols=4), q_t=Q_T)), "pairs[0].Q_0.rows"),
    "frames of two shapes": (connect(PAIR, TWO_ROWS), "pairs[1].Q_0"),
    "a complex frame": (connect(pb.FramePair(q_0=frame(1, 0, 0, imaginary=[1, 0, 0]), q_t=Q_T)), "pairs[0].Q_0.imaginary"),
    "a complex start": (points(q=frame(1, 0, 0, imaginary=[1, 0, 0])), "Q.imaginary"),
    "a complex velocity": (points(qdot=frame(0, 1, 0.5, imaginary=[1, 0, 0])), "Qdot.imaginary"),
    "a start of 2^31 rows": (points(q=pb.Matrix(rows=2**31, cols=3)), "Q.rows"),
    **{f"{method} without its numbers": (of_scene(method), "scene.initial_tensors.M.data")
       for method in ("CreateSession", "Convert", "MeasureTradeoff")},
    **{f"{method} of no system": (of_scene(method, system="nothing", shape=(500, 500), data=bytes(8 * 500 * 500)), "scene.system")
       for method in ("CreateSession", "Convert", "MeasureTradeoff")},
    "derivatives of many": (of_members("Linearize"), "session_id"),
    "exponents of many": (of_members("LyapunovSpectrum"), "session_id"),
    "a test of many": (of_members("Diagnose", symplectic_test=pb.SymplecticTest()), "symplectic_test"),
}


@pytest.fixture(scope="module")
def small():
    """A server with the least memory, and a session of many bodies, for which there is just room."""
    velocities = np.random.default_rng(1).uniform(0.5, 1, size=(MEMBERS, 3))
    with stiefel.Server.start(arguments=["--memory", "128M"]) as server, stiefel.Client(server.address) as client:
        client.create({**BODY, "members": MEMBERS, "body": {"moments": [1, 2, 3], "angular_velocity": velocities}}, id="many")
        yield simulation_pb2_grpc.SimulationServiceStub(client._channel)


@pytest.mark.parametrize("name", IMPOSSIBLE)
def test_what_is_wrong_is_told(small, name):
    (method, request), field = IMPOSSIBLE[name]
    with pytest.raises(grpc.RpcError) as refusal:
        reply = getattr(small, method)(request, timeout=60)
        list(reply if method not in ("CreateSession", "Diagnose") else [])
    error = from_rpc_error(refusal.value)
    assert isinstance(error, stiefel.InvalidArgument), error
    assert error.violations[0].field == field, error
