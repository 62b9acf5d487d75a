"""Exceptions: one type for each status code, with all violations that the server found.

A numerical stop is not an exception but an `Outcome` in the reply.
"""
from __future__ import annotations

import re
from contextlib import suppress
from typing import Any, NamedTuple, Optional, Sequence
from urllib.parse import unquote

import grpc
from google.protobuf.message import DecodeError

from stiefel import v1 as pb


class Violation(NamedTuple):
    """A fault in one field of a request."""

    field: str  #: its path: "scene.initial.Q"
    description: str  #: its value and the rule it breaks


class SceneWarning(UserWarning):
    """A warning of the server about a scene that it accepts, such as moments that no rigid body can have."""


class StiefelError(Exception):
    """The base class of all exceptions of this package."""

    code: grpc.StatusCode = grpc.StatusCode.UNKNOWN
    quota: tuple[Violation, ...] = ()  #: the limits that the request exceeds; `field` is the limit's name: "sessions"
    retry_delay: Optional[float] = None  #: seconds after which the same request may succeed, if the server says so
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

    def say(self, message: str) -> None:
        """Replaces the message."""
        self.message, self.args = message, (message,)

    def relative_to(self, place: str) -> None:
        """Makes the paths of fields relative to `place`, for a caller who gave only the fields inside it: relative to
        "pairs[0]", the path "pairs[0].Q_0" becomes "Q_0"."""
        self.say(self.message.replace(place + ".", ""))
        self.violations = tuple(v._replace(field=v.field.removeprefix(place + ".")) for v in self.violations)

    def as_given(self, name: str, order: Sequence[int]) -> None:
        """Replaces the index k of `name`[k] by `order[k]`, for a caller whose list was sent in another order."""
        def index(found: re.Match[str]) -> str:
            return f"{name}[{order[int(found[1])]}]"

        path = re.compile(rf"\b{re.escape(name)}\[(\d+)\]")
        self.say(path.sub(index, self.message))
        self.violations = tuple(v._replace(field=path.sub(index, v.field)) for v in self.violations)


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
    """The time given to a call is over. For a trajectory, `partial` has the samples that had arrived."""

    code = grpc.StatusCode.DEADLINE_EXCEEDED
    takes: str = ""  #: how long the call takes, if the server has told that


class Cancelled(StiefelError):
    code = grpc.StatusCode.CANCELLED


class Unavailable(StiefelError):
    code = grpc.StatusCode.UNAVAILABLE


class Unauthenticated(StiefelError):
    """The server needs a token (`reason` is TOKEN_MISSING), or the token sent is unknown or was withdrawn
    (TOKEN_UNKNOWN). `reason` is empty if the token was withdrawn while the call ran."""

    code = grpc.StatusCode.UNAUTHENTICATED


class Unimplemented(StiefelError):
    code = grpc.StatusCode.UNIMPLEMENTED


class Internal(StiefelError):
    code = grpc.StatusCode.INTERNAL


class CorruptReply(StiefelError):
    """A reply that breaks the protocol: it was damaged on the way, so that its checksum differs, or a part of it, or the
    checksum that was asked for, is missing."""

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


class NotStarted(Unavailable, RuntimeError):
    """A server started by this process ended, or did not say in time that it listens."""

    status: Optional[int] = None  #: the server's exit status, negative for a signal; None if it had to be killed
    stderr: str = ""  #: the end of the server's output to stderr


_BY_CODE = {kind.code.value[0]: kind for kind in StiefelError.__subclasses__()}


def make_error(code: int, message: str, details: bytes = b"") -> StiefelError:
    """Returns the exception for a status code with the details of `grpc-status-details-bin`. Details that cannot be
    read are ignored, because the message alone says what is wrong."""
    try:
        status = pb.Status.FromString(details)
    except DecodeError:
        status = pb.Status()
    status.code, status.message = code, message
    return from_status(status)


def from_status(status: pb.Status) -> StiefelError:
    """Returns the exception for a status with its details. Ignores a detail that cannot be read."""
    violations: list[Violation] = []
    quota: list[Violation] = []
    info, retry = pb.ErrorInfo(), pb.RetryInfo()
    for detail in status.details:
        kind = detail.type_url.rpartition("/google.rpc.")[2]
        with suppress(DecodeError):
            if kind == "BadRequest":
                request = pb.BadRequest.FromString(detail.value)
                violations += [Violation(v.field, v.description) for v in request.field_violations]
            elif kind == "QuotaFailure":
                quota += [Violation(v.subject, v.description) for v in pb.QuotaFailure.FromString(detail.value).violations]
            elif kind == "RetryInfo":
                retry = pb.RetryInfo.FromString(detail.value)
            elif kind == "ErrorInfo":
                info = pb.ErrorInfo.FromString(detail.value)
    error_type = _BY_CODE.get(status.code, StiefelError)
    error = error_type(status.message, tuple(violations), info.reason, dict(info.metadata))
    error.quota = tuple(quota)
    if retry.HasField("retry_delay"):
        error.retry_delay = retry.retry_delay.seconds + 1e-9 * retry.retry_delay.nanos
    if error_type is StiefelError:
        error.code = next((c for c in grpc.StatusCode if c.value[0] == status.code), error_type.code)
    return error


