"""The frames of gRPC's CVEs of 2023 (tests/server/attack/test_known_frames.py), sent through Envoy with docker/envoy.yaml:
no server ends for them, and other clients are answered."""
from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import pytest

import stiefel
from conftest import long

SERVER = Path(__file__).parents[1] / "server"
SCENE = {"system": "rigid_body", "step": 0.05, "body": {"moments": [1, 2, 3], "angular_velocity": [0.1, 1, 0.2]}}


@pytest.fixture
def attacks(monkeypatch: Any) -> Any:
    """By name, functions of the address to attack."""
    for folder in (SERVER / "attack", SERVER, SERVER.parent / "support"):
        monkeypatch.syspath_prepend(str(folder))
    monkeypatch.delitem(sys.modules, "conftest")  # that module has one of its own
    import test_known_frames
    return test_known_frames.ATTACKS


@long
def test_behind_envoy_the_servers_do_not_notice(attacks: Any, make_cluster: Any) -> None:
    cluster = make_cluster("envoy")
    children = [replica.child for replica in cluster.replicas]
    with stiefel.Client(cluster.address) as client, client.create(SCENE) as session:
        expected = session.step(100, fields="Q")["Q"].tobytes()
        for name, attack in attacks.items():
            attack(cluster.address)
            assert [child.poll() for child in children] == [None] * len(children), name
            assert session.step(100, fields="Q")["Q"].tobytes() == expected, name
    assert cluster.proxy.poll() is None
