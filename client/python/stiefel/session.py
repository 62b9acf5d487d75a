"""A session: a pure function from step index to state, so every call names an absolute step."""
from __future__ import annotations

import uuid
from typing import TYPE_CHECKING, Any, Iterator, Mapping, Optional, Sequence

import grpc

from stiefel import calls
from stiefel.arrays import Batch, Collector, RunStatus, Outcome, State, Trajectory
from stiefel.diagnosis import Diagnosis
from stiefel.drive import Drive
from stiefel.errors import DeadlineExceeded, FailedPrecondition, Internal, StiefelError, Unavailable
from stiefel.names import Names, names
from stiefel.scenes import to_dict, to_matrix, to_method
from stiefel.v1 import scene_pb2
from stiefel.v1 import simulation_pb2 as pb

if TYPE_CHECKING:
    from stiefel.client import Client

TangentVector = Mapping[str, Any]
Form = tuple[str, TangentVector, TangentVector]
Bracket = tuple[Sequence[tuple[Any, Any]], Sequence[tuple[Any, Any]]]


class Session:
    """Made by `Client.create` or `Client.get`. As a context manager it deletes itself at the end."""

    def __init__(self, client: Client, message: pb.Session, created: bool):
        self._client = client
        self.message = message
        self.created = created  #: False if the session was there already

    @property
    def id(self) -> str:
        return self.message.session_id

    @property
    def scene(self) -> dict[str, Any]:
        """The resolved scene, every default filled in."""
        return to_dict(self.message.scene)

    def step(self, to: int, fields: Optional[Names] = None, checkpoint: bool = False,
             timeout: Optional[float] = None) -> State:
        """The state at step `to`, or the last good one before it. `fields`: a name or several; the system's blocks if none."""
        request = pb.StepRequest(session_id=self.id, to=to, fields=names("fields", fields), checkpoint=checkpoint)
        return State.of(self._client.call("Step", request, timeout))

    def drive(self, fields: Optional[Names] = None) -> Drive:
        """`step` for tight loops, over one stream: `with session.drive() as drive: drive.step(k)`."""
        return Drive(self._client, self.id, fields)

    def diagnose(self, to: int, invariants: Names = (), forms: Sequence[Form] = (),
                 dirac_brackets: Sequence[Bracket] = (), symplectic: bool = False,
                 timeout: Optional[float] = None, estimate_error: bool = False) -> Diagnosis:
        """The invariants at step `to` beside their values at step 0.

        A form is its name and two tangent vectors, each a mapping from block to array; a bracket two
        products, each a list of pairs (A, B) for tr A^T Q + tr B^T P. `symplectic` asks how far a step
        is from keeping the system's two-form, `estimate_error` for `estimated_error`: how far the state
        is from the exact motion, if that can be told in about ten seconds.
        """
        request = pb.DiagnoseRequest(session_id=self.id, to=to, invariants=names("invariants", invariants),
                                     symplectic_test=pb.SymplecticTest() if symplectic else None,
                                     estimate_error=pb.ERROR_ESTIMATION_ALWAYS if estimate_error else None)
        for i, (name, first, second) in enumerate(forms):
            request.forms.add(form=name, first=_blocks(first, f"forms[{i}].first"),
                              second=_blocks(second, f"forms[{i}].second"))
        for i, (one, other) in enumerate(dirac_brackets):
            request.dirac_brackets.add(first=_factors(one, f"dirac_brackets[{i}].first"),
                                       second=_factors(other, f"dirac_brackets[{i}].second"))
        return Diagnosis.of(self._client.call("Diagnose", request, timeout))

    def fork(self, at: int, method: Optional[Mapping[str, Any]] = None, step: Optional[float] = None,
             system: Optional[str] = None, id: Optional[str] = None,
             timeout: Optional[float] = None) -> Session:
        """A new session that starts where this one is at step `at`, with what is named changed.

        What the method has drifted off the manifold by is repaired, up to 0.01.
        """
        request = pb.ForkSessionRequest(session_id=str(uuid.uuid4()) if id is None else id,
                                        from_session_id=self.id, from_step=at, step=step, system=system)
        if method is not None:
            request.method.CopyFrom(to_method(method))
        reply = self._client.call("ForkSession", request, timeout)
        if not reply.HasField("session"):
            raise FailedPrecondition(f"step {at} cannot be reached: {reply.run_status.message}")
        return Session(self._client, reply.session, reply.created)

    def delete(self) -> None:
        self._client.call("DeleteSession", pb.DeleteSessionRequest(session_id=self.id))

    def stream(self, to: int, start: int = 0, every: int = 1,
               fields: Optional[Names] = None, timeout: Optional[float] = None) -> Iterator[Batch]:
        """The samples at start, start + every, ... and at `to`, batch by batch.

        A stream that breaks goes on at the sample where it stopped. A run that ends early ends the
        iteration; `trajectory` says why. `timeout` bounds the whole iteration, its resumptions,
        pauses and the caller's own time included: DeadlineExceeded.
        """
        every = every or 1  # as on the wire
        for message in self._messages(to, start, every, fields, timeout):
            if message.steps:
                yield Batch.of(message, every, self.message.scene.step)

    def trajectory(self, to: int, start: int = 0, every: int = 1,
                   fields: Optional[Names] = None, progress: bool = False,
                   timeout: Optional[float] = None) -> Trajectory:
        """The same samples as whole arrays, each allocated once.

        `timeout` bounds the whole call, its resumptions and pauses included. An exception has what
        had arrived in `partial`:

            try:
                run = session.trajectory(to=10**9, every=1000, timeout=10)
            except stiefel.DeadlineExceeded as late:
                run = late.partial
        """
        every = every or 1
        collector = Collector(max(-(-(to - start) // every), 0) + 1)
        computed, run_status = 0, RunStatus(Outcome.CANCELLED)
        try:
            with _progress_bar(to - start, progress) as bar:
                for message in self._messages(to, start, every, fields, timeout):
                    if message.steps:
                        collector.add(Batch.of(message, every, self.message.scene.step))
                        bar.update(message.steps[-1] - start - bar.n)
                    computed = message.computed_steps
                    if message.HasField("run_status"):
                        run_status = RunStatus.of(message.run_status)
        except StiefelError as error:
            error.partial = collector.trajectory(RunStatus(Outcome.CANCELLED, message=error.message), computed)
            raise
        return collector.trajectory(run_status, computed)

    def _messages(self, to: int, start: int, every: int, fields: Optional[Names],
                  timeout: Optional[float]) -> Iterator[pb.StreamResponse]:
        """Messages, the last one with the run status, over as many streams as it takes; `computed_steps`
        of each is that of all streams so far.

        `timeout` is the deadline of all of them together. Without it each has the client's, and one
        that brought something is followed by another.
        """
        deadline, waits = calls.Deadline(timeout), calls.pauses()
        wanted = names("fields", fields)
        last: Optional[int] = None
        before = 0  # computed by the streams before this one
        while True:
            begin = start if last is None else min(last + every, to)
            request = pb.StreamRequest(session_id=self.id, to=to, every=every, fields=wanted, **{"from": begin})
            stream = self._client.stub.Stream(request, timeout=self._client.deadline(deadline.left()))
            progress, computed = False, 0
            try:
                for message in stream:
                    if last == to:  # only the run status was missing
                        message.ClearField("steps")
                    if message.steps:
                        progress, last = True, message.steps[-1]
                    computed = max(computed, message.computed_steps)
                    message.computed_steps = before + computed
                    yield message
                    if message.HasField("run_status"):
                        return
                error: StiefelError = Internal("the stream ended without saying how")
            except grpc.RpcError as failure:
                error = self._client.error(failure)
            finally:
                stream.cancel()
            before += computed
            if progress and isinstance(error, Unavailable if timeout is not None else (DeadlineExceeded, Unavailable)):
                waits = calls.pauses()
            else:
                calls.pause_or_raise(error, waits, deadline, late=True)

    def __enter__(self) -> Session:
        return self

    def __exit__(self, kind: Optional[type[BaseException]], *exception: object) -> None:
        try:
            self.delete()
        except StiefelError:
            if kind is None:  # else what ended the block is what matters; the server drops idle sessions
                raise

    def __repr__(self) -> str:
        scene = self.message.scene
        return f"<stiefel.Session {self.id}: {f'{scene.system} {scene.method.name}'.rstrip()}, step {scene.step!r}>"


def _blocks(vector: TangentVector, path: str) -> dict[str, scene_pb2.Matrix]:
    return {name: to_matrix(block, f"{path}.{name}") for name, block in vector.items()}


def _factors(factors: Sequence[tuple[Any, Any]], path: str) -> list[pb.LinearFunction]:
    return [pb.LinearFunction(a=to_matrix(A, f"{path}[{i}].A"), b=to_matrix(B, f"{path}[{i}].B"))
            for i, (A, B) in enumerate(factors)]


class _NoBar:
    n = 0

    def __enter__(self) -> _NoBar:
        return self

    def __exit__(self, *exception: object) -> None:
        pass

    def update(self, steps: int) -> None:
        pass


def _progress_bar(steps: int, wanted: bool) -> Any:
    if not wanted:
        return _NoBar()
    from tqdm import tqdm  # only those who want a bar need it

    return tqdm(total=steps, unit=" steps", unit_scale=True)
