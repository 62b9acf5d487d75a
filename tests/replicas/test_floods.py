"""Floods that take a bare server's memory or processor time (tests/server/attack/floods.py), sent through the proxies of
docker/: other clients are served as before, and the servers need no more memory."""
from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stiefel
from conftest import LONG, long
from stiefel._wire import failures

FLOODS = Path(__file__).parents[1] / "server/attack/floods.py"
NAMES = ["continuations", "large_continuations", "resets", "metadata", "calls", "settings"]
CONNECTIONS = 16 if LONG else 4
SECONDS = 10 if LONG else 2
SCENE = {"system": "rigid_body", "step": 0.05, "body": {"moments": [1, 2, 3], "angular_velocity": [0.1, 1, 0.2]}}
MIB = 1 << 20


def resident(pid: int) -> int:
    return int(Path(f"/proc/{pid}/statm").read_text().split()[1]) * os.sysconf("SC_PAGESIZE")


def wait_until_they_rest(cluster: Any) -> None:
    """Until the servers take no more processor time than their health checks."""
    def taken() -> float:
        return sum(time.clock_gettime(~replica.child.pid << 3 | 2) for replica in cluster.replicas)
    more = 1.0
    while more > 0.1:
        before = taken()
        time.sleep(1)
        more = taken() - before


class Steps:
    """A client that steps several sessions, one after another."""

    def __init__(self, client: stiefel.Client):
        self._sessions = [client.create(SCENE) for _ in range(6)]
        self._expected = self._sessions[0].step(100, fields="Q")["Q"].tobytes()

    def p99(self, holds: Any) -> float:
        """Seconds that a Step takes at most in 99 % of the calls, while `holds()`."""
        seconds = []
        while holds():
            for session in self._sessions:
                begin = time.monotonic()
                state = session.step(100, fields="Q")
                seconds.append(time.monotonic() - begin)
                assert state["Q"].tobytes() == self._expected
                time.sleep(0.002)
        return float(np.percentile(seconds, 99))

    def p99_in(self, seconds: float) -> float:
        end = time.monotonic() + seconds
        return self.p99(lambda: time.monotonic() < end)


@pytest.mark.parametrize("proxy", ["haproxy", pytest.param("envoy", marks=long)])
def test_a_flood_is_no_matter_of_others(proxy: str, make_cluster: Any) -> None:
    cluster = make_cluster(proxy)
    children = [replica.child for replica in cluster.replicas]
    with stiefel.Client(cluster.address) as client:
        steps = Steps(client)
        before = [resident(child.pid) for child in children]
        for name in NAMES:
            # A busy machine may be slow in one of three floods; a flood that reaches the servers makes it so in all of them.
            for attempt in range(3):
                quiet = steps.p99_in(SECONDS)
                # With a lower priority: it stands for another machine, which has processors of its own.
                with subprocess.Popen(["nice", "-n", "5", sys.executable, FLOODS, name, cluster.address, str(SECONDS),
                                       str(CONNECTIONS)], stdout=subprocess.PIPE, text=True) as flood:
                    p99 = steps.p99(lambda: flood.poll() is None)
                    opened, sent = map(int, flood.communicate()[0].split())
                more = max(resident(child.pid) - old for child, old in zip(children, before))
                print(f"{proxy}, {name}: p99 {1e3 * p99:.1f} ms (quiet {1e3 * quiet:.1f}), {more / MIB:+.0f} MiB; "
                      f"{opened} connections, {sent / 1e6:.0f} MB")
                assert sent > 10_000, "the flood was one"
                assert more < 32 * MIB, name
                assert [child.poll() for child in children] == [None] * len(children), name
                # SETTINGS and PINGs take processor time of the proxy, for which HAProxy 2.6 has no limit.
                if name == "settings" or p99 < max(0.1, 10 * quiet):
                    break
            else:
                pytest.fail(f"{name}: p99 {p99:.3f} s, without a flood {quiet:.3f} s")
    assert cluster.proxy.poll() is None


@pytest.mark.parametrize("proxy", ["haproxy", pytest.param("envoy", marks=long)])
def test_streams_that_nobody_reads_stop_no_other_call(proxy: str, make_cluster: Any) -> None:
    """Neither of their own client nor of another one, and the proxy holds little for each of them."""
    cluster = make_cluster(proxy)
    before, requests = resident(cluster.proxy.pid), stiefel.v1.StreamRequest
    with stiefel.Client(cluster.address) as client, stiefel.Client(cluster.address) as other:
        sessions = [client.create(SCENE) for _ in range(6)]
        unread = [client._stub.Stream(requests(session_id=session.id, to=10**12), metadata=[("stiefel-session", session.id)],
                                      timeout=120) for session in sessions * 15]
        for stream in unread:
            assert next(stream).steps[0] == 0
        wait_until_they_rest(cluster)  # all buffers on the way are full
        for session in sessions:
            expected = session.step(100, fields="Q", timeout=60)["Q"].tobytes()
            assert other.get(session.id).step(100, fields="Q", timeout=60)["Q"].tobytes() == expected
        each = (resident(cluster.proxy.pid) - before) / len(unread)
        print(f"{proxy}: {each / MIB:.2f} MiB for each of {len(unread)} streams")
        assert each < 2 * MIB
        for stream in unread:
            stream.cancel()


@pytest.mark.parametrize("proxy", ["haproxy", pytest.param("envoy", marks=long)])
def test_a_client_that_calls_too_often_is_told_when_to_come_back(proxy: str, make_cluster: Any) -> None:
    """Its client comes back by itself, so that no call is lost; without one it reads a RetryInfo."""
    cluster = make_cluster(proxy)
    request = stiefel.v1.DescribeRequest()
    with stiefel.Client(cluster.address) as client:
        refusals: list[Any] = []
        end = time.monotonic() + 60
        while not refusals and time.monotonic() < end:
            many = [client._stub.ListSessions.future(stiefel.v1.ListSessionsRequest()) for _ in range(2000)]
            refusals = [error for call in many if (error := call.exception())]
        if not refusals:
            pytest.skip("this machine makes fewer calls a second than the proxy admits")
        error = failures.from_rpc_error(refusals[0])
        assert isinstance(error, stiefel.ResourceExhausted) and error.retry_delay == 0.25
        assert client._connection.call("Describe", request).version
