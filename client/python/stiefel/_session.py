"""A session: a pure function from step index to state, so every call names an absolute step."""
from __future__ import annotations

import uuid
from dataclasses import replace
from typing import Any, Callable, Iterator, Mapping, Optional, Sequence, TypeVar, Union, cast

import numpy as np
from numpy.typing import NDArray

from stiefel import v1 as pb
from stiefel._given.instants import instant
from stiefel._given.mappings import Names, names
from stiefel._given.initial import normalized, with_given_names, with_hint, with_momenta
from stiefel._given.numbers import SECONDS, optional, refused, step_index, text, whole
from stiefel._given.shown import shown
from stiefel._given.summaries import (Bracket, EventDescription, Form, Quantities, put_structure, to_events,
                                      to_quantities)
from stiefel._given.sections import Coordinate, column, columns, of_section, to_section
from stiefel._given.when import every_of, step_of, time_of
from stiefel._given.typed import Blocks, Body, Fields, Method, MethodName, Scene
from stiefel._results.base import joined
from stiefel._results.origin import Origin, side_of
from stiefel._wire import answers
from stiefel._wire.answers import described
from stiefel._wire.calls import Calls
from stiefel._wire.connection import Connection
from stiefel._wire.driving import Drive
from stiefel._wire.streams import Samples, Summarizing
from stiefel._wire.tangents import covariance, grown, linearized
from stiefel._wire.times import between_steps, errors_at, trajectory
from stiefel.errors import (DeadlineExceeded, FailedPrecondition, InvalidArgument, StiefelError, Unavailable, warn_of_scene)
from stiefel.results import (Batch, Choice, Diagnosis, EstimatedErrors, Events, LyapunovSpectrum, Outcome, Price, Section,
                             State, StateTransition, Summary, Trajectory)
from stiefel._scene import to_dict, to_method, with_changes

__all__ = ["Drive", "Session"]
__dir__ = lambda: sorted(__all__)  # noqa: E731

T = TypeVar("T")
_ESTIMATION = {True: pb.ERROR_ESTIMATION_ALWAYS, False: pb.ERROR_ESTIMATION_UNSPECIFIED, None: pb.ERROR_ESTIMATION_IF_CHEAPER}


