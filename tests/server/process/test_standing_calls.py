"""Calls without a token that stay open: health's Watch and reflection. Their number is limited."""
import threading

import grpc
import pytest

from conftest import eventually

WATCH = "/grpc.health.v1.Health/Watch"
REFLECT = "/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo"
OF_CONNECTION, LEAST_OF_SERVER, REFLECTIONS = 16, 64, 16


def connection(process, number):
    """A channel with a connection of its own."""
    return process.channel(options=[("grpc.use_local_subchannel_pool", 1), ("number", number)])


def watch(channel):
    """The call if it was answered, else the status with which it was refused."""
    call = channel.unary_stream(WATCH)(b"", timeout=60)
    try:
        assert next(call) == b"\x08\x01"
    except grpc.RpcError as error:
        return error.code()
    return call


def refusals(calls):
    return [call for call in calls if isinstance(call, grpc.StatusCode)]


def test_watches_of_a_connection(serve):
    process = serve("--log-level", "off")
    with connection(process, 0) as one, connection(process, 1) as other:
        calls = [watch(one) for _ in range(OF_CONNECTION + 3)]
        assert refusals(calls) == [grpc.StatusCode.RESOURCE_EXHAUSTED] * 3
        assert not refusals([watch(other)])
        calls[0].cancel()
        assert eventually(lambda: not refusals([watch(one)]))


def test_watches_of_all_connections(serve):
    process = serve("--log-level", "off", "--memory", "64M")
    channels = [connection(process, number) for number in range(6)]
    calls = [watch(channel) for channel in channels for _ in range(OF_CONNECTION)]
    assert refusals(calls) == [grpc.StatusCode.RESOURCE_EXHAUSTED] * (len(calls) - LEAST_OF_SERVER)
    channels[0].close()
    assert eventually(lambda: not refusals([watch(channels[-1])]))
    for channel in channels:
        channel.close()


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
        assert threads(process) <= before + REFLECTIONS
        ends = {one.code() for one in held if one.done()}
        assert ends == {grpc.StatusCode.RESOURCE_EXHAUSTED}
        over.set()
