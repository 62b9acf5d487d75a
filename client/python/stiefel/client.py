"""The client: sessions by name, and what the server can do."""
from __future__ import annotations

import os
import uuid
import warnings
from typing import Any, Iterator, Optional

import grpc

from stiefel import calls
from stiefel.answers import Conversion, Geodesic
from stiefel.errors import Closed, SceneWarning, StiefelError, from_rpc_error
from stiefel.scenes import SceneLike, to_matrix, to_message
from stiefel.session import Session
from stiefel.tradeoff import Tradeoff
from stiefel.v1 import simulation_pb2 as pb
from stiefel.v1 import tradeoff_pb2
from stiefel.v1.simulation_pb2_grpc import SimulationServiceStub

_OPTIONS = [
    ("grpc.max_receive_message_length", -1),
    ("grpc.max_send_message_length", -1),
    ("grpc.initial_reconnect_backoff_ms", 50),
    ("grpc.min_reconnect_backoff_ms", 50),
    ("grpc.max_reconnect_backoff_ms", 1000),
]


class Client:
    """A connection to the server at `address`: "host:port" or "unix:/path".

    `timeout` is the deadline of every call in seconds, unless the call is given its own; None waits
    for ever. Of a stream or a trajectory, which may be long, it bounds what comes at a time: one that
    has brought something in `timeout` seconds goes on. As a context manager it closes itself at the
    end; what is called after that raises `Closed`. Safe to use from many threads.
    """

    def __init__(self, address: Optional[str] = None, timeout: Optional[float] = 60.0):
        self.address = address or os.environ.get("STIEFEL_ADDRESS", "127.0.0.1:50551")
        self.timeout = timeout
        self.channel = grpc.insecure_channel(self.address, options=_OPTIONS)
        self._stub = SimulationServiceStub(self.channel)  # type: ignore[no-untyped-call]
        self._closed = False

    @property
    def stub(self) -> SimulationServiceStub:
        """The calls as gRPC makes them. Raises `Closed`."""
        if self._closed:
            raise self._closed_error()
        return self._stub

    def describe(self) -> pb.DescribeResponse:
        """Systems, methods, limits, versions."""
        reply: pb.DescribeResponse = self.call("Describe", pb.DescribeRequest())
        return reply

    def create(self, scene: SceneLike, id: Optional[str] = None, checkpoint: bytes = b"") -> Session:
        """A session of `scene`; the existing one if `id` names one of the same scene.

        `checkpoint` is a `State.checkpoint` of the same scene, possibly from another server. What the
        server finds doubtful about the scene is issued as `SceneWarning`.
        """
        request = pb.CreateSessionRequest(session_id=str(uuid.uuid4()) if id is None else id,
                                          scene=to_message(scene), checkpoint=checkpoint)
        reply = self.call("CreateSession", request)
        for text in reply.session.warnings:
            warnings.warn(text, SceneWarning, stacklevel=2)
        return Session(self, reply.session, reply.created)

    def get(self, id: str) -> Session:
        """The session of that id; NotFound if there is none."""
        reply = self.call("GetSession", pb.GetSessionRequest(session_id=id))
        return Session(self, reply.session, created=False)

    def list(self) -> Iterator[Session]:
        """All sessions of the server, ordered by id."""
        token = ""
        while True:
            reply = self.call("ListSessions", pb.ListSessionsRequest(page_token=token))
            yield from (Session(self, session, created=False) for session in reply.sessions)
            token = reply.next_page_token
            if not token:
                return

    def delete(self, id: str) -> None:
        """Deleting an unknown id succeeds."""
        self.call("DeleteSession", pb.DeleteSessionRequest(session_id=id))

    def convert(self, scene: SceneLike, to: str, epsilon: Optional[float] = None,
                parameter: Optional[float] = None) -> Conversion:
        """The same motion as a scene of the system `to`, or as its "velocity", "angular_velocity" or
        "interpolation"."""
        return Conversion.of(self.call("Convert", pb.ConvertRequest(
            scene=to_message(scene), to=to, epsilon=epsilon, parameter=parameter)))

    def geodesic(self, inertia: Any, Q_0: Any, Q_T: Any, time: float = 1.0, steps: int = 0,
                 samples: int = 0, seed: int = 0, restarts: Optional[int] = None,
                 timeout: Optional[float] = None) -> Geodesic:
        """The geodesic from the frame Q_0 to the frame Q_T in that time; with `steps` the discrete one."""
        return Geodesic.of(self.call("Connect", pb.ConnectRequest(
            inertia=inertia, q_0=to_matrix(Q_0, "Q_0"), q_t=to_matrix(Q_T, "Q_T"), time=time, steps=steps,
            samples=samples, seed=seed, restarts=restarts), timeout))

    def tradeoff(self, scene: SceneLike, horizon: Optional[float] = None, budget: Optional[float] = None,
                 repeats: Optional[int] = None, timeout: Optional[float] = None) -> Tradeoff:
        """Error against cost of every method on `scene`, whose own method is not looked at.

        The horizon is the scene's, or 100 steps, when absent; the budget, in units of work, about ten
        seconds.
        """
        return Tradeoff.of(self.tradeoff_parts(scene, horizon, budget, repeats, timeout))

    def tradeoff_parts(self, scene: SceneLike, horizon: Optional[float] = None,
                       budget: Optional[float] = None, repeats: Optional[int] = None,
                       timeout: Optional[float] = None) -> Iterator[tradeoff_pb2.MeasureTradeoffResponse]:
        """The same, part by part as they arrive; to leave the iteration ends the measurement."""
        request = tradeoff_pb2.MeasureTradeoffRequest(scene=to_message(scene), horizon=horizon, budget=budget,
                                            repeats=repeats)
        stream = self.stub.MeasureTradeoff(request, timeout=self.deadline(timeout))
        try:
            yield from stream
        except grpc.RpcError as failure:
            raise self.error(failure) from None
        finally:
            stream.cancel()

    def call(self, method: str, request: Any, timeout: Optional[float] = None) -> Any:
        """One unary call by name, with the deadline, the retries and the exceptions of this package."""
        return calls.call(lambda left: getattr(self.stub, method)(request, timeout=left), self.error,
                          self.deadline(timeout))

    def error(self, failure: Exception) -> StiefelError:
        """This package's exception for gRPC's."""
        if self._closed:  # gRPC says so with a ValueError or CANCELLED
            return self._closed_error()
        if isinstance(failure, grpc.RpcError):
            return from_rpc_error(failure)
        raise failure

    def _closed_error(self) -> Closed:
        return Closed(f"the client of {self.address} is closed")

    def deadline(self, timeout: Optional[float]) -> Optional[float]:
        return self.timeout if timeout is None else timeout

    def close(self) -> None:
        """Ends what is still running. Sessions stay on the server."""
        self._closed = True
        self.channel.close()

    @property
    def closed(self) -> bool:
        return self._closed

    def __enter__(self) -> Client:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<stiefel.Client of {self.address}{', closed' if self._closed else ''}>"
