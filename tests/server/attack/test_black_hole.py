"""A connection from which nothing comes any more, though nobody closed it: the client and the server notice within 30 s,
and the calls go on over another connection."""
import contextlib
import threading
import time

import stiefel
from conftest import BODY
from fault_socket import FaultSocket, Hole

NOTICED = 30.0
LAST = 2_000_000_000  # a step that no stream here reaches


def steps(client, session):
    for k in range(10**9):
        yield session.step(to=k)


def drives(client, session):
    with session.drive() as drive:
        for k in range(10**9):
            yield drive.step(to=k)


def summaries(client, session):
    while True:
        yield session.summarize(10**5, quantities={"energy": ["last"]})


USES = {
    "Step": steps, "Drive": drives, "Summarize": summaries,
    "Stream": lambda client, session: session.stream(LAST, every=1000),
    "GetSession": lambda client, session: (client.get(session.id) for _ in range(10**9)),
}


class Caller(threading.Thread):
    """Makes one kind of call over and over; `answered` is when the last answer came."""

    def __init__(self, address, use, over):
        super().__init__(daemon=True)
        self._address, self._use, self._over = address, use, over
        self.answered, self.error = 0.0, None

    def run(self):
        try:
            with stiefel.Client(self._address, timeout=120) as client, client.create(BODY) as session, \
                 contextlib.closing(iter(self._use(client, session))) as answers:
                for _ in answers:
                    self.answered = time.monotonic()
                    if self._over.wait(0.01):
                        return
        except Exception as error:  # which the test shows
            self.error = error


def lasts(callers, holds, limit):
    """Waits until `holds` of every caller, at most `limit` seconds, and returns of which it does not hold then."""
    end = time.monotonic() + limit
    while (left := [name for name, caller in callers.items() if not holds(caller)]) and time.monotonic() < end:
        time.sleep(0.05)
    return left


def test_the_python_client_goes_on_over_another_connection(serve):
    """All kinds of calls at once, and a client that is idle when its connection is swallowed."""
    process, hole, over = serve("--log-level", "error"), Hole(), threading.Event()
    with FaultSocket(process.address, hole) as between, stiefel.Client(between.address, timeout=120) as client:
        callers = {name: Caller(between.address, use, over) for name, use in USES.items()}
        for caller in callers.values():
            caller.start()
        idle = client.create(BODY)
        assert lasts(callers, lambda caller: caller.answered, 60) == []
        hole.swallow()
        begun = time.monotonic()
        arrived = begun + 2  # what was on its way
        assert idle.step(to=3).step == 3
        assert lasts(callers, lambda caller: caller.answered > arrived, begun + NOTICED - time.monotonic()) == []
        assert time.monotonic() - begun < NOTICED
        print(f"all calls go on after {time.monotonic() - begun:.1f} s")
        over.set()
        for caller in callers.values():
            caller.join(60)
        assert [caller.error for caller in callers.values()] == [None] * len(callers)


def test_the_server_ends_a_connection_whose_peer_is_gone_without_a_word(serve):
    connection, _ = serve("--log-level", "error").speaking()
    connection.settimeout(2 * NOTICED)
    begun = time.monotonic()
    while connection.recv(4096):  # settings and pings, which get no answer
        pass
    assert time.monotonic() - begun < NOTICED
