"""What takes longer than 50 µs runs on the threads that compute, and not on those that serve connections."""
import os

import pytest

import stiefel
from conftest import BODY, SANITIZED
from stiefel import v1 as pb
from stiefel.v1 import simulation_pb2_grpc as rpc

pytestmark = pytest.mark.skipif(SANITIZED, reason="processor time with a sanitizer says nothing")


def seconds(process):
    """The processor time of the threads that compute, and of all others."""
    compute = others = 0.0
    folder = f"/proc/{process.child.pid}/task"
    for task in os.listdir(folder):
        try:
            with open(f"{folder}/{task}/comm", encoding="ascii") as comm, open(f"{folder}/{task}/schedstat", encoding="ascii") as stat:
                name, used = comm.read().strip(), int(stat.read().split()[0]) / 1e9
        except FileNotFoundError:  # the thread has ended
            continue
        if name == "compute":
            compute += used
        else:
            others += used
    return compute, others


def used(process, call, times):
    """The seconds of one call, by both kinds of thread."""
    before = seconds(process)
    for _ in range(times):
        call()
    return [(now - then) / times for now, then in zip(seconds(process), before)]


def test_lists_are_made_by_the_threads_that_compute(serve):
    process = serve("--log-level", "off", "--threads", "2")
    with stiefel.Client(process.address) as client, process.channel() as channel:
        for number in range(499):
            client.create(BODY, id=f"s{number}")
        stub = rpc.SimulationServiceStub(channel)
        made = sent = of_few = 0.0
        for _ in range(10):  # alternately, so that other load on the machine changes all of them alike
            of_few += used(process, lambda: stub.ListSessions(pb.ListSessionsRequest(page_size=17)), 20)[1]
            times = used(process, lambda: stub.ListSessions(pb.ListSessionsRequest(page_size=1000)), 20)
            made, sent = made + times[0], sent + times[1]
    assert sent - of_few < made / 3, "to send 32 kB that another core has made takes a fifth of making them"


def test_no_thread_polls_what_has_no_connections(serve):
    """gRPC's connections are in one set of descriptors."""
    process = serve("--log-level", "off")
    folder = f"/proc/{process.child.pid}/fd"
    assert sum("eventpoll" in os.readlink(f"{folder}/{each}") for each in os.listdir(folder)) == 1


def test_requests_are_read_by_the_threads_that_compute(serve):
    """400 000 faults in 0.8 MB."""
    process = serve("--log-level", "off", "--threads", "2")
    with stiefel.Client(process.address) as client, process.channel() as channel:
        client.create(BODY, id="s")
        raw = pb.DiagnoseRequest(session_id="s", dirac_brackets=[{"first": [{}] * 100_000}] * 4).SerializeToString()
        call = channel.unary_unary("/stiefel.v1.SimulationService/Diagnose")
        read, received = used(process, lambda: call.future(raw, timeout=60).exception(), 10)
    assert read > 3 * received, (read, received)
