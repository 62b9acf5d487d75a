"""stiefel.aio has the names and signatures of the blocking client and its answers, and tasks may do with it what threads do
there."""
import asyncio
import gc
import inspect
import pickle
import subprocess
import sys
import warnings

import grpc
import grpc.aio
import numpy as np
import pytest

import fake
import stiefel
import stiefel.aio
from stiefel import client as blocking_client, session as blocking_session, v1 as pb

TWINS = [(blocking_client.Client, stiefel.aio.Client), (blocking_session.Session, stiefel.aio.Session),
         (blocking_session.Drive, stiefel.aio.Drive)]
SCENE = {"system": "rigid_body", "method": {"name": "variational"}, "step": 0.01,
         "body": {"moments": [1, 2, 3], "angular_velocity": [0.1, 2, 0.1]}}
LONG = 10**12
TOLD_BY_ITSELF = {"message", "created", "address", "channel", "epoch"}  # attributes that the constructors set


@pytest.fixture(scope="module")
def server():
    with stiefel.Server.start() as server:
        yield server


@pytest.fixture(autouse=True)
def no_warnings():
    """Such as that of a coroutine that nobody awaited."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        yield
        gc.collect()


def public(kind):
    return {name for name in dir(kind) if not name.startswith("_")}


def parameters(function):
    return [(p.name, p.kind, p.default, p.annotation) for p in inspect.signature(function).parameters.values()]


@pytest.mark.parametrize("one, other", TWINS, ids=lambda kind: kind.__name__)
def test_names_and_signatures_are_those_of_the_blocking_client(one, other):
    assert public(one) - TOLD_BY_ITSELF == public(other) - TOLD_BY_ITSELF
    for name in public(one) - TOLD_BY_ITSELF:
        theirs, ours = inspect.getattr_static(one, name), inspect.getattr_static(other, name)
        assert isinstance(theirs, property) == isinstance(ours, property), name
        assert inspect.getdoc(ours.fget if isinstance(ours, property) else ours), name
        if not isinstance(theirs, property):
            assert parameters(theirs) == parameters(ours), name
    for name in ("simulate", "sweep"):
        one, other = getattr(stiefel, name), getattr(stiefel.aio, name)
        assert parameters(one) == parameters(other) and one.__doc__ == other.__doc__ and inspect.iscoroutinefunction(other)


def test_answers_are_those_of_the_blocking_client(server):
    """In the last bit, whatever is asked for; also of tasks that share a session and a drive."""
    async def main():
        async with stiefel.aio.Client(server.address) as client, client.create(SCENE) as session:
            async with session.drive() as drive, session.fork(at=3) as fork:
                driven, steps = await asyncio.gather(*(drive.step(k) for k in range(40))), \
                    await asyncio.gather(*(session.step(k) for k in range(40)))
                batches = [batch async for batch in session.stream(to=300, every=7)]
                found = await client.get(session.id)
                assert session.id in [one.id async for one in client.list()] and found.id == session.id
                return (steps, driven, batches, await session.trajectory(to=300, every=7), await fork.step(5), await session.scene,
                        await session.summarize(300, {"energy": "drift"}), await session.lyapunov(to=4000),
                        await session.state_transition(30), await session.events(300, {"field": "Q", "coefficients": [1] * 9}))

    steps, driven, batches, run, forked, scene, *others = asyncio.run(main())
    with blocking_client.Client(server.address) as client, client.create(SCENE) as session:
        assert [session.step(k) for k in range(40)] == steps == driven and session.scene == scene
        assert session.trajectory(to=300, every=7) == run
        assert np.array_equal(np.concatenate([batch["quaternion"] for batch in batches]), run["quaternion"])
        assert others == [session.summarize(300, {"energy": "drift"}), session.lyapunov(to=4000), session.state_transition(30),
                          session.events(300, {"field": "Q", "coefficients": [1] * 9})]
        with session.fork(at=3) as fork:
            assert fork.step(5) == forked


def test_simulate_gives_the_motion_of_the_blocking_one():
    """Also its errors, and a result that makes calls after the connection of `simulate` is closed."""
    async def main():
        run = await stiefel.aio.simulate("toutatis", time=6000, fields="quaternion")
        with pytest.raises(stiefel.InvalidArgument, match="fields"):
            await stiefel.aio.simulate("toutatis", to=3, fields="nothing")
        with pytest.raises(stiefel.FailedPrecondition, match="await stiefel.aio.run"):
            async with stiefel.aio.Client() as client:
                client._blocking.describe()
        return run
    run = asyncio.run(main())
    assert run == stiefel.simulate("toutatis", time=6000, fields="quaternion")
    assert run.error_at([600.0]).attitude[0] < 1e-12


def test_a_sweep_gives_the_result_of_the_blocking_one_and_ends_when_it_is_cancelled(server):
    asked = {"axes": {"body.angular_velocity[1]": np.linspace(1, 2, 40)}, "summarize": {"energy": ["drift"]}, "servers": [server.address]}

    async def main():
        swept = await stiefel.aio.sweep(SCENE, to=20_000, **asked)
        sweep = asyncio.create_task(stiefel.aio.sweep(SCENE, to=LONG, **asked))
        await asyncio.sleep(0.5)  # the loop goes on meanwhile
        sweep.cancel()
        with pytest.raises(asyncio.CancelledError):
            await asyncio.wait_for(sweep, 30)
        return swept
    assert asyncio.run(main()).attrs["sha256"] == stiefel.sweep(SCENE, to=20_000, **asked).attrs["sha256"]
    with stiefel.Client(server.address) as client:
        assert client.describe().version  # the server serves others


def test_a_lost_server_is_waited_for_and_a_broken_stream_goes_on(tmp_path):
    service, fakes, address = fake.serve(tmp_path)

    async def main():
        async with stiefel.aio.Client(address) as client:
            session = await client.get("fake")
            service.failures = [grpc.StatusCode.UNAVAILABLE] * 3
            assert (await session.step(to=5)).step == 5
            service.failures = [fake.refusal(0.01)]
            async with session.drive() as drive:
                assert (await drive.step(7)).step == 7
            service.failures = [2, grpc.StatusCode.UNAVAILABLE, 1]
            return await session.trajectory(to=155, every=3)
    assert list(asyncio.run(main()).step) == [*range(0, 155, 3), 155]
    fakes.stop(None)


async def ended(client, id, seconds=20):
    """Waits until the server has ended the call of a new session, whose cursor moves at the end of a call."""
    end = asyncio.get_running_loop().time() + seconds
    while not (await client.stub.GetSession(pb.GetSessionRequest(session_id=id))).session.cursor:
        assert asyncio.get_running_loop().time() < end
        await asyncio.sleep(0.05)


@pytest.mark.parametrize("name", ["step", "trajectory", "stream", "drive"])
def test_the_cancellation_of_a_task_cancels_its_call(server, name):
    """The server stops computing, and the client goes on."""
    async def stream(session):
        async for _ in session.stream(to=LONG, every=10):
            pass

    async def drive(session):
        async with session.drive() as drive:
            await drive.step(LONG)

    async def main():
        async with stiefel.aio.Client(server.address, timeout=None) as client, client.create(SCENE) as session:
            call = {"step": lambda: session.step(LONG), "trajectory": lambda: session.trajectory(to=LONG, every=LONG // 10),
                    "stream": lambda: stream(session), "drive": lambda: drive(session)}[name]
            task = asyncio.ensure_future(call())
            await asyncio.sleep(0.3)
            assert not task.done()
            with pytest.raises(AssertionError):
                await ended(client, session.id, seconds=0.2)
            task.cancel()
            with pytest.raises(asyncio.CancelledError):
                await task
            await ended(client, session.id)
            assert (await session.step(3)).step == 3
    asyncio.run(main())


def test_to_close_a_client_ends_its_calls(server):
    async def main():
        client = stiefel.aio.Client(server.address)
        session = await client.create(SCENE)
        drive = session.drive()
        await drive.step(1)
        batches = session.stream(to=LONG, every=10)
        await batches.__anext__()
        await batches.aclose()  # a stream that is left is cancelled
        await ended(client, session.id)
        calls = [asyncio.ensure_future(call) for call in (session.step(LONG), drive.step(LONG), session.trajectory(to=LONG, every=LONG))]
        await asyncio.sleep(0.3)
        await client.close()
        for call in calls:
            with pytest.raises(stiefel.Closed):
                await call
        with pytest.raises(stiefel.Closed):
            client.stub
        absent = stiefel.aio.Client("127.0.0.1:1")
        call = asyncio.ensure_future(absent.describe())
        await asyncio.sleep(0.02)
        await absent.close()  # which ends the pause
        with pytest.raises((stiefel.Closed, stiefel.Unavailable)):
            await asyncio.wait_for(call, 5)
    asyncio.run(main())


def test_one_client_serves_one_loop_after_the_other_and_is_pickled_by_its_address(server):
    client = pickle.loads(pickle.dumps(stiefel.aio.Client(server.address, timeout=7)))

    async def main():
        return (await client.describe()).version
    assert {asyncio.run(main()) for _ in range(2)} == {stiefel.__version__} and client.timeout == 7


def test_a_channel_of_the_caller_s(server):
    async def main():
        async with grpc.aio.insecure_channel(server.address) as channel:
            client = stiefel.aio.Client(channel=channel)
            assert client.channel is channel and (await client.describe()).version == stiefel.__version__
            with pytest.raises(TypeError):
                pickle.dumps(client)
        with pytest.raises(stiefel.InvalidArgument, match="of grpc.aio"), grpc.insecure_channel(server.address) as blocking:
            stiefel.aio.Client(channel=blocking)
    asyncio.run(main())


def test_greenlet_is_needed_where_aio_is_imported_only():
    program = """
import sys
sys.modules["greenlet"] = None
import stiefel
try:
    import stiefel.aio
except ImportError as missing:
    print(missing)
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert (done.stdout, done.stderr) == ("stiefel.aio needs the package greenlet: pip install 'stiefel[aio]'\n", "")


def test_what_a_block_raises_is_raised(server):
    async def main():
        async with stiefel.aio.Client(server.address) as client:
            with pytest.raises(ZeroDivisionError):
                async with client.create(SCENE, id="block"):
                    1 / 0
            with pytest.raises(stiefel.NotFound):
                await client.get("block")
            assert repr(client) == f"<stiefel.aio.Client of {server.address}>"
            async with client.create(SCENE, id="shown") as session, session.drive() as drive:
                assert repr(session) == "<stiefel.aio.Session shown: rigid_body variational, step 0.01>"
                assert repr(drive) == "<stiefel.aio.Drive of shown, idle>"
    asyncio.run(main())
