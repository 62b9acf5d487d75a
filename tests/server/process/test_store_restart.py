"""What the next server with the same --store says of deleted, idle and running sessions."""
import sqlite3
import time

import grpc
import pytest

import stiefel
from conftest import BODY, eventually
from stiefel import v1 as pb
from stiefel.v1 import simulation_pb2_grpc as rpc
from stored import blocks, is_deleted, reason, scene_of


def test_a_handle_does_not_bring_back_what_was_deleted_before_the_server_was_killed(serve, tmp_path):
    process = serve("--store", str(tmp_path / "store"))
    with stiefel.Client(process.address) as one, stiefel.Client(process.address) as other:
        handle, kept = one.create(scene_of(1)), one.create(scene_of(2))
        other.delete(handle.id)
        process.child.kill()
        process.stop()
        serve("--store", str(tmp_path / "store"), listen=process.address)
        with pytest.raises(stiefel.StiefelError) as refused:
            handle.step(10)
        assert refused.value.reason == "SESSION_DELETED"
        assert kept.step(10).step == 10
        assert [session.id for session in other.list()] == [kept.id]


def test_a_deleted_name_ends_when_its_time_is_over(serve, tmp_path):
    store = str(tmp_path / "store")
    process = serve("--store", store, "--idle-timeout", "0.5")
    with process.channel() as channel:
        rpc.SimulationServiceStub(channel).DeleteSession(pb.DeleteSessionRequest(session_id="a"), timeout=60)
    process.child.kill()
    process.stop()
    time.sleep(0.5)
    process = serve("--store", store)
    with process.channel() as channel:
        assert not is_deleted(rpc.SimulationServiceStub(channel), "a")
    with sqlite3.connect(f"file:{store}?mode=ro", uri=True) as live:
        assert live.execute("SELECT count(*) FROM deleted_name").fetchone() == (0,)


def test_restored_sessions_take_their_principals_permits(serve, tmp_path):
    store = ("--store", str(tmp_path / "store"))
    process = serve(*store)
    with stiefel.Client(process.address) as client:
        ids = [client.create(scene_of(number)).id for number in range(3)]
    process.child.kill()
    process.stop()
    process = serve(*store, "--principal-sessions", "3")
    with process.channel() as channel:
        stub = rpc.SimulationServiceStub(channel)
        more = pb.CreateSessionRequest(session_id="more", scene=scene_of(3))
        with pytest.raises(grpc.RpcError) as refused:
            stub.CreateSession(more, timeout=60)
        assert refused.value.code() == grpc.StatusCode.RESOURCE_EXHAUSTED and reason(refused.value) == "OVER_QUOTA"
        stub.DeleteSession(pb.DeleteSessionRequest(session_id=ids[0]), timeout=60)
        assert stub.CreateSession(more, timeout=60).created


def test_idle_sessions_leave_the_store(serve, tmp_path):
    process = serve("--store", str(tmp_path / "store"), "--idle-timeout", "0.2")
    with stiefel.Client(process.address) as client:
        client.create(BODY)
        assert eventually(lambda: not list(client.list()))
    process.child.kill()
    process.stop()
    with stiefel.Client(serve("--store", str(tmp_path / "store")).address) as client:
        assert not list(client.list())


def test_checkpoints_are_written_behind(serve, tmp_path):
    """A killed server's successor goes on near the step that was reached."""
    process = serve("--store", str(tmp_path / "store"))
    with process.channel() as channel:
        stub = rpc.SimulationServiceStub(channel)
        stub.CreateSession(pb.CreateSessionRequest(session_id="a", scene=scene_of(1)), timeout=60)
        bits = blocks(stub, "a", 500_000)

        def stored():
            with sqlite3.connect(f"file:{tmp_path / 'store'}?mode=ro", uri=True) as live:
                return live.execute("SELECT step FROM checkpoint").fetchone()
        assert eventually(stored)
    process.child.kill()
    process.stop()
    process = serve("--store", str(tmp_path / "store"))
    with process.channel() as channel:
        reply = rpc.SimulationServiceStub(channel).Step(pb.StepRequest(session_id="a", to=500_000), timeout=60)
        assert [field.value.data for field in reply.sample.fields] == bits
        assert reply.computed_steps < 500_000
