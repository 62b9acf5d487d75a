"""Tests --memory 1G under all loads at once: 10^4 sessions of N = 256, 10^6 members, 1000 unread streams, messages at
the limit. The short form with 256 MiB is tests/server/process/test_memory.py."""
import sys
from pathlib import Path

import pytest

from conftest import LONG

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "server"))

GiB = 1 << 30


@pytest.mark.skipif(not LONG, reason="takes minutes")
def test_a_gigabyte():
    from flood import Health, flood  # noqa: PLC0415
    from stiefel import Server  # noqa: PLC0415

    with Server.start(arguments=["--memory", "1G", "--max-sessions", "20000"]) as server:
        process = Started(server)
        with Health(process) as health:
            ends = flood(process, sessions=10_000, dimension=256, ensembles=16, members=65_536, streams=1000,
                         messages=16)
        assert not ends.untyped, ends.untyped[:3]
        assert not health.wrong and health.longest <= 1
        assert process.memory() < 1.2 * GiB
        assert all(set(ends.of(kind)) <= {"OK", "RESOURCE_EXHAUSTED"} for kind in ("session", "ensemble", "stream"))


class Started:
    """Adapts a server of the Python client to the interface of Process in tests/server."""

    def __init__(self, server):
        self.server = server

    def channel(self, options=()):
        import grpc  # noqa: PLC0415
        return grpc.insecure_channel(self.server.address, options=options)

    def memory(self):
        with open(f"/proc/{self.server.process.pid}/status", encoding="ascii") as status:
            return next(int(line.split()[1]) for line in status if line.startswith("VmHWM")) * 1024
