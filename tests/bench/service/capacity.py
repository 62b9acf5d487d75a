"""Measures the bytes of a server's memory that sessions, unread streams and connections take.

    PYTHONPATH=build/release/python STIEFEL_SERVER=build/release/bin/stiefel-server /usr/bin/python3 tests/bench/service/capacity.py [N ...]
"""
import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "server"))

import stiefel  # noqa: E402
from conftest import Process  # noqa: E402
from stiefel import v1 as pb  # noqa: E402
from stiefel.v1 import simulation_pb2_grpc as rpc  # noqa: E402


def resident(process):
    with open(f"/proc/{process.child.pid}/status", encoding="ascii") as status:
        return next(int(line.split()[1]) for line in status if line.startswith("VmRSS")) * 1024


def body(N):
    A = np.random.default_rng(1).normal(size=(N, N)) / N
    return {"system": "rigid_body", "step": 1e-3, "inertia": list(1 + np.arange(N) / N),
            "initial": {"M": A - A.T, "Q": np.eye(N)}}


def sessions_and_streams(N, sessions=500, streams=20):
    process = Process("--log-level", "off")
    with stiefel.Client(process.address) as client, process.channel() as channel:
        empty = resident(process)
        made = [client.create(body(N)) for _ in range(sessions)]
        full = resident(process)
        stub = rpc.SimulationServiceStub(channel)
        unread = [stub.Stream(pb.StreamRequest(session_id=made[0].id, to=10**12)) for _ in range(streams)]
        for stream in unread:
            next(stream)
        time.sleep(2)
        streaming = resident(process)
        for stream in unread:
            stream.cancel()
    process.stop()
    print(f"N = {N}: {(full - empty) / sessions:.0f} a session, {(streaming - full) / streams:.0f} a stream that nobody reads")


def connections(count=500):
    process = Process("--log-level", "off")
    empty = resident(process)
    speaking = [process.speaking()[0] for _ in range(count)]
    full = resident(process)
    silent = [process.connect() for _ in range(count)]
    time.sleep(0.5)
    print(f"{(full - empty) / count:.0f} a connection, {(resident(process) - full) / count:.0f} a silent one")
    del speaking, silent
    process.stop()


if __name__ == "__main__":
    connections()
    for dimension in map(int, sys.argv[1:] or ["3"]):
        sessions_and_streams(dimension)
