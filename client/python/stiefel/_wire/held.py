"""What the handle of a session knows of it: its scene, and how far its steps and times reach."""
from __future__ import annotations

import threading
from typing import Any, Callable, Optional, Sequence, TypeVar, Union, cast

from stiefel import v1 as pb
from stiefel._given.numbers import step_index
from stiefel._given.typed import Scene
from stiefel._given.when import step_of, time_of
from stiefel._results.origin import side_of
from stiefel._wire import answers
from stiefel._wire.arrays import decode_fields, named
from stiefel._wire.connection import Connection
from stiefel._wire.recreating import Recreation
from stiefel._wire.replies import Layout, described, ends_at, require
from stiefel._wire.sampling import Samples
from stiefel._wire.summarizing import Summarizing
from stiefel.errors import StiefelError
from stiefel.results import Choice, Price, State
from stiefel._scene import to_dict

T = TypeVar("T")


class Held:
    """The handle of a session of a server."""

    def __init__(self, connection: Connection, message: pb.Session, created: bool, owner: bool = False,
                 checkpoint: bytes = b"", epoch: Optional[str] = None):
        """`message`: the server's reply, with its scene, except of a session from `Client.list`. `owner`: whether this
        handle created the session, with `checkpoint`."""
        self._connection = connection
        self.created = created  #: False if the session existed already
        #: The instant of time 0, such as "1992-11-09T17:49:47 UTC"; None if the scene has none, and for sessions from
        #: `Client.get` and `Client.list`, because the server does not know it.
        self.epoch = epoch
        self._lock = threading.Lock()
        self._take(message, whole=owner)
        self._recreation = Recreation(connection, message, message.scene if owner else None, checkpoint)

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

    def _side(self) -> Optional[str]:
        """Returns how the frame of the system moves, as `Origin.side`; None if one call does not tell it."""
        try:
            return side_of(self._message.system, lambda: self._connection.call(
                "Describe", pb.DescribeRequest(), 5.0, waits=False).systems)
        except StiefelError:
            return None

    def _resolved(self) -> pb.Scene:
        """Returns the resolved scene as a message. Do not change it: the session keeps it."""
        with self._lock:
            if not self._message.HasField("scene"):
                request = pb.GetSessionRequest(session_id=self.id, return_scene=True)
                reply = self._recreation.call("GetSession", request)
                self._take(described(reply.session, self.id), whole=True)
            return self._message.scene

    def _take(self, message: pb.Session, whole: bool) -> None:
        require(message.HasField("scene") and message.scene.system == message.system or not whole,
                f"the session has no scene of {message.system!r}")
        self._message = message

    def _blocks(self) -> set[str]:
        """Returns the names of the blocks of the scene's initial state."""
        scene = self._resolved()
        return {*scene.initial, *scene.initial_tensors}

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
        return Summarizing(self._recreation, request, self._resolved().HasField("members"), timeout)

    def _samples(self, to: int, start: int, every: int, fields: Sequence[str], timeout: Optional[float]) -> Samples:
        request = self._request(pb.StreamRequest, to, start, every, fields=fields,
                                checkpoint_every=self._recreation.checkpoint_every())
        return Samples(self._recreation, request, self._resolved().step, timeout)

    def _state(self, reply: pb.StepResponse, request: Union[pb.StepRequest, pb.DriveRequest], fields: Sequence[str],
               checkpoint: bool) -> State:
        """Reads a reply of Step or Drive. Keeps its checkpoint, and passes it on only if the caller asked for it.
        `fields`: the names that are in force, none for the system's blocks."""
        sample = reply.sample
        ends_at(reply.run_status, sample.step, request.to)
        if reply.checkpoint:
            self._recreation.keep(sample.step, reply.checkpoint)
        if not checkpoint:
            reply.ClearField("checkpoint")
        arrays = decode_fields(sample.fields)
        Layout(fields).check(arrays)
        return answers.state(reply, named(arrays))._of(self._side)
