"""The command as a process: signals, pipes, disks, and what it imports; and its files, which are those of the Python package."""
import json
import os
import re
import signal
import subprocess
import time

import pytest

import stiefel
from stiefel.cli import main

BODY = {"system": "rigid_body", "method": {"name": "variational"}, "step": 0.1,
        "body": {"moments": [1, 2, 3], "angular_velocity": [0.3, 1, 0.2]}}
FAR = 10**12


@pytest.fixture
def start(tmp_path):
    """Starts the command in a folder with body.json; what is still there at the end is killed."""
    (tmp_path / "body.json").write_text(json.dumps(BODY))
    running = []

    def start(line, stdout=subprocess.PIPE, **more):
        more.setdefault("preexec_fn", lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))  # a shell ignores it for jobs behind `&`
        running.append(subprocess.Popen([os.environ["STIEFEL_CLI"], *line.split()], cwd=tmp_path, stdout=stdout,
                                        stderr=subprocess.PIPE, text=True, **more))
        return running[-1]
    yield start
    for process in running:
        process.kill()
        process.wait()


@pytest.fixture(scope="module")
def server():
    with stiefel.Server.start() as running:
        yield running


def wait_until_it_runs(server):
    """Until a session of the server has computed something."""
    with stiefel.Client(server.address) as client:
        while not any(max(client.get(session.id)._message.cached_steps, default=0) for session in client.list()):
            time.sleep(0.01)


@pytest.mark.parametrize("line, how", [
    (f"run body.json --to {FAR} --every {FAR} --output out.csv", signal.SIGINT), (f"diagnose body.json --to {FAR}", signal.SIGTERM)])
def test_an_interrupt_says_the_step_and_leaves_no_file(start, server, tmp_path, line, how):
    run = start(f"{line} --server {server.address}")
    wait_until_it_runs(server)
    run.send_signal(how)
    out, err = run.communicate(timeout=60)
    assert run.returncode == -how and out == ""  # by the signal: 128 + signal to a shell
    said = re.fullmatch(rf"stiefel: interrupted at step (\d+) of {FAR}\n", err)
    assert said and 0 < int(said[1]) < FAR
    assert [path.name for path in tmp_path.iterdir()] == ["body.json"]
    with stiefel.Client(server.address) as client:
        assert list(client.list()) == []


def test_an_interrupt_of_the_terminal_reaches_the_command_alone(start):
    """Its own server, which has to tell the step, is in another process group."""
    run = start(f"run body.json --to {FAR} --every {FAR}", start_new_session=True)
    while not subprocess.run(["pgrep", "-P", str(run.pid)], capture_output=True).stdout:
        time.sleep(0.01)
    os.killpg(run.pid, signal.SIGINT)
    assert run.communicate(timeout=60)[1].startswith("stiefel: interrupted") and run.returncode == -signal.SIGINT


def test_an_interrupt_ends_it_while_it_waits_for_its_input(start, tmp_path):
    os.mkfifo(tmp_path / "fifo")
    run = start("run fifo --to 10")  # waits for who writes the scene
    with open(tmp_path / "fifo", "w"):  # opened by the command
        run.send_signal(signal.SIGTERM)
        assert run.wait(timeout=60) == -signal.SIGTERM
    assert run.stderr.read() == "stiefel: interrupted\n"


def test_a_closed_pipe_and_a_full_disk(start, tmp_path):
    run = start("run body.json --to 30000 --every 1")
    assert run.stdout.readline() == '{"samples": [\n'
    run.stdout.close()
    assert run.wait(60) == 128 + signal.SIGPIPE and run.stderr.read() == ""
    (tmp_path / "full.npz").symlink_to("/dev/full")
    with open("/dev/full", "w") as full:
        for line, what in (("describe", "stdout"), ("run body.json --to 2 --output full.npz", "full.npz")):
            run = start(line, stdout=full)
            assert run.wait(60) == 1 and run.stderr.read() == f"stiefel: error: cannot write to {what}: No space left on device\n"


@pytest.mark.parametrize("extension", ["json", "csv", "npz"])
def test_a_file_is_that_of_python_and_is_run_again(server, tmp_path, monkeypatch, capsys, extension):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "body.json").write_text(json.dumps(BODY))
    file, at = tmp_path / f"out.{extension}", ["--server", server.address]
    assert main(["run", "body.json", "--to", "3000", "--estimate-error", "--output", file.name, *at]) == 0
    with stiefel.Client(server.address) as client, client.create(BODY) as session:
        session.trajectory(to=3000, every=None, estimate_error=True).save(tmp_path / f"ours.{extension}")
    assert (tmp_path / f"ours.{extension}").read_bytes() == file.read_bytes()
    capsys.readouterr()
    assert main(["rerun", file.name, *at]) == 0 and capsys.readouterr().out == f"{file.name}: the same samples, to the last bit\n"
    if extension == "json":
        file.write_text(file.read_text().replace('"step": 0.1', '"step": 0.2'))
        assert main(["rerun", file.name, *at]) == 1 and capsys.readouterr().out == f"{file.name}: other samples\n"
