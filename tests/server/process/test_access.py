"""Tokens and principals: who is let in, whose sessions a caller sees, what it may use, and what withdrawing a token ends."""
import collections
import hashlib
import os
import re
import statistics
import threading
import time
import uuid

import grpc
import numpy as np
import pytest

import stiefel
from conftest import BODY, eventually, program, reason, refused_at_the_start
from stiefel import v1 as pb
from stiefel._wire.failures import from_status
from stiefel.v1 import simulation_pb2_grpc as rpc

RUN = {**BODY, "method": {"name": "rk4"}}
SERVICE = pb.simulation_pb2.DESCRIPTOR.services_by_name["SimulationService"]
NUMERICS, DETAILS = "stiefel-numerics-id", "grpc-status-details-bin"
GUESSES = int(os.environ.get("STIEFEL_GUESSES", "2000"))
AT_ONCE = 100
ANSWERED = 10.0  # seconds, for a Step of some microseconds, on a machine of any load


def make_token(name):
    """A token and its line, by the program."""
    done = program("token", name)
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


class Caller:
    """A principal: its stub and the metadata of its token."""

    def __init__(self, address, secret):
        self.address, self.secret = address, secret
        self.channel = grpc.insecure_channel(address)
        self.stub, self.who = rpc.SimulationServiceStub(self.channel), (("authorization", f"Bearer {secret}"),)

    def client(self):
        return stiefel.Client(self.address, token=self.secret)

    def call(self, method, request):
        return getattr(self.stub, method)(request, timeout=60, metadata=self.who)

    def begin(self, method, request):
        return getattr(self.stub, method).future(request, timeout=60, metadata=self.who)

    def create(self, id, step, recreate=False):
        scene = stiefel.to_message({**BODY, "step": step})
        return self.call("CreateSession", pb.CreateSessionRequest(session_id=id, scene=scene, recreate=recreate))

    def bits(self, id, to=50):
        reply = self.call("Step", pb.StepRequest(session_id=id, to=to))
        return [field.value.data for field in reply.sample.fields]

    def ids(self):
        return {session.session_id for session in
                self.call("ListSessions", pb.ListSessionsRequest(page_size=1000)).sessions}

    def admitted(self):
        """Whether it may call, by a new client."""
        with self.client() as client:
            try:
                return bool(client.describe().version)
            except stiefel.StiefelError as error:
                assert error.code is grpc.StatusCode.UNAUTHENTICATED, error
                return False


@pytest.fixture
def guarded(serve, tmp_path):
    """Starts servers with the tokens of alice and bob: their file, and them as callers of the last one."""
    class Guarded:
        file = tmp_path / "tokens"
        (alice, alices_line), (bob, bobs_line) = make_token("alice"), make_token("bob")

        def __call__(self, *arguments, **more):
            self.write(self.alices_line, "", self.bobs_line)
            self.process = serve("--tokens", str(self.file), "--log-format", "json", *arguments, **more)
            return self.process, Caller(self.process.address, self.alice), Caller(self.process.address, self.bob)

        def write(self, *lines):
            text = tmp_path / "tokens.new"
            text.write_text("# who may call\n" + "".join(f"{line}\n" for line in lines))
            os.replace(text, self.file)
    return Guarded()


def end_of(channel, method, message, *metadata):
    """How an RPC ended: the error, or the call."""
    kind = getattr(channel, f"{'stream' if method.client_streaming else 'unary'}_"
                            f"{'stream' if method.server_streaming else 'unary'}")
    call = kind(f"/{SERVICE.full_name}/{method.name}")
    given = iter([message]) if method.client_streaming else message
    try:
        if method.server_streaming:
            call = call(given, timeout=60, metadata=metadata)
            list(call)
        else:
            _, call = call.with_call(given, timeout=60, metadata=metadata)
        return call
    except grpc.RpcError as error:
        return error


def refusal(call):
    """What the call is refused with; none if it is not."""
    try:
        call()
    except grpc.RpcError as error:
        return from_status(pb.Status.FromString(dict(error.trailing_metadata())[DETAILS]))
    return None


def told_numerics(call):
    """The numerics ids in the initial and in the trailing metadata."""
    return [[value for key, value in metadata or () if key == NUMERICS]
            for metadata in (call.initial_metadata(), call.trailing_metadata())]


