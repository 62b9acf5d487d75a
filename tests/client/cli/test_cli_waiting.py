"""What the command `stiefel` says while it runs, and how it ends when it is interrupted."""
import fcntl
import json
import os
import pty
import re
import select
import shlex
import signal
import struct
import subprocess
import termios
import time

import pytest

FAR = 10**12


def last_line(err):
    """The last line on stderr. On a slow machine lines of progress come before it."""
    return err.decode().splitlines()[-1]


@pytest.fixture
def start(tmp_path):
    """Starts the command; what is still there at the end is killed."""
    running = []

    def start(*arguments, **files):
        files = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, **files}
        # Without a buffer `readline` takes nothing from `communicate`.
        running.append(subprocess.Popen([os.environ["STIEFEL_CLI"], *map(str, arguments)], cwd=tmp_path, bufsize=0,
                                        **files))
        return running[-1]
    yield start
    for process in running:
        process.kill()
        process.wait()


@pytest.fixture
def terminal():
    """The two ends of a terminal of the given width."""
    ends = []

    def terminal(columns):
        ours, theirs = pty.openpty()
        fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))
        ends.append(ours)
        return ours, theirs
    yield terminal
    for end in ends:
        os.close(end)


def read_until(end, pattern, seconds=60):
    seen, deadline = b"", time.monotonic() + seconds
    while not re.search(pattern, seen):
        assert select.select([end], [], [], max(0, deadline - time.monotonic()))[0], seen
        seen += os.read(end, 1000)
    return seen.decode()


def wait_until(holds, seconds=120):
    deadline = time.monotonic() + seconds
    while not holds():
        assert time.monotonic() < deadline
        time.sleep(0.01)


def wait_until_it_computes(process, seconds=0.5):
    """Until the process has taken that much processor time."""
    def taken():
        with open(f"/proc/{process.pid}/stat", encoding="ascii") as stat:
            return sum(map(int, stat.read().rpartition(")")[2].split()[11:13])) / os.sysconf("SC_CLK_TCK")
    wait_until(lambda: taken() >= seconds)


def signals(process, which):
    """A set of signals of the process: "SigBlk", those that it blocks, "ShdPnd", those that wait."""
    with open(f"/proc/{process.pid}/status", encoding="ascii") as status:
        mask = next(int(line.split()[1], 16) for line in status if line.startswith(which))
    return {number for number in range(1, 65) if mask >> (number - 1) & 1}


# Interrupted


@pytest.mark.parametrize("extension, how", [("json", signal.SIGINT), ("csv", signal.SIGTERM), ("npz", signal.SIGHUP)])
def test_an_interrupted_run_leaves_no_file_and_says_how_far_it_got(start, write, scene, tmp_path, extension, how):
    (tmp_path / f"out.{extension}").write_text("before")
    run = start("run", write(scene), "--to", FAR, "--every", 10**4, "--output", f"out.{extension}")
    wait_until((tmp_path / f"out.{extension}.part").exists)
    wait_until_it_computes(run)
    run.send_signal(how)
    out, err = run.communicate(timeout=60)
    assert run.returncode == -how  # by the signal: 128 + signal to a shell
    said = re.fullmatch(rf"stiefel: interrupted at step (\d+) of {FAR}; nothing was written", last_line(err))
    assert said and 0 < int(said[1]) < FAR
    assert out == b""
    assert sorted(path.name for path in tmp_path.iterdir()) == [f"out.{extension}", "scene.json"]
    assert (tmp_path / f"out.{extension}").read_text() == "before"


def test_a_shell_sees_130(write, scene):
    run = shlex.join([os.environ["STIEFEL_CLI"], "run", str(write(scene)), "--to", str(FAR)])
    command = f"trap : INT; {run}; echo $?"
    shell = subprocess.Popen(["bash", "-c", command], stdout=subprocess.PIPE, text=True, start_new_session=True)
    shell.stdout.readline()  # the command has begun
    os.killpg(shell.pid, signal.SIGINT)
    assert shell.communicate(timeout=60)[0].splitlines()[-1] == "130"


def test_interrupted_json_on_stdout_is_whole(start, write, scene):
    run = start("run", write(scene), "--to", FAR, "--every", 10**5)
    first = run.stdout.readline() + run.stdout.readline()
    run.send_signal(signal.SIGINT)
    out, err = run.communicate(timeout=60)
    assert run.returncode == -signal.SIGINT
    result = json.loads(first + out)
    assert result["outcome"] == "CANCELLED" and result["message"] == "interrupted"
    steps = [sample["step"] for sample in result["samples"]]
    assert steps == list(range(0, 10**5 * len(steps), 10**5)) and len(steps) > 1
    said = re.fullmatch(rf"stiefel: interrupted at step (\d+) of {FAR}; the samples up to there are on stdout",
                        last_line(err))
    assert said and int(said[1]) >= steps[-1]


