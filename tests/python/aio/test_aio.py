"""stiefel.aio has the names and signatures of the blocking client, and tasks may do with it what threads do there. The other
tests of the client run through it too: `pytest --aio`."""
import asyncio
import contextvars
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


@pytest.mark.parametrize("one, other", TWINS, ids=lambda kind: kind.__name__)
def test_names_and_signatures_are_those_of_the_blocking_client(one, other):
    assert public(one) - TOLD_BY_ITSELF == public(other) - TOLD_BY_ITSELF
    for name in public(one) - TOLD_BY_ITSELF:
        theirs, ours = inspect.getattr_static(one, name), inspect.getattr_static(other, name)
        assert isinstance(theirs, property) == isinstance(ours, property), name
        assert inspect.getdoc(ours.fget if isinstance(ours, property) else ours), name
        if not isinstance(theirs, property):
            assert parameters(theirs) == parameters(ours), name
    first, second = (inspect.signature(kind).parameters.values() for kind in (one, other))
    if one is blocking_client.Client:
        assert [(p.name, p.default) for p in first] == [(p.name, p.default) for p in second]


@pytest.mark.parametrize("name", ["simulate", "sweep"])
def test_functions_have_the_signatures_of_the_blocking_ones(name):
    one, other = getattr(stiefel, name), getattr(stiefel.aio, name)
    assert parameters(one) == parameters(other) and one.__doc__ == other.__doc__
    assert inspect.iscoroutinefunction(other) and other.__name__ == name and name in stiefel.aio.__all__


def test_simulate_gives_the_motion_of_the_blocking_one():
    """Also its errors, and a result that makes calls after the connection of `simulate` is closed."""
    async def main():
        first, second = await asyncio.gather(*(stiefel.aio.simulate("toutatis", time=time, fields="quaternion") for time in (6000, 60000)))
        with pytest.raises(stiefel.InvalidArgument, match="fields"):
            await stiefel.aio.simulate("toutatis", to=3, fields="nothing")
        return first, second, first.error_at([600.0])
    first, second, errors = asyncio.run(main())
    assert first == stiefel.simulate("toutatis", time=6000, fields="quaternion") == second[:len(first)]
    assert errors.attitude[0] < 1e-12


AXES = {"body.angular_velocity[1]": np.linspace(1, 2, 40)}


def test_sweep_gives_the_result_of_the_blocking_one(server):
    async def main():
        ticks = asyncio.create_task(tick())
        swept = await stiefel.aio.sweep(SCENE, AXES, to=20_000, summarize={"energy": ["drift"]}, servers=[server.address])
        return swept, ticks.cancel() and ticks
    counted = []

    async def tick():
        while True:
            counted.append(None)
            await asyncio.sleep(0.01)
    swept, _ = asyncio.run(main())
    again = stiefel.sweep(SCENE, AXES, to=20_000, summarize={"energy": ["drift"]}, servers=[server.address])
    assert swept.attrs["sha256"] == again.attrs["sha256"]
    assert len(counted) > 3  # the loop went on meanwhile


def test_a_cancelled_sweep_ends(server):
    async def main():
        sweep = asyncio.create_task(stiefel.aio.sweep(SCENE, AXES, to=LONG, summarize={"energy": ["drift"]}, servers=[server.address]))
        await asyncio.sleep(0.5)
        sweep.cancel()
        with pytest.raises(asyncio.CancelledError):
            await asyncio.wait_for(sweep, 30)
    asyncio.run(main())
    with stiefel.Client(server.address) as client:
        assert client.describe().version  # the server serves others


def parameters(function):
    return [(p.name, p.kind, p.default, p.annotation) for p in inspect.signature(function).parameters.values()]


def test_what_a_session_has_is_there_too(server):
    async def main():
        async with stiefel.aio.Client(server.address) as client, client.create(SCENE) as session:
            return [(public(session._blocking), public(session)), (public(client._blocking), public(client))]
    for theirs, ours in asyncio.run(main()):
        assert theirs == ours


def test_answers_are_those_of_the_blocking_client(server):
    """In the last bit, whatever is asked for."""
    async def main():
        async with stiefel.aio.Client(server.address) as client, client.create(SCENE) as session:
            state, run = await session.step(300), await session.trajectory(to=300, every=7)
            async with session.drive() as drive:
                driven = [await drive.step(k) for k in (300, 3)]
            batches = [batch async for batch in session.stream(to=300, every=7)]
            found = await client.get(session.id)
            assert session.id in [one.id async for one in client.list()] and found.id == session.id
            async with session.fork(at=3) as fork:
                forked = await fork.step(5)
            scene = await session.scene
            return state, run, driven, batches, forked, scene

    state, run, driven, batches, forked, scene = asyncio.run(main())
    with blocking_client.Client(server.address) as client, client.create(SCENE) as session:
        assert session.step(300) == state and session.trajectory(to=300, every=7) == run and session.scene == scene
        assert driven[0].fields.keys() == state.fields.keys()
        assert all(np.array_equal(driven[0][name], state[name]) for name in state)
        assert np.array_equal(np.concatenate([batch["quaternion"] for batch in batches]), run["quaternion"])
        with session.fork(at=3) as fork:
            assert np.array_equal(fork.step(5)["quaternion"], forked["quaternion"])


def test_tasks_share_a_client_a_session_and_a_drive(server):
    async def main():
        async with stiefel.aio.Client(server.address) as client, client.create(SCENE) as session:
            with blocking_client.Client(server.address) as other:
                listed, = [one async for one in client.list() if one.id == session.id]
                expected = [other.get(session.id).step(k)["quaternion"] for k in range(40)]
            async with session.drive() as drive:
                for call in (session.step, drive.step, listed.step):
                    got = await asyncio.gather(*(call(k) for k in range(40)))
                    assert all(np.array_equal(state["quaternion"], right) for state, right in zip(got, expected))
            assert len({id(await one) for one in [listed.resolved() for _ in range(5)]}) == 1
            scenes = await asyncio.gather(*(listed.scene for _ in range(20)))
            assert all(scene == scenes[0] for scene in scenes)
    asyncio.run(main())


