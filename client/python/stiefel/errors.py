"""Exceptions: one type a status code, with every violation that the server found.

A numerical stop is not among them: it is an `Outcome` in the reply.
"""
from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any, NamedTuple, Optional
from urllib.parse import unquote

import grpc
from google.protobuf.message import DecodeError

from stiefel.v1 import error_pb2

if TYPE_CHECKING:
    from stiefel.arrays import Trajectory


class Violation(NamedTuple):
    """What is wrong with one field of a request."""

    field: str  #: its path: "scene.initial.Q"
    description: str  #: its value and the rule it breaks


class SceneWarning(UserWarning):
    """What the server finds doubtful about a scene that it takes: moments that no rigid body can have."""


class StiefelError(Exception):
    """The base of all of them."""

    code: grpc.StatusCode = grpc.StatusCode.UNKNOWN
    #: Of `Session.trajectory`: the samples that had arrived, as a trajectory with the outcome
    #: CANCELLED. None of every other call.
    partial: Optional[Trajectory] = None

    def __init__(self, message: str, violations: tuple[Violation, ...] = (), reason: str = "",
                 metadata: Optional[dict[str, str]] = None):
        super().__init__(message)
        self.message = message
        self.violations = violations
        self.reason = reason  #: a constant such as "SESSION_NOT_FOUND", or empty
        self.metadata = metadata or {}

    def __str__(self) -> str:
        lines = [f"{v.field}: {v.description}" for v in self.violations]
        if self.partial is not None and self.partial.samples:
            lines.append(f"{self.partial.samples} samples had arrived; they are in `partial`")
        return "\n  ".join([self.message] + [line for line in lines if line not in self.message])


class InvalidArgument(StiefelError, ValueError):
    code = grpc.StatusCode.INVALID_ARGUMENT


class NotFound(StiefelError):
    code = grpc.StatusCode.NOT_FOUND


class AlreadyExists(StiefelError):
    code = grpc.StatusCode.ALREADY_EXISTS


class ResourceExhausted(StiefelError):
    code = grpc.StatusCode.RESOURCE_EXHAUSTED


class FailedPrecondition(StiefelError):
    code = grpc.StatusCode.FAILED_PRECONDITION


class DeadlineExceeded(StiefelError, TimeoutError):
    """The time given to a call is over. `partial` has what a trajectory had got by then."""

    code = grpc.StatusCode.DEADLINE_EXCEEDED


class Cancelled(StiefelError):
    code = grpc.StatusCode.CANCELLED


class Unavailable(StiefelError):
    code = grpc.StatusCode.UNAVAILABLE


class Unimplemented(StiefelError):
    code = grpc.StatusCode.UNIMPLEMENTED


class Internal(StiefelError):
    code = grpc.StatusCode.INTERNAL


class Closed(FailedPrecondition):
    """A call of a client that is closed, or of one of its sessions, streams or drives."""


class NotStarted(Unavailable, RuntimeError):
    """A server of one's own that ended, or said nothing in time, before it listened."""

    status: Optional[int] = None  #: its exit status, negative a signal; None if it had to be killed
    stderr: str = ""  #: the end of what it wrote there


_BY_CODE = {kind.code.value[0]: kind for kind in StiefelError.__subclasses__()}


def make_error(code: int, message: str, details: bytes = b"") -> StiefelError:
    """The exception for a status code, with what `grpc-status-details-bin` says."""
    violations: list[Violation] = []
    info = error_pb2.ErrorInfo()
    for detail in _details(details):
        if detail.type_url.endswith("/google.rpc.BadRequest"):
            request = error_pb2.BadRequest.FromString(detail.value)
            violations += [Violation(v.field, v.description) for v in request.field_violations]
        elif detail.type_url.endswith("/google.rpc.ErrorInfo"):
            info.ParseFromString(detail.value)
    kind = _BY_CODE.get(code, StiefelError)
    error = kind(message, tuple(violations), info.reason, dict(info.metadata))
    if kind is StiefelError:
        error.code = next((c for c in grpc.StatusCode if c.value[0] == code), kind.code)
    return error


def _details(details: bytes) -> list[Any]:
    """None if they cannot be read: the message says what is wrong without them."""
    try:
        return list(error_pb2.Status.FromString(details).details)
    except DecodeError:
        return []


# What gRPC says of a server that it does not find; the address is the first group.
_UNREACHABLE = re.compile(r"DNS resolution failed for (\S+): |failed to connect to all addresses(?:; last error: \w+: "
                          r"(?:ipv4:|ipv6:)?(\S+): )?")
_REASONS = {  # the first that occurs in gRPC's message
    "Connection refused": "the connection is refused, nothing listens there",
    "No such file or directory": "there is no such socket",
    "Permission denied": "permission is denied",
    "No route to host": "there is no route to this host",
    "Network is unreachable": "its network cannot be reached",
    "handshaker shutdown": "nothing that speaks gRPC answers there",
    "Timeout occurred": "nobody answers",
    "contacting DNS servers": "no name server answers",
    "contact DNS servers": "no name server answers",
    "DNS resolution failed": "the name is unknown",
}


def in_plain_words(message: str) -> str:
    """"cannot reach HOST:PORT: the name is unknown" in place of what gRPC says of a server that it does not find;
    any other message as it is."""
    found = _UNREACHABLE.match(message)
    if not found:
        return message
    address = unquote(found.group(1) or found.group(2) or "the server")
    reason = next((plain for grpc_says, plain in _REASONS.items() if grpc_says in message), message.split(": ")[-1])
    return f"cannot reach {address}: {reason}"


def from_rpc_error(error: grpc.RpcError) -> StiefelError:
    trailing = dict(error.trailing_metadata() or ())
    details = trailing.get("grpc-status-details-bin", b"")
    return make_error(error.code().value[0], in_plain_words(error.details() or ""), details)
