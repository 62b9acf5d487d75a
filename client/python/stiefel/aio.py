"""The client for asyncio, on grpc.aio: the names, arguments, results and exceptions of `stiefel.Client`.

    async with stiefel.aio.Client("host:50551") as client, client.create("scene.json") as session:
        state = await session.step(to=100)
        async for batch in session.stream(to=10_000, every=10):
            print(batch.step, batch["quaternion"])

What the blocking client returns is awaited here, what it iterates over is iterated with `async for`, and its context
managers are entered with `async with`, also `client.create(...)`, `client.get(...)` and `session.fork(...)` themselves.
`await stiefel.aio.simulate("toutatis", time=86400)` is one line, as `stiefel.simulate` is, and there is `sweep`. Calls
are repeated, streams resumed and lost sessions created again as there. Cancelling a task cancels its call. A method of a result
that makes a call is awaited with `run`: `await stiefel.aio.run(trajectory.error_at)`. The package greenlet must be installed:
pip install 'stiefel[aio]'.
"""
from __future__ import annotations

import asyncio
import contextvars
import functools
import sys
from concurrent.futures import Future
from contextlib import suppress
from typing import Any, AsyncGenerator, Awaitable, Callable, Coroutine, Generator, Iterator, Optional, TypeVar

import grpc
import grpc.aio

from stiefel import _client as blocking, _session as blocking_session, simulation
from stiefel._given.typed import Fields, Scene
from stiefel._sweep.dispatch import STOP
from stiefel._wire.address import Tls, TlsLike
from stiefel._wire.waiting import Channel, run
from stiefel.errors import InvalidArgument, StiefelError
from stiefel.results import Choice, Price, Trajectory
from stiefel._scene import SceneLike
from stiefel._sweep.sweep import sweep as blocking_sweep

if sys.version_info >= (3, 10):
    from typing import Concatenate, ParamSpec

    P = ParamSpec("P")

__all__ = ["Client", "Drive", "Opening", "Session", "Tls", "run", "simulate", "sweep"]
__dir__ = lambda: sorted(__all__)  # noqa: E731

T = TypeVar("T")
_END: Any = object()


def _awaited(method: Callable[Concatenate[Any, P], T]) -> Callable[Concatenate[Any, P], Coroutine[Any, Any, T]]:
    async def call(self: Any, /, *arguments: P.args, **more: P.kwargs) -> T:
        return await run(method, self._blocking, *arguments, **more)
    functools.update_wrapper(call, method)
    return call


def _iterated(method: Callable[Concatenate[Any, P], Iterator[T]]) -> Callable[Concatenate[Any, P], AsyncGenerator[T, None]]:
    async def iterate(self: Any, /, *arguments: P.args, **more: P.kwargs) -> AsyncGenerator[T, None]:
        parts: Any = method(self._blocking, *arguments, **more)
        part: Any
        try:
            while (part := await run(next, parts, _END)) is not _END:
                yield part
        finally:
            await run(parts.close)
    functools.update_wrapper(iterate, method)
    return iterate


def _opened(method: Callable[Concatenate[Any, P], blocking_session.Session]) -> Callable[Concatenate[Any, P], Opening]:
    def begin(self: Any, /, *arguments: P.args, **more: P.kwargs) -> Opening:
        return Opening(run(method, self._blocking, *arguments, **more))
    functools.update_wrapper(begin, method)
    return begin


def _shown(of: type, name: str) -> Any:
    """Returns a property that the blocking object has too, and that makes no call."""
    return property(lambda self: getattr(self._blocking, name), doc=getattr(of, name).__doc__)


def _fetched(of: type, name: str) -> Any:
    """Returns a property that is awaited, because it may make a call."""
    return property(lambda self: run(getattr, self._blocking, name), doc=getattr(of, name).__doc__)


def _twin_of(function: Callable[P, T]) -> Callable[[Callable[..., Coroutine[Any, Any, T]]], Callable[P, Coroutine[Any, Any, T]]]:
    """Gives a coroutine function the name, the arguments and the docstring of a blocking one."""
    def named(twin: Callable[..., Coroutine[Any, Any, T]]) -> Callable[P, Coroutine[Any, Any, T]]:
        return functools.update_wrapper(twin, function, ("__name__", "__qualname__", "__doc__"), ())
    return named


@_twin_of(simulation.simulate)
async def simulate(scene: SceneLike, *, normalize: bool = False, **of_trajectory: Any) -> Trajectory:
    own = await _in_thread(simulation.own_client)
    async with Client(own.address, timeout=own.timeout) as client, client.create(scene, normalize=normalize) as session:
        return await session.trajectory(**of_trajectory)


@_twin_of(blocking_sweep)
async def sweep(*arguments: Any, **more: Any) -> Any:
    stop: Future[None] = Future()

    def swept() -> Any:
        STOP.set(stop)
        return blocking_sweep(*arguments, **more)
    running = asyncio.ensure_future(_in_thread(swept))
    try:
        return await asyncio.shield(running)
    except asyncio.CancelledError:
        stop.set_exception(StiefelError("the sweep's task was cancelled"))
        with suppress(Exception):
            await running
        raise


def _in_thread(function: Callable[[], T]) -> Awaitable[T]:
    return asyncio.get_running_loop().run_in_executor(None, contextvars.copy_context().run, function)


class _Client(blocking.Client):
    """The blocking client over a channel of grpc.aio, for use inside `run`."""

    @staticmethod
    def _open_channel(open: Callable[[Any, Any], Any]) -> Any:
        return Channel(lambda: open(grpc.aio, blocking._OPTIONS))