def test_no_rpc_passes_without_a_token_and_each_with_one(guarded):
    """Whoever is not let in, or sends no message, is told the numerics id in the trailing metadata: gRPC repeats no call
    with initial metadata."""
    process, alice, _ = guarded()
    numerics = [alice.call("Describe", pb.DescribeRequest()).numerics_id]
    with process.channel() as channel:
        for method in SERVICE.methods:
            for metadata, why in ([], "TOKEN_MISSING"), ([("authorization", "Bearer unknown")], "TOKEN_UNKNOWN"):
                error = end_of(channel, method, b"", *metadata)
                assert (error.code(), reason(error)) == (grpc.StatusCode.UNAUTHENTICATED, why), method.name
                assert told_numerics(error) == [[], numerics]
            code = end_of(channel, method, b"", *alice.who).code()
            assert code not in (grpc.StatusCode.UNAUTHENTICATED, grpc.StatusCode.UNIMPLEMENTED), method.name
            if method.name != "Drive":
                error = end_of(channel, method, b"\xff" * 64, *alice.who)
                assert error.code() == grpc.StatusCode.INVALID_ARGUMENT and told_numerics(error) == [[], numerics]
        answer = end_of(channel, SERVICE.methods_by_name["Describe"], b"", *alice.who)
        assert told_numerics(answer) == [numerics, []]
    assert program("healthcheck", "--address", process.address).returncode == 0, "health needs no token"


def test_what_is_a_token(guarded):
    process, alice, bob = guarded()
    describe, digest = SERVICE.methods_by_name["Describe"], guarded.alices_line.split()[1]
    with process.channel() as channel:
        for value in ("", "Bearer", "Bearer ", f"Basic {alice.secret}", alice.secret, f"Bearer {alice.secret}x",
                      f"Bearer x {alice.secret}", f"Bearer {digest}", "Bearer " + 64 * "0"):
            error = end_of(channel, describe, b"", ("authorization", value))
            assert (error.code(), reason(error)) == (grpc.StatusCode.UNAUTHENTICATED, "TOKEN_UNKNOWN"), value
        assert end_of(channel, describe, b"", *alice.who, *bob.who).code() == grpc.StatusCode.UNAUTHENTICATED
        assert end_of(channel, describe, b"", ("authorization", f"bearer  {alice.secret}")).code() == grpc.StatusCode.OK
        # What a proxy says of the caller is not believed.
        alice.create("hers", 0.01)
        for name in ("x-forwarded-user", "x-forwarded-client-cert", "x-forwarded-email", "x-real-user"):
            assert end_of(channel, SERVICE.methods_by_name["ListSessions"], b"", (name, "alice")).code() == \
                grpc.StatusCode.UNAUTHENTICATED
            assert not bob.stub.ListSessions(pb.ListSessionsRequest(), metadata=[*bob.who, (name, "alice")]).sessions


def test_a_unix_socket_needs_a_token_too(guarded, tmp_path):
    process, _, bob = guarded(listen=f"unix:{tmp_path}/socket")
    with stiefel.Client(process.address) as nobody, pytest.raises(stiefel.StiefelError) as refused:
        nobody.describe()
    assert refused.value.reason == "TOKEN_MISSING" and bob.admitted()


def test_a_withdrawn_token_is_refused_and_its_calls_end(guarded):
    process, alice, bob = guarded()
    with alice.client() as hers, bob.client() as his:
        sessions = {"alice": hers.create(RUN), "bob": his.create(RUN)}
        ends = {}

        def stream(name):
            try:
                for _ in sessions[name].stream(to=10**12, every=10**4):
                    ends.setdefault(name, None)
            except stiefel.StiefelError as error:
                ends[name] = error
        running = {name: threading.Thread(target=stream, args=(name,), daemon=True) for name in sessions}
        for thread in running.values():
            thread.start()
        drive = sessions["alice"].drive()
        assert drive.step(5).step == 5
        assert eventually(lambda: len(ends) == 2)
        guarded.write(guarded.bobs_line)
        assert eventually(lambda: not alice.admitted())
        running["alice"].join(60)
        assert ends["alice"].code is grpc.StatusCode.UNAUTHENTICATED, "the stream that ran has ended"
        with pytest.raises(stiefel.StiefelError, match="token"):
            drive.step(6)
        assert ends["bob"] is None and running["bob"].is_alive(), "the other's stream goes on"
        assert sessions["bob"].step(7).step == 7
        newer, line = make_token("alice")
        guarded.write(guarded.alices_line, line, guarded.bobs_line)
        assert eventually(alice.admitted) and eventually(Caller(process.address, newer).admitted)
        assert sessions["alice"].step(8).step == 8, "its sessions were kept"
        assert Caller(process.address, newer).ids() == {sessions["alice"].id}, "for the principal's newer token too"
    process.stop()


