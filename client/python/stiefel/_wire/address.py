"""The address of a server: "host:port" or "unix:/path"."""
from __future__ import annotations

import re
from typing import Optional

from stiefel.errors import InvalidArgument, Violation

LONGEST_PATH = 107  #: bytes of the path of a Unix socket

_OTHER_SCHEMES = re.compile(r"(unix-abstract|dns|ipv4|ipv6|vsock|xds|passthrough|google-c2p):")


def check(address: str) -> None:
    """Raises InvalidArgument for what cannot be an address."""
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
    scheme = re.match(r"\w*://", address)
    if scheme:
        return f"it must be HOST:PORT, without '{scheme[0]}'"
    host, colon, port = address.rpartition(":")
    if re.search(r"[\s/]", address):
        return "it must be HOST:PORT or unix:PATH"
    if ":" in host and not re.fullmatch(r"\[[^\[\]]+\]", host):
        return "an IPv6 address is written in brackets, [IPv6]:PORT"
    if not colon or not port:
        return "the port is missing"
    if not host:
        return "the host is missing"
    if not re.fullmatch("[0-9]+", port):
        return f"the port {port!r} is not a number"
    return None if 1 <= int(port) <= 65535 else f"the port {port} is not between 1 and 65535"
