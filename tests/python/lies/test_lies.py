"""Whatever a server answers, a call returns an answer of the right shape or raises CorruptReply."""
import pytest

import liar
import stiefel
from stiefel import v1 as pb

SCENE = {"system": "rigid_body", "method": {"name": "variational"}, "step": 0.01,
         "body": {"moments": [1, 2, 3], "angular_velocity": [0.1, 2, 0.1]}}
ENSEMBLE = {**SCENE, "members": 2, "body": {"moments": [1, 2, 3], "angular_velocity": [[0.1, 2, 0.1], [1, 2, 3]]}}
STATISTICS = {"energy": ["drift", {"quantiles": [0.5]}], "M": ["last", "sign_changes", {"edges": [-9, 0, 9]}]}
ZEROS = {"field": "angular_velocity", "coefficients": [1, 0, 0]}
CALLS = {  # the RPC, and a call
    "describe": ("Describe", lambda c, s: c.describe()), "create": ("CreateSession", lambda c, s: c.create(SCENE, id="one").scene),
    "get": ("GetSession", lambda c, s: c.get("one").scene),
    "fork": ("ForkSession", lambda c, s: s.fork(at=3, id="forked", step=0.02).scene),
    "step": ("Step", lambda c, s: s.step(to=5, fields=["Q", "quaternion"])), "default": ("Step", lambda c, s: s.step(to=5)),
    "drive": ("Drive", lambda c, s: s.drive("Q").step(3)),
    "stream": ("Stream", lambda c, s: s.trajectory(to=100, every=7, fields=["Q", "M"])),
    "diagnose": ("Diagnose", lambda c, s: s.diagnose(to=5)),
    "convert": ("Convert", lambda c, s: c.convert(SCENE, system="velocity")),
    "connect": ("Connect", lambda c, s: c.geodesics([([[1, 0, 0]], [[0, 0.6, 0.8]])], inertia=[1, 2, 3], samples=3)[0]),
    "conjugate points": ("ConjugatePoints", lambda c, s: c.conjugate_points(inertia=[1, 2, 3], Q=[[1, 0, 0]], Qdot=[[0, 1, 0.5]], time=9)),
    "tradeoff": ("MeasureTradeoff", lambda c, s: c.tradeoff(SCENE, horizon=0.05, budget=1e7, repeats=1)),
    "summarize": ("Summarize", lambda c, s: s.summarize(100, quantities=STATISTICS)),
    "events": ("Summarize", lambda c, s: s.events(300, events=ZEROS, fields="angular_velocity")),
    "times": ("Summarize", lambda c, s: s.trajectory(times=[0.123, 0.02, 0.5], fields="Q")),
    "lyapunov": ("LyapunovSpectrum", lambda c, s: s.lyapunov(to=40, every=20, interval=1)),
    "linearize": ("Linearize", lambda c, s: s.linearize(to=20, every=10, inertia=True)),
}


@pytest.fixture(scope="module")
def served(tmp_path_factory):
    with stiefel.Server.start() as right, stiefel.Client(right.address) as client:
        lies, server, address = liar.serve(tmp_path_factory.mktemp("liar"), right.address)
        client.create(SCENE, id="one")
        client.create(ENSEMBLE, id="members")
        yield lies, address
        server.stop(None)


@pytest.mark.parametrize("call", CALLS)
@pytest.mark.parametrize("of", ["one", "members"])
def test_a_lie_is_told_as_one(served, call, of):
    """A message is missing, empty or garbage; an array has another shape, type or length; a step or an outcome is another."""
    lies, address = served
    method, make = CALLS[call]
    if of == "members" and (method not in ("Step", "Stream", "Summarize") or call == "stream"):
        pytest.skip("its arrays have no axis of members")
    with stiefel.Client(address) as client:
        lies.lie()
        session = client.get(of)
        lies.lie()
        right, told = make(client, session), lies.told[method]
        for index in sorted({0, 1, len(told) - 1} & set(range(len(told)))):
            for name, instead in liar.lies(told[index], getattr(pb, f"{method}Response")):
                if name == "absent" and method == "Drive":
                    continue  # gRPC waits for the end of the call, which no deadline brings in a Drive
                lies.lie(method, index, instead)
                try:
                    found = make(client, session)
                except (stiefel.CorruptReply, stiefel.FailedPrecondition):  # which says that the run to a fork has stopped
                    continue
                assert name not in ("garbage", "empty"), f"{index}: {name}"
                if name.rpartition(".")[2].split()[0] in ("shape", "data_type") and hasattr(right, "fields"):
                    assert {k: v.shape for k, v in found.fields.items()} == {k: v.shape for k, v in right.fields.items()}, name