def test_a_file_that_goes_wrong_lets_nobody_in_by_mistake(guarded):
    """And nothing secret is logged: tokens, their digests and what is refused."""
    process, alice, bob = guarded("--log-level", "trace")
    alice.create("hers", 0.01)
    assert not Caller(process.address, "stiefel_wrong-one").admitted()
    guarded.write(guarded.alices_line[:-1], guarded.bobs_line)  # a digit is missing
    assert eventually(lambda: not alice.admitted()) and bob.admitted()
    guarded.file.unlink()
    assert eventually(lambda: not bob.admitted())
    guarded.write(guarded.alices_line)
    assert eventually(alice.admitted) and not bob.admitted()
    guarded.write(f"alice {alice.secret}")  # the token itself
    assert eventually(lambda: not alice.admitted())
    process.stop()
    text = process.child.stderr.read()
    assert '"code":"UNAUTHENTICATED"' in text and "line 2: " in text and "No such file or directory" in text
    for word in (alice.secret, alice.secret[8:], guarded.alices_line.split()[1], "wrong-one"):
        assert word not in text


def test_a_new_token_is_random_and_its_line_is_its_digest():
    (one, line), (two, _) = make_token("a.b-c_9"), make_token("a.b-c_9")
    assert re.fullmatch("stiefel_[0-9a-f]{64}", one) and one != two
    assert line == f"a.b-c_9 {hashlib.sha256(one.encode()).hexdigest()}"
    for name in ("", "with space", "a/b", "ä", 129 * "x"):
        done = program("token", name)
        assert done.returncode != 0 and done.stdout == "" and "1 to 128 characters of [A-Za-z0-9._-]" in done.stderr


@pytest.mark.parametrize("text, rule", [
    ("alice 12", "line 1: after the name there must be 64"), ("\n\n# x\na/b " + 64 * "0", "line 4: a name must have 1 to 128"),
    (f"a {64 * '0'}\nb {64 * '0'}", "line 2: another line has this token"), (None, "No such file or directory")])
def test_a_file_that_is_none_is_refused_at_the_start(tmp_path, text, rule):
    file = tmp_path / "tokens"
    if text is not None:
        file.write_text(text)
    assert all(f"--tokens: {file}: {rule}" in said for said in refused_at_the_start("--tokens", file))


def made(caller, most):
    """Creates sessions until one is refused: their number, and the refusal."""
    for number in range(most + 1):
        if error := refusal(lambda: caller.create(str(number), 0.01)):
            return number, error
    raise AssertionError("nothing was refused")


def test_half_of_the_sessions_unless_a_flag_says_otherwise(guarded):
    _, alice, bob = guarded("--max-sessions", "7")
    number, error = made(alice, 7)
    assert number == 4 and error.reason == "OVER_QUOTA" and error.quota[0].field == "principal_sessions"
    assert made(bob, 7)[0] == 3
    _, alice, _ = guarded("--max-sessions", "7", "--principal-sessions", "0")
    number, error = made(alice, 7)
    assert number == 7 and error.reason == "TOO_MANY_SESSIONS"


def test_half_of_the_memory(guarded):
    """Of 64 MiB, 40 MiB are for sessions and calls, and a session of this scene takes 3.5 MB and more."""
    process, alice, bob = guarded("--memory", "64M")
    scene = stiefel.to_message({"system": "rigid_body", "inertia": list(range(1, 65)), "step": 0.01,
                                "method": {"name": "variational", "order": 2},
                                "initial": {"Q": np.eye(64), "M": np.zeros((64, 64))}})

    def fill(caller):
        """Keeps the simulations of its sessions in use, so that they are no caches."""
        running = []
        for number in range(100):
            id = str(number)
            error = refusal(lambda: caller.call("CreateSession", pb.CreateSessionRequest(session_id=id, scene=scene)))
            if error:
                return running, error
            running.append(caller.begin("Step", pb.StepRequest(session_id=id, to=10**9)))
        raise AssertionError("nothing was refused")
    running, error = fill(alice)
    assert error.quota[0].field == "principal_memory" and float(error.metadata["most"]) == 20 * 2**20
    assert bob.call("CreateSession", pb.CreateSessionRequest(session_id="0", scene=scene)).created
    for call in running:
        call.cancel()
    limits = next(line for line in process.log() if line["message"] == "limits of a principal")
    assert limits["sessions"] == 500 and limits["memory_bytes"] == 20 * 2**20


def test_check_shows_the_limits(tmp_path):
    def checked(*arguments, **environment):
        return program("check", "--memory", "64M", *arguments, **environment).stdout.split("of one principal, ")[1].strip()
    (tmp_path / "tokens").write_text(make_token("alice")[1] + "\n")
    tokens = ("--tokens", str(tmp_path / "tokens"))
    assert checked() == "sessions: no limit, bytes of memory: no limit"
    assert checked(*tokens) == "sessions: 500, bytes of memory: 20971520"
    assert checked(*tokens, "--principal-memory", "0", STIEFEL_PRINCIPAL_SESSIONS="3") == (
        "sessions: 3, bytes of memory: no limit")


