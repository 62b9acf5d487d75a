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
NO_NUMBERS = pb.FramePair(q_0=pb.Matrix(rows=1000, cols=4000), q_t=pb.Matrix(rows=1000, cols=4000))


def connect(pair):
    return "Connect", pb.ConnectRequest(inertia=[1, 2, 3], pairs=[pb.FramePair(q_0=Q_0, q_t=Q_T), pair], time=1)


def points(q):
    return "ConjugatePoints", pb.ConjugatePointsRequest(inertia=[1, 2, 3], time=6, q=q, qdot=frame(0, 1, 0.5))


def scene(system="rigid_body", shape=(3000, 3000), data=b""):
    made = pb.Scene(system=system, step=0.01, inertia=[1, 2, 3], tolerance=1e-6, horizon=1)
    made.initial_tensors["M"].CopyFrom(tensor(*shape, data=data))
    return made


SCENES = {"without its numbers": (scene(), "scene.initial_tensors.M.data"),
          "of no system": (scene("nothing", (500, 500), bytes(8 * 500 * 500)), "scene.system")}
IMPOSSIBLE = {  # what is asked for, and the field that is wrong
    "a frame without its numbers": (connect(NO_NUMBERS), "pairs[1].Q_0.values"),
    "a frame of 2^31 rows": (connect(pb.FramePair(q_0=pb.Matrix(rows=2**31, cols=4), q_t=Q_T)), "pairs[1].Q_0.rows"),
    "a complex frame": (connect(pb.FramePair(q_0=frame(1, 0, 0, imaginary=[1, 0, 0]), q_t=Q_T)), "pairs[1].Q_0.imaginary"),
    "a start of 2^31 rows": (points(pb.Matrix(rows=2**31, cols=3)), "Q.rows"),
    **{f"{method} {what}": ((method, kind(scene=one, **more)), field) for what, (one, field) in SCENES.items()
       for method, kind, more in (("CreateSession", pb.CreateSessionRequest, {"session_id": "new"}),
                                  ("Convert", pb.ConvertRequest, {"to": "velocity"}),
                                  ("MeasureTradeoff", pb.MeasureTradeoffRequest, {"horizon": 1}))},
    "derivatives of many": (("Linearize", pb.LinearizeRequest(session_id="many", to=100)), "session_id"),
    "exponents of many": (("LyapunovSpectrum", pb.LyapunovSpectrumRequest(session_id="many", to=100)), "session_id"),
    "a test of many": (("Diagnose", pb.DiagnoseRequest(session_id="many", symplectic_test=pb.SymplecticTest())), "symplectic_test"),
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
