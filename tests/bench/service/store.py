"""Measures what `--store` costs: sessions created per second, and Step's p50, compared with the same server in memory.

    PYTHONPATH=build/release/python STIEFEL_SERVER=build/release/bin/stiefel-server /usr/bin/python3 tests/bench/service/store.py [FOLDER]

FOLDER: where the store is created, on the disk to measure. The two servers take turns, and the medians of
the pairs are printed. The fsync line is the time of one synchronized write of 4 KiB on that disk.
"""
import os
import statistics
import sys
import tempfile
import threading
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "server"))

import stiefel  # noqa: E402
from conftest import BODY, Process  # noqa: E402
from stiefel import v1 as pb  # noqa: E402
from stiefel.v1 import simulation_pb2_grpc as rpc  # noqa: E402

PAIRS, SESSIONS, STEPS = 9, 1000, 1000


def fsync_seconds(folder, count=50):
    with open(os.path.join(folder, "fsync"), "wb", buffering=0) as file:
        times = []
        for _ in range(count):
            file.write(b"\0" * 4096)
            start = time.perf_counter()
            os.fsync(file.fileno())
            times.append(time.perf_counter() - start)
    return statistics.median(times)


def creations_a_second(process, name, at_once):
    """Returns how many sessions are created per second with `at_once` calls in flight."""
    with process.channel() as channel:
        stub, left = rpc.SimulationServiceStub(channel), threading.Semaphore(at_once)
        scene, calls = stiefel.to_message(BODY), []
        start = time.perf_counter()
        for number in range(SESSIONS if at_once > 1 else SESSIONS // 5):
            left.acquire()
            call = stub.CreateSession.future(pb.CreateSessionRequest(session_id=f"{name}-{number}", scene=scene))
            call.add_done_callback(lambda _: left.release())
            calls.append(call)
        for call in calls:
            call.result()
        rate = len(calls) / (time.perf_counter() - start)
        for call in [stub.DeleteSession.future(pb.DeleteSessionRequest(session_id=f"{name}-{number}"))
                     for number in range(len(calls))]:
            call.result()
    return rate


def step_p50(process):
    with process.channel() as channel:
        stub = rpc.SimulationServiceStub(channel)
        stub.CreateSession(pb.CreateSessionRequest(session_id="p50", scene=stiefel.to_message(BODY)))
        times = []
        for to in range(STEPS):
            start = time.perf_counter()
            stub.Step(pb.StepRequest(session_id="p50", to=to))
            times.append(time.perf_counter() - start)
    return statistics.median(times)


def main(folder):
    with tempfile.TemporaryDirectory(dir=folder) as made:
        print(f"fsync: {1e6 * fsync_seconds(made):.0f} µs")
        memory = Process("--log-level", "off", "--max-sessions", "100000")
        store = Process("--log-level", "off", "--max-sessions", "100000", "--store", os.path.join(made, "store"))
        try:
            for at_once in (1, 16, 256):
                rates = [(creations_a_second(memory, f"{at_once}-{pair}", at_once),
                          creations_a_second(store, f"{at_once}-{pair}", at_once)) for pair in range(PAIRS)]
                print(f"CreateSession, {at_once} at once: {statistics.median(m for m, _ in rates):.0f} /s in memory, "
                      f"{statistics.median(s for _, s in rates):.0f} /s in a store")
            p50 = [(step_p50(memory), step_p50(store)) for _ in range(PAIRS)]
            print(f"Step, p50: {1e6 * statistics.median(m for m, _ in p50):.0f} µs in memory, "
                  f"{1e6 * statistics.median(s for _, s in p50):.0f} µs with a store, "
                  f"{statistics.median(s / m for m, s in p50):.2f} × (median of {PAIRS} pairs)")
        finally:
            memory.stop()
            store.stop()


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else None)
