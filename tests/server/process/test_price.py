"""A Step, a stream and a Drive that reach their prices go on without their caller noticing, with the same bits. A
stream by a closed form costs its samples."""
import json

import numpy as np
import pytest

import stiefel
from conftest import BODY
from stiefel import v1 as pb
from stiefel.v1 import simulation_pb2_grpc as rpc

#: A geodesic on a flat ellipsoid, on which `adaptive` tries about twenty times as many substeps as predicted.
SCENE = {"system": "ellipsoid", "inertia": [1, 0.8, 1e-6], "step": 0.1, "method": {"name": "adaptive", "tolerance": 1e-12},
         "initial": {"q": [[0, 0, 1.0]], "qdot": [[1, 0.1, 0.0]]}}
TO = 400


def computed(serve, call):
    """What the call returns on a server of its own, and how many calls ended at their prices."""
    process = serve("--log-format", "json")
    with stiefel.Client(process.address) as client, client.create(SCENE) as session:
        answer = call(session)
    process.stop()
    lines = [json.loads(line) for line in process.child.stderr]
    return answer, sum("instructions, its price" in line.get("error", "") for line in lines)


def drive(session):
    with session.drive() as at:
        return at.step(TO)


def test_the_bits_do_not_depend_on_the_stops(serve):
    short, none = computed(serve, lambda session: [session.step(k) for k in range(1, TO + 1)])
    state, of_step = computed(serve, lambda session: session.step(TO))
    run, of_stream = computed(serve, lambda session: session.trajectory(to=TO))
    driven, _ = computed(serve, drive)
    assert 1 <= of_step <= 3 and 1 <= of_stream <= 3 and none == 0
    for field in ("q", "qdot"):
        for last in (state[field], run[field][-1], driven[field]):
            assert np.array_equal(last, short[-1][field])
    assert list(run.step) == list(range(TO + 1)) and run.run_status.outcome == "REACHED"


@pytest.mark.parametrize("members", [None, 3])
def test_a_closed_form_costs_a_jump_to_each_sample(serve, members):
    scene = {**BODY, "method": {"name": "exact"}}
    if members:
        scene |= {"members": members, "body": {"moments": [1, 2, 3], "angular_velocity": [0.1, 1, 0.2] * members}}
    with serve("--log-level", "off").channel() as channel:
        stub = rpc.SimulationServiceStub(channel)
        made = stub.CreateSession(pb.CreateSessionRequest(session_id="s", scene=stiefel.to_message(scene)))
        stub.Step(pb.StepRequest(session_id="s", to=0))
        for every in (1, 1000, 100_000):
            sent = list(stub.Stream(pb.StreamRequest(session_id="s", to=100_000, every=every)))
            assert sent[0].price.work == pytest.approx(sent[-1].computed_steps * made.session.step_price.work)
            assert sent[-1].computed_steps == 100_000 // every
