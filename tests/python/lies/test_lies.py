"""Whatever a server answers, a call returns an answer of the right shape or raises CorruptReply."""
import functools

import numpy as np
import pytest

import liar
import stiefel
from client_calls import REQUESTS, by_name
from every_call import STREAMS
from stiefel import v1 as pb

SCENE = {"system": "rigid_body", "method": {"name": "variational"}, "step": 0.01,
         "body": {"moments": [1, 2, 3], "angular_velocity": [0.1, 2, 0.1]}}
ENSEMBLE = {**SCENE, "members": 2, "body": {"moments": [1, 2, 3], "angular_velocity": [[0.1, 2, 0.1], [1, 2, 3]]}}
STATISTICS = {"energy": ["drift", {"quantiles": [0.5]}], "M": ["last", "sign_changes", {"edges": [-9, 0, 9]}]}
ZEROS = {"field": "angular_velocity", "coefficients": [1, 0, 0]}


def drive(session):
    with session.drive("Q") as steps:
        return [steps.step(k) for k in (3, 5)]


CALLS = {  # the RPC, and a call with an answer that can be compared
    "describe": ("Describe", lambda c, s: c.describe()),
    "create": ("CreateSession", lambda c, s: c.create(SCENE, id="lied-about").scene),
    "get": ("GetSession", lambda c, s: c.get("lied-about").scene),
    "list": ("ListSessions", lambda c, s: [one.id for one in c.list()]),
    "delete": ("DeleteSession", lambda c, s: c.delete("nobody")),
    "fork": ("ForkSession", lambda c, s: s.fork(at=3, id="forked", step=0.02).scene),
    "step": ("Step", lambda c, s: s.step(to=5, fields=["Q", "quaternion"], checkpoint=True)),
    "drive": ("Drive", lambda c, s: drive(s)),
    "stream": ("Stream", lambda c, s: s.trajectory(to=100, every=7, fields=["Q", "M"])),
    "diagnose": ("Diagnose", lambda c, s: s.diagnose(to=5, estimate_error=True, symplectic=True)),
    "convert": ("Convert", lambda c, s: c.convert(SCENE, "symmetric_rigid_body")),
    "velocity": ("Convert", lambda c, s: c.convert(SCENE, "velocity")),
    "connect": ("Connect", lambda c, s: c.geodesic([1, 2, 3], [[1, 0, 0]], [[0, 0.6, 0.8]], samples=3)),
    "conjugate points": ("ConjugatePoints", lambda c, s: c.conjugate_points([1, 2, 3], [[1, 0, 0]], [[0, 1, 0.5]], time=9)),
    "radius": ("ConjugatePoints", lambda c, s: c.injectivity_radius([1, 2, 3], 1, starts=1)),
    "tradeoff": ("MeasureTradeoff", lambda c, s: c.tradeoff(SCENE, horizon=0.05, budget=1e7, repeats=1)),
    "summarize": ("Summarize", lambda c, s: s.summarize(100, STATISTICS)),
    "events": ("Summarize", lambda c, s: s.events(300, ZEROS, fields="angular_velocity")),
    "lyapunov": ("LyapunovSpectrum", lambda c, s: s.lyapunov(to=40, every=20, interval=1)),
    "linearize": ("Linearize", lambda c, s: s.state_transition(to=20, every=10, inertia=True)),
    "times": ("Summarize", lambda c, s: s.trajectory(times=[0.123, 0.02, 0.5], fields="Q")),
}
CALLS |= {rpc: (rpc, functools.partial(by_name, rpc=rpc, request=requests[0])) for rpc, requests in REQUESTS.items()
          if rpc not in {rpc for rpc, _ in CALLS.values()}}
MAY_BE_EMPTY = ("ListSessions", "DeleteSession")


@pytest.fixture(scope="module")
def served(tmp_path_factory):
    with stiefel.Server.start() as right, stiefel.Client(right.address) as client:
        lies, server, address = liar.serve(tmp_path_factory.mktemp("liar"), right.address)
        client.create(SCENE, id="lied-about")
        client.create(ENSEMBLE, id="of-members")
        yield lies, address
        server.stop(None)


