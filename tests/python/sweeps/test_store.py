"""The store: finished chunks are not computed again, and only those of the same sweep."""
import dataclasses
import multiprocessing
import os
import shutil
import signal
import subprocess
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
import pytest
import zarr
from cases import SPINS, failures, small_chunks, sweep  # noqa: F401

import stiefel
from stiefel._sweep import chunk_store, worker

pytestmark = pytest.mark.usefixtures("small_chunks")


@pytest.fixture
def computed(monkeypatch):
    """The chunks that were computed, by their index."""
    chunks, compute_at = [], worker.compute_at

    def counting(client, task):
        chunks.append(task.index)
        return compute_at(client, task)

    monkeypatch.setattr("stiefel._sweep.executors.compute_at", counting)
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
import stiefel._sweep.chunks
from cases import sweep
stiefel._sweep.chunks.LARGEST = 4
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
    monkeypatch.setattr("stiefel._sweep.executors.compute_at",
                        lambda client, task: seen.append(os.listdir(tmp_path / "sweep.zarr")) or 1 / 0)
    with pytest.raises(ZeroDivisionError):
        sweep(store=tmp_path / "sweep.zarr")
    assert "done" in seen[0] and len(seen[0]) >= 2


def shared(tmp_path, **options):
    """A sweep on two processes of its own with a store."""
    with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("spawn")) as pool:
        return sweep(store=tmp_path / "sweep.zarr", executor=pool, threads=1, **options)


@pytest.fixture
def put(monkeypatch):
    """The chunks whose numbers came home."""
    chunks, put = [], chunk_store.Store.put
    monkeypatch.setattr(chunk_store.Store, "put", lambda self, chunk, arrays: chunks.append(chunk) or put(self, chunk, arrays))
    return chunks


@pytest.fixture
def one_at_a_time(monkeypatch):
    """The first chunk is back, and the arrays are made, before most others are given."""
    monkeypatch.setattr("stiefel._sweep.executors.AHEAD", 1)


def test_workers_that_see_the_store_write(tmp_path, put, one_at_a_time, computed):
    expected = sweep().attrs["sha256"]
    assert shared(tmp_path).attrs["sha256"] == expected
    assert 1 <= len(put) <= 4
    computed.clear()
    assert sweep(store=tmp_path / "sweep.zarr").attrs["sha256"] == expected and computed == []


def test_workers_that_see_another_store_send_their_numbers(tmp_path, put, one_at_a_time, monkeypatch):
    """A challenge that is not in the group stands for a worker whose path leads elsewhere."""
    place = chunk_store.Store.place

    def elsewhere(self, chunk):
        found = place(self, chunk)
        return found and dataclasses.replace(found, challenge="0" * 64)

    monkeypatch.setattr(chunk_store.Store, "place", elsewhere)
    assert shared(tmp_path).attrs["sha256"] == sweep().attrs["sha256"]
    assert sorted(put) == list(range(15))


def test_a_chunk_that_is_not_there_after_all_is_computed_again(tmp_path, put, one_at_a_time, monkeypatch):
    """A store that the worker sees in another state than the sweep: a damaged number stands for it."""
    read = chunk_store.Store.read

    def late(self, chunk, written):
        self._group["energy.drift"][self._plan.chunks[chunk][1]] = 7.0
        return read(self, chunk, written)

    monkeypatch.setattr(chunk_store.Store, "read", late)
    assert shared(tmp_path).attrs["sha256"] == sweep().attrs["sha256"]
    assert len(put) > 4
    group = zarr.open_group(str(tmp_path / "sweep.zarr"))
    assert (np.asarray(group["energy.drift"][:]) != 7.0).all()


def test_chunks_that_share_a_block_are_written_at_home(tmp_path, put, one_at_a_time):
    """Six points for each step: the chunks of the second do not begin with a block of four."""
    options = {"axes": {"step": [0.01, 0.02], "body.angular_velocity": SPINS[:6]}, "zipped": False}
    assert shared(tmp_path, **options).attrs["sha256"] == sweep(**options).attrs["sha256"]
    assert sorted(put) == [0, 1, 2, 3]
