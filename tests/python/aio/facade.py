"""stiefel.aio used as the blocking client is: its event loop runs in a thread, and what is awaited is waited for. `pytest --aio`
gives it to the tests in place of `stiefel.Client`."""
import asyncio
import functools
import inspect
import threading

import stiefel.aio

_loop = asyncio.new_event_loop()
_thread = threading.Thread(target=_loop.run_forever, daemon=True)
_thread.start()


def result_of(awaitable):
    async def awaited():
        return await awaitable
    coming = asyncio.run_coroutine_threadsafe(awaited(), _loop)
    return None if threading.current_thread() is _thread else coming.result()  # where the collector ends a generator


def blocking(value):
    """What the blocking client would have returned."""
    if inspect.isasyncgen(value):
        return iterated(value)
    if inspect.isawaitable(value):
        return blocking(result_of(value))
    if isinstance(value, (stiefel.aio.Client, stiefel.aio.Session, stiefel.aio.Drive)):
        return Facade(value)
    if inspect.ismethod(value):
        return lambda *arguments, **more: blocking(value(*arguments, **more))
    return value


def iterated(parts):
    try:
        while True:
            yield blocking(result_of(parts.__anext__()))
    except StopAsyncIteration:
        pass
    finally:
        result_of(parts.aclose())


class Facade:
    def __init__(self, of):
        vars(self)["_of"] = of

    def __getattr__(self, name):
        """What is private is that of the blocking object behind."""
        if name.startswith("_"):
            return getattr(self._of._blocking, name)

        async def get():  # a channel is that of the running loop
            value = getattr(self._of, name)
            return await value if inspect.iscoroutine(value) else value
        return blocking(result_of(get()))

    def __reduce__(self):
        made, arguments = self._of.__reduce__()
        return functools.partial(client, **made.keywords), arguments

    def __enter__(self):
        return blocking(self._of.__aenter__())

    def __exit__(self, *exception):
        result_of(self._of.__aexit__(*exception))

    def __repr__(self):
        return repr(self._of).replace("stiefel.aio.", "stiefel.")


def client(*arguments, **more):
    return Facade(stiefel.aio.Client(*arguments, **more))


def session(*arguments, **more):
    """Of the arguments of a `stiefel.Session`, which makes no call."""
    return Facade(stiefel.aio.Session(stiefel.session.Session(*arguments, **more)))
