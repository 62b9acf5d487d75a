"""The frames of gRPC's CVEs of 2023 (tests/server/attack/test_frames.py), sent through the proxies of docker/: no server
ends for them or needs more memory, and other clients are answered."""
from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import pytest

import stiefel
from conftest import long
from test_floods import resident

SERVER = Path(__file__).parents[1] / "server"
SCENE = {"system": "rigid_body", "step": 0.05, "body": {"moments": [1, 2, 3], "angular_velocity": [0.1, 1, 0.2]}}


@pytest.fixture
def attacks(monkeypatch: Any) -> Any:
    """By name, functions of the address to attack."""
    for folder in (SERVER / "attack", SERVER, SERVER.parent / "support"):
        monkeypatch.syspath_prepend(str(folder))
    monkeypatch.delitem(sys.modules, "conftest")  # that module has one of its own
    import test_frames
    return test_frames.ATTACKS


@pytest.mark.parametrize("proxy", ["haproxy", pytest.param("envoy", marks=long)])
def test_behind_a_proxy_the_servers_do_not_notice(attacks: Any, make_cluster: Any, proxy: str) -> None:
    cluster = make_cluster(proxy)
    children = [replica.child for replica in cluster.replicas]
    with stiefel.Client(cluster.address) as client, client.create(SCENE) as session:
        expected = session.step(100, fields="Q")["Q"].tobytes()
        for name, attack in attacks.items():
            attack(cluster.address)
            assert [child.poll() for child in children] == [None] * len(children), name
            assert session.step(100, fields="Q")["Q"].tobytes() == expected, name
            assert max(resident(child.pid) for child in children) < 256 << 20, name
    assert cluster.proxy.poll() is None
