"""The services that gRPC tools expect: health, reflection, status codes."""
import platform
import subprocess
from pathlib import Path

import grpc
import pytest

from stiefel.v1 import simulation_pb2

ROOT = Path(__file__).parents[2]
SERVICE = "stiefel.v1.SimulationService"
METHODS = [method.name for method in simulation_pb2.DESCRIPTOR.services_by_name["SimulationService"].methods]


def raw(client, method, request, kind="unary_unary"):
    """Makes a call with a request of bytes, because these services have no stubs here."""
    call = getattr(client._channel, kind)(method)
    return call(iter([request]) if kind.startswith("stream") else request, timeout=10)


def check(client, service):
    return raw(client, "/grpc.health.v1.Health/Check", bytes([0x0a, len(service)]) + service.encode())


@pytest.mark.parametrize("service", ["", SERVICE])
def test_health_is_serving(client, service):
    assert check(client, service) == b"\x08\x01"  # HealthCheckResponse {status: SERVING}


def test_health_of_an_unknown_service(client):
    with pytest.raises(grpc.RpcError) as error:
        check(client, "no.such.Service")
    assert error.value.code() is grpc.StatusCode.NOT_FOUND


def test_health_watch_begins_with_the_present(client):
    replies = raw(client, "/grpc.health.v1.Health/Watch", b"", "unary_stream")
    assert next(replies) == b"\x08\x01"
    replies.cancel()


def test_reflection_lists_the_service(client):
    replies = raw(client, "/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo", b"\x3a\x01*",
                  "stream_stream")
    assert SERVICE.encode() in next(replies)


def test_a_method_that_does_not_exist(client):
    with pytest.raises(grpc.RpcError) as error:
        raw(client, f"/{SERVICE}/NoSuchMethod", b"")
    assert error.value.code() is grpc.StatusCode.UNIMPLEMENTED


@pytest.mark.parametrize("method", [name for name in METHODS if name != "Drive"])
def test_bytes_that_are_no_message(client, method):
    with pytest.raises(grpc.RpcError) as error:
        list(raw(client, f"/{SERVICE}/{method}", b"\xff" * 64, "unary_stream"))
    assert error.value.code() is grpc.StatusCode.INVALID_ARGUMENT
    assert error.value.details().startswith("request") and f"{method}Request" in error.value.details()
    assert check(client, "") == b"\x08\x01"


def test_the_build_names_what_decides_the_bits(client, tmp_path):
    """All of it goes into the numerics id: the sources as they are in this tree, the libraries, the options of the
    kernels for each instruction set too, and the C library."""
    header = tmp_path / "sources_digest.h"
    subprocess.run(["cmake", f"-DENGINE={ROOT / 'engine'}", f"-DOUTPUT={header}", "-P",
                    ROOT / "engine/sources_digest.cmake"], check=True)
    digest = header.read_text().split('"')[1]
    build = client.describe().build
    assert build.startswith(f"sources {digest}, ")
    for part in (", Eigen 3.", ", Boost 1", ", gcc ", " -ffp-contract=off ", ", glibc "):
        assert part in build, part
    if platform.machine() == "x86_64":
        assert ", avx2 -mavx2 -mfma" in build and ", avx512 -mavx512f" in build


def test_describe(client):
    catalogue = client.describe()
    assert catalogue.version and catalogue.build and len(catalogue.numerics_id) == 16
    assert {"rigid_body", "moser_veselov"} <= {system.name for system in catalogue.systems}
    methods = {method.name: method for method in catalogue.methods}
    assert {"variational", "rk4", "munthe_kaas4"} <= set(methods)
    for system in catalogue.systems:
        assert system.equations and system.source and system.file and system.blocks and system.fields
        assert all(entry.preserves for entry in system.methods)
        assert {entry.method for entry in system.methods} <= ({""} if system.discrete else set(methods))
    for method in catalogue.methods:
        assert method.default_order in (method.orders or [0])
    assert catalogue.limits.max_message_bytes == min(256 << 20, catalogue.limits.memory_bytes // 16)
    assert 2**30 < catalogue.limits.max_reply_bytes < 2**31
    assert catalogue.limits.idle_timeout.seconds > 0
