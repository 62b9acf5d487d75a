"""Runs the blocking client on an event loop, over grpc.aio. A function runs in a greenlet, a stack of its own. Where it waits
for the server, the greenlet stands still and the loop goes on."""
from __future__ import annotations

import asyncio
import weakref
from contextlib import suppress
from typing import Any, Awaitable, Callable, Iterator, Optional, TypeVar

import grpc
import grpc.aio

from stiefel.errors import FailedPrecondition

try:
    from greenlet import getcurrent, greenlet
except ImportError as missing:
    raise ImportError("stiefel.aio needs the package greenlet: pip install 'stiefel[aio]'") from missing

T = TypeVar("T")
_EOF: Any = getattr(grpc.aio, "EOF")


class _Blocking(greenlet):  # type: ignore[misc]
    """A greenlet that hands what it waits for to its parent. It has the context variables of its task."""

    def __init__(self, function: Callable[..., Any]):
        parent = getcurrent()
        super().__init__(function, parent)
        self.gr_context = parent.gr_context


async def run(function: Callable[..., T], *arguments: Any, **more: Any) -> T:
    """Returns what a function returns that makes calls with objects of `stiefel.aio`, and waits for their replies without
    blocking the event loop: `await stiefel.aio.run(trajectory.error_at, times)`. An exception of what it waits for, such as
    the cancellation of the task, is raised where it waits."""
    blocking = _Blocking(function)
    handed = blocking.switch(*arguments, **more)
    while not blocking.dead:
        try:
            result = await handed
        except BaseException as error:
            handed = blocking.throw(error)
        else:
            handed = blocking.switch(result)
    returned: T = handed
    return returned


def wait(awaitable: Awaitable[T]) -> T:
    """Waits inside `run`."""
    parent: Any = getcurrent().parent
    result: T = parent.switch(awaitable)
    return result


class Lock:
    """A lock that may be held while `run` waits."""

    def __init__(self) -> None:
        self._lock = asyncio.Lock()

    def __enter__(self) -> None:
        wait(self._lock.acquire())

    def __exit__(self, *exception: object) -> None:
        self._lock.release()


class Channel:
    """A channel of grpc.aio that blocks as one of grpc does, inside `run`. Every event loop gets a channel of its own, which
    is opened when it is first used."""

    def __init__(self, open: Callable[[], grpc.aio.Channel]):
        self._open = open
        self._loop: Optional[asyncio.AbstractEventLoop] = None
        self._opened: Any = None
        self.calls: weakref.WeakSet[_Call] = weakref.WeakSet()  #: grpc.aio finds those alone on which a task waits

    @property
    def opened(self) -> grpc.aio.Channel:
        """The channel of grpc.aio of the running loop."""
        loop = asyncio.get_running_loop()
        if self._loop is not loop:
            self._loop, self._opened = loop, self._open()
        return self._opened

    def unary_unary(self, *method: Any, **more: Any) -> _Method:
        return _Method(self, lambda channel: channel.unary_unary(*method, **more))

    def unary_stream(self, *method: Any, **more: Any) -> Callable[..., _Call]:
        return _Method(self, lambda channel: channel.unary_stream(*method, **more)).begin

    def stream_stream(self, *method: Any, **more: Any) -> Callable[..., _Call]:
        """Of a method that answers each request with one reply: reading a reply sends its request. Tasks that do so at the
        same time take turns."""
        made = _Method(self, lambda channel: channel.stream_stream(*method, **more))
        return lambda requests, **call: made.begin(None, **call).sending(requests)

    def rest(self, seconds: float) -> None:
        """Waits for `seconds`."""
        wait(asyncio.sleep(seconds))

    def close(self) -> None:
        """Ends every call. Outside `run`, when the process ends, there is no loop that could do so."""
        if self._opened is not None and isinstance(getcurrent(), _Blocking):
            for call in list(self.calls):
                call.cancel()
            wait(self._opened.close())


class _Method:
    """A method of a channel, for calls in any loop."""

    def __init__(self, channel: Channel, make: Callable[[Any], Any]):
        self._channel, self._make = channel, make
        self._made: tuple[Any, Any] = (None, None)

    def begin(self, *request: Any, timeout: Optional[float] = None, metadata: Any = ()) -> _Call:
        if not isinstance(getcurrent(), _Blocking):
            raise FailedPrecondition("what makes a call of stiefel.aio must be awaited: `await stiefel.aio.run(function, ...)`")
        opened = self._channel.opened
        if self._made[0] is not opened:
            self._made = opened, self._make(opened)
        call = _Call(self._made[1](*request, timeout=timeout, metadata=tuple(metadata)))
        self._channel.calls.add(call)
        return call

    def with_call(self, request: Any, timeout: Optional[float] = None, metadata: Any = ()) -> tuple[Any, _Call]:
        call = self.begin(request, timeout=timeout, metadata=metadata)
        return call.result(), call


class _Call:
    """A call, and an iterator over the replies of one with a stream."""

    def __init__(self, call: Any):
        self._call, self._left = call, False
        self._requests: Optional[Iterator[Any]] = None

    def sending(self, requests: Iterator[Any]) -> _Call:
        self._requests, self._turn = requests, asyncio.Lock()
        return self

    def result(self) -> Any:
        return self._wait(self._call)

    def __iter__(self) -> _Call:
        return self

    def __next__(self) -> Any:
        reply = self._wait(self._call.read() if self._requests is None else self._exchange(next(self._requests)))
        if reply is _EOF:
            raise StopIteration
        return reply

    async def _exchange(self, request: Any) -> Any:
        async with self._turn:
            with suppress(asyncio.InvalidStateError):  # the call has ended; reading says how
                await self._call.write(request)
            return await self._call.read()

    def initial_metadata(self) -> Any:
        return tuple(self._wait(self._call.initial_metadata()))

    def cancel(self) -> None:
        self._left = True
        self._call.cancel()

    def _wait(self, awaitable: Awaitable[T]) -> T:
        """Waits. After `cancel` grpc.aio raises what the cancellation of a task raises, and grpc an RpcError."""
        try:
            return wait(awaitable)
        except asyncio.CancelledError:
            if not self._left:
                raise
        none = grpc.aio.Metadata()
        raise grpc.aio.AioRpcError(grpc.StatusCode.CANCELLED, none, none, "the call was ended by this client")
