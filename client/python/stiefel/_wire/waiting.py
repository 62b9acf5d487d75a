"""Runs the blocking client on an event loop, over grpc.aio. A function runs in a greenlet, a stack of its own. Where it waits
for the server, the greenlet stands still and the loop goes on."""
from __future__ import annotations

import asyncio
import weakref
from contextlib import suppress
from types import SimpleNamespace
from typing import Any, Awaitable, Callable, Iterator, Optional, TypeVar, cast

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
    """A greenlet that hands what it waits for to its parent."""


async def run(function: Callable[..., T], *arguments: Any, **more: Any) -> T:
    """Returns what a function returns that makes calls with objects of `stiefel.aio`, and waits for their replies without
    blocking the event loop: `await stiefel.aio.run(trajectory.error_at, times)`. An exception of what it waits for, such as
    the cancellation of the task, is raised where it waits."""
    blocking = _Blocking(function)
    blocking.gr_context = getcurrent().gr_context  # it has the context variables of its task
    handed = blocking.switch(*arguments, **more)
    while not blocking.dead:
        try:
            result = await handed
        except BaseException as error:
            handed = blocking.throw(error)
        else:
            handed = blocking.switch(result)
    return cast(T, handed)


def wait(awaitable: Awaitable[T]) -> T:
    """Waits inside `run`."""
    return cast(T, getcurrent().parent.switch(awaitable))


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

    def _begin(self, kind: str, method: tuple[Any, ...], coders: dict[str, Any], request: tuple[Any, ...],
               requests: Optional[Iterator[Any]] = None, timeout: Optional[float] = None, metadata: Any = ()) -> _Call:
        if not isinstance(getcurrent(), _Blocking):
            raise FailedPrecondition("what makes a call of stiefel.aio must be awaited: `await stiefel.aio.run(function, ...)`")
        made = getattr(self.opened, kind)(*method, **coders)
        call = _Call(made(*request, timeout=timeout, metadata=tuple(metadata)), requests)
        self.calls.add(call)
        return call

    def unary_unary(self, *method: Any, **coders: Any) -> Any:
        def with_call(request: Any, **call: Any) -> tuple[Any, _Call]:
            begun = self._begin("unary_unary", method, coders, (request,), **call)
            return begun.result(), begun
        return SimpleNamespace(with_call=with_call)

    def unary_stream(self, *method: Any, **coders: Any) -> Callable[..., _Call]:
        return lambda request, **call: self._begin("unary_stream", method, coders, (request,), **call)

    def stream_stream(self, *method: Any, **coders: Any) -> Callable[..., _Call]:
        """Of a method that answers each request with one reply: reading a reply sends its request."""
        return lambda requests, **call: self._begin("stream_stream", method, coders, (), requests, **call)

    def rest(self, seconds: float) -> None:
        """Waits for `seconds`."""
        wait(asyncio.sleep(seconds))

    def close(self) -> None:
        """Ends every call. Outside `run`, when the process ends, there is no loop that could do so."""
        if self._opened is not None and isinstance(getcurrent(), _Blocking):
            for call in list(self.calls):
                call.cancel()
            wait(self._opened.close())


class _Call:
    """A call, and an iterator over the replies of one with a stream. Tasks that read at the same time take turns."""

    def __init__(self, call: Any, requests: Optional[Iterator[Any]]):
        self._call, self._requests, self._turn, self._left = call, requests, asyncio.Lock(), False

    def result(self) -> Any:
        return self._wait(self._call)

    def __iter__(self) -> _Call:
        return self

    def __next__(self) -> Any:
        reply = self._wait(self._read())
        if reply is _EOF:
            raise StopIteration
        return reply

    async def _read(self) -> Any:
        async with self._turn:
            if self._requests is not None:
                with suppress(asyncio.InvalidStateError):  # the call has ended; reading says how
                    await self._call.write(next(self._requests))
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
