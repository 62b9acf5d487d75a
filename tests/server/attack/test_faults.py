"""Every call through a socket that cuts, resets or swallows: the right answer or a typed error, never another."""
import time

import numpy as np
import pytest

import stiefel
from client_calls import CALLS, SCENE
from conftest import Process
from fault_socket import Ends, FaultSocket, plain

FAULTS = {
    **{f"{how} after {limit} bytes": Ends(how, limit)
       for how in ("reset", "close") for limit in (0, 60, 700, 5000, 60_000)},
    "silence after 0 bytes": Ends("silence", 0), "silence after 700 bytes": Ends("silence", 700),
}
# Where no connection works, every call waits for its retries: four calls show it.
FEW = ("Describe", "Step", "Stream", "Drive")
# A stream whose first message never comes takes all of its timeout: one of these faults shows it.
NO_STREAM = ("close after 5000 bytes", "reset after 60000 bytes", "close after 60000 bytes")
#: Seconds of a call, by the fault's first word, where it may end by its deadline; 60 otherwise.
PATIENCE = {"silence": 1, "reset": 5, "close": 5}


@pytest.fixture(scope="module")
def process():
    server = Process("--log-level", "error")
    yield server
    assert server.stop() == 0


@pytest.fixture(scope="module")
def answers(process):
    with stiefel.Client(process.address) as client:
        return {name: call(client, f"plain-{number}") for number, (name, call) in enumerate(CALLS.items())}


@pytest.mark.parametrize("fault", FAULTS)
def test_every_call_with_every_connection_faulty(process, answers, fault):
    """With silence a call ends at its deadline. After few bytes no call gets through, and each says so."""
    number = list(FAULTS).index(fault)
    failures = 0
    with FaultSocket(process.address, FAULTS[fault]) as between:
        for name, call in CALLS.items():
            if fault.endswith((" 0 bytes", " 60 bytes", " 700 bytes")) and name not in FEW:
                continue
            if name == "Stream" and fault in NO_STREAM:
                continue
            with stiefel.Client(between.address, timeout=PATIENCE.get(fault.split()[0], 60)) as client:
                try:
                    answer = call(client, f"{number}-{name.replace(' ', '-')}")
                except stiefel.StiefelError as error:
                    failures += 1
                    assert isinstance(error, (stiefel.Unavailable, stiefel.DeadlineExceeded)), error
                else:
                    np.testing.assert_equal(answer, answers[name])
    if fault.endswith(("after 0 bytes", "after 60 bytes")):
        assert failures > 0
    with stiefel.Client(process.address) as client:
        assert client.describe().numerics_id == answers["Describe"]


@pytest.mark.parametrize(("of_call", "of_client"), [(1.0, 60.0), (None, 1.0)])
def test_a_stream_whose_first_message_never_comes_ends_with_its_timeout(process, of_call, of_client):
    """However often its attempts fail, and whether the timeout is the call's or the client's."""
    with FaultSocket(process.address, Ends("close", 5000)) as between, \
         stiefel.Client(between.address, timeout=of_client) as client:
        session = client.create(SCENE, id=f"cut-{of_client:g}")
        begun = time.monotonic()
        with pytest.raises((stiefel.Unavailable, stiefel.DeadlineExceeded)):
            for _ in session.stream(to=4000, every=1, timeout=of_call):
                pass
        assert time.monotonic() - begun < 10


@pytest.mark.parametrize("limit", [0, 300, 900, 2500, 9000, 40_000])
@pytest.mark.parametrize("how", ["reset", "close"])
def test_a_call_whose_first_connections_break_is_answered(process, answers, how, limit):
    """The client makes a broken call again, and a stream goes on where it broke: no sample is missing or other.
    A broken measurement of a trade-off is an error: it takes minutes, and its caller decides."""
    for name, call in CALLS.items():
        if name == "MeasureTradeoff":
            continue
        with FaultSocket(process.address, Ends(how, limit), connections=2) as between, \
             stiefel.Client(between.address) as client:
            answer = call(client, f"{how}-{limit}-{name.replace(' ', '-')}")
            np.testing.assert_equal(answer, answers[name])


def test_a_server_that_goes_down_and_comes_back(answers):
    first = Process("--log-level", "error")
    with FaultSocket(first.address, plain) as between, stiefel.Client(between.address, timeout=10) as client:
        assert CALLS["Step"](client, "before").tolist() == answers["Step"].tolist()
        first.stop()
        with pytest.raises(stiefel.Unavailable):
            client._connection.call("Describe", stiefel.v1.DescribeRequest(), timeout=3)
        second = Process("--log-level", "error", listen=first.address)
        np.testing.assert_array_equal(CALLS["Step"](client, "after"), answers["Step"])
        assert second.stop() == 0
