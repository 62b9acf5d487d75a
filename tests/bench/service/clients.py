"""Counts the Steps of a body in three dimensions that a server answers to 1, 4 and 8 clients at once, a process each.

Arguments: address of the server, its number of threads, repeats, seconds of each.
"""
from __future__ import annotations

import json
import multiprocessing
import sys
import time

import stiefel

BODY = {"system": "rigid_body", "step": 0.05, "body": {"moments": [1, 2, 3], "angular_velocity": [0.1, 1, 0.2]}}


def calls(address: str, seconds: float, counts: multiprocessing.SimpleQueue) -> None:
    with stiefel.Client(address) as client, client.create(BODY) as session:
        step, end = 0, time.perf_counter() + seconds
        while time.perf_counter() < end:
            step += 1
            session.step(step)
        counts.put(step)


def calls_a_second(address: str, clients: int, seconds: float) -> float:
    context = multiprocessing.get_context("spawn")
    counts = context.SimpleQueue()
    processes = [context.Process(target=calls, args=(address, seconds, counts)) for _ in range(clients)]
    for process in processes:
        process.start()
    total = sum(counts.get() for _ in processes)
    for process in processes:
        process.join()
    return total / seconds


if __name__ == "__main__":
    address, threads, repeats, seconds = sys.argv[1], sys.argv[2], int(sys.argv[3]), float(sys.argv[4])
    for clients in (1, 4, 8):
        print(json.dumps({"name": f"Steps answered to {clients} clients by {threads} threads", "unit": "a second", "bound": None,
                          "values": [calls_a_second(address, clients, seconds) for _ in range(repeats)]}), flush=True)
