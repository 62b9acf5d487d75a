"""Sessions that are created, stepped and deleted, one after another, leave nothing behind."""
import os

from flood import body, creation
from stiefel import v1 as pb
from stiefel.v1 import simulation_pb2_grpc as rpc

CYCLES = int(os.environ.get("STIEFEL_CYCLES", "1000"))
# gRPC and the scheduler start a few threads of their pools late, when a machine is slow. A leak grows with the cycles.
POOLS = 8
MiB = 1 << 20


def held(process):
    with open(f"/proc/{process.child.pid}/status", encoding="ascii") as status:
        threads = next(int(line.split()[1]) for line in status if line.startswith("Threads"))
    return {"threads": threads, "descriptors": process.open_descriptors()}


def test_cycles_leave_nothing(serve):
    """The names of deleted sessions are kept for the idle timeout: the warm-up is longer."""
    process = serve("--log-level", "off", "--idle-timeout", "1")
    with process.channel() as channel:
        stub = rpc.SimulationServiceStub(channel)

        def cycle(k):
            stub.CreateSession(creation(f"cycle-{k}", body(8)))
            assert stub.Step(pb.StepRequest(session_id=f"cycle-{k}", to=2)).sample.step == 2
            stub.DeleteSession(pb.DeleteSessionRequest(session_id=f"cycle-{k}"))

        for k in range(CYCLES):
            cycle(k)
        before, memory = held(process), process.resident()
        for k in range(CYCLES, 2 * CYCLES):
            cycle(k)
        after = held(process)
        assert all(after[what] < before[what] + POOLS for what in before), (before, after)
        assert process.resident() < memory + MiB, (process.resident() / MiB, memory / MiB)
