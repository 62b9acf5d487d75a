"""Short sweeps one after another leave nothing behind."""
import gc
import os
import tempfile
import threading

import psutil
import pytest
from cases import SPINS, sweep

SWEEPS = int(os.environ.get("STIEFEL_SHORT_SWEEPS", "12"))


def held(folder):
    gc.collect()
    this = psutil.Process()
    return {"processes": len(this.children(recursive=True)), "descriptors": this.num_fds(), "threads": threading.active_count(),
            "folders": len(list(folder.iterdir()))}


def test_short_sweeps_leave_nothing(tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))  # where servers have their sockets

    def one():
        sweep(axes={"body.angular_velocity": SPINS[:3]}, to=3)

    for _ in range(SWEEPS // 4):
        one()
    before, memory = held(tmp_path), psutil.Process().memory_info().rss
    for _ in range(SWEEPS):
        one()
    assert held(tmp_path) == before
    assert psutil.Process().memory_info().rss < memory + 20e6 + 2e3 * SWEEPS


@pytest.mark.parametrize("done, points, line", [(0, 10, "0 of 10 motions"), (5, 10, "5 of 10 motions, ")])
def test_progress_without_tqdm(monkeypatch, capsys, done, points, line):
    import sys

    from stiefel._sweep.progress import Progress

    monkeypatch.setitem(sys.modules, "tqdm", None)
    with Progress(points, 0, True) as progress:
        if done:
            progress.add(done)
        assert progress.line().startswith(line)
    assert (capsys.readouterr().err == "") is (done == 0)


def test_a_worker_has_its_share_of_the_machine(monkeypatch):
    from stiefel._sweep.chunks import Task
    from stiefel._sweep.own_server import Share
    from stiefel._sweep.worker import here, share_of

    monkeypatch.delenv("SLURM_CPUS_PER_TASK", raising=False)
    monkeypatch.setattr(os, "cpu_count", lambda: 8)
    machine = psutil.virtual_memory().total
    elsewhere = Task(b"", 1, (), b"", "")
    assert share_of(elsewhere).threads == 1 and share_of(elsewhere).memory == pytest.approx(0.75 / 8 * machine, rel=0.02)
    assert share_of(Task(b"", 1, (), b"", "", home=here())) == Share(0)
    assert share_of(Task(b"", 1, (), b"", "", threads=3, home=here())) == Share(3)
    assert share_of(Task(b"", 1, (), b"", "", threads=3)).threads == 3
    monkeypatch.setenv("SLURM_CPUS_PER_TASK", "4")
    assert share_of(elsewhere).threads == 4 and share_of(elsewhere).memory == pytest.approx(0.75 / 2 * machine, rel=0.02)
