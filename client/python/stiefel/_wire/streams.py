"""The reader of the streams of a call, and a progress bar."""
from __future__ import annotations

from contextlib import closing, nullcontext
from types import SimpleNamespace
from typing import Any, Generic, Iterator, Optional, TypeVar

from stiefel import v1 as pb
from stiefel._results.base import RunStatus
from stiefel._results.extras import imported
from stiefel._wire import replies
from stiefel._wire.recreating import Recreation, refuses_checkpoint
from stiefel._wire.retries import Attempts
from stiefel.errors import DeadlineExceeded, StiefelError, Unavailable

T = TypeVar("T")


class Reading(Generic[T]):
    """Iterates over the parts of a call's answer as they arrive. A stream that breaks is followed by another one, for as long
    as each brings something. The attributes describe what has arrived so far."""

    method: str  #: the RPC
    endless = True  #: whether a call without a timeout of its own has none

    def __init__(self, handle: Recreation, request: Any, timeout: Optional[float]):
        """`timeout`: the time for all streams together. None: none, or without `endless` that of the client, which begins
        anew after each stream that brought something."""
        self._handle, self._request, self._timeout = handle, request, timeout
        self.run_status: Optional[RunStatus] = None  #: set at the end
        self.computed_steps = 0  #: steps computed by all streams so far
        self.work = 0.0  #: instructions, measured, of all streams so far
        self.checkpoint = b""  #: the last checkpoint

    def __iter__(self) -> Iterator[T]:
        attempts = Attempts(self._handle.connection, self._timeout, self._handle, endless=self.endless)
        while True:
            before, work, progress = self._begin(), self.work, False
            try:
                with closing(self._handle.messages(self.method, self._request, attempts.left())) as arriving:
                    for message in arriving:
                        replies.require(message.work > 0, "a message says no work")
                        self.work = work + message.work
                        self.computed_steps = max(before + message.computed_steps, self.computed_steps)
                        part = self._take(message)
                        if part is not None:
                            progress = True
                            yield part
                        ends = message.HasField("run_status")
                        if "checkpoint" in message.DESCRIPTOR.fields_by_name and message.HasField("checkpoint"):
                            self.checkpoint = message.checkpoint.data
                            progress |= self._keep(message, ends)
                        if ends:
                            self.run_status = replies.run_status(message.run_status)
                            self._check_end(message)
                            return
            except StiefelError as broken:
                error: StiefelError = broken
            if self._begins_anew(error):
                continue
            passes = isinstance(error, Unavailable) or error._may_pass or (
                isinstance(error, DeadlineExceeded) and not attempts.has_own)
            if progress and passes:
                attempts.renew()
            else:
                attempts.again(error)

    def _begin(self) -> int:
        """Prepares the request and the object for another stream. Returns the computed steps that its own are added to."""
        raise NotImplementedError

    def _take(self, message: Any) -> Optional[T]:
        """Reads a message, and returns the part of the answer that it completes."""
        raise NotImplementedError

    def _keep(self, message: Any, ends: bool) -> bool:
        """Keeps the checkpoint that has arrived. Returns whether another stream goes on there. `ends`: whether it is the end."""
        raise NotImplementedError

    def _begins_anew(self, error: StiefelError) -> bool:
        """Returns whether the next stream succeeds without the checkpoint that this one got."""
        return False

    def _check_end(self, message: Any) -> None:
        """Checks that all has arrived when the last message has."""
        raise NotImplementedError


class Resuming(Reading[T]):
    """A reading whose requests take a checkpoint, from which the next stream goes on."""

    def __init__(self, handle: Recreation, request: Any, timeout: Optional[float]):
        super().__init__(handle, request, timeout)
        self._given = request.checkpoint  # the caller's
        self.checkpoint = request.checkpoint

    def _keep(self, message: Any, ends: bool) -> bool:
        if not ends:
            self._request.checkpoint = self.checkpoint
        return not ends

    def _begins_anew(self, error: StiefelError) -> bool:
        anew = self._request.checkpoint != self._given and refuses_checkpoint(error)  # by a server of another build
        if anew:
            self._request.checkpoint = self._given
        return anew


def progress_bar(count: Optional[int], wanted: bool, unit: str) -> Any:
    """Returns a bar of tqdm for `count` units, None for an unknown number, as a context manager with `update(number)`; one
    that shows nothing if none is wanted."""
    if not wanted:
        return nullcontext(SimpleNamespace(n=0, update=lambda number: None))
    return imported("tqdm", "progress").tqdm(total=count, unit=unit, unit_scale=True)