def test_other_commands_are_interrupted_too(start, write, scene, tmp_path):
    diagnose = start("diagnose", write(scene), "--to", FAR)
    tradeoff = start("tradeoff", write({**scene, "step": 0.1}, "other.json"), "--budget", "1e13", "--output", "p.json")
    wait_until_it_computes(diagnose)
    wait_until_it_computes(tradeoff)
    for command, said in [(diagnose, rf"at step \d+ of {FAR}"),
                          (tradeoff, r"(before the first point|after \d+ of about \d+ points); nothing was written")]:
        command.send_signal(signal.SIGINT)
        out, err = command.communicate(timeout=60)
        assert command.returncode == -signal.SIGINT
        assert re.fullmatch(f"stiefel: interrupted {said}", last_line(err))
        assert out == b""
    assert not list(tmp_path.glob("p.json*"))


def test_an_interrupt_ends_a_command_that_waits_for_its_reader(start, write, scene):
    """The pipe of stdout is full, so that the command cannot stop by itself."""
    run = start("run", write(scene), "--to", 10**9, "--every", 1)
    full = fcntl.fcntl(run.stdout, fcntl.F_GETPIPE_SZ)
    wait_until(lambda: struct.unpack("i", fcntl.ioctl(run.stdout, termios.FIONREAD, b"\0" * 4))[0] == full)
    run.send_signal(signal.SIGINT)
    assert run.wait(timeout=60) == -signal.SIGINT
    assert run.stderr.read().startswith(b"stiefel: interrupted")


def test_a_second_interrupt_ends_it_at_once(start, write, scene, tmp_path):
    scene_file, fifo = write(scene), tmp_path / "fifo"
    os.mkfifo(fifo)
    run = start("run", fifo, "--to", 10)  # waits for who writes the scene
    wait_until(lambda: signal.SIGTERM in signals(run, "SigBlk"))  # a thread of the command takes it
    begun = time.monotonic()
    run.send_signal(signal.SIGTERM)
    wait_until(lambda: signal.SIGTERM not in signals(run, "ShdPnd"))
    run.send_signal(signal.SIGTERM)
    assert run.wait(timeout=60) == -signal.SIGTERM
    assert time.monotonic() - begun < 3, "after 3 s the first one ends it"
    assert run.stderr.read() == b"stiefel: interrupted\n"
    assert scene_file.exists()


def test_what_the_caller_ignores_stays_ignored(start, write, scene):
    """As nohup does."""
    run = start("run", write(scene), "--to", 10**7, "--every", 10**7,
                preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN))
    time.sleep(0.5)
    run.send_signal(signal.SIGHUP)
    out, _ = run.communicate(timeout=600)
    assert run.returncode == 0 and json.loads(out)["outcome"] == "REACHED"


def test_the_session_on_a_server_is_deleted(start, write, scene, tmp_path):
    address = f"unix:{tmp_path}/server"
    server = subprocess.Popen([os.environ["STIEFEL_SERVER"], "--listen", address, "--log-format", "json",
                               "--log-level", "debug"],
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        assert server.stdout.readline().startswith("listening")
        run = start("run", write(scene), "--to", FAR, "--output", "out.csv", "--server", address)
        wait_until_it_computes(server)
        run.send_signal(signal.SIGINT)
        assert run.wait(timeout=60) == -signal.SIGINT
    finally:
        server.terminate()
        log = [json.loads(line) for line in server.communicate(timeout=60)[1].splitlines()]
    assert [line["code"] for line in log if line.get("method") == "DeleteSession"] == ["OK"]
    assert {line["code"] for line in log if line.get("method") == "Stream" and "code" in line} == {"CANCELLED"}
    assert {line["message"] for line in log if "method" in line} == {"rpc", "rpc begins"}


# Progress


def test_progress_on_a_terminal_fits_it(start, terminal, write, scene):
    ours, theirs = terminal(60)
    start("run", write(scene), "--to", FAR, "--every", FAR, stderr=theirs)
    os.close(theirs)
    lines = read_until(ours, rb"(?s)(ETA.*){3}").split("\r")
    assert all(len(line.removesuffix("\x1b[K")) < 60 for line in lines)


def test_a_short_command_says_nothing(stiefel, write, scene):
    result = stiefel("run", write(scene), "--to", 1000, "--every", 1000)
    assert (result.status, result.err) == (0, "")