@pytest.mark.parametrize("call", CALLS)
def test_a_lie_is_told_as_one(served, call):
    lies, address = served
    method, make = CALLS[call]
    kind = getattr(pb, f"{method}Response")
    streams = method in STREAMS
    with stiefel.Client(address) as client:
        lies.truth()
        session = client.get("lied-about")
        lies.truth()
        make(client, session)
        told = lies.told[method]
        for index in sorted({0, 1, len(told) - 1} & set(range(len(told)))):
            for name, instead in liar.lies(told[index], kind):
                if name == "twice" and not streams or name == "absent" and method == "Drive":
                    continue  # gRPC waits for the end of the call, which no deadline brings in a Drive
                lies.lie(method, index, instead)
                try:
                    make(client, session)
                    assert name != "garbage" and (name != "empty" or method in MAY_BE_EMPTY), f"{index}: {name}"
                except stiefel.CorruptReply:
                    pass
                except stiefel.FailedPrecondition:  # which says that the run to the fork's step has stopped
                    assert call == "fork" and name.startswith("run_status.outcome")


@pytest.mark.parametrize("call", [
    lambda s: s.trajectory(to=20, every=3, fields="Q"), lambda s: s.trajectory(times=[0.05, 0.1]),
    lambda s: s.summarize(20, STATISTICS), lambda s: s.step(to=7), lambda s: s.events(300, ZEROS),
], ids=["stream", "times", "summarize", "step", "events"])
def test_shapes_of_an_ensemble(served, call):
    """Its arrays have one axis more, on which the members are."""
    lies, address = served
    with stiefel.Client(address) as client:
        lies.truth()
        session = client.get("of-members")
        lies.truth()
        right = call(session)
        (method, told), = ((method, list(told)) for method, told in lies.told.items() if method != "GetSession")
        for index, reply in enumerate(told):
            for name, instead in liar.lies(reply, getattr(pb, f"{method}Response")):
                if name.rpartition(".")[2].split()[0] not in ("shape", "whole_shape", "data_type", "data", "members") \
                        or name.endswith("members other"):  # another member's number is a number
                    continue
                lies.lie(method, index, instead)
                try:
                    assert call(session) == right, name
                except stiefel.CorruptReply:
                    pass


@pytest.mark.parametrize("call", [lambda s: s.step(to=5), lambda s: s.drive().step(5), lambda s: s.trajectory(to=5),
                                  lambda s: s.trajectory(times=[0.05])], ids=["step", "drive", "stream", "times"])
def test_a_field_that_nobody_named_is_missed_too(served, call):
    """Without names there are those of `body`: a reply without one of them is incomplete."""
    lies, address = served
    with stiefel.Client(address) as client:
        lies.truth()
        session = client.get("lied-about")
        lies.truth()
        assert set(call(session).fields) == {"quaternion", "angular_velocity"}
        (method, told), = ((method, list(told)) for method, told in lies.told.items() if method != "GetSession")
        reply = getattr(pb, f"{method}Response").FromString(told[0])
        fields = {"Step": lambda: reply.sample.fields, "Drive": lambda: reply.step.sample.fields, "Stream": lambda: reply.fields,
                  "Summarize": lambda: reply.states.fields}[method]()
        del fields[0]
        lies.lie(method, 0, [reply.SerializeToString()])
        with pytest.raises(stiefel.CorruptReply, match="it has the fields"):
            call(session)


def test_a_conversion_that_is_cut(tmp_path, served):
    """Its blocks have 2 MiB each, and come in messages of their own."""
    lies, address = served
    n = 512
    M = np.zeros((n, n))
    M[0, 1] = 1
    scene = {"system": "rigid_body", "method": {"name": "rk4"}, "step": 0.01, "inertia": np.linspace(1, 2, n),
             "initial": {"Q": np.eye(n), "M": M - M.T}}
    with stiefel.Client(address) as client:
        lies.truth()
        right = client.convert(scene, "velocity")
        told = lies.told["Convert"]
        assert len(told) > 1 and set(right.blocks) == {"Q", "Qdot"}
        for index in range(len(told)):
            lies.lie("Convert", index, [])
            with pytest.raises(stiefel.CorruptReply):
                client.convert(scene, "velocity")
