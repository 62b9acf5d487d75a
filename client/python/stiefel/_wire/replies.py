"""Checks that a reply has what the protocol promises: the shapes of its arrays, its steps, and how its run ended. A message that
is absent has enums of the value 0, which no reply has. What breaks the protocol raises CorruptReply."""
from __future__ import annotations

from typing import Any, Iterable, Mapping, Optional

from google.protobuf.message import Message

from stiefel import v1 as pb
from stiefel._results.base import Array, Outcome, RunStatus
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


def ends_at(status: pb.RunStatus, step: int, to: int) -> None:
    """Checks that a run to step `to` that ended at `step` was at `to` exactly if it REACHED it."""
    reached = run_status(status).outcome == Outcome.REACHED
    require(step == to if reached else 0 <= step < to, f"{pb.Outcome.Name(status.outcome)} at step {step} of {to}")


class Layout:
    """The names, types and shapes of the fields that arrive batch by batch: every batch has those of the first."""

    def __init__(self, wanted: Iterable[str]):
        """`wanted`: the names that were asked for; if empty, the server decides on the fields."""
        self._wanted = set(wanted)
        self._first: Optional[dict[str, Any]] = None

    def check(self, fields: Mapping[str, Array], count: Optional[int] = None) -> None:
        """`count`: the elements of the batch, along the first axis; None where the arrays are a single element."""
        batch = count is not None
        found = {name: (array.dtype, array.shape[batch:]) for name, array in fields.items()}
        if self._first is None:
            require(len(found) > 0 and found.keys() == (self._wanted or found.keys()), f"it has the fields {', '.join(found)}")
            self._first = found
        require(found == self._first and all(array.ndim >= 2 + batch and array.dtype.kind in "fc" and (not batch or len(array) == count)
                                             for array in fields.values()), "its fields have other names, types or shapes")
