"""Sessions of a server with --store, and what it answers of them."""
import grpc
import numpy as np

import stiefel
from conftest import BODY
from stiefel import v1 as pb


def scene_of(number, n=12):
    """A motion for each number; one in eight has n dimensions, so that its row has many pages."""
    if number % 8:
        return stiefel.to_message(BODY | {"step": 0.01 + 1e-6 * number})
    M = np.random.default_rng(number).uniform(-1, 1, (n, n))
    return stiefel.to_message({"system": "rigid_body", "inertia": np.linspace(1, 2, n), "step": 0.01,
                               "method": {"name": "variational"},
                               "initial": {"Q": np.eye(n), "M": M - M.T}})


def blocks(stub, id, step):
    reply = stub.Step(pb.StepRequest(session_id=id, to=step), timeout=60)
    return [field.value.data for field in reply.sample.fields]


def reason(error):
    status, info = pb.Status.FromString(dict(error.trailing_metadata())["grpc-status-details-bin"]), pb.ErrorInfo()
    info.ParseFromString(status.details[0].value)
    return info.reason


def is_deleted(stub, id):
    """Whether a handle that has lost the session is told that it may not create it again."""
    request = pb.CreateSessionRequest(session_id=id, scene=scene_of(1), recreate=True)
    try:
        stub.CreateSession(request, timeout=60)
    except grpc.RpcError as error:
        return reason(error) == "SESSION_DELETED"
    return False
