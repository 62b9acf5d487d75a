"""Where a server is, and how the channel to it is secured: TLS, and the token that tells the server who calls."""
from __future__ import annotations

import ipaddress
import os
import re
from dataclasses import dataclass
from functools import partial
from typing import Any, Callable, Optional, Sequence, Union

import grpc

from stiefel.errors import InvalidArgument, Violation

LONGEST_PATH = 107  #: bytes of the path of a Unix socket
_OTHER_SCHEMES = re.compile(r"(unix-abstract|dns|ipv4|ipv6|vsock|xds|passthrough|google-c2p):")


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


def check(address: str) -> None:
    """Raises InvalidArgument for what cannot be an address, "host:port" or "unix:/path"."""
    fault = _fault(address)
    if fault is not None:
        raise InvalidArgument(f"cannot reach {address}: {fault}", (Violation("address", f"{address}: {fault}"),))


def _fault(address: str) -> Optional[str]:
    if address.startswith("unix:"):
        path = address[7 if address.startswith("unix://") else 5:]
        long = f"the socket's path is longer than {LONGEST_PATH} bytes" if len(path.encode()) > LONGEST_PATH else None
        return long if path else "the socket's path is missing"
    if _OTHER_SCHEMES.match(address):
        return None
    scheme, (host, _, port) = re.match(r"\w*://", address), address.rpartition(":")
    if scheme:
        return f"it must be HOST:PORT, without '{scheme[0]}'"
    if re.search(r"[\s/]", address):
        return "it must be HOST:PORT or unix:PATH"
    if ":" in host and not re.fullmatch(r"\[[^\[\]]+\]", host):
        return "an IPv6 address is written in brackets, [IPv6]:PORT"
    if not host:
        return "the host is missing" if address.startswith(":") else "the port is missing"
    if not re.fullmatch("[0-9]+", port):
        return f"the port {port!r} is not a number" if port else "the port is missing"
    return None if 1 <= int(port) <= 65535 else f"the port {port} is not between 1 and 65535"


def is_local(address: str) -> bool:
    """Returns whether the address is on this machine: a Unix socket, localhost, 127.0.0.0/8 or ::1."""
    host = address.rpartition(":")[0].strip("[]")
    try:
        return address.startswith("unix:") or host == "localhost" or ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def secured(address: str, tls: TlsLike, token: Optional[str]) -> tuple[Callable[..., Any], bool, tuple[tuple[str, str], ...]]:
    """Returns what opens a channel of `grpc` or `grpc.aio` with options, whether it has TLS, and the metadata of every call, with
    the token: an interceptor, gRPC's own means, would make a call several times as expensive. `token`: by default the environment
    variable STIEFEL_TOKEN. Raises InvalidArgument for a token that would travel in plaintext beyond this machine, for TLS on a
    Unix socket, and for files that cannot be read."""
    on_socket, options, credentials = address.startswith("unix:"), [], None
    if tls is None:
        tls = not on_socket and os.environ.get("STIEFEL_TLS_CA") or False
    token = os.environ.get("STIEFEL_TOKEN") or None if token is None else token
    if token is not None and not (token.isascii() and token.isprintable() and token.strip() == token != ""):
        raise InvalidArgument("token: it must be printable ASCII, without spaces around it")  # and never shown
    if tls is not False:
        if on_socket:
            raise InvalidArgument(f"tls: {address}: a Unix socket has no TLS")
        given = tls if isinstance(tls, Tls) else Tls(None if tls is True else os.fspath(tls))
        if (given.certificate is None) != (given.key is None):
            raise InvalidArgument("tls: certificate and key: one needs the other")
        files = (_read(name, getattr(given, name)) for name in ("ca", "key", "certificate"))
        credentials = partial(grpc.ssl_channel_credentials, *files)
        options = [] if given.name is None else [("grpc.ssl_target_name_override", given.name)]
    elif token is not None and not is_local(address):
        raise InvalidArgument(f"a token is sent over TLS, to this machine or over a Unix socket only, and {address} is "
                              "none of these: give tls")
    elif token is not None:  # These credentials check the connection, too: a name that resolves to another machine gets no token.
        credentials = partial(grpc.local_channel_credentials, grpc.LocalConnectionType.UDS if on_socket else
                              grpc.LocalConnectionType.LOCAL_TCP)

    def open(kind: Any, more: Sequence[tuple[str, Any]]) -> Any:
        if credentials is None:
            return kind.insecure_channel(address, options=more)
        return kind.secure_channel(address, credentials(), options=[*more, *options])

    return open, tls is not False, (("authorization", f"Bearer {token}"),) if token is not None else ()


def _read(what: str, path: Optional[str]) -> Optional[bytes]:
    if path is None:
        return None
    try:
        with open(path, "rb") as file:
            found = file.read()
    except OSError as error:
        raise InvalidArgument(f"tls: {what}: {path}: {error.strerror}") from error
    if what == "ca" and b"CERTIFICATE-----" not in found:
        raise InvalidArgument(f"tls: ca: {path}: must hold certificates in PEM")
    return found
