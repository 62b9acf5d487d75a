"""A client that is closed while its calls rest, or soon after."""
import threading
import time

import pytest

import fake
import stiefel


@pytest.fixture
def service(tmp_path):
    service, server, address = fake.serve(tmp_path)
    service.address = address
    yield service
    server.stop(None)


def test_to_close_wakes_a_call_that_rests(service):
    client = stiefel.Client(service.address, timeout=None)
    session = client.get("fake")
    service.failures = [fake.refusal(100.0)]
    threading.Timer(0.3, client.close).start()
    begun = time.monotonic()
    with pytest.raises(stiefel.Closed):
        session.step(to=5)
    assert time.monotonic() - begun < 50


def test_a_closed_connection_rests_no_more(service):
    with stiefel.Client(service.address) as client:
        pass
    begun = time.monotonic()
    client._connection.rest(100.0)
    assert time.monotonic() - begun < 50
