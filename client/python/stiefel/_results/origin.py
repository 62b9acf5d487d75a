"""Where a trajectory comes from: what can compute it again."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Callable, ClassVar, Mapping, Optional

from numpy.typing import NDArray

from stiefel import v1 as pb


_SIDES: dict[str, str] = {}


def side_of(system: str, systems: Callable[[], Any]) -> str:
    """Returns how the frame of a body with M = J(Omega) moves: "left" if Q takes body to space, "right" if it takes space to body;
    "" of other systems. `systems`: returns those of a server, which is asked once in a process."""
    if system not in _SIDES:
        _SIDES.update({one.name: pb.Side.Name(one.side)[5:].lower() if one.side and (one.velocity or one.discrete) else ""
                       for one in systems()})
    return _SIDES.get(system, "")


@dataclass(eq=False, repr=False)
class Origin:
    """The resolved scene, the build, and what the run was asked for. A copy in another process has no connection."""

    #: Creates a session of a scene where there is no connection.
    elsewhere: ClassVar[Callable[[Mapping[str, Any]], Any]]

    _message: pb.Scene  #: the resolved scene
    build: str  #: the numerics id of the server
    _create: Any = None  #: creates a session of a scene at the server of the run, or returns None if its client is closed
    to: Optional[int] = None  #: what the caller asked for, which a run that stopped did not reach; so are the times
    times: Optional[NDArray[Any]] = None
    epoch: Optional[str] = None  #: the instant of time 0 in ISO 8601, None if the scene has none
    side: Optional[str] = ""  #: how the frame moves, as `side_of` says; None if it is not known

    def session(self, scene: Mapping[str, Any]) -> Any:
        """Returns a new session of the scene, at the server of the run or, without its connection, at the process's own."""
        found = None if self._create is None else self._create(self._message)
        return Origin.elsewhere(scene) if found is None else found

    def __getstate__(self) -> dict[str, Any]:
        return {**vars(self), "_create": None}
