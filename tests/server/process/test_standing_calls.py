"""Calls of reflection, which need no token and stay open. Their number is limited."""
import threading

import grpc
import pytest

from conftest import eventually

REFLECT = "/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo"
REFLECTIONS = 16
POLLERS = 8  # threads of gRPC that wait for calls


def threads(process):
    with open(f"/proc/{process.child.pid}/status", encoding="ascii") as status:
        return next(int(line.split()[1]) for line in status if line.startswith("Threads"))


@pytest.mark.parametrize("count", [100])
def test_reflection_takes_few_threads(serve, count):
    process = serve("--log-level", "off")
    over = threading.Event()

    def requests():
        yield b"\x3a\x01*"
        over.wait(60)
    with process.channel() as channel:
        call = channel.stream_stream(REFLECT)
        assert b"stiefel" in next(call(iter([b"\x3a\x01*"]), timeout=60))
        before = threads(process)
        held = [call(requests(), timeout=60) for _ in range(count)]
        assert eventually(lambda: sum(one.done() for one in held) >= count - REFLECTIONS)
        assert threads(process) <= before + REFLECTIONS + POLLERS
        ends = {one.code() for one in held if one.done()}
        assert ends == {grpc.StatusCode.RESOURCE_EXHAUSTED}
        over.set()
