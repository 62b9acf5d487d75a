"""--principal-memory: what does not fit is refused to its principal alone, and every stored session is restored."""
import grpc
import numpy as np
import pytest

import stiefel
from conftest import eventually
from stiefel import v1 as pb
from stiefel._wire.failures import from_status
from test_two_principals import Caller, token


def refusal(call):
    """What the call is refused with; none if it is not."""
    try:
        call()
    except grpc.RpcError as error:
        return from_status(pb.Status.FromString(dict(error.trailing_metadata())["grpc-status-details-bin"]))
    return None


def fill(caller):
    """Creates sessions until one is refused: their number, and the refusal."""
    for number in range(10_000):
        error = refusal(lambda: caller.create(str(number), 0.01))
        if error:
            return number, error
    raise AssertionError("nothing was refused")


@pytest.fixture
def principals(serve, tmp_path):
    (alices, her_line), (bobs, his_line) = token("alice"), token("bob")
    (tmp_path / "tokens").write_text(f"{her_line}\n{his_line}\n")
    arguments = ("--tokens", str(tmp_path / "tokens"), "--log-level", "off", "--max-sessions", "100000")

    def start(*more):
        process = serve(*arguments, *more)
        return process, Caller(process.address, alices), Caller(process.address, bobs)
    return start


def test_a_principal_is_refused_alone(principals):
    _, alice, bob = principals("--principal-memory", "1M")
    made, error = fill(alice)
    assert 10 < made < 1000
    assert isinstance(error, stiefel.ResourceExhausted) and error.reason == "OVER_QUOTA"
    assert error.quota[0].field == "principal_memory" and error.retry_delay == 1
    large = stiefel.to_message({"system": "rigid_body", "inertia": list(range(1, 65)), "step": 0.01,
                                "method": {"name": "variational", "order": 8},
                                "initial": {"Q": np.eye(64), "M": np.zeros((64, 64))}})
    never = refusal(lambda: bob.call("CreateSession", pb.CreateSessionRequest(session_id="large", scene=large)))
    assert never.quota[0].field == "principal_memory" and not never.retry_delay, "to wait does not help"
    assert bob.create("0", 0.01).created
    # Its own caches are given up: each session still steps.
    assert all(eventually(lambda: refusal(lambda: alice.bits(str(number))) is None) for number in range(0, made, 5))
    alice.call("DeleteSession", pb.DeleteSessionRequest(session_id="0"))
    assert eventually(lambda: refusal(lambda: alice.create("new", 0.01)) is None), "the bytes are given back"


def test_restored_sessions_count_and_are_all_restored(principals, tmp_path):
    store = ("--store", str(tmp_path / "store"))
    process, alice, _ = principals(*store)
    for number in range(60):
        alice.create(str(number), 0.01)
    process.child.kill()
    process.stop()
    process, alice, bob = principals(*store, "--principal-memory", "1M")
    assert len(alice.ids()) == 60
    more, _ = next((k, e) for k in range(10_000) if (e := refusal(lambda: alice.create(f"m{k}", 0.01))))
    alone, _ = fill(bob)
    assert more <= alone - 50
    process.child.kill()
    process.stop()
    _, alice, _ = principals(*store, "--principal-memory", "50K")
    assert len(alice.ids()) == 60 + more
    assert refusal(lambda: alice.create("one more", 0.01)).quota[0].field == "principal_memory"
