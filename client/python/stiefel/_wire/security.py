"""How a channel is secured: TLS, and the token that tells the server who calls."""
from __future__ import annotations

import ipaddress
import os
from dataclasses import dataclass
from functools import partial
from typing import Any, Callable, NamedTuple, Optional, Sequence, Union

import grpc

from stiefel.errors import InvalidArgument


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


class Secured(NamedTuple):
    """How the channels of an address are opened, and what their calls carry."""

    open: Callable[[Any, Sequence[tuple[str, Any]]], Any]  #: opens a channel of `grpc` or `grpc.aio` with options
    tls: bool  #: whether they have TLS
    #: The metadata of every call, with the token. An interceptor, gRPC's own means, would make a call several times as expensive.
    bearer: Sequence[tuple[str, str]]


def secured(address: str, tls: TlsLike, token: Optional[str]) -> Secured:
    """`token`: by default the environment variable STIEFEL_TOKEN. Raises InvalidArgument for a token that would travel in
    plaintext beyond this machine, for TLS on a Unix socket, and for files that cannot be read."""
    security, more, credentials = _tls(tls, address), [], None
    token = os.environ.get("STIEFEL_TOKEN") or None if token is None else token
    if token is not None and not (token.isascii() and token.isprintable() and token.strip() == token != ""):
        raise InvalidArgument("token: it must be printable ASCII, without spaces around it")  # and never shown
    if security is not None:
        credentials = partial(grpc.ssl_channel_credentials, *_files(security))
        if security.name is not None:
            more = [("grpc.ssl_target_name_override", security.name)]
    elif token is not None and not is_local(address):
        raise InvalidArgument(f"a token is sent over TLS, to this machine or over a Unix socket only, and {address} is "
                              "none of these: give tls")
    elif token is not None:  # These credentials check the connection, too: a name that resolves to another machine gets no token.
        credentials = partial(grpc.local_channel_credentials, grpc.LocalConnectionType.UDS if address.startswith("unix:") else
                              grpc.LocalConnectionType.LOCAL_TCP)

    def open(kind: Any, options: Sequence[tuple[str, Any]]) -> Any:
        if credentials is None:
            return kind.insecure_channel(address, options=options)
        return kind.secure_channel(address, credentials(), options=[*options, *more])

    return Secured(open, security is not None, () if token is None else (("authorization", f"Bearer {token}"),))


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


def _files(tls: Tls) -> tuple[Optional[bytes], Optional[bytes], Optional[bytes]]:
    """Returns the authorities, the key and the certificate."""
    if (tls.certificate is None) != (tls.key is None):
        raise InvalidArgument("tls: certificate and key: one needs the other")
    authorities = _read("ca", tls.ca)
    if authorities is not None and b"CERTIFICATE-----" not in authorities:
        raise InvalidArgument(f"tls: ca: {tls.ca}: must hold certificates in PEM")
    return authorities, _read("key", tls.key), _read("certificate", tls.certificate)


def _read(what: str, path: Optional[str]) -> Optional[bytes]:
    if path is None:
        return None
    try:
        with open(path, "rb") as file:
            return file.read()
    except OSError as error:
        raise InvalidArgument(f"tls: {what}: {path}: {error.strerror}") from error
