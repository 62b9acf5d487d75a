"""The client of a server: creates and finds sessions, and makes the calls that need none."""
from __future__ import annotations

import functools
import os
from typing import Any, Callable, Iterable, Iterator, Mapping, Optional, Sequence

import grpc
import numpy as np

from stiefel import v1 as pb
from stiefel._given.initial import normalized, orthonormal, with_hint, with_momenta
from stiefel._given.numbers import SECONDS, number, numbers, optional, refused, text, timeout as checked, whole
from stiefel._given.shown import shown
from stiefel._manifold.beta import span_of
from stiefel._results.extras import progress_bar
from stiefel._wire import answers
from stiefel._wire.address import Tls, TlsLike, check, secured
from stiefel._wire.answers import described
from stiefel._wire.arrays import require, to_array
from stiefel._wire.connection import Connection
from stiefel.errors import CorruptReply, InvalidArgument, warn_of_scene
from stiefel.results import Catalogue, ConjugatePoints, Conversion, Geodesic, Tradeoff
from stiefel._scene import SceneLike, to_matrix, to_message, with_epoch
from stiefel._session import Session, created
from stiefel.v1.simulation_pb2_grpc import SimulationServiceStub

__all__ = ["Client", "Tls"]
__dir__ = lambda: sorted(__all__)  # noqa: E731

_OPTIONS = [
    ("grpc.max_receive_message_length", -1),  # a result is one message, and by default gRPC takes 4 MiB
    ("grpc.initial_reconnect_backoff_ms", 50),
    ("grpc.min_reconnect_backoff_ms", 5000),  # the least time that gRPC gives an attempt to connect
    ("grpc.max_reconnect_backoff_ms", 1000),
    # A connection on which nothing has come for 10 s while a call runs is pinged, and given up when nothing comes for
    # 10 s more. The server takes a ping every 9 s. Pings are not held back for want of data between them.
    ("grpc.keepalive_time_ms", 10_000),
    ("grpc.keepalive_timeout_ms", 10_000),
    ("grpc.http2.max_pings_without_data", 0),
]


