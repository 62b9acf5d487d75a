"""Checkpoints that clients hold: any server of the build takes them over, and damaged or forged bytes harm none."""
import hashlib
import struct

import grpc
import numpy as np
import pytest
from conftest import BODY

import stiefel

RUN = {**BODY, "method": {"name": "variational"}}
FAR = 100_000
DIGEST = 32


@pytest.fixture
def clients(serve):
    """Clients of two servers."""
    with stiefel.Client(serve().address) as one, stiefel.Client(serve().address) as other:
        yield one, other


def sealed(checkpoint):
    """With the digest that belongs to the other bytes."""
    return checkpoint[:-DIGEST] + hashlib.sha256(checkpoint[:-DIGEST]).digest()


def test_another_server_goes_on(clients):
    with clients[0].create(RUN) as session:
        there = session.step(FAR, checkpoint=True)
    state = clients[1].create(RUN, id="taken-over", checkpoint=there.checkpoint).step(FAR)
    assert state.computed_steps == 0 and all(np.array_equal(state[name], there[name]) for name in there.fields)


def test_damaged_ones_are_refused(clients):
    client = clients[0]
    checkpoint = client.create(RUN).step(FAR, checkpoint=True).checkpoint
    flipped = bytearray(checkpoint)
    flipped[-DIGEST - 1] ^= 1  # of the last number
    nan = sealed(checkpoint[:-DIGEST - 8] + struct.pack("<d", float("nan")) + bytes(DIGEST))
    for wrong in (bytes(flipped), checkpoint[:-1], checkpoint + b"x", checkpoint[:60], checkpoint[:20], b"x", nan):
        with pytest.raises(stiefel.InvalidArgument, match="checkpoint: .* bytes: is damaged: must be the bytes that Step"):
            client.create(RUN, checkpoint=wrong)


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
