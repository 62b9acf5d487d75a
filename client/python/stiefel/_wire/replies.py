"""Checks that a reply has what the protocol promises: the shapes of its arrays, its steps, and how its run ended. A message that
is absent has enums of the value 0, which no reply has. What breaks the protocol raises CorruptReply."""
from __future__ import annotations

from typing import Any, Iterable, Mapping, Optional, Sequence

import numpy as np
from google.protobuf.message import Message
from numpy.typing import NDArray

from stiefel import v1 as pb
from stiefel._given.shapes import is_repeated
from stiefel._results.base import Array, Outcome, Price, RunStatus
from stiefel.errors import CorruptReply

def require(holds: bool, fault: str) -> None:
    if not holds:
        raise CorruptReply(f"the reply breaks the protocol: {fault}")


def described(session: pb.Session, id: str) -> pb.Session:
    """Returns the description of the session `id`."""
    require(session.session_id == id, f"the session is {session.session_id!r}, not {id}")
    return session


def name_of(kind: Any, value: int) -> str:
    """Returns the name of an enum's value without its prefix, which is the name of the value 0 without UNSPECIFIED: "REACHED"
    for OUTCOME_REACHED. Raises CorruptReply for the value 0 and for an unknown one."""
    require(value != 0 and value in kind.values(), f"{kind.DESCRIPTOR.name} {value}")
    return str(kind.Name(value))[len(kind.Name(0)) - len("UNSPECIFIED"):]


def optional(message: Message, name: str) -> Any:
    """Returns the message's field; None if it is absent."""
    return getattr(message, name) if message.HasField(name) else None


def run_status(message: pb.RunStatus) -> RunStatus:
    return RunStatus(Outcome(name_of(pb.Outcome, message.outcome)), optional(message, "largest_step"), message.message,
                     optional(message, "member"))


def price(message: pb.Price) -> Price:
    return Price(message.work, message.bytes)


def ends_at(status: pb.RunStatus, step: int, to: int) -> None:
    """Checks that a run to step `to` that ended at `step` was at `to` exactly if it REACHED it."""
    reached = run_status(status).outcome == Outcome.REACHED
    require(step == to if reached else 0 <= step < to, f"{pb.Outcome.Name(status.outcome)} at step {step} of {to}")


class Layout:
    """The names, types and shapes of the fields that arrive batch by batch: every batch has those of the first."""

    def __init__(self, wanted: Iterable[str], axes: Sequence[int], blocks: int = 0):
        """`wanted`: the names that were asked for; if empty, those of the variables in which the scene is given, of which
        there are `blocks`, or any number where that is 0. `axes`: how many axes the array of a batch may have; the first
        one counts its elements."""
        self._wanted, self._blocks = set(wanted), blocks
        self._axes = axes
        self._first: Optional[dict[str, Any]] = None

    def check(self, fields: Mapping[str, Array], count: Optional[int] = None) -> None:
        """`count`: the elements of the batch; None where the arrays are a single element."""
        found = {name: (array.dtype, array.shape[count is not None:]) for name, array in fields.items()}
        if self._first is None:
            most = len(self._wanted) or self._blocks or len(found)
            require(self._wanted <= set(found) and len(found) == most > 0, f"it has the fields {', '.join(found)}")
            for name, array in fields.items():
                require(array.ndim in self._axes and array.dtype.kind in "fc",
                        f"{name} is an array of {array.dtype} with the shape {array.shape}")
            self._first = found
        require(found == self._first, "its fields are not those before, or have other shapes")
        if count is not None:
            require(all(len(array) == count for array in fields.values()), "its fields do not have one element for each sample")


class Steps:
    """The steps of a stream's samples: from, from + every, ... and `to`, or the last good step where the run stops."""

    def __init__(self, request: pb.StreamRequest):
        self._next: int = getattr(request, "from")
        self._every, self._to = request.every or 1, request.to
        self._over = False

    def take(self, message: pb.StreamResponse) -> NDArray[np.int64]:
        """Returns the steps of a message with samples. Only the first and the last one are read, because reading repeated
        numbers one by one would cost more than all the fields together."""
        count, last = len(message.steps), message.steps[-1]
        steps = self._next + self._every * np.arange(count)
        end = min(self._next + self._every * (count - 1), self._to)
        require(not self._over and (count == 1 or message.steps[0] == self._next) and 0 <= last <= end,
                "its samples are not those that come next")
        require(len(message.times) == count, "its samples do not have one time each")
        steps[-1] = last
        self._over = last < end or last == self._to
        self._next = last + self._every
        return steps

    def end(self, status: RunStatus, last: Optional[int]) -> None:
        """Checks the end of a stream whose last sample was at step `last`; None without samples."""
        require((status.outcome == Outcome.REACHED) == (last == self._to), f"{status.outcome} at step {last} of {self._to}")
