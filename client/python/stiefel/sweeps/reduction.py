"""What a sweep reads of a motion: the statistics of its samples, made where the motion is."""
from __future__ import annotations

import os
import reprlib
import socket
import uuid
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import Any, Iterator, Mapping, Sequence, Union

import numpy as np

from stiefel import v1 as pb
from stiefel.arrays import Array
from stiefel.assembly import Assembly
from stiefel.checksums import verify
from stiefel.client import Client
from stiefel.errors import InvalidArgument, StiefelError, Violation
from stiefel.names import names
from stiefel.sweeps.failures import OtherNumerics

#: Statistics by name, or `statistics`, `quantiles` and `edges` of a histogram.
Wanted = Union[str, Sequence[str], Mapping[str, Any]]
STATISTICS: tuple[str, ...] = tuple(name[len("STATISTIC_"):].lower() for name in pb.Statistic.keys()[1:])
OUTCOME, LAST_STEP = "outcome", "last_step"
# What Summarize says of the whole ensemble, and of events, which a sweep does not ask for.
_UNUSED = ("samples", "ended_by")


@dataclass(frozen=True, eq=False)
class Reduced:
    """The statistics of a chunk, each (members, ...), and the build that computed them."""

    arrays: dict[str, Array]
    numerics_id: str


def request_of(to: int, start: int, every: int, summarize: Mapping[str, Wanted]) -> pb.SummarizeRequest:
    """The request without a session. InvalidArgument where a statistic has no such name."""
    if not isinstance(summarize, Mapping) or not summarize:
        rule = f"{reprlib.repr(summarize)}: must be a mapping from fields and invariants to their statistics"
        raise InvalidArgument(f"summarize: {rule}", (Violation("summarize", rule),))
    request = pb.SummarizeRequest(to=to, every=every, quantities=[_quantity(*item) for item in summarize.items()])
    setattr(request, "from", start)
    return request


def _quantity(name: str, wanted: Wanted) -> pb.Quantity:
    place = f"summarize[{name!r}]"
    if not isinstance(wanted, Mapping):
        wanted = {"statistics": wanted}
    unknown = [key for key in wanted if key not in ("statistics", "quantiles", "edges")]
    statistics = names(place, wanted.get("statistics"))
    wrong = [Violation(place, f"{key}: must be statistics, quantiles or edges") for key in unknown]
    wrong += [Violation(place, f"{one}: must be one of {', '.join(STATISTICS)}") for one in statistics if one not in STATISTICS]
    if not wrong and not any(wanted.values()):
        wrong.append(Violation(place, "nothing is asked for"))
    if wrong:
        raise InvalidArgument("; ".join(f"{v.field}: {v.description}" for v in wrong), tuple(wrong))
    return pb.Quantity(name=name, statistics=[pb.Statistic.Value(f"STATISTIC_{one.upper()}") for one in statistics],
                       quantiles=wanted.get("quantiles", ()), edges=wanted.get("edges", ()))


def reduce(client: Client, scene: pb.Scene, request: pb.SummarizeRequest, numerics_id: str) -> Reduced:
    """The statistics of every member of the ensemble `scene`. OtherNumerics where the server's bits would be others."""
    with temporary_session(client, scene, numerics_id) as session:
        asked = pb.SummarizeRequest()
        asked.CopyFrom(request)
        asked.session_id, asked.checksum = session.session_id, client.checksums
        assembly = Assembly()
        for reply in client.call_all("Summarize", asked):
            numbers = [np.int64(reply.step).tobytes(), *(field.value.data for field in reply.statistics)]
            verify(reply, numbers, "a message of the summary")
            assembly.take(reply.statistics)
        arrays = {name: np.array(array) for name, array in assembly.finish().items() if name not in _UNUSED}
        return Reduced(arrays, session.numerics_id)


@contextmanager
def temporary_session(client: Client, scene: pb.Scene, numerics_id: str) -> Iterator[pb.Session]:
    """A session that is deleted at the end. OtherNumerics where the server has another numerics id than that
    given, which may be empty."""
    reply = client.call("CreateSession", pb.CreateSessionRequest(session_id=str(uuid.uuid4()), scene=scene))
    session = reply.session
    try:
        if numerics_id not in ("", session.numerics_id):
            raise OtherNumerics(f"the server of process {os.getpid()} on {socket.gethostname()} has the numerics id "
                                f"{session.numerics_id}, the sweep {numerics_id}: install one build on all workers")
        yield session
    finally:
        with suppress(StiefelError):  # the server drops idle sessions
            client.delete(session.session_id)
