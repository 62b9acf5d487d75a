"""How a channel is secured: TLS, and the token that tells the server who calls."""
from __future__ import annotations

import ipaddress
import os
from dataclasses import dataclass
from typing import Any, Callable, Optional, Sequence, Union

import grpc

from stiefel.errors import InvalidArgument

Options = Sequence[tuple[str, Any]]


@dataclass(frozen=True)
class Tls:
    """The paths of PEM files for TLS, and the server's name.

    `ca`: the authorities that may sign the server's certificate; None for those that gRPC comes with. `certificate` and
    `key`: this client's, for a server that asks for them. `name`: the name that the server's certificate must have, if
    it is not the host of the address.
    """

    ca: Optional[str] = None
    certificate: Optional[str] = None
    key: Optional[str] = None
    name: Optional[str] = None


#: True: the authorities that gRPC comes with; a path: a file of authorities; False: no TLS.
TlsLike = Union[None, bool, str, "os.PathLike[str]", Tls]


def is_local(address: str) -> bool:
    """Returns whether the address is on this machine: a Unix socket, localhost, 127.0.0.0/8 or ::1."""
    if address.startswith("unix:"):
        return True
    host = address.rpartition(":")[0].strip("[]")
    try:
        return host == "localhost" or ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def has_tls(tls: TlsLike, address: str) -> bool:
    """Returns whether a channel to `address` has TLS. Raises InvalidArgument for TLS on a Unix socket."""
    return _tls(tls, address) is not None


def open_channel(address: str, tls: TlsLike, token: Optional[str], options: Options) -> grpc.Channel:
    """Opens a channel to `address`. Raises what `opener` raises."""
    return opener(address, tls, token)(grpc, options)


def opener(address: str, tls: TlsLike, token: Optional[str]) -> Callable[[Any, Options], Any]:
    """Returns a function that opens a channel of `grpc` or `grpc.aio` to `address`. Raises InvalidArgument for a token that
    would travel in plaintext beyond this machine, for TLS on a Unix socket, and for files that cannot be read."""
    security, more = _tls(tls, address), []
    token = _checked(token)
    if security is not None:
        credentials = _credentials(security)
        if security.name is not None:
            more = [("grpc.ssl_target_name_override", security.name)]
    elif token is None:
        return lambda kind, options: kind.insecure_channel(address, options=options)
    elif not is_local(address):
        raise InvalidArgument(f"a token is sent over TLS, to this machine or over a Unix socket only, and {address} is "
                              "none of these: give tls")
    else:  # These credentials check the connection, too: a name that resolves to another machine gets no token.
        credentials = grpc.local_channel_credentials(grpc.LocalConnectionType.UDS if address.startswith("unix:") else
                                                     grpc.LocalConnectionType.LOCAL_TCP)
    return lambda kind, options: _with_token(kind.secure_channel(address, credentials, options=[*options, *more]), token)


def token_from_environment() -> Optional[str]:
    """Returns the environment variable STIEFEL_TOKEN; None if it is not set or empty."""
    return os.environ.get("STIEFEL_TOKEN") or None


def _tls(given: TlsLike, address: str) -> Optional[Tls]:
    on_socket = address.startswith("unix:")
    if given is None:
        ca = os.environ.get("STIEFEL_TLS_CA")
        return Tls(ca=ca) if ca and not on_socket else None
    if given is False:
        return None
    if on_socket:
        raise InvalidArgument(f"tls: {address}: a Unix socket has no TLS")
    if given is True:
        return Tls()
    return given if isinstance(given, Tls) else Tls(ca=os.fspath(given))


def _credentials(tls: Tls) -> grpc.ChannelCredentials:
    if (tls.certificate is None) != (tls.key is None):
        raise InvalidArgument("tls: certificate and key: one needs the other")
    authorities = _read("ca", tls.ca)
    if authorities is not None and b"CERTIFICATE-----" not in authorities:
        raise InvalidArgument(f"tls: ca: {tls.ca}: must hold certificates in PEM")
    return grpc.ssl_channel_credentials(authorities, _read("key", tls.key), _read("certificate", tls.certificate))


def _read(what: str, path: Optional[str]) -> Optional[bytes]:
    if path is None:
        return None
    try:
        with open(path, "rb") as file:
            return file.read()
    except OSError as error:
        raise InvalidArgument(f"tls: {what}: {path}: {error.strerror}") from error


def _checked(token: Optional[str]) -> Optional[str]:
    if token is not None and not (token.isascii() and token.isprintable() and token.strip() == token != ""):
        raise InvalidArgument("token: it must be printable ASCII, without spaces around it")  # and never shown
    return token


def _with_token(channel: grpc.Channel, token: Optional[str]) -> Any:
    return channel if token is None else _Authorized(channel, token)


class _Authorized:
    """A channel whose calls carry the token. An interceptor, gRPC's own means, would make a call several times as
    expensive."""

    def __init__(self, channel: grpc.Channel, token: str):
        self._channel = channel
        self._metadata = ("authorization", f"Bearer {token}")

    def __getattr__(self, name: str) -> Any:
        attribute = getattr(self._channel, name)
        if name not in ("unary_unary", "unary_stream", "stream_stream"):
            return attribute
        return lambda *method, **more: _AuthorizedCall(attribute(*method, **more), self._metadata)


class _AuthorizedCall:
    def __init__(self, call: Any, metadata: tuple[str, str]):
        self._call, self._metadata = call, metadata

    def __call__(self, request: Any, timeout: Optional[float] = None, metadata: Any = (), **more: Any) -> Any:
        return self._call(request, timeout=timeout, metadata=(*(metadata or ()), self._metadata), **more)

    def with_call(self, request: Any, timeout: Optional[float] = None, metadata: Any = (), **more: Any) -> Any:
        return self._call.with_call(request, timeout, (*(metadata or ()), self._metadata), **more)