def test_the_loop_goes_on_while_a_call_runs(server):
    async def main():
        async with stiefel.aio.Client(server.address) as client, client.create(SCENE) as session:
            call, turns = asyncio.ensure_future(session.step(LONG, timeout=1.0)), 0
            while not call.done():
                await asyncio.sleep(0.01)
                turns += 1
            assert turns > 10
            with pytest.raises(stiefel.DeadlineExceeded, match="the session stands at step"):
                await call
    asyncio.run(main())


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


def test_a_stream_that_is_left_is_cancelled(server):
    async def main():
        async with stiefel.aio.Client(server.address) as client, client.create(SCENE) as session:
            batches = session.stream(to=LONG, every=10)
            async for batch in batches:
                break
            await batches.aclose()
            await ended(client, session.id)
            assert batch.step[0] == 0
    asyncio.run(main())


def test_to_close_a_client_ends_its_calls(server):
    async def main():
        client = stiefel.aio.Client(server.address)
        session = await client.create(SCENE)
        drive = session.drive()
        await drive.step(1)
        calls = [asyncio.ensure_future(call) for call in (session.step(LONG), drive.step(LONG), session.trajectory(to=LONG, every=LONG))]
        await asyncio.sleep(0.3)
        await client.close()
        for call in calls:
            with pytest.raises(stiefel.Closed):
                await call
        with pytest.raises(stiefel.Closed):
            client.stub
    asyncio.run(main())


def test_a_pause_ends_with_the_client_or_the_deadline():
    async def main():
        client = stiefel.aio.Client("127.0.0.1:1")
        with pytest.raises(stiefel.StiefelError):
            await client.create(SCENE)
        call = asyncio.ensure_future(client.describe())
        await asyncio.sleep(0.02)
        await client.close()
        with pytest.raises((stiefel.Closed, stiefel.Unavailable)):
            await asyncio.wait_for(call, 5)
    asyncio.run(main())


def test_one_client_serves_one_loop_after_the_other(server):
    client = stiefel.aio.Client(server.address)

    async def main():
        return (await client.describe()).version
    assert {asyncio.run(main()) for _ in range(2)} == {stiefel.__version__}


def test_a_channel_of_the_caller_s(server):
    async def main():
        async with grpc.aio.insecure_channel(server.address) as channel:
            client = stiefel.aio.Client(channel=channel)
            assert client.channel is channel and (await client.describe()).version == stiefel.__version__
            with pytest.raises(TypeError):
                pickle.dumps(client)
        with pytest.raises(stiefel.InvalidArgument, match="^channel: address"):
            stiefel.aio.Client(server.address, channel=channel)
        with pytest.raises(stiefel.InvalidArgument, match="of grpc.aio"), grpc.insecure_channel(server.address) as blocking:
            stiefel.aio.Client(channel=blocking)
    asyncio.run(main())


def test_a_client_is_pickled_by_its_address(server):
    async def main():
        async with stiefel.aio.Client(server.address, timeout=7) as client, client.create(SCENE) as session:
            again = pickle.loads(pickle.dumps(client))
            assert (again.address, again.timeout, (await again.describe()).version) == (server.address, 7, stiefel.__version__)
            for one in (session, session.drive()):
                with pytest.raises(TypeError):
                    pickle.dumps(one)
            await again.close()
    asyncio.run(main())


def test_a_call_has_the_context_of_its_task(server):
    held = contextvars.ContextVar("held", default="nothing")

    class Text(str):
        def lower(self):
            return held.get()

    async def main():
        held.set("of the task")
        return await stiefel.aio.run(Text("").lower)
    assert asyncio.run(main()) == "of the task"


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


def test_what_a_result_asks_for_is_awaited(server):
    """An estimated error is that of a new session, which the trajectory creates."""
    async def main():
        async with stiefel.aio.Client(server.address) as client, client.create(SCENE) as session:
            run = await session.trajectory(to=100, every=50)
            with pytest.raises(stiefel.FailedPrecondition, match="await stiefel.aio.run"):
                run.error_at()
            return run.scene, await stiefel.aio.run(run.error_at), await session.error_at(run.time)
    scene, errors, same = asyncio.run(main())
    assert scene["step"] == 0.01 and np.array_equal(errors.attitude, same.attitude, equal_nan=True) and len(errors.attitude) == 3


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


def test_a_warning_is_of_the_line_that_awaits(server):
    """In the task, a task of its own, and a thread; also after the call has waited."""
    thin = {**SCENE, "body": {"moments": [1, 2, 4], "angular_velocity": [0.1, 0, 0]}}
    asked = {"to": 1, "summarize": {"angular_velocity": "last"}, "servers": [server.address]}

    async def main():
        async with stiefel.aio.Client(server.address) as client:
            async def entered():
                async with client.create(thin):
                    pass

            async def awaited():
                await (await client.create(thin)).delete()

            async def later():
                await asyncio.gather(asyncio.create_task(entered()), asyncio.create_task(awaited()))
            for call in (entered, awaited, later, lambda: stiefel.aio.simulate(thin, to=1),
                         lambda: stiefel.aio.sweep(thin, {"step": [0.1, 0.2]}, **asked)):
                with pytest.warns(stiefel.SceneWarning, match="no rigid body has these moments") as caught:
                    await call()
                assert {one.filename for one in caught} == {__file__}
    asyncio.run(main())