class Client:
    """A connection to the server at `address`: "host:port" or "unix:/path".

    `address` is by default the environment variable STIEFEL_ADDRESS, or else 127.0.0.1:50551. `timeout` is the deadline
    in seconds of every call that does not get its own; None sets no deadline. A stream or a trajectory may take longer:
    it goes on as long as samples arrive within `timeout` seconds. A server that was reached and went is waited for until
    the deadline, with a line on stderr after 3 s. When the server of a session is lost, the client
    creates the session again if it came from `create` or `fork`; it raises `BuildChanged` if a server of another build
    answers for the session, unless `any_build` is set. As a context manager the client closes itself at the end; a
    later call raises `Closed`. Thread-safe. A pickled client connects anew to the same address, and so does a
    client in a forked child. Fork while no call runs in another thread, which gRPC does not survive.

    `tls`: the path of a file of authorities in PEM, True for the authorities that gRPC comes with, or a `Tls`; by
    default the file that the environment variable STIEFEL_TLS_CA names, or no TLS. `token` tells the server who calls;
    by default the environment variable STIEFEL_TOKEN. Raises InvalidArgument for a token that would travel in plaintext
    beyond this machine, and for what cannot be an address. `channel`: a gRPC channel to use instead; address, tls and token must then be absent.
    """

    @staticmethod
    def _open_channel(open: Callable[[Any, Any], Any]) -> Any:
        return open(grpc, _OPTIONS)

    def __init__(self, address: Optional[str] = None, *, timeout: Optional[float] = 60.0, tls: TlsLike = None,
                 token: Optional[str] = None, channel: Optional[grpc.Channel] = None, any_build: bool = False):
        if channel is not None and not (address is None and tls is None and token is None):
            raise InvalidArgument("channel: address, tls and token are those of the channel")
        self._tls, self._token, self._own_channel = tls, token, channel is None
        self.address = address or os.environ.get("STIEFEL_ADDRESS", "127.0.0.1:50551")
        seconds = checked(timeout)
        if channel is not None:
            self.address = "a channel of the caller's"
            self._connection = Connection(lambda: channel, self.address, seconds, any_build, reopens=False)
            return
        check(text("address", self.address))
        open, has_tls, bearer = secured(self.address, tls, token)
        self._connection = Connection(lambda: self._open_channel(open), self.address, seconds, any_build, has_tls, bearer)

    @property
    def _channel(self) -> grpc.Channel:
        """The gRPC channel. A fork of the process closes it and opens another."""
        return self._connection.channel

    @property
    def timeout(self) -> Optional[float]:
        """The seconds of every call that does not get its own; None for no end."""
        return self._connection.timeout

    @property
    def any_build(self) -> bool:
        """Whether sessions may go on at a server of another build."""
        return self._connection.any_build

    @property
    def _stub(self) -> SimulationServiceStub:
        """The gRPC stub of the service, for calls by hand. Raises `Closed` after `close`."""
        return self._connection.stub

    def describe(self) -> Catalogue:
        """Returns the server's systems, methods, limits and versions."""
        reply: pb.DescribeResponse = self._connection.call("Describe", pb.DescribeRequest())
        require(bool(reply.systems) and bool(reply.methods), "the catalogue is empty")
        return Catalogue(reply)

    def create(self, scene: SceneLike, *, id: Optional[str] = None, checkpoint: bytes = b"", normalize: bool = False) -> Session:
        """Creates a session of `scene`, or returns the existing one with this `id` and scene.

        `id` is by default a new UUID. `checkpoint`: a `State.checkpoint` of the same scene, possibly from another
        server, that fills the session's cache. `normalize`: makes an initial state that was rounded to a few digits fit:
        quaternions of norm 1, orthonormal frames, tangent velocities, skew momenta. The server's warnings about the scene
        are issued as `SceneWarning`. Raises AlreadyExists if the session with this id has another scene.
        """
        message, epoch = with_epoch(scene)
        if normalize:
            message = normalized(message)
        return created(self._connection, message, id, checkpoint, epoch, normalize)

    def get(self, id: str) -> Session:
        """Returns the existing session of this id. Raises NotFound if there is none."""
        request = pb.GetSessionRequest(session_id=text("id", id), return_scene=True)
        reply = self._connection.call("GetSession", request)
        return Session(self._connection, described(reply.session, id), created=False)

    def list(self) -> Iterator[Session]:
        """Iterates over all sessions of the server, ordered by id."""
        token, last = "", ""
        while True:
            reply = self._connection.call("ListSessions", pb.ListSessionsRequest(page_token=token))
            for session in reply.sessions:
                require(session.session_id > last, f"session {session.session_id} comes after {last}")
                last = session.session_id
                yield Session(self._connection, described(session, last, whole=False), created=False)
            token = reply.next_page_token
            require(not token or bool(reply.sessions), "a page without sessions is not the last")
            if not token:
                return

    def delete(self, id: str) -> None:
        """Deletes a session. Deleting an unknown id succeeds."""
        self._connection.call("DeleteSession", pb.DeleteSessionRequest(session_id=text("id", id)))

    def convert(self, scene: SceneLike, *, system: str, epsilon: Optional[float] = None,
                parameter: Optional[float] = None) -> Conversion:
        """Converts a motion to a scene of another `system`, or to the blocks of "velocity", "angular_velocity" or
        "interpolation".

        `epsilon`: the scale of a symmetric or parametric system, chosen by the server when absent. `parameter`: mu of a
        parametric system, the scene's when absent. Raises InvalidArgument if the motion has no such form.
        """
        request = pb.ConvertRequest(
            scene=with_momenta(to_message(scene), self._connection.systems), to=text("system", system),
            epsilon=optional("epsilon", epsilon), parameter=optional("parameter", parameter), return_scene=True)
        return answers.conversion(self._connection.call("Convert", request))

    def geodesics(self, pairs: Iterable[tuple[Any, Any]], *, inertia: Any = (), metric: str = "lambda", beta: Optional[float] = None,
                  time: float = 1.0, steps: int = 0, samples: int = 0, seed: int = 0, restarts: Optional[int] = None,
                  budget: Optional[float] = None, scenes: bool = True, normalize: bool = False,
                  timeout: Optional[float] = None) -> tuple[Geodesic, ...]:
        """Returns the geodesics that join pairs (Q_0, Q_T) of frames of one shape, in the order of the pairs, from Q_0 at time 0
        to Q_T at `time`: `client.geodesics([(Q_0, Q_T)], inertia=[1, 2, 3])[0]`.

        `metric`: "lambda" (that of `inertia`), "euclidean" (Lambda = I), "canonical", or "beta" with the number `beta`
        (Hüper, Markina and Silva Leite 2021); the last three without `inertia`. `steps` > 0 solves the discrete problem of as
        many steps of the variational method. `samples`: samples of the trajectory after the first, 0 for none. `seed` and
        `restarts`: the seed and the number of the searches that start from random frames or velocities. `budget`: seconds,
        counted in operations, after which the search for a pair ends with the shortest geodesic so far, whose `shortest` is
        then "ended", or with SOLVER_STALLED; at most, and by default, 200. `scenes`: whether each answer has its scene beside
        its velocity, where the metric has one. `normalize`: takes the nearest frames of what was rounded to a few
        digits.
        """
        if not isinstance(pairs, Iterable):
            raise refused("pairs", f"{shown(pairs)}: must be several pairs of frames (Q_0, Q_T)")
        given: Sequence[tuple[Any, Any]] = list(pairs)
        for i, pair in enumerate(given):
            if not isinstance(pair, (tuple, list, np.ndarray)) or len(pair) != 2 or np.ndim(pair[0]) < 2 and not isinstance(pair[0], Mapping):
                raise refused(f"pairs[{i}]", f"{shown(pair)}: must be two frames (Q_0, Q_T)")
        if metric == "lambda" and not np.size(inertia):
            raise refused("inertia", "is empty: must have the N numbers of Lambda, or metric be euclidean, canonical or beta")

        def messages(normalize: bool) -> list[pb.FramePair]:
            return [_frame_pair(Q_0, Q_T, f"pairs[{i}].", normalize) for i, (Q_0, Q_T) in enumerate(given)]
        lambdas = _lambdas(inertia)
        span = None if steps or normalize else span_of(given, lambdas)
        if span is not None:
            given, lambdas = list(zip(span.start, span.end)), lambdas[:span.end.shape[-1]]
        request = pb.ConnectRequest(
            pairs=messages(normalize), metric=_metric(metric), inertia=lambdas, time=number("time", time, SECONDS),
            restarts=None if restarts is None else whole("restarts", restarts, bits=32),
            beta=None if beta is None else number("beta", beta), budget=optional("budget", budget, SECONDS),
            return_scene=scenes,
            steps=whole("steps", steps, bits=32), samples=whole("samples", samples, bits=32), seed=whole("seed", seed, bits=63))
        try:
            replies = {reply.pair: reply for reply in self._connection.call_all("Connect", request, timeout)}
        except InvalidArgument as error:
            raise error if normalize else with_hint(error, lambda: messages(True) != list(request.pairs)) from None
        if sorted(replies) != list(range(len(given))):
            raise CorruptReply(f"the server answered {len(replies)} of {len(given)} pairs")
        return tuple(answers.geodesic(replies[pair], request, span) for pair in range(len(given)))

    def conjugate_points(self, Q: Any, *, Qdot: Any, inertia: Any, time: float = 1.0,
                         timeout: Optional[float] = None) -> ConjugatePoints:
        """Returns the conjugate points up to `time` along the geodesic that starts at the frame Q with the velocity Qdot.

        The metric is tr(Lambda Qdot^T Qdot), Lambda = diag(inertia); n = N is SO(N). A geodesic is not the shortest beyond
        its first conjugate point.
        """
        request = pb.ConjugatePointsRequest(inertia=_lambdas(inertia), q=to_matrix(Q, "Q"), qdot=to_matrix(Qdot, "Qdot"),
                                            time=number("time", time, SECONDS))
        return answers.conjugate_points(self._connection.call("ConjugatePoints", request, timeout), request)

    def tradeoff(self, scene: SceneLike, *, horizon: Optional[float] = None, budget: Optional[float] = None,
                 repeats: Optional[int] = None, timeout: Optional[float] = None, progress: bool = False) -> Tradeoff:
        """Measures error against cost of every method on `scene`, whose own method is ignored.

        `horizon`: the time at which errors are measured; by default the scene's horizon, or else 100 steps. `budget`:
        instructions that the measurement may take; by default 5e10, about ten seconds. `repeats`: timed
        runs of each point; by default 3. `progress`: shows a count of tqdm. The server's warnings are issued as `SceneWarning`.
        """
        request = pb.MeasureTradeoffRequest(
            scene=with_momenta(to_message(scene), self._connection.systems), horizon=optional("horizon", horizon, SECONDS),
            budget=optional("budget", budget), repeats=None if repeats is None else whole("repeats", repeats, bits=32))
        with progress_bar(None, progress, " points") as bar:
            tradeoff = answers.tradeoff(self._connection.call_all("MeasureTradeoff", request, timeout,
                                                                  lambda part: bar.update(part.HasField("point"))))
        for warning in tradeoff.warnings:
            warn_of_scene(warning)
        return tradeoff

    def close(self) -> None:
        """Closes the connection and ends running calls. Sessions stay on the server."""
        self._connection.close()

    @property
    def closed(self) -> bool:
        """Whether `close` was called."""
        return self._connection.closed

    def __reduce__(self) -> Any:
        if not self._own_channel:
            raise TypeError("a client of the caller's channel cannot be pickled: give the client an address")
        if self._token is not None:
            raise TypeError("a client with a token cannot be pickled, because the token would be written out: set the "
                            "environment variable STIEFEL_TOKEN in every process instead")
        return functools.partial(Client, timeout=self.timeout, tls=self._tls,
                                 any_build=self.any_build), (self.address,)

    def __enter__(self) -> Client:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<stiefel.Client of {self.address}{', closed' if self.closed else ''}>"


def _lambdas(inertia: Any) -> Any:
    given = numbers("inertia", inertia)
    if given.ndim != 1:
        raise refused("inertia", f"the shape {given.shape}: must be (numbers)")
    return given.tolist()


def _frame_pair(Q_0: Any, Q_T: Any, path: str, normalize: bool) -> pb.FramePair:
    """Returns two frames as a message. `path` is that of the pair in errors."""
    pair = pb.FramePair()
    for name, frame, out in (("Q_0", Q_0, pair.q_0), ("Q_T", Q_T, pair.q_t)):
        if np.ndim(frame) == 2 and np.shape(frame)[0] > np.shape(frame)[1]:
            raise refused(path + name, f"the shape {np.shape(frame)}: it looks transposed: frames have their vectors as rows")
        if normalize:
            frame = orthonormal(path + name, to_array(to_matrix(frame, path + name)))
        out.CopyFrom(to_matrix(frame, path + name))
    return pair


def _metric(name: str) -> Any:
    known: dict[str, int] = {value[len("METRIC_"):].lower(): number for value, number in pb.Metric.items()}
    if name not in known:
        raise refused("metric", f"{name!r}: must be one of {', '.join(key for key in known if key != 'unspecified')}")
    return known[name]
