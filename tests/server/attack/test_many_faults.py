"""Requests of megabytes in which everything is wrong: every list of every request, filled with its cheapest elements.

Each is refused by what it says or for its memory, tells few faults and counts the others, takes no more memory than
--memory, and computes little after its caller has gone.
"""

import grpc
import pytest

import stiefel
from conftest import BODY, SANITIZED, Process
from stiefel import v1 as pb
from stiefel.v1 import simulation_pb2
from stiefel.v1 import simulation_pb2_grpc as rpc

MIB = 1 << 20
LIMIT = 128 * MIB
SERVICE = simulation_pb2.DESCRIPTOR.services_by_name["SimulationService"]
#: Codes with which such a request may end.
TYPED = {grpc.StatusCode.INVALID_ARGUMENT, grpc.StatusCode.RESOURCE_EXHAUSTED, grpc.StatusCode.NOT_FOUND}


def varint(x):
    out = b""
    while x > 127:
        out, x = out + bytes([x & 127 | 128]), x >> 7
    return out + bytes([x])


def delimited(field, body):
    return varint(field.number << 3 | 2) + varint(len(body)) + body


def is_list(field):
    return field.label == field.LABEL_REPEATED


def elements(field, number):
    """`number` of the shortest elements of a list."""
    if field.message_type is None and field.type not in (field.TYPE_STRING, field.TYPE_BYTES):
        return delimited(field, bytes([99]) * number)  # packed
    if field.message_type is not None and field.message_type.GetOptions().map_entry:
        key, value = field.message_type.fields
        if value.message_type is not None:
            return b"".join(delimited(field, delimited(key, b"%d" % k) + delimited(value, b"")) for k in range(number // 4))
    return delimited(field, b"") * number


def lists(message):
    """(path, fields from the message to the list) of every list of a message, and of those below it."""
    for field in message.fields:
        if is_list(field):
            yield field.name, [field]
        inner = field.message_type
        if inner is not None and inner.GetOptions().map_entry:
            inner = inner.fields_by_name["value"].message_type
        if inner is not None and inner.full_name.startswith("stiefel."):
            for path, below in lists(inner):
                yield f"{field.name}.{path}", [field, *below]


def filled(fields, number):
    """A message whose list at the end of these fields is full."""
    body = elements(fields[-1], number)
    for field in reversed(fields[:-1]):
        if field.message_type.GetOptions().map_entry:
            key, value = field.message_type.fields
            body = delimited(key, b"x") + delimited(value, body)
        body = delimited(field, body)
    return body


def named(message, body):
    """The request with the ids of a session that exists."""
    ids = [message.fields_by_name.get(name) for name in ("session_id", "from_session_id")]
    ids = [field for field in ids if field is not None]
    if message.name == "CreateSessionRequest":
        return delimited(ids[0], b"new") + body
    if message.name == "ForkSessionRequest":
        return delimited(ids[0], b"new") + delimited(ids[1], b"s") + body
    return b"".join(delimited(field, b"s") for field in ids) + body


LISTS = {f"{method.name} {path}": (method, fields) for method in SERVICE.methods for path, fields in lists(method.input_type)}


def request(name, number):
    method, fields = LISTS[name]
    return method, named(method.input_type, filled(fields, number))


def send(process, method, raw, timeout=120):
    channel = process.channel(options=[("grpc.max_send_message_length", -1)])
    kind = getattr(channel, f"{'stream' if method.client_streaming else 'unary'}_stream")
    return channel, kind(f"/{SERVICE.full_name}/{method.name}")(iter([raw]) if method.client_streaming else raw, timeout=timeout)


@pytest.fixture(scope="module")
def process():
    server = Process("--log-level", "error", "--memory", f"{LIMIT // MIB}M", "--threads", "2")
    with stiefel.Client(server.address) as client:
        client.create(BODY, id="s")
        yield server
    assert server.stop() == 0


@pytest.mark.parametrize("name", LISTS)
def test_a_request_full_of_faults_is_refused(process, name):
    method, raw = request(name, MIB)
    before = process.processor_seconds()
    channel, call = send(process, method, raw)
    with channel:
        try:
            replies = list(call)
        except grpc.RpcError as refused:
            assert refused.code() in TYPED, refused
            detail = pb.BadRequest()
            for key, value in refused.trailing_metadata():
                if key == "grpc-status-details-bin":
                    assert len(value) < 8192
                    for any_ in pb.Status.FromString(value).details:
                        if any_.type_url.endswith("BadRequest"):
                            detail.ParseFromString(any_.value)
            assert len(detail.field_violations) <= 64
        else:  # a Drive answers with the error
            assert method.name == "Drive" and len(replies) == 1
    if not SANITIZED:
        assert process.processor_seconds() - before < 3
        assert process.memory() < 1.2 * LIMIT, process.memory() / MIB


def test_the_faults_are_counted(process):
    """An empty factor lacks A and B, each with two extents that must be at least 1."""
    factors = 100_000
    asked = pb.DiagnoseRequest(session_id="s", dirac_brackets=[{"first": [{}] * factors}])
    with process.channel(options=[("grpc.max_send_message_length", -1)]) as channel:
        with pytest.raises(grpc.RpcError) as refused:
            rpc.SimulationServiceStub(channel).Diagnose(asked, timeout=60)
    text = refused.value.details()
    assert refused.value.code() is grpc.StatusCode.INVALID_ARGUMENT
    told, more = text.rsplit("; and ", 1)
    assert told.count("; ") + 1 + int(more.split()[0]) == 4 * factors
    assert told.startswith("dirac_brackets[0].first[0].A.rows: 0: must be 1 to ")


@pytest.mark.parametrize("count", [8, 12])
def test_many_at_once_beside_another(process, count):
    """While they are read, others are answered. Eight fit into --memory together; of more, gRPC, whose share is a quarter,
    ends whichever, and UNAVAILABLE means that it closed an idle connection just as a call began on it."""
    names = "Diagnose dirac_brackets.first", "Summarize quantities.statistics", "CreateSession scene.initial"
    chosen = [request(name, 2 * MIB) for name in names]
    calls = [send(process, *chosen[k % len(chosen)]) for k in range(count)]
    with stiefel.Client(process.address) as client:
        session = client.get("s")
        for k in range(50):
            assert session.step(to=k).step == k
    for channel, call in calls:
        with channel, pytest.raises(grpc.RpcError) as refused:
            list(call)
        assert refused.value.code() in (TYPED if count == 8 else {*TYPED, grpc.StatusCode.UNAVAILABLE}), refused.value
    if not SANITIZED:
        assert process.memory() < 1.2 * LIMIT, process.memory() / MIB
