"""Exceptions for the status of a failed call, in plain words."""
from __future__ import annotations

import re
import socket
from contextlib import suppress
from typing import Any, Optional
from urllib.parse import unquote

import grpc
from google.protobuf.message import DecodeError

from stiefel import v1 as pb
from stiefel.errors import CorruptReply, StiefelError, Violation

_BY_CODE = {kind.code.value[0]: kind for kind in StiefelError.__subclasses__() if kind.__module__ == StiefelError.__module__}


def from_status(status: pb.Status) -> StiefelError:
    """Returns the exception for a status with its details. Ignores a detail that cannot be read."""
    found: dict[str, Any] = {kind.__name__: kind() for kind in (pb.BadRequest, pb.QuotaFailure, pb.ErrorInfo, pb.RetryInfo, pb.Checkpoint)}
    for detail in status.details:
        kind = detail.type_url.rpartition(".")[2]
        with suppress(DecodeError, KeyError):
            found[kind] = type(found[kind]).FromString(detail.value)
    bad, exceeded, info, retry, saved = found.values()
    error_type = _BY_CODE.get(status.code, StiefelError)
    remedy = "; here: give `token`" if info.reason == "TOKEN_MISSING" else ""
    violations = tuple(Violation(v.field, v.description) for v in bad.field_violations)
    error = error_type(status.message + remedy, violations, info.reason, dict(info.metadata))
    error.quota = tuple(Violation(v.subject, v.description) for v in exceeded.violations)
    error._checkpoint = saved.step, saved.data
    if retry.HasField("retry_delay"):
        error.retry_delay = retry.retry_delay.seconds + 1e-9 * retry.retry_delay.nanos
    if error_type is StiefelError:
        error.code = next((c for c in grpc.StatusCode if c.value[0] == status.code), error_type.code)
    return error


# The messages of gRPC for a server that it does not find. The address is the first or the second group.
_UNREACHABLE = re.compile(r"(?:DNS resolution failed for|errors resolving) (\S+): |failed to connect to all addresses"
                          r"(?:; last error: \w+: (?:ipv4:|ipv6:)?(\S+): )?")
_REFUSED = "the connection is refused, nothing listens there"
_CLOSES = "it closes the connection"
_REASONS = (  # the first one that occurs in gRPC's message counts
    ("Connection refused", _REFUSED),
    ("No such file", "there is no such socket"),
    ("not in peer certificate|Hostname Verification Check failed", "its certificate has another name"),
    ("(?i)certificate.verify.failed", "its certificate is not trusted"),
    ("(?i)wrong.version.number", "it does not speak TLS"),
    ("handshaker shutdown|http1.x server|Failed parsing HTTP/2", "nothing that speaks gRPC answers there"),
    ("Socket closed|Connection reset|Broken pipe", _CLOSES),
    ("(?i)timed out|timeout occurred", "the server does not answer"),
    ("errors resolving|DNS", "the name is unknown"),
)
# gRPC's messages for a connection that broke while a call ran, such as that of a proxy to its server, and for a call
# that reached a server while it shut down. Their codes are CANCELLED, INTERNAL, UNKNOWN and UNAVAILABLE; errors of the
# server itself have details.
_BROKEN = re.compile(r"Received RST_STREAM|Stream removed\b|Socket closed$|CANCELLED$|No status received|"
                     r"recvmsg:|sendmsg:|Broken pipe$|Connection reset by peer$|GOAWAY received$")
_ENHANCE_YOUR_CALM = "Received RST_STREAM with error code 11"  # HTTP/2's error for too much at once
_PLAIN = (  # gRPC's messages for calls that reached a server, by how they begin
    (f"{_ENHANCE_YOUR_CALM}|received initial metadata size", "the server or a proxy before it refuses the call as too much: "
     "the call's metadata, such as its token, is too large, or too many calls or bytes come at once"),
    ("Received http2 header with status:", "a web server answers there, not a stiefel server"),
    ("Deadline Exceeded", "the call took longer than its timeout"),
    (_BROKEN.pattern, "the connection to the server broke"),
)


def in_plain_words(message: str, tls: Optional[bool] = None, asked: str = "") -> str:
    """Replaces gRPC's message for a server that it does not find by one such as "cannot reach HOST:PORT: the name is
    unknown", and its messages for a call that broke. Returns any other message unchanged. `tls`: whether the channel
    has TLS, if that is known. `asked`: the address of the channel."""
    found = _UNREACHABLE.match(message)
    if not found:
        return next((plain for pattern, plain in _PLAIN if re.match(pattern, message)), message)
    address = unquote(found.group(1) or found.group(2) or "the server")
    reason = next((plain for pattern, plain in _REASONS if re.search(pattern, message)), message.split(": ")[-1])
    if reason == _REFUSED and asked not in ("", address) and _accepts(asked):
        address, reason = asked, "it accepts the connection, and then the TLS handshake fails" if tls else _CLOSES
    if reason == _CLOSES and tls is not None:
        reason += (", as a server does that asks clients for a certificate: give one in `tls`" if tls else
                   ", as a server with TLS does to a client without: give `tls`")
    return f"cannot reach {address}: {reason}{gone.get(asked, '')}"


gone: dict[str, str] = {}  #: why a server that this process started is gone, behind "; ", by its address


def _accepts(address: str) -> bool:
    """Returns whether one of the addresses of a name, of which gRPC's message has the last alone, accepts connections:
    localhost may be 127.0.0.1, where a server closes them, and ::1, where none listens."""
    host, _, port = address.rpartition(":")
    try:
        with socket.create_connection((host, int(port)), timeout=1):
            return True
    except (OSError, ValueError):
        return False


def from_rpc_error(error: grpc.RpcError, tls: Optional[bool] = None, asked: str = "") -> StiefelError:
    """Returns this package's exception. `tls`: whether the channel has TLS, if that is known. `asked`: its address."""
    message, code, metadata = error.details() or "", error.code(), error.trailing_metadata() or ()
    for details in (value for key, value in metadata if key == "grpc-status-details-bin"):
        status = pb.Status()
        with suppress(DecodeError):  # the message alone says what is wrong
            status = pb.Status.FromString(details)
        return from_status(pb.Status(code=code.value[0], message=message, details=status.details))
    if code is grpc.StatusCode.INTERNAL and message == "Exception deserializing response!":
        return CorruptReply("the reply's bytes are not a message of this call")
    if code is grpc.StatusCode.DEADLINE_EXCEEDED and _BROKEN.match(message):
        message = "Deadline Exceeded"  # new versions of gRPC say how the call was ended
    maybe = code in (grpc.StatusCode.CANCELLED, grpc.StatusCode.INTERNAL, grpc.StatusCode.UNKNOWN)
    if (maybe and _BROKEN.match(message)) or message.startswith("Received http2 header"):
        code = grpc.StatusCode.UNAVAILABLE
    plain = from_status(pb.Status(code=code.value[0], message=in_plain_words(message, tls, asked)))
    plain._may_pass = message.startswith(_ENHANCE_YOUR_CALM)
    return plain
