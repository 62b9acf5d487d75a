"""The store: finished chunks are not computed again, and only those of the same sweep."""
import signal
import subprocess
import sys
import time
from pathlib import Path

import psutil
import pytest
from cases import SPINS, small_chunks, sweep  # noqa: F401

import stiefel
from stiefel._sweep import worker

pytestmark = pytest.mark.usefixtures("small_chunks")


@pytest.fixture
def computed(monkeypatch):
    """One entry for each chunk that was computed."""
    chunks, compute = [], worker.compute

    def counting(*arguments):
        chunks.append(compute(*arguments))
        return chunks[-1]

    monkeypatch.setattr("stiefel._sweep.sweep.compute", counting)
    return chunks


def test_only_chunks_that_are_missing_or_damaged_are_computed(tmp_path, computed):
    first = sweep(store=tmp_path)
    assert len(computed) == 15
    assert sweep(store=str(tmp_path)).equals(first) and len(computed) == 15
    (tmp_path / "3.npz").unlink()
    damaged = bytearray((tmp_path / "7.npz").read_bytes())
    damaged[len(damaged) // 2] ^= 1
    (tmp_path / "7.npz").write_bytes(damaged)
    (tmp_path / "9.npz").write_bytes((tmp_path / "9.npz").read_bytes()[:100])
    assert sweep(store=tmp_path).attrs["sha256"] == first.attrs["sha256"] == sweep().attrs["sha256"]
    assert len(computed) == 15 + 3 + 15


@pytest.mark.parametrize("change, differs", [
    ({"to": 201}, "request"), ({"summarize": {"energy": "drift"}}, "request"),
    ({"axes": {"body.angular_velocity": SPINS}}, "scene, axes"), ({"zipped": False}, "zipped, chunks"),
    ({"scene": {"system": "rigid_body", "step": 0.03, "method": {"name": "variational"}}}, "scene"),
])
def test_a_store_of_another_sweep_is_refused_before_work(tmp_path, computed, change, differs):
    sweep(store=tmp_path)
    computed.clear()
    before = {path: path.stat().st_mtime_ns for path in tmp_path.iterdir()}
    with pytest.raises(stiefel.InvalidArgument, match=f"is the store of another sweep: {differs} differ"):
        sweep(store=tmp_path, **change)
    assert computed == [] and before == {path: path.stat().st_mtime_ns for path in tmp_path.iterdir()}


def test_what_is_no_store_is_refused_before_work(tmp_path, computed):
    (tmp_path / "notes").mkdir()
    (tmp_path / "notes" / "text").write_text("mine")
    for name in ("notes", "notes/text"):
        with pytest.raises(stiefel.InvalidArgument, match=f"store: .*{name}: is something else: must be an empty folder"):
            sweep(store=tmp_path / name)
    assert computed == [] and (tmp_path / "notes" / "text").read_text() == "mine"


SWEEP = f"""
import sys
sys.path.insert(0, {str(Path(__file__).parent)!r})
import stiefel._sweep.plan
from cases import sweep
stiefel._sweep.plan.LARGEST = 4
try:
    sweep(to=50_000, store=sys.argv[1], threads=1)
except KeyboardInterrupt as error:
    print(error, (error.partial["outcome"].values == 1).sum())
"""


@pytest.mark.parametrize("sent", [signal.SIGINT, signal.SIGKILL])
def test_a_sweep_that_was_interrupted_goes_on(tmp_path, computed, sent):
    """Ctrl-C says how far it came."""
    program = subprocess.Popen([sys.executable, "-c", SWEEP, tmp_path], stdout=subprocess.PIPE, text=True)
    while len(list(tmp_path.glob("*.npz"))) < 2 and program.poll() is None:
        time.sleep(0.005)
    children = psutil.Process(program.pid).children()
    program.send_signal(sent)
    said, done = program.communicate()[0], len(list(tmp_path.glob("*.npz")))
    assert 2 <= done < 15 and children and psutil.wait_procs(children, timeout=60)[1] == []
    interrupted = f"{done} of 15 chunks are done; they are in the store, and the same call goes on from there {4 * done}\n"
    assert said == (interrupted if sent == signal.SIGINT else "")
    assert sweep(to=50_000, store=tmp_path).attrs["sha256"] == sweep(to=50_000).attrs["sha256"]
    assert len(computed) == 15 - done + 15
