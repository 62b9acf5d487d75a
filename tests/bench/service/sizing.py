"""Measures the processor time that a server takes for a call, by which a machine for a load is chosen.

    PYTHONPATH=build/release/python STIEFEL_SERVER=build/release/bin/stiefel-server /usr/bin/python3 tests/bench/service/sizing.py

The time is that of the server's process, in user and system mode, for calls made one after the other. Other programs on
the machine change it little. Prints the median of five rounds and the calls that a core can answer in a second.
"""
from __future__ import annotations

import statistics
import sys
import time
from pathlib import Path
from typing import Callable

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "server"))

import stiefel  # noqa: E402
from conftest import Process  # noqa: E402

ROUNDS = 5
BODY = {"system": "rigid_body", "step": 0.01, "body": {"moments": [1, 2, 3], "angular_velocity": [0.1, 1, 0.2]}}
VARIATIONAL = {**BODY, "method": {"name": "variational"}}


def processor_seconds(pid: int) -> float:
    """The processor time of a process and all of its threads: Linux numbers the clock of a process so."""
    return time.clock_gettime((~pid << 3) | 2)


def of_a_call(process: Process, calls: Callable[[], int]) -> float:
    """The server's processor time for one of the calls that `calls` makes and counts, in seconds."""
    found = []
    for _ in range(ROUNDS + 1):
        begun = processor_seconds(process.child.pid)
        count = calls()
        found.append((processor_seconds(process.child.pid) - begun) / count)
    return statistics.median(found[1:])  # without the round that warms up


def steps(session: stiefel.Session, by: int, count: int = 2000) -> Callable[[], int]:
    at = 0

    def calls() -> int:
        nonlocal at
        for _ in range(count):
            at += by
            session.step(to=at)
        return count
    return calls


def drives(session: stiefel.Session, count: int = 5000) -> Callable[[], int]:
    at = 0

    def calls() -> int:
        nonlocal at
        with session.drive() as drive:
            for _ in range(count):
                at += 1
                drive.step(at)
        return count
    return calls


def lives(client: stiefel.Client, count: int = 500) -> Callable[[], int]:
    def calls() -> int:
        for _ in range(count):
            with client.create(BODY) as session:
                session.step(to=1)
        return count
    return calls


def streams(session: stiefel.Session, count: int = 200_000) -> Callable[[], int]:
    at = 0

    def calls() -> int:
        nonlocal at
        for batch in session.stream(to=at + count, start=at, every=1):
            at = int(batch.step[-1])
        return count
    return calls


def main() -> None:
    process = Process("--log-level", "off")
    with stiefel.Client(process.address) as client:
        session, stepped = client.create(BODY), client.create(VARIATIONAL)
        kinds = {"Step, any step of the closed form": steps(session, 1), "Step by 1000 of variational": steps(stepped, 1000, 500),
                 "Drive, one request": drives(client.create(BODY)), "CreateSession, Step and DeleteSession": lives(client),
                 "Stream, one sample of variational": streams(client.create(VARIATIONAL))}
        print(f"{'call':<40}{'processor time':>16}{'a second a core':>18}")
        for name, calls in kinds.items():
            seconds = of_a_call(process, calls)
            print(f"{name:<40}{seconds * 1e6:>13.2f} µs{1 / seconds:>18,.0f}")
    process.stop()


if __name__ == "__main__":
    main()
