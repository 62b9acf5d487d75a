"""A connection from which nothing comes any more, though nobody closed it: the client notices within 30 s, and the calls go
on over another connection. (programs/connections_test.cc has the server's side.)"""
import contextlib
import threading
import time

import stiefel
from conftest import BODY, eventually
from fault_socket import FaultSocket, Hole

NOTICED = 30.0
ENDLESS = range(10**9)


def drives(client, session):
    with session.drive() as drive:
        yield from (drive.step(to=k) for k in ENDLESS)


USES = {  # iterators over answers
    "Step": lambda client, session: (session.step(to=k) for k in ENDLESS),
    "Drive": drives,
    "Summarize": lambda client, session: (session.summarize(10**5, quantities={"energy": ["last"]}) for _ in ENDLESS),
    "Stream": lambda client, session: session.stream(2_000_000_000, every=1000),
    "GetSession": lambda client, session: (client.get(session.id) for _ in ENDLESS),
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


def test_the_python_client_goes_on_over_another_connection(serve):
    """All kinds of calls at once, and a client that is idle when its connection is swallowed."""
    process, hole, over = serve("--log-level", "error"), Hole(), threading.Event()
    with FaultSocket(process.address, hole) as between, stiefel.Client(between.address, timeout=120) as client:
        callers = [Caller(between.address, use, over) for use in USES.values()]
        for caller in callers:
            caller.start()
        idle = client.create(BODY)
        assert eventually(lambda: all(caller.answered for caller in callers), 60)
        hole.swallow()
        begun = time.monotonic()
        arrived = begun + 2  # what was on its way
        assert idle.step(to=3).step == 3
        eventually(lambda: all(caller.answered > arrived for caller in callers), begun + NOTICED - time.monotonic())
        assert [caller.answered > arrived for caller in callers] == [True] * len(callers), list(USES)
        print(f"all calls go on after {time.monotonic() - begun:.1f} s")
        over.set()
        for caller in callers:
            caller.join(60)
        assert [caller.error for caller in callers] == [None] * len(callers)
