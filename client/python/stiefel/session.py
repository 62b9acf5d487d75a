"""A session: a pure function from step index to state, so every call names an absolute step."""
from __future__ import annotations

from typing import TYPE_CHECKING, Any, Iterator, Optional, Sequence

import grpc

from stiefel import calls
from stiefel.arrays import Batch, Collector, State, Trajectory
from stiefel.drive import Drive
from stiefel.errors import DeadlineExceeded, Internal, StiefelError, Unavailable, from_rpc_error
from stiefel.scenes import to_dict
from stiefel.v1 import simulation_pb2 as pb

if TYPE_CHECKING:
    from stiefel.client import Client


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

    def diagnose(self, to: int, invariants: Sequence[str] = (),
                 timeout: Optional[float] = None) -> pb.DiagnoseResponse:
        """The invariants at step `to` beside their values at step 0."""
        request = pb.DiagnoseRequest(session_id=self.id, to=to, invariants=invariants)
        return self._client.call("Diagnose", request, timeout)

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
