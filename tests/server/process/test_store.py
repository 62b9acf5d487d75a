"""The file of --store: on a full disk, beside a second server, from a backup."""
import os
import sqlite3
import subprocess

import grpc
import pytest

import stiefel
from conftest import BODY, eventually
from stiefel import v1 as pb
from stored import reason, scene_of

SERVER = os.environ["STIEFEL_SERVER"]


@pytest.fixture
def small_disk(tmp_path):
    """A file system of 5 MB; without the right to mount one there is no test."""
    folder = tmp_path / "disk"
    folder.mkdir()
    if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=5m", "none", folder], capture_output=True).returncode != 0:
        pytest.skip("mounting a tmpfs needs root")
    yield folder
    subprocess.run(["umount", "-l", folder], check=True)


def left_on(folder):
    room = os.statvfs(folder)
    return room.f_bavail * room.f_frsize


def fill(client):
    """Creates sessions of 10 KB until one is refused; returns those that were not, and the error."""
    made = {}
    for number in range(8, 8000, 8):
        try:
            session = client.create(scene_of(number, n=24), id=f"s{number}")
        except stiefel.StiefelError as error:
            return made, error
        made[session.id] = session
    raise AssertionError("nothing was refused")


def create(client, id, number=1, n=3):
    """Creates a session of 16n² bytes or, for n = 3, 300, without the client's retries; returns the reason of a refusal."""
    scene = scene_of(number if n == 3 else 8 * number, n)
    try:
        client._stub.CreateSession(pb.CreateSessionRequest(session_id=id, scene=scene), timeout=60)
    except grpc.RpcError as error:
        return reason(error)
    return None


def create_until_refused(client, most, n, name):
    """The names of those that were created, and the reason of the refusal."""
    made = []
    for number in range(1, most + 1):
        if refusal := create(client, f"{name}{number}", number, n):
            return made, refusal
        made.append(f"{name}{number}")
    return made, None


def test_a_full_disk_is_a_typed_error_and_loses_nothing(serve, small_disk):
    process = serve("--store", str(small_disk / "store"), "--log-level", "warn")
    with stiefel.Client(process.address, timeout=5) as client:
        made, error = fill(client)
        assert isinstance(error, stiefel.ResourceExhausted) and error.reason == "STORE_FULL"
        assert "no space in the store" in str(error)
        assert len(made) > 20
        some = next(iter(made))
        assert client.get(some).step(10).step == 10
    process.child.kill()
    process.stop()
    process = serve("--store", str(small_disk / "store"), "--log-level", "warn")
    with stiefel.Client(process.address) as client:
        assert {session.id for session in client.list()} == made.keys()
    assert process.stop() == 0
    process = serve("--store", str(small_disk / "store"), "--log-level", "warn")
    with stiefel.Client(process.address) as client:
        assert {session.id for session in client.list()} == made.keys()


