"""A server that lies: it passes calls on to a right one, and changes one message of the replies."""
from concurrent.futures import ThreadPoolExecutor

import grpc
from google.protobuf.descriptor import FieldDescriptor
from google.protobuf.message import Message

from stiefel._given.shapes import is_repeated

DEEPEST = 4  #: levels of messages within messages in which fields are changed


class Liar(grpc.GenericRpcHandler):
    """Replaces message number `index` of the replies to `method` by the messages `instead`; all as bytes. Without a method
    it keeps in `told` what the right server said to each call."""

    def __init__(self, channel):
        self._channel = channel
        self._answers = {}
        self.truth()

    def truth(self):
        self.method, self.index, self.instead, self.told = "", 0, [], {}

    def lie(self, method, index, instead):
        self.method, self.index, self.instead = method, index, instead

    def service(self, details):
        return grpc.stream_stream_rpc_method_handler(lambda requests, context: self._answer(details.method, requests))

    def _answer(self, path, requests):
        method = path.rpartition("/")[2]
        for k, reply in enumerate(self._right(path, method, requests)):
            self.told.setdefault(method, []).append(reply)
            yield from self.instead if (method, k) == (self.method, self.index) else [reply]

    def _right(self, path, method, requests):
        """What the right server says. It is asked once for each request, but over and over in a Drive."""
        call = self._channel.stream_stream(path)
        if method == "Drive":
            return call(requests)
        asked = tuple(requests)
        if (path, asked) not in self._answers:
            self._answers[path, asked] = list(call(iter(asked)))
        return self._answers[path, asked]


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
    yield "twice", [reply, reply]
    yield "empty", [b""]
    yield "garbage", [b"\xff\xff\xff"]
    for path in _paths(kind.FromString(reply)):
        for name, change in _changes(*_at(kind.FromString(reply), path)):
            message = kind.FromString(reply)
            change(_at(message, path)[0])
            yield f"{'.'.join(map(str, path))} {name}", [message.SerializeToString()]


def _paths(message, begin=()):
    """The paths of all fields: names, and indices of the first and the last element in lists of messages."""
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


def _at(message, path):
    """The message that has the field in which the path ends, and the field."""
    for name in path[:-1]:
        message = message[name] if isinstance(name, int) else getattr(message, name)
    return message, message.DESCRIPTOR.fields_by_name[path[-1]]


def _changes(message, field):
    """Yields names and functions that change the field of a message like this one."""
    name, value = field.name, getattr(message, field.name)
    yield "dropped", lambda m: m.ClearField(name)
    if field.message_type is not None and field.message_type.GetOptions().map_entry:
        return
    if is_repeated(field):
        yield "shorter", lambda m: getattr(m, name).pop()
        yield "longer", lambda m: getattr(m, name).append(getattr(m, name)[-1])
        if field.message_type is None and field.cpp_type != FieldDescriptor.CPPTYPE_STRING:
            yield "other", lambda m: getattr(m, name).__setitem__(-1, 1 + getattr(m, name)[-1])
    elif field.enum_type is not None:
        for other in [*(value.number for value in field.enum_type.values), 99]:
            if other != value:
                yield str(other), lambda m, other=other: setattr(m, name, other)
    elif field.cpp_type == FieldDescriptor.CPPTYPE_STRING:  # bytes too
        yield "longer", lambda m: setattr(m, name, value + value[:8])
        yield "shorter", lambda m: setattr(m, name, value[:-1])
        if isinstance(value, bytes):
            yield "a number shorter", lambda m: setattr(m, name, value[:-8])
    elif field.message_type is None and field.cpp_type != FieldDescriptor.CPPTYPE_BOOL:
        yield "greater", lambda m: setattr(m, name, value + 1)
        if field.cpp_type in (FieldDescriptor.CPPTYPE_INT64, FieldDescriptor.CPPTYPE_DOUBLE):
            yield "negative", lambda m: setattr(m, name, -1 - value)