class Client:
    """A connection to the server at `address`, as that of `stiefel.Client` with the same arguments.

    A client serves one event loop at a time: each loop gets a connection of its own, which is opened by the first call.
    `channel`: a channel of grpc.aio to use instead. Tasks of one loop may share a client.
    """

    def __init__(self, address: Optional[str] = None, *, timeout: Optional[float] = 60.0, tls: TlsLike = None,
                 token: Optional[str] = None, channel: Optional[grpc.aio.Channel] = None, any_build: bool = False):
        if isinstance(channel, grpc.Channel):
            raise InvalidArgument("channel: must be a channel of grpc.aio")
        given: Any = None if channel is None else Channel(lambda: channel)
        self._blocking = _Client(address, timeout=timeout, tls=tls, token=token, channel=given, any_build=any_build)
        opened: Any = self._blocking._channel
        self._channel: Channel = opened
        self.address = self._blocking.address

    timeout: Optional[float] = _shown(blocking.Client, "timeout")
    any_build: bool = _shown(blocking.Client, "any_build")
    closed: bool = _shown(blocking.Client, "closed")
    describe = _awaited(blocking.Client.describe)
    create = _opened(blocking.Client.create)
    get = _opened(blocking.Client.get)
    delete = _awaited(blocking.Client.delete)
    convert = _awaited(blocking.Client.convert)
    geodesics = _awaited(blocking.Client.geodesics)
    conjugate_points = _awaited(blocking.Client.conjugate_points)
    tradeoff = _awaited(blocking.Client.tradeoff)
    close = _awaited(blocking.Client.close)
    _sessions = _iterated(blocking.Client.list)

    async def list(self) -> AsyncGenerator[Session, None]:
        """Iterates over all sessions of the server, ordered by id."""
        async for session in self._sessions():
            yield Session(session)

    def __reduce__(self) -> Any:
        made, arguments = self._blocking.__reduce__()
        return functools.partial(Client, **made.keywords), arguments

    async def __aenter__(self) -> Client:
        return self

    async def __aexit__(self, *exception: object) -> None:
        await self.close()

    def __repr__(self) -> str:
        return repr(self._blocking).replace("stiefel.", "stiefel.aio.", 1)


class Session:
    """A simulation held by a server, as `stiefel.Session`, made by `Client.create` or `Client.get`.

    As an asynchronous context manager it deletes the session at the end, unless its server is gone then.
    """

    def __init__(self, session: blocking_session.Session):
        self._blocking = session
        self.created = session.created  #: False if the session existed already
        self.epoch = session.epoch  #: as that of `stiefel.Session`

    id: str = _shown(blocking_session.Session, "id")
    scene: Awaitable[Scene] = _fetched(blocking_session.Session, "scene")
    choice: Awaitable[Optional[Choice]] = _fetched(blocking_session.Session, "choice")
    step_price: Awaitable[Price] = _fetched(blocking_session.Session, "step_price")
    step = _awaited(blocking_session.Session.step)
    diagnose = _awaited(blocking_session.Session.diagnose)
    error_at = _awaited(blocking_session.Session.error_at)
    fork = _opened(blocking_session.Session.fork)
    delete = _awaited(blocking_session.Session.delete)
    stream = _iterated(blocking_session.Session.stream)
    trajectory = _awaited(blocking_session.Session.trajectory)
    linearize = _awaited(blocking_session.Session.linearize)
    covariance = _awaited(blocking_session.Session.covariance)
    lyapunov = _awaited(blocking_session.Session.lyapunov)
    summarize = _awaited(blocking_session.Session.summarize)
    events = _awaited(blocking_session.Session.events)
    poincare = _awaited(blocking_session.Session.poincare)
    stream_events = _iterated(blocking_session.Session.stream_events)
    _exit = _awaited(blocking_session.Session.__exit__)

    def drive(self, fields: Optional[Fields] = None) -> Drive:
        """Opens a stream for many steps in a tight loop: `async with session.drive("Q") as drive: await drive.step(k)`."""
        return Drive(self._blocking.drive(fields))

    def __reduce__(self) -> Any:
        return self._blocking.__reduce__()

    async def __aenter__(self) -> Session:
        return self

    async def __aexit__(self, *exception: Any) -> None:
        await self._exit(*exception)

    def __repr__(self) -> str:
        return repr(self._blocking).replace("stiefel.", "stiefel.aio.", 1)


class Opening:
    """A session that is being created or fetched: `await` returns it; `async with` enters it and deletes it at the end."""

    def __init__(self, session: Coroutine[Any, Any, blocking_session.Session]):
        self._session = session

    def __await__(self) -> Generator[Any, None, Session]:
        return Session((yield from self._session.__await__()))

    async def __aenter__(self) -> Session:
        self._entered = await self
        return self._entered

    async def __aexit__(self, *exception: Any) -> None:
        await self._entered.__aexit__(*exception)


class Drive:
    """An open stream for many steps of a session, as `stiefel.Drive`, made by `Session.drive`.

    Steps that tasks ask for at the same time are done one after the other.
    """

    def __init__(self, drive: blocking_session.Drive):
        self._blocking = drive

    step = _awaited(blocking_session.Drive.step)
    close = _awaited(blocking_session.Drive.close)

    def __reduce__(self) -> Any:
        return self._blocking.__reduce__()

    async def __aenter__(self) -> Drive:
        return self

    async def __aexit__(self, *exception: object) -> None:
        await self.close()

    def __repr__(self) -> str:
        return repr(self._blocking).replace("stiefel.", "stiefel.aio.", 1)
