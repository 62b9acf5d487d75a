"""Reduces motions to the statistics of their samples, on the server that runs them."""
from __future__ import annotations

import os
import socket
import uuid
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import Iterator, Optional

from stiefel import v1 as pb
from stiefel._given.shown import shown
from stiefel._results.base import Array
from stiefel.client import Client
from stiefel.errors import StiefelError
from stiefel._given.numbers import refused
from stiefel._given.summaries import Quantities, to_quantities
from stiefel._wire.recreating import Recreation
from stiefel._wire.replies import described
from stiefel._wire.summarizing import Summarizing
from stiefel._sweep.failures import OtherNumerics
from stiefel._sweep.fold import check

OUTCOME = "outcome"
_UNUSED = ("ended_by",)  #: arrays of a summary that a sweep drops, because they are about events


@dataclass(frozen=True, eq=False)
class Reduced:
    """The statistics of a chunk, each (members, ...), and the numerics id of the server that computed them."""

    arrays: dict[str, Array]
    numerics_id: str
    warnings: tuple[str, ...] = ()  #: of the server about the scene


def request_of(to: int, start: int, every: int, summarize: Quantities) -> pb.SummarizeRequest:
    """Returns the request without a session. Raises InvalidArgument if `summarize` is malformed, for example with an
    unknown statistic."""
    if not hasattr(summarize, "items") or not summarize:
        raise refused("summarize", f"{shown(summarize)}: must be a mapping from fields and invariants to statistics")
    request = pb.SummarizeRequest(to=to, every=every, quantities=to_quantities(summarize))
    setattr(request, "from", start)
    for quantity in request.quantities:
        place = f"summarize[{quantity.name!r}]"
        if quantity.over_members:
            check(quantity, place)
        if not (quantity.statistics or quantity.quantiles or quantity.edges):
            raise refused(place, "nothing is asked for: must have a statistic, quantiles or edges")
    return request


def reduce(client: Client, scene: pb.Scene, request: pb.SummarizeRequest, numerics_id: str,
           timeout: Optional[float]) -> Reduced:
    """Returns the statistics of every member of the ensemble `scene`. Raises OtherNumerics if the server has another
    numerics id, so that its bits could differ."""
    with temporary_session(client, scene, numerics_id) as session:
        arrays = summary_of(client, session, request, True, timeout)
        return Reduced({name: array for name, array in arrays.items() if name not in _UNUSED}, session.numerics_id,
                       tuple(session.warnings))


def summary_of(client: Client, session: pb.Session, request: pb.SummarizeRequest, ensemble: bool,
               timeout: Optional[float]) -> dict[str, Array]:
    """Makes a Summarize and returns its arrays by their names on the wire."""
    asked = pb.SummarizeRequest()
    asked.CopyFrom(request)
    asked.session_id = session.session_id
    running = Summarizing(Recreation(client._connection, session), asked, ensemble, timeout)
    for _ in running:
        pass
    return running.arrays


@contextmanager
def temporary_session(client: Client, scene: pb.Scene, numerics_id: str) -> Iterator[pb.Session]:
    """Creates a session that is deleted at the end. Raises OtherNumerics if the server's numerics id is not
    `numerics_id`, which is not checked if empty."""
    request = pb.CreateSessionRequest(session_id=str(uuid.uuid4()), scene=scene)
    session = described(client._connection.call("CreateSession", request).session, request.session_id)
    try:
        if numerics_id not in ("", session.numerics_id):
            raise OtherNumerics(f"the server of process {os.getpid()} on {socket.gethostname()} has the numerics id "
                                f"{session.numerics_id}, the sweep {numerics_id}: install one build on all workers")
        yield session
    finally:
        with suppress(StiefelError):  # the server drops idle sessions
            client._connection.call("DeleteSession", pb.DeleteSessionRequest(session_id=session.session_id), waits=False)
