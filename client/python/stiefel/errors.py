"""Exceptions, with all violations that the server found.

A numerical stop is not an exception but an `Outcome` in the reply.
"""
from __future__ import annotations

import os
import re
import sys
import warnings
from contextvars import ContextVar
from typing import Any, NamedTuple, Optional, Sequence

import grpc

__all__ = ["AlreadyExists", "BuildChanged", "Closed", "CorruptReply", "DeadlineExceeded", "FailedPrecondition",
           "InvalidArgument", "NotFound", "ResourceExhausted", "SceneWarning", "StiefelError", "Unavailable", "Violation"]
__dir__ = lambda: sorted(__all__)  # noqa: E731


class Violation(NamedTuple):
    """A fault in one field of a request."""

    field: str  #: its path: "scene.initial.Q"
    description: str  #: its value and the rule it breaks


class SceneWarning(UserWarning):
    """A warning of the server about a scene that it accepts, such as moments that no rigid body can have."""


_HERE = os.path.dirname(__file__) + os.sep


#: A list that takes the texts of warnings about scenes, which are then not given; None: they are given.
SCENE_WARNINGS: ContextVar[Optional[list[str]]] = ContextVar("warnings", default=None)


def warn_of_scene(text: str) -> None:
    """Gives a SceneWarning at the line that called this package, however many of its functions lie between."""
    kept = SCENE_WARNINGS.get()
    if kept is not None:
        kept.append(text)
        return
    frame, level = sys._getframe(), 1
    while frame.f_code.co_filename.startswith(_HERE) and frame.f_back is not None:
        frame, level = frame.f_back, level + 1
    warnings.warn(text, SceneWarning, stacklevel=level)


class StiefelError(Exception):
    """The base class of all exceptions of this package. `code` is the status code of gRPC: it tells what has no class of its
    own, such as UNAUTHENTICATED for a token that is missing (`reason` TOKEN_MISSING) or unknown (TOKEN_UNKNOWN)."""

    code: grpc.StatusCode = grpc.StatusCode.UNKNOWN
    quota: tuple[Violation, ...] = ()  #: the limits that the request exceeds; `field` is the limit's name: "sessions"
    retry_delay: Optional[float] = None  #: seconds after which the same request may succeed, if the server says so
    _checkpoint: tuple[int, bytes] = 0, b""  #: the state at which a server that ends left the session, and its step
    _may_pass: bool = False  #: whether gRPC or a proxy ended the call because of too much at once
    #: For `Session.trajectory`, the samples that had arrived, as a trajectory with the outcome CANCELLED. For
    #: `stiefel.sweep`, what it would have returned, with the outcome 0 at the missing points. None for all other calls.
    partial: Optional[Any] = None

    def __init__(self, message: str, violations: tuple[Violation, ...] = (), reason: str = "",
                 metadata: Optional[dict[str, str]] = None):
        super().__init__(message)
        self.message = message
        self.violations = violations
        self.reason = reason  #: a constant such as "SESSION_NOT_FOUND", or empty
        self.metadata = metadata or {}

    def __str__(self) -> str:
        lines = [f"{v.field}: {v.description}" for v in self.violations]
        samples = getattr(self.partial, "samples", None)  # a sweep's `partial` has none
        if isinstance(samples, int) and samples:
            lines.append(f"{samples} samples had arrived; they are in `partial`")
        return "\n  ".join([self.message] + [line for line in lines if line not in self.message])

    def _say(self, message: str) -> None:
        """Replaces the message."""
        self.message, self.args = message, (message,)

    def _as_given(self, name: str, order: Sequence[int]) -> None:
        """Replaces the index k of `name`[k] by `order[k]`, for a caller whose list was sent in another order."""
        def index(found: re.Match[str]) -> str:
            return f"{name}[{order[int(found[1])]}]"

        path = re.compile(rf"\b{re.escape(name)}\[(\d+)\]")
        self._say(path.sub(index, self.message))
        self.violations = tuple(v._replace(field=path.sub(index, v.field)) for v in self.violations)


class InvalidArgument(StiefelError, ValueError):
    """A value in a request breaks a rule. `violations` has the path of each wrong field, its value and the rule."""

    code = grpc.StatusCode.INVALID_ARGUMENT


class NotFound(StiefelError):
    """The server has no session of this id (`reason` is SESSION_NOT_FOUND), or it was deleted (SESSION_DELETED)."""

    code = grpc.StatusCode.NOT_FOUND


class AlreadyExists(StiefelError):
    """A session with the id that the caller chose exists and has another scene."""

    code = grpc.StatusCode.ALREADY_EXISTS


class ResourceExhausted(StiefelError):
    """The request exceeds a limit of the server or of its caller: `quota` names it, `reason` says which kind it is, and
    `retry_delay` says when the same request may succeed."""

    code = grpc.StatusCode.RESOURCE_EXHAUSTED


class FailedPrecondition(StiefelError):
    """The request is right, but the motion or the session does not allow it, such as a step that cannot be reached."""

    code = grpc.StatusCode.FAILED_PRECONDITION


class DeadlineExceeded(StiefelError, TimeoutError):
    """The time given to a call is over. For a trajectory, `partial` has the samples that had arrived."""

    code = grpc.StatusCode.DEADLINE_EXCEEDED


class Unavailable(StiefelError):
    """No server can be reached at the address, or the server is stopping or cannot use its store, or a server that this process
    started has ended."""

    code = grpc.StatusCode.UNAVAILABLE


class CorruptReply(StiefelError):
    """A reply that breaks the protocol: a field or a part of it is missing, or has a wrong shape."""

    code = grpc.StatusCode.DATA_LOSS


class Closed(FailedPrecondition):
    """A call of a closed client, or of one of its sessions, streams or drives."""


class BuildChanged(FailedPrecondition):
    """A server of another build answers for the session, so that further states could have other bits.

    `Client(any_build=True)` goes on nevertheless.
    """

    def __init__(self, id: str, began_with: str, now: str):
        super().__init__(f"session {id} began with the numerics id {began_with}, the server has {now}: the bits could "
                         "differ", reason="BUILD_CHANGED")
        self.began_with = began_with  #: the numerics id of the server that created the session
        self.now = now  #: the numerics id of the server that answered
