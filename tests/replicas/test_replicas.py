"""Servers are killed and nobody loses a call: no call fails, no byte differs, no deleted session is back."""
from __future__ import annotations

import os
import subprocess
import threading
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stiefel
from conftest import LONG, long
from use import Resumptions, Use

COUNT = 20_000
SECONDS = float(os.environ.get("STIEFEL_REPLICAS_SECONDS", "600" if LONG else "15"))  # of kills, one a second
# Seconds from a failure to the next byte. The short form runs beside other tests, on a machine of any load.
RESUMED = 2.0 if LONG else 20.0


def client_in_cpp(*arguments: object) -> None:
    subprocess.run([os.environ["STIEFEL_REPLICAS_CLIENT"], *map(str, arguments)], check=True)


def use_for(seconds: float, cluster: Any, folder: Path, first: int, monkeypatch: Any) -> None:
    resumptions = Resumptions(monkeypatch)
    with stiefel.Server.start() as reference:
        use = Use(cluster.address, reference.address, folder, first, COUNT, resumptions)
        with cluster:
            use.run(seconds)
    p99 = float(np.percentile(resumptions.seconds, 99)) if resumptions.seconds else 0.0
    print(f"{cluster.kills} kills; {dict(use.calls)}, {len(resumptions.seconds)} resumptions, p99 {p99:.2f} s, "
          f"longest {max(resumptions.seconds, default=0):.2f} s")
    assert use.lost[:9] == []
    assert cluster.kills >= seconds / 4
    for kind in ("step", "stream", "drive", "fork", "diagnose", "summarize", "create", "delete"):
        assert use.calls[kind] > 0, kind
    assert use.differing == 0
    assert use.back == 0
    assert resumptions.seconds and p99 < RESUMED


@pytest.mark.parametrize("proxy", ["haproxy", pytest.param("envoy", marks=long)])
def test_killed_every_second(proxy: str, make_cluster: Any, tmp_path: Path, monkeypatch: Any) -> None:
    client_in_cpp("states", tmp_path, 0, COUNT)
    use_for(SECONDS, make_cluster(proxy), tmp_path, 0, monkeypatch)


@pytest.mark.parametrize("proxy, first", [
    ("haproxy", 10_000_000), pytest.param("haproxy", 10**9, marks=long), pytest.param("envoy", 10**9, marks=long)])
def test_killed_far_from_step_0(proxy: str, first: int, make_cluster: Any, tmp_path: Path, monkeypatch: Any) -> None:
    """To compute the state from step 0 takes seconds, at step 10^9 minutes: a session goes on from its checkpoint."""
    cluster = make_cluster(proxy)
    states = threading.Thread(target=client_in_cpp, args=("states", tmp_path, first, COUNT))
    states.start()
    with stiefel.Server.start() as alone:
        client_in_cpp("checkpoint", alone.address, tmp_path, first)
    states.join()
    use_for(SECONDS if LONG and first == 10**9 else 6, cluster, tmp_path, first, monkeypatch)
