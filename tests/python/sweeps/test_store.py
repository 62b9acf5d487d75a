"""The store: finished chunks are not computed again, and only those of the same sweep."""
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import zarr
from cases import SPINS, failures, small_chunks, sweep  # noqa: F401

import stiefel
from stiefel.sweeps import worker

pytestmark = pytest.mark.usefixtures("small_chunks")


@pytest.fixture
def computed(monkeypatch):
    """The chunks that were computed, by their index."""
    chunks, compute_at = [], worker.compute_at

    def counting(client, task):
        chunks.append(task.index)
        return compute_at(client, task)

    monkeypatch.setattr("stiefel.sweeps.executors.compute_at", counting)
    return chunks


def test_a_finished_sweep_is_read(tmp_path, computed):
    first = sweep(store=tmp_path / "sweep.zarr")
    assert sorted(computed) == list(range(15))
    second = sweep(store=str(tmp_path / "sweep.zarr"))
    assert len(computed) == 15
    assert first.attrs["sha256"] == second.attrs["sha256"] == sweep().attrs["sha256"]
    assert first.equals(second)


def test_a_store_in_memory(computed):
    store = zarr.group(store={})
    sweep(store=store.store)
    sweep(store=store.store)
    assert len(computed) == 15


def test_unmarked_and_damaged_chunks_are_computed_again(tmp_path, computed):
    expected = sweep(store=tmp_path / "sweep.zarr").attrs["sha256"]
    group = zarr.open_group(str(tmp_path / "sweep.zarr"), mode="a")
    group["done"][3] = 0
    group["energy.drift"][4 * 7] = 1.0
    computed.clear()
    assert sweep(store=tmp_path / "sweep.zarr").attrs["sha256"] == expected
    assert sorted(computed) == [3, 7]


def test_marks_without_an_array_count_for_nothing(tmp_path, computed):
    expected = sweep(store=tmp_path / "sweep.zarr").attrs["sha256"]
    shutil.rmtree(tmp_path / "sweep.zarr" / "energy.drift")
    with pytest.raises(Exception):
        zarr.open_group(str(tmp_path / "sweep.zarr"))["energy.drift"]
    computed.clear()
    assert sweep(store=tmp_path / "sweep.zarr").attrs["sha256"] == expected and len(computed) == 15


@pytest.mark.parametrize("change, differs", [
    ({"to": 201}, "request"), ({"summarize": {"energy": "drift"}}, "request"),
    ({"axes": {"body.angular_velocity": SPINS}}, "scene, axes"),
    ({"scene": {"system": "rigid_body", "step": 0.03, "method": {"name": "variational"},
                "body": {"moments": [1, 2, 3]}}}, "scene"),
])
def test_a_store_of_another_sweep_is_refused_before_work(tmp_path, computed, change, differs):
    sweep(store=tmp_path / "sweep.zarr")
    computed.clear()
    before = {path: path.stat().st_mtime_ns for path in (tmp_path / "sweep.zarr").rglob("*")}
    with pytest.raises(stiefel.InvalidArgument, match=f"is the store of another sweep: ({differs}) differ"):
        sweep(store=tmp_path / "sweep.zarr", **change)
    assert computed == []
    assert before == {path: path.stat().st_mtime_ns for path in (tmp_path / "sweep.zarr").rglob("*")}


def test_what_is_no_store_is_refused_before_work(tmp_path, computed):
    (tmp_path / "notes").mkdir()
    (tmp_path / "notes" / "text").write_text("mine")
    (tmp_path / "file").write_text("mine")
    zarr.open_group(str(tmp_path / "other.zarr"), mode="w").create_group("x")
    for name, message in [("notes", "is a folder with something else in it"), ("file", "cannot be opened"),
                          ("other.zarr", "holds something else")]:
        with pytest.raises(stiefel.InvalidArgument, match=f"store: .*{name}: {message}"):
            sweep(store=tmp_path / name)
    assert computed == [] and (tmp_path / "notes" / "text").read_text() == "mine"


KILLED = """
import sys
sys.path.insert(0, {here!r})
import stiefel.sweeps.chunks
from cases import sweep
stiefel.sweeps.chunks.LARGEST = 4
sweep(to=20_000, store=sys.argv[1], threads=1)
"""


def marks(store):
    """The files of the marks, in the layouts of Zarr 2 and 3."""
    return sum(path.is_file() and path.name.strip("0123456789.") == "" and path.name[0] != "." for path in store.rglob("done/**/*"))


def test_a_sweep_whose_client_was_killed_goes_on(tmp_path, computed):
    """Killed between the numbers and marks of chunks, anywhere."""
    store = tmp_path / "sweep.zarr"
    program = subprocess.Popen([sys.executable, "-c", KILLED.format(here=str(Path(__file__).parent)), store])
    while marks(store) < 3 and program.poll() is None:
        time.sleep(0.005)
    program.send_signal(signal.SIGKILL)
    assert program.wait() == -signal.SIGKILL
    done = marks(store)
    assert 3 <= done < 15
    found = sweep(to=20_000, store=store)
    assert len(computed) == 15 - done
    assert found.attrs["sha256"] == sweep(to=20_000).attrs["sha256"]


def test_a_store_without_zarr_says_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "zarr", None)
    with pytest.raises(stiefel.InvalidArgument, match=r"zarr is not installed: pip install stiefel\[xarray\]"):
        sweep(store=tmp_path / "sweep.zarr")


def test_the_store_is_made_before_work(tmp_path, monkeypatch):
    """A folder that cannot be written to is found before the first chunk."""
    seen = []
    monkeypatch.setattr("stiefel.sweeps.executors.compute_at",
                        lambda client, task: seen.append(os.listdir(tmp_path / "sweep.zarr")) or 1 / 0)
    with pytest.raises(ZeroDivisionError):
        sweep(store=tmp_path / "sweep.zarr")
    assert "done" in seen[0] and len(seen[0]) >= 2
