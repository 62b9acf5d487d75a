"""Checkpoints that clients hold: forged bytes harm no server."""
import hashlib
import struct

import grpc
import pytest
from conftest import BODY

import stiefel

RUN = {**BODY, "method": {"name": "variational"}}
DIGEST = 32


def sealed(checkpoint):
    """With the digest that belongs to the other bytes."""
    return checkpoint[:-DIGEST] + hashlib.sha256(checkpoint[:-DIGEST]).digest()


def step(client, session, checkpoint=b""):
    if not checkpoint:
        return session.step(1000, checkpoint=True)
    with client.create(RUN, checkpoint=checkpoint) as resumed:
        return resumed.step(1001)


def summary(client, session, checkpoint=b""):
    return session.summarize(3000, quantities={"energy": ["drift", "mean", {"quantiles": [0.5], "edges": [0, 1, 10]}]},
                             checkpoint_every=1000, checkpoint=checkpoint)


def growth(client, session, checkpoint=b""):
    return session.lyapunov(to=4000 if checkpoint else 2000, checkpoint=checkpoint)


NUMBERS = [struct.pack("<d", number) for number in (float("nan"), float("inf"), -1e300, -1.0)] + [
    struct.pack("<q", number) for number in (-1, 0, 2**62, -2**63)]


@pytest.mark.parametrize("call", [step, summary, growth])
def test_forged_ones_end_no_server(serve, call):
    """Each part of a checkpoint replaced by numbers that no server writes, with the right digest."""
    process = serve("--log-level", "off")
    with stiefel.Client(process.address) as client:
        session = client.create(RUN)
        checkpoint = call(client, session).checkpoint
        places = range(8, len(checkpoint) - DIGEST - 8)
        for index, place in enumerate(list(places)[::max(1, len(places) // 300)]):
            number = NUMBERS[index % len(NUMBERS)]
            try:
                call(client, session, sealed(checkpoint[:place] + number + checkpoint[place + 8:]))
            except stiefel.StiefelError as error:  # CorruptReply where the numbers of the caller come back
                assert error.code not in (grpc.StatusCode.UNAVAILABLE, grpc.StatusCode.INTERNAL), error
        assert client.describe().version and process.child.poll() is None
