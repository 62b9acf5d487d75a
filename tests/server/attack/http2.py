"""HTTP/2 by hand: frames (RFC 9113) and headers without compression (RFC 7541), right or wrong."""
import contextlib
import socket
import struct

PREFACE = b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n"
DATA, HEADERS, PRIORITY, RST_STREAM, SETTINGS, PUSH_PROMISE, PING, GOAWAY, WINDOW_UPDATE, CONTINUATION = range(10)
END_STREAM, END_HEADERS, ACK = 1, 4, 1


def frame(kind, flags=0, stream=0, payload=b"", length=None):
    """`length` is what the frame says of itself, that of its payload by default."""
    size = len(payload) if length is None else length
    return struct.pack(">I", size)[1:] + bytes([kind, flags]) + struct.pack(">I", stream) + payload


def integer(value, prefix_bits, first=0):
    """An integer of HPACK with the bits `first` above its prefix."""
    limit = (1 << prefix_bits) - 1
    if value < limit:
        return bytes([first | value])
    out, value = [first | limit], value - limit
    while value >= 128:
        out.append(128 + value % 128)
        value //= 128
    return bytes(out + [value])


def text(value):
    return integer(len(value), 7) + value


def header(name, value, indexed=False):
    """A literal header field; `indexed`: the receiver adds it to its dynamic table."""
    return bytes([0x40 if indexed else 0]) + text(name) + text(value)


def call_headers(path=b"/stiefel.v1.SimulationService/Describe", *more):
    return b"".join([header(b":method", b"POST"), header(b":scheme", b"http"), header(b":path", path),
                     header(b":authority", b"a"), header(b"te", b"trailers"),
                     header(b"content-type", b"application/grpc"), *(header(*one) for one in more)])


START = PREFACE + frame(SETTINGS)
EMPTY_MESSAGE = frame(DATA, END_STREAM, 1, b"\0\0\0\0\0")


def call(headers, body=EMPTY_MESSAGE, flags=END_HEADERS):
    return START + frame(HEADERS, flags, 1, headers) + body


def say(address, data, acknowledge, patience):
    """Sends it, reads what comes until nothing has come for `patience` seconds, and leaves. The server may hang up before.

    gRPC holds a client to its limit of headers from the moment at which the client has acknowledged its SETTINGS.
    """
    host, port = address.rsplit(":", 1)
    with contextlib.suppress(OSError), socket.create_connection((host, int(port)), timeout=60) as connection:
        if acknowledge:
            connection.sendall(START)
            connection.recv(65536)
            connection.sendall(frame(SETTINGS, ACK))
            data = data.removeprefix(START)
        connection.settimeout(patience)
        for at in range(0, len(data), 1 << 20):
            connection.sendall(data[at:at + (1 << 20)])
        while connection.recv(65536):
            pass
