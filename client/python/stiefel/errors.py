"""Exceptions: one type a status code, with every violation that the server found.

A numerical stop is not among them: it is an `Outcome` in the reply.
"""
from __future__ import annotations

import re
from typing import TYPE_CHECKING, NamedTuple, Optional
from urllib.parse import unquote

import grpc
from google.protobuf.message import DecodeError

from stiefel import v1 as pb

if TYPE_CHECKING:
    from stiefel.arrays import Trajectory


class Violation(NamedTuple):
    """A fault in one field of a request."""

    field: str  #: its path: "scene.initial.Q"
    description: str  #: its value and the rule it breaks


class SceneWarning(UserWarning):
    """What the server finds doubtful about a scene that it takes: moments that no rigid body can have."""


class StiefelError(Exception):
    """The base class of all exceptions of this package."""

    code: grpc.StatusCode = grpc.StatusCode.UNKNOWN
    quota: tuple[Violation, ...] = ()  #: the limits that the request exceeds, by what they are on: "sessions"
    retry_delay: Optional[float] = None  #: seconds after which the same request may succeed, if the server says so
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

    def relative_to(self, place: str) -> None:
        """Shortens the paths of fields inside `place`, for a caller who gave only what is there: relative to
        "pairs[0]" the path "pairs[0].Q_0" is "Q_0"."""
        self.message = self.message.replace(place + ".", "")
        self.violations = tuple(v._replace(field=v.field.removeprefix(place + ".")) for v in self.violations)
        self.args = (self.message,)


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


class Unauthenticated(StiefelError):
    """The server needs a token, or the one sent is unknown or was withdrawn: `reason` is TOKEN_MISSING or
    TOKEN_UNKNOWN; empty for a call that ran when its token was withdrawn."""

    code = grpc.StatusCode.UNAUTHENTICATED


class Unimplemented(StiefelError):
    code = grpc.StatusCode.UNIMPLEMENTED


class Internal(StiefelError):
    code = grpc.StatusCode.INTERNAL


class CorruptReply(StiefelError):
    """A reply whose numbers are not those that the server sent: its checksum differs, or a part is missing."""

    code = grpc.StatusCode.DATA_LOSS


class Closed(FailedPrecondition):
    """A call of a client that is closed, or of one of its sessions, streams or drives."""


class BuildChanged(FailedPrecondition):
    """A server of another build answers for the session: its states could have other bits than those so far.

    `Client(any_build=True)` goes on nevertheless.
    """

    def __init__(self, id: str, began_with: str, now: str):
        super().__init__(f"session {id} began with the numerics id {began_with}, the server has {now}: the bits could "
                         "differ", reason="BUILD_CHANGED")
        self.began_with = began_with  #: the numerics id of the server that created the session
        self.now = now  #: that of the server that answered


class NotStarted(Unavailable, RuntimeError):
    """A server started by this process that ended, or said nothing in time, before it listened."""

    status: Optional[int] = None  #: its exit status, negative a signal; None if it had to be killed
    stderr: str = ""  #: the end of what it wrote there


_BY_CODE = {kind.code.value[0]: kind for kind in StiefelError.__subclasses__()}


def make_error(code: int, message: str, details: bytes = b"") -> StiefelError:
    """The exception for a status code, with what `grpc-status-details-bin` says. Details that cannot be
    read are left out: the message says what is wrong without them."""
    try:
        status = pb.Status.FromString(details)
    except DecodeError:
        status = pb.Status()
    status.code, status.message = code, message
    return from_status(status)


def from_status(status: pb.Status) -> StiefelError:
    """The exception for a status with its details."""
    violations: list[Violation] = []
    quota: list[Violation] = []
    info, retry = pb.ErrorInfo(), pb.RetryInfo()
    for detail in status.details:
        kind = detail.type_url.rpartition("/google.rpc.")[2]
        if kind == "BadRequest":
            request = pb.BadRequest.FromString(detail.value)
            violations += [Violation(v.field, v.description) for v in request.field_violations]
        elif kind == "QuotaFailure":
            quota += [Violation(v.subject, v.description) for v in pb.QuotaFailure.FromString(detail.value).violations]
        elif kind == "RetryInfo":
            retry.ParseFromString(detail.value)
        elif kind == "ErrorInfo":
            info.ParseFromString(detail.value)
    error_type = _BY_CODE.get(status.code, StiefelError)
    error = error_type(status.message, tuple(violations), info.reason, dict(info.metadata))
    error.quota = tuple(quota)
    if retry.HasField("retry_delay"):
        error.retry_delay = retry.retry_delay.seconds + 1e-9 * retry.retry_delay.nanos
    if error_type is StiefelError:
        error.code = next((c for c in grpc.StatusCode if c.value[0] == status.code), error_type.code)
    return error


# The message of gRPC for a server that it does not find; the address is the first group.
_UNREACHABLE = re.compile(r"DNS resolution failed for (\S+): |failed to connect to all addresses(?:; last error: \w+: "
                          r"(?:ipv4:|ipv6:)?(\S+): )?")
_REASONS = {  # the first that occurs in gRPC's message
    "Connection refused": "the connection is refused, nothing listens there",
    "No such file or directory": "there is no such socket",
    "Permission denied": "permission is denied",
    "No route to host": "there is no route to this host",
    "Network is unreachable": "its network cannot be reached",
    "is not in peer certificate": "its certificate has another name",
    "CERTIFICATE_VERIFY_FAILED": "its certificate is not trusted",
    "certificate verify failed": "its certificate is not trusted",
    "Ssl handshake failed": "the TLS handshake failed",
    "handshaker shutdown": "nothing that speaks gRPC answers there",
    "Timeout occurred": "the server does not answer",
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


# What gRPC says of a connection that broke while a call ran, such as that of a proxy to its server, and of a call that
# reached a server at its end. The codes are CANCELLED, INTERNAL and UNKNOWN; an error of the server's own has details.
_BROKEN = re.compile(r"Received RST_STREAM|Stream removed$|Socket closed$|CANCELLED$|No status received")


def from_rpc_error(error: grpc.RpcError) -> StiefelError:
    trailing = dict(error.trailing_metadata() or ())
    details = trailing.get("grpc-status-details-bin", b"")
    message, code = error.details() or "", error.code()
    maybe = code in (grpc.StatusCode.CANCELLED, grpc.StatusCode.INTERNAL, grpc.StatusCode.UNKNOWN)
    if maybe and not details and _BROKEN.match(message):
        code = grpc.StatusCode.UNAVAILABLE
    return make_error(code.value[0], in_plain_words(message), details)
