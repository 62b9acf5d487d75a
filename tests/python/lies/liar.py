"""A server that lies: it passes calls on to a right one, and changes one message of the replies."""
import functools
from concurrent.futures import ThreadPoolExecutor

import grpc
from google.protobuf.message import Message

DEEPEST = 4  #: levels of messages within messages in which fields are changed


class Liar(grpc.GenericRpcHandler):
    """Replaces message number `index` of the replies to `method` by the messages `instead`; all as bytes. Without a method
    it keeps in `told` what the right server said to each call."""

    def __init__(self, channel):
        self._channel = channel
        self.lie()

    def lie(self, method="", index=0, instead=()):
        """Without a method it tells the truth."""
        self.method, self.index, self.instead = method, index, instead
        if not method:
            self.told = {}

    def service(self, details):
        return grpc.stream_stream_rpc_method_handler(lambda requests, context: self._answer(details.method, requests))

    @functools.lru_cache(maxsize=None)
    def _right(self, path, requests):
        return list(self._channel.stream_stream(path)(iter(requests)))

    def _answer(self, path, requests):
        method = path.rpartition("/")[2]
        replies = self._channel.stream_stream(path)(requests) if method == "Drive" else self._right(path, tuple(requests))
        for k, reply in enumerate(replies):
            self.told.setdefault(method, []).append(reply)
            yield from self.instead if (method, k) == (self.method, self.index) else [reply]


def serve(folder, right):
    """The liar, its server and its address. `right`: the address of the right server."""
    liar, address = Liar(grpc.insecure_channel(right)), f"unix:{folder}/liar"
    server = grpc.server(ThreadPoolExecutor(8), options=[("grpc.max_receive_message_length", -1)])
    server.add_generic_rpc_handlers((liar,))
    server.add_insecure_port(address)
    server.start()
    return liar, server, address


def lies(reply, kind):
    """Yields names of changes and the messages that they make of `reply`, the bytes of a message of type `kind`."""
    yield "absent", []
    yield "empty", [b""]
    yield "garbage", [b"\xff\xff\xff"]
    for path in _paths(kind.FromString(reply)):
        for name, change in CHANGES.get(path[-1], {}).items():
            message = kind.FromString(reply)
            owner = _owner(message, path)
            value = getattr(owner, path[-1])
            if isinstance(value, (str, Message)) != (path[-1] in ("run_status", "session_id")) or path[-1] == "steps" and isinstance(value, int):
                continue  # another field of this name
            change(owner, path[-1])
            yield f"{'.'.join(map(str, path))} {name}", [message.SerializeToString()]


def _set(new):
    return lambda message, name: setattr(message, name, new(getattr(message, name)))


def _last(new):
    return lambda message, name: getattr(message, name).__setitem__(-1, new(getattr(message, name)[-1]))


_LIST = {"shorter": lambda message, name: getattr(message, name).pop(), "other": _last(lambda value: value + 1)}
_NUMBER = {"greater": _set(lambda value: value + 1), "negative": _set(lambda value: -1 - value)}
CHANGES = {
    "shape": _LIST,
    "data_type": {"other": _set(lambda value: 99), "next": _set(lambda value: value % 4 + 1)},
    "data": {"shorter": _set(lambda value: value[:-1]), "a number shorter": _set(lambda value: value[:-8])},
    "steps": _LIST, "times": {"shorter": _LIST["shorter"]}, "step": _NUMBER,
    "outcome": {"other": _set(lambda value: 99), "none": _set(lambda value: 0), "next": _set(lambda value: value % 5 + 1)},
    "run_status": {"dropped": lambda message, name: message.ClearField(name)},
    "fields": {"shorter": _LIST["shorter"]}, "session_id": {"other": _set(lambda value: value + "x")},
}


def _paths(message, begin=()):
    """The paths of all fields that are changed: names, and indices of the first and the last element in lists of messages."""
    for field, value in message.ListFields():
        here = (*begin, field.name)
        yield here
        if field.message_type is None or len(begin) >= DEEPEST or field.message_type.GetOptions().map_entry:
            continue
        if isinstance(value, Message):
            yield from _paths(value, here)
        else:
            for i in sorted({0, len(value) - 1}):
                yield from _paths(value[i], (*here, i))


def _owner(message, path):
    """The message that has the field in which the path ends."""
    for name in path[:-1]:
        message = message[name] if isinstance(name, int) else getattr(message, name)
    return message
