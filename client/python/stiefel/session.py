"""A session: a pure function from step index to state, so every call names an absolute step."""
from __future__ import annotations

import uuid
from typing import TYPE_CHECKING, Any, Iterator, Mapping, Optional, Sequence

import grpc
from google.protobuf import json_format

from stiefel import calls
from stiefel.arrays import Batch, Collector, State, Trajectory
from stiefel.drive import Drive
from stiefel.errors import (DeadlineExceeded, FailedPrecondition, Internal, StiefelError, Unavailable,
                            from_rpc_error)
from stiefel.scenes import to_dict, to_matrix
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

    def step(self, to: int, fields: Optional[Sequence[str]] = None, checkpoint: bool = False,
             timeout: Optional[float] = None) -> State:
        """The state at step `to`, or the last good one before it."""
        request = pb.StepRequest(session_id=self.id, to=to, fields=fields, checkpoint=checkpoint)
        return State.of(self._client.call("Step", request, timeout))

    def drive(self, fields: Optional[Sequence[str]] = None) -> Drive:
        """`step` for tight loops, over one stream: `with session.drive() as drive: drive.step(k)`."""
        return Drive(self._client.stub.Drive, self.id, fields)

    def diagnose(self, to: int, invariants: Sequence[str] = (), forms: Sequence[Form] = (),
                 dirac_brackets: Sequence[Bracket] = (), symplectic: bool = False,
                 timeout: Optional[float] = None, estimate_error: bool = False) -> pb.DiagnoseResponse:
        """The invariants at step `to` beside their values at step 0.

        A form is its name and two tangent vectors, each a mapping from block to array; a bracket two
        products, each a list of pairs (A, B) for tr A^T Q + tr B^T P. `symplectic` asks how far a step
        is from keeping the system's two-form, `estimate_error` for `estimated_error`: how far the state
        is from the exact motion, if that can be told in about ten seconds.
        """
        request = pb.DiagnoseRequest(session_id=self.id, to=to, invariants=invariants,
                                     symplectic_test=pb.SymplecticTest() if symplectic else None,
                                     estimate_error=pb.ERROR_ESTIMATION_ALWAYS if estimate_error else None)
        for name, first, second in forms:
            request.forms.add(form=name, first=_blocks(first), second=_blocks(second))
        for first, second in dirac_brackets:
            request.dirac_brackets.add(first=_factors(first), second=_factors(second))
        return self._client.call("Diagnose", request, timeout)

    def fork(self, at: int, method: Optional[Mapping[str, Any]] = None, step: Optional[float] = None,
             system: Optional[str] = None, id: Optional[str] = None,
             timeout: Optional[float] = None) -> Session:
        """A new session that starts where this one is at step `at`, with what is named changed.

        What the method has drifted off the manifold by is repaired, up to 0.01.
        """
        request = pb.ForkSessionRequest(session_id=str(uuid.uuid4()) if id is None else id,
                                        from_session_id=self.id, from_step=at, step=step, system=system)
        if method is not None:
            json_format.ParseDict(method, request.method)
        reply = self._client.call("ForkSession", request, timeout)
        if not reply.HasField("session"):
            raise FailedPrecondition(f"step {at} cannot be reached: {reply.ending.message}")
        return Session(self._client, reply.session, reply.created)

    def delete(self) -> None:
        self._client.call("DeleteSession", pb.DeleteSessionRequest(session_id=self.id))

    def stream(self, to: int, start: int = 0, every: int = 1,
               fields: Optional[Sequence[str]] = None, timeout: Optional[float] = None) -> Iterator[Batch]:
        """The samples at start, start + every, ... and at `to`, batch by batch.

        A stream that breaks goes on at the sample where it stopped. A run that ends early ends the
        iteration; `trajectory` says why.
        """
        every = every or 1  # as on the wire
        for message in self._messages(to, start, every, fields, timeout):
            if message.steps:
                yield Batch.of(message, every, self.message.scene.step)

    def trajectory(self, to: int, start: int = 0, every: int = 1,
                   fields: Optional[Sequence[str]] = None, progress: bool = False,
                   timeout: Optional[float] = None) -> Trajectory:
        """The same samples as whole arrays, each allocated once."""
        every = every or 1
        collector = Collector(max(-(-(to - start) // every), 0) + 1)
        with _progress_bar(to - start, progress) as bar:
            for message in self._messages(to, start, every, fields, timeout):
                if message.steps:
                    collector.add(Batch.of(message, every, self.message.scene.step))
                    bar.update(message.steps[-1] - start - bar.n)
        return collector.trajectory(message)

    def _messages(self, to: int, start: int, every: int, fields: Optional[Sequence[str]],
                  timeout: Optional[float]) -> Iterator[pb.StreamResponse]:
        """Messages, the last one with the ending, over as many streams as it takes.

        Each stream has the deadline of a call. One that brought something is followed by another.
        """
        waits = calls.pauses()
        last: Optional[int] = None
        while True:
            begin = start if last is None else min(last + every, to)
            request = pb.StreamRequest(session_id=self.id, to=to, every=every, fields=fields, **{"from": begin})
            stream = self._client.stub.Stream(request, timeout=self._client.deadline(timeout))
            progress = False
            try:
                for message in stream:
                    if last == to:  # only the ending was missing
                        message.ClearField("steps")
                    if message.steps:
                        progress, last = True, message.steps[-1]
                    yield message
                    if message.HasField("ending"):
                        return
                error: StiefelError = Internal("the stream ended without saying how")
            except grpc.RpcError as rpc_error:
                error = from_rpc_error(rpc_error)
            finally:
                stream.cancel()
            if progress and isinstance(error, (DeadlineExceeded, Unavailable)):
                waits = calls.pauses()
            else:
                calls.pause_or_raise(error, waits)

    def __enter__(self) -> Session:
        return self

    def __exit__(self, *exception: object) -> None:
        self.delete()

    def __repr__(self) -> str:
        scene = self.message.scene
        return f"<stiefel.Session {self.id}: {scene.system} {scene.method.name}>"


def _blocks(vector: TangentVector) -> dict[str, scene_pb2.Matrix]:
    return {name: to_matrix(block) for name, block in vector.items()}


def _factors(factors: Sequence[tuple[Any, Any]]) -> list[pb.LinearFunction]:
    return [pb.LinearFunction(a=to_matrix(A), b=to_matrix(B)) for A, B in factors]


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
