"""Compares streaming samples of N = 3 into the Python client as arrays with a bare Python stream of the same bytes, steps of
its Drive with its Step, and the first result of `stiefel.simulate` with the imports of what it needs.

Arguments: address of the server, address of the echo server, repeats, samples.
"""
import json
import subprocess
import sys
import time

import echo_pb2
import grpc
import numpy as np
import stiefel
from stiefel import v1 as pb

SCENE = {"system": "rigid_body", "method": {"name": "variational"}, "inertia": [1, 2, 4],
         "initial": {"Q": {"rows": 3, "cols": 3, "values": [1, 0, 0, 0, 1, 0, 0, 0, 1]},
                     "M": {"rows": 3, "cols": 3, "values": [0, -1.5, 2, 1.5, 0, -3, -2, 3, 0]}},
         "step": 0.05}


def seconds(work) -> float:
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


def main(address: str, echo: str, repeats: int, samples: int) -> None:
    client = stiefel.Client(address)
    pour = grpc.insecure_channel(echo).unary_stream("/stiefel.bench.v1.EchoService/Pour",
                                                    request_serializer=echo_pb2.PourRequest.SerializeToString,
                                                    response_deserializer=echo_pb2.EchoResponse.FromString)

    def ours() -> None:
        with client.create(SCENE) as session:
            trajectory = session.trajectory(to=samples - 1, every=1, fields=["Q", "M"])
        assert trajectory["Q"].shape == trajectory["M"].shape == (samples, 3, 3)

    with client.create(SCENE) as session:
        stream = client.stub.Stream(pb.StreamRequest(session_id=session.id, to=samples - 1, fields=["Q", "M"]))
        messages = [message.ByteSize() for message in stream]
    request = echo_pb2.PourRequest(message_bytes=sum(messages) // len(messages), messages=len(messages))

    def bare() -> None:
        received = b"".join(message.payload for message in pour(request))
        assert np.frombuffer(received, np.uint8).size == request.message_bytes * request.messages

    times = [(seconds(ours), seconds(bare)) for _ in range(repeats + 1)][1:]
    print(json.dumps({"name": f"Stream, {samples} samples, Python client", "unit": "s",
                      "rival": "bare Python stream, bytes joined", "bound": None,
                      "ours": [a for a, _ in times], "theirs": [b for _, b in times]}))


def steps(address: str, repeats: int, count: int) -> None:
    """A step of a Drive costs at most two thirds of a Step."""
    with stiefel.Client(address) as client, client.create(SCENE) as session, session.drive() as drive:
        def each(step) -> float:
            return 1e6 / count * seconds(lambda: [step(k) for k in range(count)])
        times = [(each(drive.step), each(session.step)) for _ in range(repeats + 1)][1:]
    print(json.dumps({"name": "Drive, Python client", "unit": "µs", "rival": "Step, the same", "bound": 0.667,
                      "ours": [a for a, _ in times], "theirs": [b for _, b in times]}))


def first_result(repeats: int) -> None:
    """A new process has its first trajectory, from a server of its own, in at most three times the time of the imports."""
    def program(text: str) -> float:
        return seconds(lambda: subprocess.run([sys.executable, "-c", text], check=True))
    times = [(program("import stiefel; stiefel.simulate('toutatis', time=86400)"),
              program("import grpc, numpy, numpy.typing, google.protobuf.json_format")) for _ in range(repeats + 1)][1:]
    print(json.dumps({"name": "First result, stiefel.simulate", "unit": "s", "rival": "import grpc, numpy, protobuf", "bound": 3,
                      "ours": [a for a, _ in times], "theirs": [b for _, b in times]}))


if __name__ == "__main__":
    first_result(int(sys.argv[3]))
    steps(sys.argv[1], int(sys.argv[3]), max(int(sys.argv[4]) // 500, 10))
    main(sys.argv[1], sys.argv[2], int(sys.argv[3]), int(sys.argv[4]))
