"""Toxiproxy between client and server: the right answer or a typed error, never a wrong or a missing sample."""
from __future__ import annotations

import contextlib
import random
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stiefel
import tools
from toxiproxy import Toxiproxy

sys.path.insert(0, str(Path(__file__).parents[1] / "calls"))
from client_calls import CALLS  # noqa: E402

TYPED = (stiefel.Unavailable, stiefel.DeadlineExceeded)
DELAYS = {
    "latency": {"latency": 40, "jitter": 20},
    "bandwidth": {"rate": 400},  # kB a second
    "slow_close": {"delay": 300},
    "slicer": {"average_size": 30, "size_variation": 20, "delay": 20},  # bytes, bytes, microseconds
}
ENDS = {
    "down": {"type": "down"},
    "timeout at once": {"type": "timeout", "timeout": 1},
    "timeout of 300 ms to the client": {"type": "timeout", "stream": "downstream", "timeout": 300},
    "timeout that never ends": {"type": "timeout", "stream": "upstream", "timeout": 0},
    "reset at once": {"type": "reset_peer", "stream": "downstream", "timeout": 0},
    "reset after 60 ms": {"type": "reset_peer", "stream": "downstream", "timeout": 60},
    "reset to the server after 20 ms": {"type": "reset_peer", "stream": "upstream", "timeout": 20},
    **{f"limit of {limit} bytes to the client": {"type": "limit_data", "stream": "downstream", "bytes": limit}
       for limit in (0, 100, 700, 5000, 60_000)},
    **{f"limit of {limit} bytes to the server": {"type": "limit_data", "stream": "upstream", "bytes": limit}
       for limit in (60, 900, 9000)},
    "half of the connections reset": {"type": "reset_peer", "stream": "downstream", "timeout": 5, "toxicity": 0.5},
}


@pytest.fixture(scope="module")
def toxiproxy(server: stiefel.Server) -> Iterator[Toxiproxy]:
    with Toxiproxy(tools.from_go("toxiproxy"), server.address) as toxiproxy:
        yield toxiproxy


@pytest.fixture(scope="module")
def answers(server: stiefel.Server) -> dict[str, Any]:
    """Without a proxy."""
    with stiefel.Client(server.address) as client:
        return {name: call(client, f"plain-{number}") for number, (name, call) in enumerate(CALLS.items())}


def id_of(*words: object) -> str:
    return "-".join(map(str, words)).replace(" ", "-")


@pytest.mark.parametrize("toxic", DELAYS)
def test_what_only_delays_fails_no_call(toxiproxy: Toxiproxy, answers: dict[str, Any], toxic: str) -> None:
    proxy = toxiproxy.proxy(type=toxic, **DELAYS[toxic])
    for name, call in CALLS.items():
        with stiefel.Client(proxy.address) as client:
            np.testing.assert_equal(call(client, id_of(toxic, name)), answers[name])


@pytest.mark.parametrize("toxic", ENDS)
def test_what_ends_connections_gives_the_answer_or_a_typed_error(toxiproxy: Toxiproxy, answers: dict[str, Any],
                                                                 toxic: str) -> None:
    """And once it is gone the client that met it has its answers."""
    proxy, failed = toxiproxy.proxy(**ENDS[toxic]), []
    with contextlib.ExitStack() as stack:
        clients = {}
        for name, call in CALLS.items():
            clients[name] = stack.enter_context(stiefel.Client(proxy.address, timeout=2.0))
            try:
                answer = call(clients[name], id_of(toxic, name))
            except TYPED as error:
                failed.append(name)
                assert error.message
            else:
                np.testing.assert_equal(answer, answers[name])
        print(f"{toxic}: {len(failed)} of {len(CALLS)} calls failed")
        if toxic in ("down", "timeout at once", "reset at once", "limit of 0 bytes to the client"):
            assert len(failed) == len(CALLS)
        proxy.heal()
        for name, call in CALLS.items():
            clients[name].timeout = 60.0
            np.testing.assert_equal(call(clients[name], id_of("healed", toxic, name)), answers[name])


def test_toxics_that_come_and_go_while_calls_run(toxiproxy: Toxiproxy, answers: dict[str, Any]) -> None:
    """Another toxic every 0.15 s, half of the time none."""
    proxy, choice, over = toxiproxy.proxy(), random.Random(16), threading.Event()
    toxics = [{"type": name, **attributes} for name, attributes in DELAYS.items()] + list(ENDS.values())

    def exchange() -> None:
        while not over.wait(0.15):
            proxy.heal()
            if choice.random() < 0.5:
                proxy.poison(**choice.choice(toxics))  # type: ignore[arg-type]
        proxy.heal()
    thread, right, failed = threading.Thread(target=exchange), 0, 0
    thread.start()
    try:
        with stiefel.Client(proxy.address, timeout=10.0) as client:
            for turn in range(20):
                for name, call in CALLS.items():
                    try:
                        answer = call(client, id_of("turn", turn, name))
                    except TYPED:
                        failed += 1
                    else:
                        right += 1
                        np.testing.assert_equal(answer, answers[name])
    finally:
        over.set()
        thread.join()
    print(f"{right} calls answered, {failed} failed")
    assert right > 10 * len(CALLS)
