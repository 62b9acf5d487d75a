"""The reader of the streams of a call, and a progress bar."""
from __future__ import annotations

from contextlib import closing, nullcontext
from types import SimpleNamespace
from typing import Any, Generic, Iterator, Optional, TypeVar

import grpc

from stiefel._results.base import Outcome, RunStatus
from stiefel._results.extras import imported
from stiefel._wire import replies
from stiefel._wire.recreating import Recreation
from stiefel._wire.retries import Attempts
from stiefel.errors import CorruptReply, StiefelError

T = TypeVar("T")


class Reading(Generic[T]):
    """Iterates over the parts of a call's answer as they arrive. A stream that breaks is followed by another one, from its last
    checkpoint if the request takes one. The attributes describe what has arrived so far."""

    endless = True  #: whether a call without a timeout of its own has none

    def __init__(self, handle: Recreation, request: Any, timeout: Optional[float]):
        """`timeout`: the time for all streams together. None: none, or without `endless` that of the client, which begins
        anew with each part that arrives."""
        self._handle, self._request, self._timeout = handle, request, timeout
        self._method = type(request).__name__[:-len("Request")]
        self.run_status = RunStatus(Outcome.CANCELLED)  #: that of the answer, at the end
        self.computed_steps = 0  #: steps computed by all streams so far
        self.work = 0.0  #: instructions, measured, of all streams so far
        self.checkpoint: bytes = getattr(request, "checkpoint", b"")  #: the last checkpoint

    def __iter__(self) -> Iterator[T]:
        attempts = Attempts(self._handle, self._request, self._timeout, endless=self.endless)
        while True:
            before, work = self._begin(), self.work
            try:
                with closing(self._handle.messages(self._method, self._request, attempts.left())) as arriving:
                    for message in arriving:
                        replies.require(message.work > 0, "a message says no work")
                        self._handle.reached = getattr(message, "step", self._handle.reached)
                        self.work = work + message.work
                        self.computed_steps = max(before + message.computed_steps, self.computed_steps)
                        part = self._take(message)
                        if part is not None:
                            attempts.renew()
                            yield part
                        ends = message.HasField("run_status")
                        if "checkpoint" in message.DESCRIPTOR.fields_by_name and message.HasField("checkpoint"):
                            self.checkpoint = message.checkpoint.data
                            self._keep(message)
                            if not ends and hasattr(self._request, "checkpoint"):
                                self._request.checkpoint = self.checkpoint
                                attempts.renew()
                        if ends:
                            self.run_status = replies.run_status(message.run_status)
                            self._check_end(message)
                            return
                raise CorruptReply("the stream ended without saying how the run ended: a part of it is missing")
            except (StiefelError, grpc.RpcError, ValueError) as broken:
                attempts.again(broken)

    def _begin(self) -> int:
        """Prepares the request and the object for another stream. Returns the computed steps that its own are added to."""
        return self.computed_steps

    def _take(self, message: Any) -> Optional[T]:
        """Reads a message, and returns the part of the answer that it completes."""
        raise NotImplementedError

    def _keep(self, message: Any) -> None:
        """Keeps what stands behind the checkpoint of a message."""

    def _check_end(self, message: Any) -> None:
        """Checks that all has arrived when the last message has."""
        raise NotImplementedError


def progress_bar(count: Optional[int], wanted: bool, unit: str) -> Any:
    """Returns a bar of tqdm for `count` units, None for an unknown number, as a context manager with `update(number)`; one
    that shows nothing if none is wanted."""
    if not wanted:
        return nullcontext(SimpleNamespace(n=0, update=lambda number: None))
    return imported("tqdm", "progress").tqdm(total=count, unit=unit, unit_scale=True)
