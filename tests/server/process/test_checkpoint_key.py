"""Checkpoints from server to server: with a shared key they are believed, with another they are ignored."""
import struct

import numpy as np
import pytest
from conftest import BODY, refused_at_the_start

import stiefel
from stiefel import v1 as pb

RUN = {**BODY, "method": {"name": "variational"}}
OLD, NEW = "a1" * 32, "b2" * 32
FAR = 100_000


def checkpoint_of(address, to=FAR):
    with stiefel.Client(address) as client, client.create(RUN) as session:
        state = session.step(to, checkpoint=True)
        return state.checkpoint, state


@pytest.fixture
def keyed(serve, tmp_path):
    def start(name, *lines):
        file = tmp_path / name
        file.write_text("".join(f"{line}\n" for line in lines))
        return serve("--checkpoint-key", str(file)).address
    return start


def goes_on(address, checkpoint):
    """Whether a new session ignores the checkpoint, the steps it then computes to `FAR`, and that state."""
    with stiefel.Client(address) as client:
        reply = client._connection.call("CreateSession", pb.CreateSessionRequest(
            session_id="taken-over", scene=stiefel.to_message(RUN), checkpoint=checkpoint))
        try:
            state = client.get("taken-over").step(FAR)
            return reply.checkpoint_ignored, state.computed_steps, state
        finally:
            client.delete("taken-over")


def same(a, b):
    return all(np.array_equal(a.fields[name], b.fields[name]) for name in a.fields)


def test_a_shared_key_and_an_old_one_beside_the_new(keyed):
    checkpoint, expected = checkpoint_of(keyed("first", OLD))
    for lines in ([OLD], [NEW, OLD], ["# new", NEW, "", "# old", OLD]):
        ignored, computed, state = goes_on(keyed("second", *lines), checkpoint)
        assert not ignored and computed == 0 and same(state, expected)


def test_a_replica_that_knows_the_new_key_signs_with_it(keyed):
    checkpoint, expected = checkpoint_of(keyed("both", NEW, OLD))
    ignored, computed, state = goes_on(keyed("new", NEW), checkpoint)
    assert not ignored and computed == 0 and same(state, expected)
    assert goes_on(keyed("old", OLD), checkpoint)[0]


def test_of_another_key_it_is_ignored_and_the_state_computed(keyed, serve):
    checkpoint, expected = checkpoint_of(serve().address)
    for address in (serve().address, keyed("other", OLD)):
        ignored, computed, state = goes_on(address, checkpoint)
        assert ignored and computed == FAR and same(state, expected)


def summary_of(address, checkpoint=b"", to=FAR):
    with stiefel.Client(address) as client, client.create(RUN) as session:
        return session.summarize(to, {"energy": ["drift", "mean"]}, checkpoint_every=FAR // 2, checkpoint=checkpoint)


def test_of_another_key_that_of_a_summary_is_ignored_too(keyed, serve):
    whole = summary_of(keyed("first", OLD))
    assert whole.checkpoint and not whole.checkpoint_ignored
    on = summary_of(keyed("both", NEW, OLD), whole.checkpoint)
    assert on["energy"] == whole["energy"] and not on.checkpoint_ignored
    for address in (keyed("new", NEW), serve().address):
        anew = summary_of(address, whole.checkpoint)
        assert anew["energy"] == whole["energy"] and anew.checkpoint_ignored
    with pytest.raises(stiefel.InvalidArgument, match="checkpoint: .* bytes: is damaged: must be the bytes that Summarize"):
        summary_of(keyed("key", OLD), whole.checkpoint[:-1])


def test_forged_truncated_and_not_finite(keyed):
    address = keyed("key", OLD)
    checkpoint, expected = checkpoint_of(address)
    forged = bytearray(checkpoint)
    forged[-33] ^= 1  # of the last number
    nan = checkpoint[:-40] + struct.pack("<d", float("nan")) + checkpoint[-32:]
    for wrong in (bytes(forged), checkpoint[:-1], checkpoint + b"x", checkpoint[:60], checkpoint[:20], b"x", nan):
        with pytest.raises(stiefel.InvalidArgument, match="checkpoint: .* bytes: is damaged: must be the bytes that Step"):
            goes_on(address, wrong)
    foreign = checkpoint[:8] + bytes(8) + checkpoint[16:]  # as if another server had signed it
    ignored, computed, state = goes_on(address, foreign)
    assert ignored and computed == FAR and same(state, expected)


def test_a_forged_one_does_not_reach_a_session_that_is_there(keyed):
    address = keyed("key", OLD)
    checkpoint, expected = checkpoint_of(address)
    forged = bytearray(checkpoint)
    forged[-100] ^= 0x40
    with stiefel.Client(address) as client:
        session = client.create(RUN, id="there")
        with pytest.raises(stiefel.InvalidArgument):
            client.create(RUN, id="there", checkpoint=bytes(forged))
        assert same(session.step(FAR), expected)


@pytest.mark.parametrize("text, rule", [("", "there must be at least one key"), ("zz", "line 1: a key must be 64"),
                                        (f"{OLD}\n{OLD[:-1]}", "line 2: a key must be 64"), (None, "No such file")])
def test_a_file_that_is_none_is_refused_at_the_start(tmp_path, text, rule):
    file = tmp_path / "key"
    if text is not None:
        file.write_text(text)
    for said in refused_at_the_start("--checkpoint-key", file):
        assert f"--checkpoint-key: {file}: {rule}" in said and OLD[:-1] not in said