class Steps(threading.Thread):
    """Single Steps of a principal, one after another: the seconds that each took, or what went wrong."""

    def __init__(self, caller, id):
        super().__init__()
        self.caller, self.id, self.over = caller, id, threading.Event()
        self.seconds, self.error, self.expected = [], None, caller.bits(id)

    def run(self):
        try:
            while not self.over.wait(0.002):
                begin = time.monotonic()
                assert self.caller.bits(self.id) == self.expected
                self.seconds.append(time.monotonic() - begin)
        except BaseException as error:  # noqa: B036 - told by the test's own thread
            self.error = error

    def stop(self):
        self.over.set()
        self.join()
        assert self.error is None, self.error
        return self.seconds


def guesses(ids):
    """Yields (method, request) pairs: half of them with ids of the other principal, half with ids that do not exist."""
    for k in range(GUESSES):
        id = ids[k % len(ids)] if k % 2 else str(uuid.uuid4())
        yield [("GetSession", pb.GetSessionRequest(session_id=id)), ("Step", pb.StepRequest(session_id=id, to=3)),
               ("Diagnose", pb.DiagnoseRequest(session_id=id, to=3)),
               ("ForkSession", pb.ForkSessionRequest(session_id=f"fork-{k}", from_session_id=id))][k // 2 % 4], id


def told(call, id):
    """What a refusal says, without the id."""
    error = call.exception(60)
    assert isinstance(error, grpc.RpcError), f"{id} was found"
    details = dict(error.trailing_metadata())[DETAILS]
    return error.code(), error.details().replace(id, "ID"), details.replace(id.encode(), b"ID")


def guess_all(bob, ids):
    """Guesses with `AT_ONCE` under way; what was told, by method and whether the id was another's."""
    seen, under_way = collections.defaultdict(set), collections.deque()

    def take():
        call, method, id = under_way.popleft()
        seen[method, id in hers].add(told(call, id))
    hers = set(ids)
    for (method, request), id in guesses(ids):
        under_way.append((bob.begin(method, request), method, id))
        if len(under_way) == AT_ONCE:
            take()
    while under_way:
        take()
    return seen


def test_neither_sees_delays_or_ends_the_others(guarded):
    """Two principals use the same ids; one of them creates, deletes, lists and guesses ids of the other."""
    _, alice, bob = guarded("--log-level", "off", "--max-sessions", "100000")
    ids = [str(uuid.uuid4()) for _ in range(50)]
    for k, id in enumerate(ids):
        alice.create(id, 0.01 + 1e-5 * k)
    expected = {id: alice.bits(id) for id in ids}
    stream = alice.stub.Stream(pb.StreamRequest(session_id=ids[0], to=10**12, every=10**6), metadata=alice.who)
    next(stream)
    during = Steps(alice, ids[1])
    during.start()
    try:
        seen = guess_all(bob, ids)
        for method in ("GetSession", "Step", "Diagnose", "ForkSession"):
            assert seen[method, True] == seen[method, False], "an id of another principal gets the reply of an id that does not exist"
            (code, _, _), = seen[method, True]
            assert code == grpc.StatusCode.NOT_FOUND
        assert bob.ids() == set()
        same = ids[:20]
        for _ in range(GUESSES // 1000):  # sessions of the same ids with another motion, and their end
            made = [bob.begin("CreateSession", pb.CreateSessionRequest(
                session_id=id, scene=stiefel.to_message({**BODY, "step": 0.5}))) for id in same]
            assert all(call.result(60).created for call in made)
            assert bob.ids() == set(same)
            assert bob.bits(same[1]) != expected[same[1]]
            gone = [bob.begin("DeleteSession", pb.DeleteSessionRequest(session_id=id)) for id in ids]
            assert all(call.result(60) is not None for call in gone)
            assert bob.ids() == set()
    finally:
        crowded = during.stop()
    print(f"{GUESSES} guesses; a Step meanwhile: median {1e3 * statistics.median(crowded):.2f} ms, longest "
          f"{1e3 * max(crowded):.1f} ms of {len(crowded)}")
    assert len(crowded) > 10 and max(crowded) < ANSWERED

    assert alice.ids() == set(ids)
    assert {id: alice.bits(id) for id in ids} == expected
    assert next(stream).steps, "her stream goes on"
    stream.cancel()
    # What he deleted is not deleted for her, and the other way round.
    alice.call("DeleteSession", pb.DeleteSessionRequest(session_id=ids[-1]))
    assert not alice.create(ids[0], 0.01, recreate=True).created
    assert bob.call("DeleteSession", pb.DeleteSessionRequest(session_id="other")) is not None
    assert alice.create("other", 0.01, recreate=True).created
    assert refusal(lambda: alice.create(ids[-1], 0.01, recreate=True)).code == grpc.StatusCode.NOT_FOUND
    assert bob.create("other", 0.01).created
