"""Tokens: who is let in, whose sessions a caller sees, and what withdrawing a token ends."""
import hashlib
import os
import re
import subprocess
import threading

import grpc
import pytest
from conftest import BODY, eventually, refused_at_the_start

import stiefel
from stiefel import v1 as pb

RUN = {**BODY, "method": {"name": "rk4"}}
SERVICE = pb.simulation_pb2.DESCRIPTOR.services_by_name["SimulationService"]


def make_token(name):
    """A token and its line, by the program."""
    done = subprocess.run([os.environ["STIEFEL_SERVER"], "token", name], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    token, line = done.stdout.splitlines()
    return token, line


@pytest.fixture
def guarded(serve, tmp_path):
    """A server of two principals: the process, the file, and their tokens."""
    class Guarded:
        file = tmp_path / "tokens"
        alice, alices_line = make_token("alice")
        bob, bobs_line = make_token("bob")

        def write(self, *lines):
            text = tmp_path / "tokens.new"
            text.write_text("# who may call\n" + "".join(f"{line}\n" for line in lines))
            os.replace(text, self.file)

        def client(self, token):
            return stiefel.Client(self.process.address, token=token)
    guarded = Guarded()
    guarded.write(guarded.alices_line, "", guarded.bobs_line)
    guarded.process = serve("--tokens", str(guarded.file), "--log-level", "info")
    return guarded


def call(channel, method, *metadata):
    """The status code and the details of an RPC with an empty message."""
    kind = getattr(channel, f"{'stream' if method.client_streaming else 'unary'}_"
                            f"{'stream' if method.server_streaming else 'unary'}")
    message = iter([b""]) if method.client_streaming else b""
    done = kind(f"/{SERVICE.full_name}/{method.name}")(message, timeout=60, metadata=metadata)
    try:
        if method.server_streaming:
            list(done)
        return grpc.StatusCode.OK, b""
    except grpc.RpcError as error:
        return error.code(), dict(error.trailing_metadata()).get("grpc-status-details-bin", b"")


def code_of(channel, method, *metadata):
    try:
        return call(channel, method, *metadata)
    except grpc.RpcError as error:  # of a unary call
        return error.code(), dict(error.trailing_metadata()).get("grpc-status-details-bin", b"")


def reason(details):
    status, info = pb.Status.FromString(details), pb.ErrorInfo()
    info.ParseFromString(status.details[0].value)
    return info.reason


def test_no_rpc_passes_without_a_token_and_each_with_one(guarded):
    with guarded.process.channel() as channel:
        for method in SERVICE.methods:
            code, details = code_of(channel, method)
            assert (code, reason(details)) == (grpc.StatusCode.UNAUTHENTICATED, "TOKEN_MISSING"), method.name
            code, _ = code_of(channel, method, ("authorization", f"Bearer {guarded.alice}"))
            assert code not in (grpc.StatusCode.UNAUTHENTICATED, grpc.StatusCode.UNIMPLEMENTED), method.name


def test_what_is_a_token(guarded):
    describe, digest = SERVICE.methods_by_name["Describe"], guarded.alices_line.split()[1]
    with guarded.process.channel() as channel:
        for value in ("", "Bearer", "Bearer ", f"Basic {guarded.alice}", guarded.alice, f"Bearer {guarded.alice}x",
                      f"Bearer x {guarded.alice}", f"Bearer {digest}", "Bearer " + 64 * "0"):
            code, details = code_of(channel, describe, ("authorization", value))
            assert (code, reason(details)) == (grpc.StatusCode.UNAUTHENTICATED, "TOKEN_UNKNOWN"), value
        both = [("authorization", f"Bearer {token}") for token in (guarded.alice, guarded.bob)]
        assert code_of(channel, describe, *both)[0] == grpc.StatusCode.UNAUTHENTICATED
        assert code_of(channel, describe, ("authorization", f"bearer  {guarded.alice}"))[0] == grpc.StatusCode.OK


def test_what_a_proxy_says_of_the_caller_is_not_believed(guarded):
    with guarded.process.channel() as channel, guarded.client(guarded.bob) as bob, guarded.client(guarded.alice) as alice:
        alice.create(BODY, id="hers")
        for name in ("x-forwarded-user", "x-forwarded-client-cert", "x-forwarded-email", "x-real-user"):
            code, _ = code_of(channel, SERVICE.methods_by_name["ListSessions"], (name, "alice"))
            assert code == grpc.StatusCode.UNAUTHENTICATED
            assert not bob.stub.ListSessions(pb.ListSessionsRequest(), metadata=[(name, "alice")]).sessions


def test_health_needs_no_token(guarded):
    done = subprocess.run([os.environ["STIEFEL_SERVER"], "healthcheck", "--address", guarded.process.address], timeout=60)
    assert done.returncode == 0


def test_a_unix_socket_needs_a_token_too(guarded, serve, tmp_path):
    address = f"unix:{tmp_path}/socket"
    serve("--tokens", str(guarded.file), listen=address)
    with stiefel.Client(address) as nobody, pytest.raises(stiefel.StiefelError) as refused:
        nobody.describe()
    assert refused.value.reason == "TOKEN_MISSING"
    with stiefel.Client(address, token=guarded.bob) as bob:
        assert bob.describe().version


def test_a_withdrawn_token_is_refused_and_its_calls_end(guarded):
    with guarded.client(guarded.alice) as alice, guarded.client(guarded.bob) as bob:
        hers, his = alice.create(RUN), bob.create(RUN)
        broken = {}

        def stream(session, name):
            try:
                for _ in session.stream(to=10**12, every=10**4):
                    broken.setdefault(name, None)
            except stiefel.StiefelError as error:
                broken[name] = error
        running = [threading.Thread(target=stream, args=(one, name), daemon=True)
                   for one, name in ((hers, "alice"), (his, "bob"))]
        for thread in running:
            thread.start()
        drive = hers.drive()
        assert drive.step(5).step == 5
        assert eventually(lambda: len(broken) == 2)
        guarded.write(guarded.bobs_line)

        def refused():
            try:
                alice.describe()
            except stiefel.StiefelError as error:
                return error.reason == "TOKEN_UNKNOWN"
            return False
        assert eventually(refused)
        running[0].join(60)
        assert broken["alice"].code is grpc.StatusCode.UNAUTHENTICATED, "the stream that ran has ended"
        with pytest.raises(stiefel.StiefelError, match="token"):
            drive.step(6)
        assert broken["bob"] is None and running[1].is_alive(), "the other's stream goes on"
        assert his.step(7).step == 7
        guarded.write(guarded.alices_line, guarded.bobs_line)
        assert eventually(lambda: not refused())
        assert hers.step(8).step == 8, "its sessions were kept"
    guarded.process.stop()


def test_a_file_that_goes_wrong_lets_nobody_in_by_mistake(guarded):
    with guarded.client(guarded.alice) as alice, guarded.client(guarded.bob) as bob:
        def in_order(client):
            try:
                return bool(client.describe().version)
            except stiefel.StiefelError:
                return False
        guarded.write(guarded.alices_line[:-1], guarded.bobs_line)  # a digit is missing
        assert eventually(lambda: not in_order(alice)) and in_order(bob)
        guarded.file.unlink()
        assert eventually(lambda: not in_order(bob))
        guarded.write(guarded.alices_line)
        assert eventually(lambda: in_order(alice)) and not in_order(bob)


def test_a_second_token_of_a_principal_sees_the_same_sessions(guarded):
    newer, line = make_token("alice")
    guarded.write(guarded.alices_line, line, guarded.bobs_line)
    with guarded.client(guarded.alice) as before, guarded.client(newer) as after:
        before.create(BODY, id="kept")

        def there():
            try:
                return after.get("kept").id == "kept"
            except stiefel.StiefelError:
                return False
        assert eventually(there)


def test_a_new_token_is_random_and_its_line_is_its_digest():
    (one, line), (two, _) = make_token("a.b-c_9"), make_token("a.b-c_9")
    assert re.fullmatch("stiefel_[0-9a-f]{64}", one) and one != two
    assert line == f"a.b-c_9 {hashlib.sha256(one.encode()).hexdigest()}"


@pytest.mark.parametrize("name", ["", "with space", "a/b", "ä", 129 * "x"])
def test_what_is_no_name(name):
    done = subprocess.run([os.environ["STIEFEL_SERVER"], "token", name], capture_output=True, text=True, timeout=60)
    assert done.returncode != 0 and done.stdout == "" and "1 to 128 characters of [A-Za-z0-9._-]" in done.stderr


def test_nothing_secret_is_logged(serve, tmp_path):
    """At the finest level: tokens, their digests and what is refused."""
    token, line = make_token("alice")
    (tmp_path / "tokens").write_text(line + "\n")
    process = serve("--tokens", str(tmp_path / "tokens"), "--log-level", "trace", "--log-format", "json")
    with stiefel.Client(process.address, token=token) as alice:
        alice.create(BODY).step(10, checkpoint=True)
    with stiefel.Client(process.address, token="stiefel_wrong-one") as nobody:
        with pytest.raises(stiefel.StiefelError) as refused:
            nobody.describe()
    (tmp_path / "tokens").write_text("alice " + token + "\n")  # the token itself, by mistake
    assert eventually(lambda: _refuses(process.address, token))
    process.stop()
    text = process.child.stderr.read() + str(refused.value)
    assert '"code":"UNAUTHENTICATED"' in text and "line 1: " in text
    for word in (token, token[8:], line.split()[1], "wrong-one"):
        assert word not in text


def _refuses(address, token):
    with stiefel.Client(address, token=token) as client:
        try:
            client.describe()
            return False
        except stiefel.StiefelError:
            return True


@pytest.mark.parametrize("text, rule", [
    ("alice", "line 1: after the name there must be 64"), ("alice 12", "line 1: after the name there must be 64"),
    ("\n\n# x\na/b " + 64 * "0", "line 4: a name must have 1 to 128"),
    (f"a {64 * '0'}\nb {64 * '0'}", "line 2: another line has this token"), (None, "No such file or directory")])
def test_a_file_that_is_none_is_refused_at_the_start(tmp_path, text, rule):
    file = tmp_path / "tokens"
    if text is not None:
        file.write_text(text)
    assert all(f"--tokens: {file}: {rule}" in said for said in refused_at_the_start("--tokens", file))