# The messages of gRPC for a server that it does not find. The address is the first or the second group.
_UNREACHABLE = re.compile(r"(?:DNS resolution failed for|errors resolving) (\S+): |failed to connect to all addresses"
                          r"(?:; last error: \w+: (?:ipv4:|ipv6:)?(\S+): )?")
_NO_GRPC = "nothing that speaks gRPC answers there"
_CLOSES = "it closes the connection"
_REASONS = {  # the first key that occurs in gRPC's message counts
    "Connection refused": "the connection is refused, nothing listens there",
    "No such file or directory": "there is no such socket",
    "Permission denied": "permission is denied",
    "No route to host": "there is no route to this host",
    "Network is unreachable": "its network cannot be reached",
    "is not in peer certificate": "its certificate has another name",
    "Hostname Verification Check failed": "its certificate has another name",
    "CERTIFICATE_VERIFY_FAILED": "its certificate is not trusted",
    "certificate verify failed": "its certificate is not trusted",
    "WRONG_VERSION_NUMBER": "it does not speak TLS",
    "wrong version number": "it does not speak TLS",
    "handshake failed": "the TLS handshake failed",
    "handshaker shutdown": _NO_GRPC,
    "http1.x server": _NO_GRPC,
    "Failed parsing HTTP/2": _NO_GRPC,
    "Socket closed": _CLOSES,
    "Connection reset": _CLOSES,
    "Broken pipe": _CLOSES,
    "Timeout occurred": "the server does not answer",
    "timed out": "the server does not answer",
    "contacting DNS servers": "no name server answers",
    "contact DNS servers": "no name server answers",
    "DNS resolution failed": "the name is unknown",
    "Domain name not found": "the name is unknown",
    "errors resolving": "its name cannot be resolved",
}
# gRPC's messages for a connection that broke while a call ran, such as that of a proxy to its server, and for a call
# that reached a server while it shut down. Their codes are CANCELLED, INTERNAL, UNKNOWN and UNAVAILABLE; errors of the
# server itself have details.
_BROKEN = re.compile(r"Received RST_STREAM|Stream removed\b|Socket closed$|CANCELLED$|No status received|"
                     r"recvmsg:|sendmsg:|Broken pipe$|Connection reset by peer$")
_BROKE = "the connection to the server broke"
_PLAIN = {  # gRPC's messages for calls that reached a server, by how they begin
    "Received RST_STREAM with error code 11": "the server or a proxy before it refuses the call as too much: the call's "
                                              "metadata, such as its token, is too large, or too many calls come at once",
    "received initial metadata size exceeds": "the call's metadata, such as its token, is larger than the server takes",
    "Received http2 header with status:": "a web server answers there, not a stiefel server",
    "Deadline Exceeded": "the call took longer than its timeout",
}


def in_plain_words(message: str, tls: Optional[bool] = None) -> str:
    """Replaces gRPC's message for a server that it does not find by one such as "cannot reach HOST:PORT: the name is
    unknown", and its messages for a call that broke. Returns any other message unchanged. `tls`: whether the channel
    has TLS, if that is known."""
    found = _UNREACHABLE.match(message)
    if not found:
        plain = next((ours for theirs, ours in _PLAIN.items() if message.startswith(theirs)), None)
        return plain or (_BROKE if _BROKEN.match(message) else message)
    address = unquote(found.group(1) or found.group(2) or "the server")
    reason = next((plain for grpc_says, plain in _REASONS.items() if grpc_says in message), message.split(": ")[-1])
    if reason == _CLOSES and tls is not None:
        reason += (", as a server does that asks clients for a certificate: give one in `tls`" if tls else
                   ", as a server with TLS does to a client without: give `tls`")
    return f"cannot reach {address}: {reason}"


def from_rpc_error(error: grpc.RpcError, tls: Optional[bool] = None) -> StiefelError:
    """Returns this package's exception. `tls`: whether the channel has TLS, if that is known."""
    trailing = dict(error.trailing_metadata() or ())
    details = trailing.get("grpc-status-details-bin", b"")
    message, code = error.details() or "", error.code()
    if details:
        return make_error(code.value[0], message, details)
    if code is grpc.StatusCode.INTERNAL and message == "Exception deserializing response!":
        return CorruptReply("the reply's bytes are not a message of this call")
    maybe = code in (grpc.StatusCode.CANCELLED, grpc.StatusCode.INTERNAL, grpc.StatusCode.UNKNOWN)
    if (maybe and _BROKEN.match(message)) or message.startswith("Received http2 header"):
        code = grpc.StatusCode.UNAVAILABLE
    return make_error(code.value[0], in_plain_words(message, tls))
