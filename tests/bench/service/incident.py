#!/usr/bin/env python3
"""Shows an incident in the metrics: three servers behind HAProxy are overloaded, then one of them is killed.

    PYTHONPATH=build/release/python STIEFEL_SERVER=build/release/bin/stiefel-server tests/bench/service/incident.py

Prints a table of what the panels of docker/grafana/dashboard.json show at the end of each phase, and the alerts that
fire. docs/operations.md explains it.
"""
from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import grpc

import stiefel
from stiefel import v1 as pb
from stiefel.v1 import simulation_pb2_grpc as rpc

TESTS = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(TESTS / "support"), str(TESTS / "replicas")]
from cluster import free_ports, start_haproxy, wait_for  # noqa: E402
from prometheus import Prometheus  # noqa: E402

BODY = {"system": "rigid_body", "step": 0.05, "body": {"moments": [1, 2, 3], "angular_velocity": [0.1, 1, 0.2]}}
CLIENTS, LONG_CALLS = 4, 24
QUERIES = {
    "servers up": 'sum(up{job="stiefel"})',
    "Step a second, OK": 'sum(rate(stiefel_calls_total{method="Step",code="OK"}[5s]))',
    "Step, median, ms": '1e3 * histogram_quantile(0.5, sum by (le) (rate(stiefel_call_seconds_bucket{method="Step"}[5s])))',
    "Step, 99 %, ms": '1e3 * histogram_quantile(0.99, sum by (le) (rate(stiefel_call_seconds_bucket{method="Step"}[5s])))',
    "computing, s/s": 'sum(rate(stiefel_computing_seconds_total[5s]))',
    "calls waiting, most": 'max(stiefel_calls_waiting)',
    "Steps running": 'sum(stiefel_calls_running{method="Step"})',
    "sessions": 'sum(stiefel_sessions)',
    "SESSION_NOT_FOUND a second": 'sum(rate(stiefel_refusals_total{reason="SESSION_NOT_FOUND"}[10s])) or vector(0)',
    "CANCELLED so far": 'sum(stiefel_calls_total{code="CANCELLED"})',
}


class Server:
    def __init__(self, port: int, metrics: int):
        self.arguments = ["--listen", f"127.0.0.1:{port}", "--metrics", f"127.0.0.1:{metrics}", "--threads", "2",
                          "--log-level", "warn", "--exit-with-parent"]
        self.start()

    def start(self) -> None:
        self.child = subprocess.Popen([os.environ["STIEFEL_SERVER"], *self.arguments], stdin=subprocess.PIPE,
                                      stdout=subprocess.DEVNULL)

    def kill(self) -> None:
        self.child.kill()
        self.child.wait()


class Stepping:
    """Clients that step their own sessions, with the calls that they lost and the longest one."""

    def __init__(self, address: str):
        self.address, self.lost, self.longest, self._stop = address, [], 0.0, threading.Event()
        self._threads = [threading.Thread(target=self._run) for _ in range(CLIENTS)]
        for thread in self._threads:
            thread.start()

    def _run(self) -> None:
        with stiefel.Client(self.address) as client:
            session = client.create(BODY)
            step = 0
            while not self._stop.is_set():
                step += 100
                begin = time.monotonic()
                try:
                    session.step(step)
                except stiefel.StiefelError as error:
                    self.lost.append(repr(error))
                self.longest = max(self.longest, time.monotonic() - begin)
                time.sleep(0.005)

    def stop(self) -> None:
        self._stop.set()
        for thread in self._threads:
            thread.join()


def long_calls(address: str) -> tuple[grpc.Channel, list[grpc.Future]]:
    """Starts Steps that take hours, each in its own session."""
    channel = grpc.insecure_channel(address)
    stub, calls = rpc.SimulationServiceStub(channel), []
    with stiefel.Client(address) as client:
        for _ in range(LONG_CALLS):
            session = client.create(BODY)
            calls.append(stub.Step.future(pb.StepRequest(session_id=session.id, to=10**12),
                                          metadata=[("stiefel-session", session.id)]))
    return channel, calls


def main() -> None:
    phases: dict[str, dict[str, float]] = {}
    alerts: dict[str, str] = {}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        *ports, local, tls = free_ports(8)
        servers = [Server(port, metrics) for port, metrics in zip(ports[:3], ports[3:])]
        prometheus = Prometheus(folder, [f"127.0.0.1:{port}" for port in ports[3:]])
        proxy = start_haproxy(folder, ports[:3], local, tls)
        for port in [*ports, local]:
            wait_for(port)
        time.sleep(1)
        address = f"127.0.0.1:{local}"

        def note(phase: str) -> None:
            phases[phase] = {title: sum(prometheus.values(query).values()) for title, query in QUERIES.items()}
            firing = prometheus.values('ALERTS{alertstate="firing"}')
            alerts[phase] = ", ".join(sorted({one.split('"alertname": "')[1].split('"')[0] for one in firing})) or "none"

        stepping = Stepping(address)
        time.sleep(15)
        note("quiet")
        stepping.longest = 0
        channel, calls = long_calls(address)
        time.sleep(75)
        note("overload")
        print(f"longest Step of a client in the overload: {1e3 * stepping.longest:.0f} ms")
        for call in calls:
            call.cancel()
        channel.close()
        time.sleep(12)
        note("cancelled")
        stepping.longest = 0
        servers[0].kill()
        time.sleep(5)
        note("killed, 5 s")
        print(f"longest Step of a client at the kill: {1e3 * stepping.longest:.0f} ms")
        time.sleep(15)
        note("killed, 20 s")
        servers[0].start()
        time.sleep(15)
        note("started again")
        stepping.stop()
        print(f"calls lost: {len(stepping.lost)} {stepping.lost[:2]}\n")
        for each in servers:
            each.kill()
        proxy.terminate()
        proxy.wait()
        prometheus.stop()
    print("| | " + " | ".join(phases) + " |\n" + "| --- " * (len(phases) + 1) + "|")
    for title in QUERIES:
        print(f"| {title} | " + " | ".join(f"{phases[phase][title]:.4g}" for phase in phases) + " |")
    print("| alerts | " + " | ".join(alerts[phase] for phase in phases) + " |")


if __name__ == "__main__":
    main()