class Session:
    """A simulation held by a server, made by `Client.create` or `Client.get`.

    As a context manager it deletes the session at the end, unless its server is gone then. A session from
    `Client.create` or `fork` survives the loss of its server: the next call creates it again, from the last checkpoint that
    has arrived, and goes on. A deleted session is not created again, whoever deleted it.
    """

    def __init__(self, connection: Connection, message: pb.Session, created: bool, owner: bool = False,
                 checkpoint: bytes = b"", epoch: Optional[str] = None):
        """`message`: the server's reply, with its scene, except of a session from `Client.list`. `owner`: whether this
        handle created the session, with `checkpoint`."""
        self._connection, self._message = connection, message
        self.created = created  #: False if the session existed already
        #: The instant of time 0, such as "1992-11-09T17:49:47 UTC"; None if the scene has none, and for sessions from
        #: `Client.get` and `Client.list`, because the server does not know it.
        self.epoch = epoch
        self._calls = Calls(connection, message, message.scene if owner else None, checkpoint)

    @property
    def id(self) -> str:
        """The id by which every client finds the session."""
        return self._message.session_id

    @property
    def scene(self) -> Scene:
        """The resolved scene, every default filled in.

        This makes a call only the first time, for sessions from `Client.list`.
        """
        scene = to_dict(self._resolved())
        return cast(Scene, scene if self.epoch is None else {**scene, "epoch": self.epoch})

    @property
    def choice(self) -> Optional[Choice]:
        """The method that the server chose for the scene's tolerance; None if the scene had no tolerance."""
        self._resolved()
        return answers.choice(self._message)

    @property
    def step_price(self) -> Price:
        """The predicted price of one step."""
        self._resolved()
        return answers.read(Price, self._message.step_price)

    def step(self, to: Optional[int] = None, *, time: Any = None, fields: Optional[Fields] = None, checkpoint: bool = False,
             timeout: Optional[float] = None) -> State:
        """Returns the state at step `to` or at `time`, or the last good one if the run ends before; see `State.outcome`.

        `fields`: a name or several; by default the variables in which the scene is given: quaternion and
        angular_velocity with `body`, otherwise the system's blocks. `checkpoint`: asks for `State.checkpoint`.
        `timeout`: seconds for the whole call; by default the client's. `time`: seconds, a timedelta, a quantity or, where
        the scene has an epoch, an instant; between two steps the state is as `trajectory` says of `times`, and has no
        checkpoint.
        """
        wanted = names("fields", fields)
        if time is not None and to is None and not self._is_step(time):
            return between_steps(self, time, wanted, timeout)
        to = self._step_of("to", to, time)
        request = pb.StepRequest(session_id=self.id, to=to, fields=wanted,
                                 return_checkpoint=checkpoint or self._calls.wants_checkpoint(to))
        return self._state(self._calls.call("Step", request, timeout), request, wanted, checkpoint)

    def drive(self, fields: Optional[Fields] = None) -> Drive:
        """Opens a stream for many steps in a tight loop: `with session.drive("Q") as drive: drive.step(k)`."""
        return Drive(self, fields)

    def diagnose(self, to: Optional[int] = None, *, time: Any = None, invariants: Names = (), forms: Sequence[Form] = (),
                 dirac_brackets: Sequence[Bracket] = (), symplectic: bool = False, estimate_error: Optional[bool] = False,
                 timeout: Optional[float] = None) -> Diagnosis:
        """Returns the invariants at step `to`, or at a `time` that is a step's, with their values at step 0.

        `invariants`: names of families or of single invariants; by default every family. `forms`: two-forms, each the
        form's name and two tangent vectors, which are mappings from block names to arrays. `dirac_brackets`: each two
        functions, which are products of factors tr A^T Q + tr B^T P, given as a list of pairs (A, B). `symplectic`:
        asks how far a step is from keeping the system's two-form. `estimate_error`: asks for
        `Diagnosis.estimated_error`, if it can be computed in about ten seconds; None asks for it if it takes less work than
        the run from step 0 or less than 10 ms.
        """
        if not isinstance(estimate_error, (bool, np.bool_, type(None))):
            raise refused("estimate_error", f"{shown(estimate_error)}: must be True, False or None")
        request = pb.DiagnoseRequest(session_id=self.id, to=self._step_of("to", to, time), invariants=names("invariants", invariants),
                                     symplectic_test=pb.SymplecticTest() if symplectic else None,
                                     estimate_error=_ESTIMATION[estimate_error])
        put_structure(request, forms, dirac_brackets)
        return answers.diagnosis(self._calls.call("Diagnose", request, timeout), request, self._resolved().HasField("body"))

    def error_at(self, times: Any, *, timeout: Optional[float] = None) -> EstimatedErrors:
        """Returns the estimated errors at times, given as in `trajectory`. At a time between two steps it is the error at the
        one further from 0. An estimate takes at most about ten seconds; see `Diagnosis.estimated_error`."""
        return errors_at(self, times, timeout)

    def fork(self, at: Optional[int] = None, *, time: Any = None, method: Union[Method, MethodName, None] = None,
             step: Optional[float] = None, system: Optional[str] = None, body: Optional[Body] = None,
             initial: Optional[Blocks] = None, id: Optional[str] = None, normalize: bool = False,
             timeout: Optional[float] = None) -> Session:
        """Creates a session that starts from this one's state at step `at`, or at a `time` that is a step's, with the given
        method, step, system, fields of `body` or blocks of `initial`.

        What is not given stays the same. An impulse in a control loop changes the angular velocity:

            state = session.step(to=k)
            session = session.fork(at=k, body={"angular_velocity": state["angular_velocity"] + impulse})

        `body` and `initial` take every form that a scene takes: an attitude as a matrix or a Rotation, vectors in the `frame`
        "space", `angular_momentum`, Omega, Qdot, and with `normalize` what was rounded to a few digits. What stands in body
        axes stays there when the attitude changes. A drift of the state off the manifold is repaired up to 0.01. The epoch of
        the fork is the instant of its start.
        Raises FailedPrecondition if the step cannot be reached.
        """
        at = self._step_of("at", at, time)
        changed = body is not None or initial is not None
        request = pb.ForkSessionRequest(session_id=str(uuid.uuid4()) if id is None or changed else text("id", id),
                                        from_session_id=self.id, from_step=at, step=optional("step", step, SECONDS), return_scene=True,
                                        system=None if system is None else text("system", system))
        if method is not None:
            request.method.CopyFrom(to_method(method))
        reply = self._calls.call("ForkSession", request, timeout)
        if answers.run_status(reply.run_status).outcome != Outcome.REACHED:
            raise FailedPrecondition(f"step {at} cannot be reached: {reply.run_status.message}")
        forked = Session(self._connection, described(reply.session, request.session_id), reply.created, owner=True,
                         epoch=self._epoch_after(at))
        if not changed:
            return forked
        with forked:
            scene = with_changes(forked._resolved(), body, initial, normalize)
        return created(self._connection, scene, id, b"", forked.epoch, normalize)

    def _epoch_after(self, step: int) -> Optional[str]:
        return self.epoch and str(instant("epoch", self.epoch).after(step * self._resolved().step))

    def delete(self) -> None:
        """Deletes the session from its server. Later calls of this handle raise NotFound."""
        self._delete()

    def _delete(self, waits: bool = True) -> None:
        self._calls.end()
        self._connection.call("DeleteSession", pb.DeleteSessionRequest(session_id=self.id), waits=waits)

    def stream(self, to: Optional[int] = None, *, time: Any = None, start: int = 0, every: Optional[int] = None,
               fields: Optional[Fields] = None, timeout: Optional[float] = None) -> Iterator[Batch]:
        """Yields the samples at start, start + every, ... and at `to`, batch by batch.

        `time`: instead of `to`, the time of a step. `every`: by default what makes about 1000 samples. `fields`: as in `step`.
        A stream that breaks is resumed at the sample where it stopped. A run that ends early ends the iteration; `trajectory`
        tells why. `timeout`: seconds for the whole iteration including resumptions, pauses and the caller's own time, after
        which DeadlineExceeded is raised.
        """
        to, start, _ = self._range(to, start, 1, time)
        for batch in self._samples(to, start, every_of(every, to - start), names("fields", fields), timeout):
            yield batch._of(self._side)

    def trajectory(self, to: Optional[int] = None, *, time: Any = None, times: Any = None, start: int = 0, every: Optional[int] = None,
                   fields: Optional[Fields] = None, progress: bool = False, estimate_error: bool = False,
                   timeout: Optional[float] = None) -> Trajectory:
        """Returns the samples at start, start + every, ... and at `to` as whole arrays, each allocated once.

        `time`: instead of `to`, the last time in seconds; one between two steps is a sample too. Without `to`, `time` and
        `times` the end is the scene's horizon. `every`: by default what makes about 1000 samples. `fields`: as in `step`. `progress`:
        shows a progress bar of tqdm.

        With `times` instead of `to`, `start` and `every`, returns the states at these times, in the order given: seconds,
        timedeltas, quantities or, where the scene has an epoch, datetimes, texts of ISO 8601 or a Time of astropy. They may
        be on both sides of 0; a state before 0 is that of the scene with a step of the other sign, and its `step` is
        negative. A state between two steps is the state before it, advanced by the method with a shorter step; its `step` is
        the step from which it was advanced. A discrete system has states at multiples of its step only.

        `estimate_error`: asks for `Trajectory.estimated_error`, by another call at the end, which takes `timeout` too.
        `timeout`: seconds for the whole call, including resumptions and pauses. When the call fails, the exception has
        the samples that had arrived in `partial`:

            try:
                run = session.trajectory(to=10**9, every=1000, timeout=10)
            except stiefel.DeadlineExceeded as late:
                run = late.partial
        """
        run = trajectory(self, to, start, every, names("fields", fields), progress, timeout, times, time)
        if not (estimate_error and len(run)):
            return run
        end = self.diagnose(to=max(0, int(run.step.max())), timeout=timeout, estimate_error=True)
        return replace(run, estimated_error=end.estimated_error)

    def linearize(self, to: Optional[int] = None, *, time: Any = None, start: int = 0, every: int = 0, vectors: Any = None,
                         inertia: bool = False, step: bool = False, timeout: Optional[float] = None) -> StateTransition:
        """Returns the derivative of the state at step `to`, or at a `time` that is a step's, by the state at `start`: that of
        the computed steps, not of the flow that they approximate. `matrix` has it in the coordinates that `StateTransition`
        names, `basis` and `start_basis` their vectors.

        `vectors`: moves these tangent vectors at `start` instead, (m, d) by coordinates or (m, rows, cols) as blocks. A
        call then takes time and memory in proportion to m. `inertia`, `step`: adds the derivatives by lambda_1 ... lambda_N
        and by the scene's step, at a constant state at `start`. `every`: sends a result every so many steps too.
        """
        to, start = self._step_of("to", to, time), step_index("start", start)
        request = self._request(pb.LinearizeRequest, to, start, step_index("every", every), inertia=inertia, step=step,
                                bases=np.ndim(vectors) < 3)
        return linearized(self._calls, request, vectors, self._resolved().step, timeout)

    def covariance(self, P0: Any, *, to: Optional[int] = None, time: Any = None, times: Any = None, start: int = 0, every: int = 0,
                   rates: bool = False, timeout: Optional[float] = None) -> NDArray[np.float64]:
        """Returns the covariance Phi P0 Phi^T of the state at step `to`, or at a `time`, to first order; `P0` is that at
        `start`. Both are in the coordinates of `linearize`, for a body in three dimensions of (eta, dm): eta turns
        the attitude about body axes. `rates`: both are of (eta, domega), with dm = I domega. With `every`, and at `times`
        that are steps', given as in `trajectory`, they are (results, d, d)."""
        return covariance(self, P0, to, start, every, timeout, time, rates, times)

    def lyapunov(self, to: Optional[int] = None, *, time: Any = None, count: Optional[int] = None, start: int = 0, every: int = 0,
                 interval: int = 0, seed: int = 0, checkpoint: bytes = b"",
                 timeout: Optional[float] = None) -> LyapunovSpectrum:
        """Returns the Lyapunov exponents of the motion from `start` to step `to`, or to a `time` that is a step's, with
        error bars, and a verdict: regular, chaotic or undecided. Chaotic is said of the flow: what looks chaotic is
        followed again, by a method of the highest order, which may take many times the work.

        `count`: how many, the largest ones; by default all, for states of up to 1024 numbers. `every`: keeps the numbers
        about every so many steps. `interval`: steps between two orthonormalisations; by default about a radian of the
        motion; `to` must allow 20. `seed`: of the random first vectors. `checkpoint`: the `LyapunovSpectrum.checkpoint` of
        an earlier call that had the same arguments but `to` and `every`; goes on from there, with the same bits. `timeout`:
        seconds for the whole call; none by default.
        """
        to, start = self._step_of("to", to, time), step_index("start", start)
        request = self._request(
            pb.LyapunovSpectrumRequest, to, start, step_index("every", every), interval=whole("interval", interval),
            count=0 if count is None else min(whole("count", count, 1), 2**32 - 1), seed=whole("seed", seed), checkpoint=checkpoint)
        return grown(self._calls, request, timeout)

    def summarize(self, to: Optional[int] = None, *, time: Any = None, quantities: Quantities, start: int = 0, every: int = 1,
                  checkpoint_every: int = 0, checkpoint: bytes = b"", timeout: Optional[float] = None) -> Summary:
        """Returns statistics of fields and invariants over the samples at start, start + every, ... and at `to`.

            session.summarize(10**6, quantities={"energy": "drift", "quaternion": ["last"],
                                                 "angular_velocity": ["rms", {"quantiles": [0.05, 0.95]}]})

        `quantities`: for each field, invariant or family of invariants, names of statistics (last, min, max, mean, rms,
        sign_changes, drift), "quantiles" at fractions in [0, 1], and "edges" of a histogram. In an ensemble each member
        has its own statistics; with `"over_members": True` they are computed over all members together.
        `checkpoint_every`: steps between two checkpoints, from the last of which a call that breaks is resumed; with 0
        it begins anew. `checkpoint`: a `Summary.checkpoint` of an earlier call from which to go on. `timeout`: seconds
        for the whole call; none by default. `time`: instead of `to`, the time of a step.
        """
        between = step_index("checkpoint_every", checkpoint_every)
        request = self._request(pb.SummarizeRequest, *self._range(to, start, every, time), checkpoint_every=between, checkpoint=checkpoint,
                                          return_checkpoint=between > 0, quantities=to_quantities(quantities))
        running = self._summarizing(request, timeout)
        for _ in running:
            pass
        return running.summary()

    def events(self, to: Optional[int] = None, *, time: Any = None, events: Union[EventDescription, Sequence[EventDescription]],
               start: int = 0, fields: Optional[Fields] = None, timeout: Optional[float] = None) -> Events:
        """Returns the zeros of g = sum(coefficients * field) - level after step `start`, up to step `to`.

            flips = session.events(10**5, events={"field": "angular_velocity", "coefficients": [0, 1, 0],
                                                  "direction": "rising"})

        Each event is a mapping with the keys field and coefficients, and optionally level (default 0), direction
        ("both", the default, "rising" or "falling"), limit (the most zeros; default 0, all), terminal (whether the
        motion ends at the last zero of `limit`, by default False), plus (a mapping from more fields to coefficients,
        whose sums are added to g) and extremum (True: zeros of the derivative of g, rising at minima). A zero is found where g has different signs at two consecutive steps; two zeros
        between them are not seen. `fields`: the fields to return at the zeros, as in `step`. `time`: instead of `to`, the
        time of a step.
        """
        request = self._events_request(to, events, start, fields, time)
        running = self._summarizing(request, timeout)
        parts = [part for part in running if isinstance(part, Events)]
        return joined(parts or [self._no_events(fields, timeout)], run_status=running.run_status)

    def _no_events(self, fields: Optional[Fields], timeout: Optional[float]) -> Events:
        """Returns events without any zero. Some state gives names, shapes and types of the fields."""
        ensemble, state = self._resolved().HasField("members"), self.step(to=0, fields=fields, timeout=timeout)
        empty = {name: np.empty((0, *values.shape[ensemble:]), values.dtype) for name, values in state.items()}
        none = np.empty(0, np.uint32)
        return Events(none, np.empty(0, np.int64), np.empty(0), np.empty(0), none if ensemble else None, empty)

    def poincare(self, section: Mapping[str, Any], *, to: Optional[int] = None, time: Any = None, level: float = 0.0,
                 direction: str = "rising", coordinates: Sequence[Coordinate] = (), start: int = 0,
                 fields: Optional[Fields] = None, timeout: Optional[float] = None) -> Section:
        """Returns the crossings of the plane g = sum(coefficients * field) - level after step `start`, up to step `to`.

            session.poincare({"q": [0, 0, 1]}, to=10**5, coordinates=[{"q": [1, 0, 0]}, {"qdot": [1, 0, 0]}]).points

        `section`: fields and their coefficients, in the field's shape, whose sums are added. `direction`: "rising", "falling" or "both".
        `coordinates`: the columns of `points`; each a mapping from fields to coefficients, whose sums are added, or a function
        of the section, such as `lambda s: np.arctan2(s["q"][:, 1], s["q"][:, 0])`. `fields`: the fields to return, by default
        those that `section` and the mappings name. A crossing is located, and two of them between two steps are missed, as
        `events` says; `Section.residual` is g at the states that are returned. `time`: instead of `to`, the time of a step.
        """
        event = to_section(section, level, direction, coordinates)
        wanted: Any = names("fields", fields)
        asked = len(wanted)
        for one in (field for of in (section, *coordinates) if isinstance(of, Mapping) for field in of):
            if one not in wanted:
                wanted.append(one)
        try:
            found = self.events(to, events=event, start=start, fields=wanted, timeout=timeout, time=time)
        except InvalidArgument as error:
            raise of_section(error, asked) from None
        residual = column("section", found, section) - event["level"]
        return Section(found.event, found.step, found.fraction, found.time, found.member, found.fields, found.run_status,
                       columns(found, coordinates), residual)

    def stream_events(self, to: Optional[int] = None, *, time: Any = None, events: Union[EventDescription, Sequence[EventDescription]],
                      start: int = 0, fields: Optional[Fields] = None, timeout: Optional[float] = None) -> Iterator[Events]:
        """Yields what `events` returns in batches, as they are found. Leaving the iteration ends the search."""
        for part in self._summarizing(self._events_request(to, events, start, fields, time), timeout):
            if isinstance(part, Events):
                yield part

    def _events_request(self, to: Optional[int], events: Union[EventDescription, Sequence[EventDescription]], start: int,
                        fields: Optional[Fields], time: Any) -> pb.SummarizeRequest:
        asked = to_events(events)
        if not asked:
            raise refused("events", "must be given, a mapping or several")
        return self._request(pb.SummarizeRequest, *self._range(to, start, 1, time), events=asked, fields=names("fields", fields))

    def _side(self) -> Optional[str]:
        """Returns how the frame of the system moves, as `Origin.side`; None if one call does not tell it."""
        try:
            return side_of(self._message.system, lambda: self._connection.call(
                "Describe", pb.DescribeRequest(), 5.0, waits=False).systems)
        except StiefelError:
            return None

    def _resolved(self) -> pb.Scene:
        """Returns the resolved scene as a message. Do not change it: the session keeps it."""
        if not self._message.HasField("scene"):
            request = pb.GetSessionRequest(session_id=self.id, return_scene=True)
            self._message = answers.described(self._calls.call("GetSession", request).session, self.id)
        return self._message.scene

    def _is_step(self, time: Any) -> bool:
        steps = time_of(time, self._resolved().step, self.epoch)[1]
        return steps >= 0 and steps == round(steps)

    def _step_of(self, name: str, given: Any, time: Any) -> int:
        """Returns the step that the caller gives under `name` or as a time."""
        return step_of(name, given, time, self._resolved().step, self.epoch)

    def _range(self, to: Any, start: Any, every: Any, time: Any) -> tuple[int, int, int]:
        """Returns the steps of a run as whole numbers."""
        to, start = self._step_of("to", to, time), step_index("start", start)
        return to, start, step_index("every", every, 1)

    def _request(self, kind: Callable[..., T], to: int, start: int, every: int, **more: Any) -> T:
        """Returns the request of a run of this session. `kind`: its message."""
        return kind(session_id=self.id, to=to, every=every, **{**more, "from": start})

    def _summarizing(self, request: pb.SummarizeRequest, timeout: Optional[float]) -> Summarizing:
        return Summarizing(self._calls, request, self._resolved().HasField("members"), timeout)

    def _samples(self, to: int, start: int, every: int, fields: Sequence[str], timeout: Optional[float]) -> Samples:
        request = self._request(pb.StreamRequest, to, start, every, fields=fields,
                                checkpoint_every=self._calls.checkpoint_every())
        return Samples(self._calls, request, self._resolved().step, timeout)

    def _state(self, reply: pb.StepResponse, request: Union[pb.StepRequest, pb.DriveRequest], fields: Sequence[str],
               checkpoint: bool) -> State:
        """Reads a reply of Step or Drive. Keeps its checkpoint, and passes it on only if the caller asked for it.
        `fields`: the names that are in force, none for the system's blocks."""
        sample, status = reply.sample, answers.run_status(reply.run_status)
        answers.ends_at(status, sample.step, request.to)
        self._calls.keep(sample.step, reply.checkpoint)
        return State(sample.step, sample.time, answers.Layout(fields).read(sample.fields), status, reply.computed_steps,
                     reply.checkpoint if checkpoint else b"", reply.work)._of(self._side)

    def _origin(self, to: Optional[int] = None, times: Any = None) -> Origin:
        return Origin(self._resolved(), self._message.numerics_id, self._again, to, times, self.epoch, self._side())

    def _again(self, scene: pb.Scene) -> Optional[Session]:
        """Creates a session of the same scene; None after the client was closed."""
        return None if self._connection.closed else created(self._connection, scene, epoch=self.epoch)

    def __reduce__(self) -> Any:
        raise TypeError("a session cannot be pickled, because only one handle may create it again: send its `id`, and use "
                        "`Client.get(id)` in the other process")

    def __enter__(self) -> Session:
        return self

    def __exit__(self, kind: Optional[type[BaseException]], *exception: object) -> None:
        try:
            self._delete(waits=False)
        except (Unavailable, DeadlineExceeded):
            pass  # with the server the session is gone, or the server drops it when it has been idle
        except StiefelError:
            if kind is None:  # else the exception that ended the block matters more
                raise

    def __repr__(self) -> str:
        scene = self._message.scene
        if not scene.system:
            return f"<stiefel.Session {self.id}: {self._message.system}>"
        return f"<stiefel.Session {self.id}: {f'{scene.system} {scene.method.name}'.rstrip()}, step {scene.step!r}>"


def created(connection: Connection, scene: pb.Scene, id: Optional[str] = None, checkpoint: bytes = b"",
            epoch: Optional[str] = None, normalize: bool = False) -> Session:
    """Creates a session of a scene, and warns of what the server warns of. `normalize`: whether the scene is normalized."""
    sent = with_momenta(scene, connection.systems)
    request = pb.CreateSessionRequest(session_id=str(uuid.uuid4()) if id is None else text("id", id), scene=sent, checkpoint=checkpoint,
                                      return_scene=True)
    try:
        reply = connection.call("CreateSession", request)
    except InvalidArgument as error:
        raise with_given_names(error if normalize else with_hint(error, lambda: normalized(scene) != scene), scene) from None
    session = described(reply.session, request.session_id)
    for warning in session.warnings:
        warn_of_scene(warning)
    return Session(connection, session, reply.created, owner=True, checkpoint=checkpoint, epoch=epoch)