@pytest.mark.parametrize("n", [3, 150])
def test_space_that_comes_back_is_used(serve, small_disk, n):
    """On a full disk changes end with STORE_FULL, deletions too; nothing that was acknowledged is lost."""
    (small_disk / "rest").write_bytes(b"x" * 2_000_000)
    process = serve("--store", str(small_disk / "store"), "--log-level", "warn", "--max-sessions", "100000")
    with stiefel.Client(process.address) as client:
        made, refusal = create_until_refused(client, 20_000, n, "s")
        assert refusal == "STORE_FULL" and len(made) >= 2
        (small_disk / "rest").unlink()
        for id in made[::2]:
            client.delete(id)
        again, refusal = create_until_refused(client, len(made) // 2, n, "t")
        assert refusal is None
        there = {*made[1::2], *again}
    process.child.kill()
    process.stop()
    with stiefel.Client(serve("--store", str(small_disk / "store")).address) as client:
        assert {session.id for session in client.list()} == there


@pytest.mark.parametrize("suffix", ["", "-wal"])
def test_a_server_whose_store_is_removed_acknowledges_nothing(serve, tmp_path, suffix):
    process = serve("--store", str(tmp_path / "store"), "--log-level", "warn")
    with stiefel.Client(process.address) as client, process.channel() as channel:
        check = channel.unary_unary("/grpc.health.v1.Health/Check")
        first, kept = client.create(BODY), client.create(BODY)
        assert check(b"") == b"\x08\x01"
        os.rename(tmp_path / f"store{suffix}", tmp_path / "elsewhere")
        assert create(client, "second") == "STORE_UNAVAILABLE"
        with pytest.raises(grpc.RpcError) as refusal:
            client._stub.DeleteSession(pb.DeleteSessionRequest(session_id=first.id), timeout=60)
        assert reason(refusal.value) == "STORE_UNAVAILABLE" and f"store{suffix} was removed" in refusal.value.details()
        assert kept.step(10).step == 10
        assert eventually(lambda: check(b"") == b"\x08\x02"), "not serving"
        os.rename(tmp_path / "elsewhere", tmp_path / f"store{suffix}")
        assert eventually(lambda: check(b"") == b"\x08\x01")
        assert create(client, "third") is None
    assert process.stop() == 0
    log = process.child.stderr.read()
    assert "store lost" in log and "store there again" in log and f"store{suffix} was removed" in log


def refused(*arguments):
    """The line on stderr of a server that does not start."""
    done = subprocess.run([SERVER, "--listen", "127.0.0.1:0", *arguments], stdin=subprocess.DEVNULL,
                          capture_output=True, text=True, timeout=30)
    assert done.returncode == 1 and done.stdout == ""
    return done.stderr


def test_a_file_that_is_no_sound_store_is_refused(tmp_path):
    notes = tmp_path / "notes"
    notes.write_text("not a store\n" * 1000)
    assert "file is not a database" in refused("--store", str(notes))
    assert notes.read_text() == "not a store\n" * 1000
    with sqlite3.connect(tmp_path / "songs") as songs:
        songs.execute("CREATE TABLE song (title TEXT)")
    assert "SQLite file of another program" in refused("--store", str(tmp_path / "songs"))
    assert "No such file or directory" in refused("--store", str(tmp_path / "no" / "store"))


def check(store, *arguments):
    return subprocess.run([SERVER, "check", "--listen", "127.0.0.1:0", "--store", str(store), *arguments],
                          capture_output=True, text=True, timeout=30)


def test_check_looks_at_the_store(tmp_path):
    assert check(tmp_path / "store").returncode == 0
    assert not (tmp_path / "store").exists()
    (tmp_path / "notes").write_text("not a store\n" * 1000)
    assert check(tmp_path / "notes").returncode == 1
    assert "--store: the store" in check(tmp_path / "notes").stderr


@pytest.mark.parametrize("there", [True, False], ids=["a store", "none yet"])
def test_check_finds_that_the_store_cannot_be_written(serve, small_disk, there):
    store = small_disk / "store"
    if there:
        process = serve("--store", str(store))
        with stiefel.Client(process.address) as client:
            client.create(BODY)
        assert process.stop() == 0
    assert check(store).returncode == 0
    rest = small_disk / "rest"
    rest.write_bytes(b"x" * left_on(small_disk))
    full = check(store)
    assert full.returncode == 1 and "there is no space: the disk has " in full.stderr
    rest.unlink()
    assert check(store).returncode == 0
    subprocess.run(["mount", "-o", "remount,ro", small_disk], check=True)
    fixed = check(store)
    assert fixed.returncode == 1 and "Read-only file system" in fixed.stderr


@pytest.mark.parametrize("way", ["backup", "VACUUM INTO"])
def test_a_backup_of_a_running_server_is_a_store(serve, tmp_path, way):
    process = serve("--store", str(tmp_path / "store"))
    with stiefel.Client(process.address) as client:
        session = client.create(scene_of(8))
        bits = session.step(30, fields="Q")["Q"].tobytes()
        live = sqlite3.connect(f"file:{tmp_path / 'store'}?mode=ro", uri=True)
        if way == "backup":
            with sqlite3.connect(tmp_path / "copy") as copy:
                live.backup(copy)
            copy.close()
        else:
            live.execute("VACUUM INTO ?", [str(tmp_path / "copy")])
        live.close()
        client.create(BODY)  # the server goes on writing
    with stiefel.Client(serve("--store", str(tmp_path / "copy")).address) as client:
        assert [one.id for one in client.list()] == [session.id]
        assert client.get(session.id).step(30, fields="Q")["Q"].tobytes() == bits
