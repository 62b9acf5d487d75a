"""The properties of the image, checked on a running container."""
from __future__ import annotations

import os
import subprocess
import sys
import time

import grpc
import pytest

from conftest import BASE, ENGINE, IMAGE, ROOT, SERVICE, Container, engine, hardening, inspect

MB = 1e6
# debian:bookworm-slim for amd64 as published, unpacked. A base made locally is larger.
PUBLISHED_BASE = 75 * MB


def until(condition, seconds: float = 30) -> None:
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "it did not happen in time"
        time.sleep(0.2)


def test_size() -> None:
    base, whole = (inspect("image", name)["Size"] for name in (BASE, IMAGE))
    on_published = whole if ENGINE == "docker" else whole - base + PUBLISHED_BASE
    print(f"the image is {whole / MB:.1f} MB on a base of {base / MB:.1f} MB: "
          f"{(whole - base) / MB:.1f} MB above it (bound 60), "
          f"{on_published / MB:.1f} MB on the published base (bound 150)")
    assert whole - base <= 60 * MB
    assert on_published <= 150 * MB


def test_labels() -> None:
    labels = inspect("image", IMAGE)["Config"]["Labels"]
    assert labels["org.opencontainers.image.title"] == "stiefel"
    assert labels["org.opencontainers.image.licenses"] == "Apache-2.0"
    assert f"project(stiefel VERSION {labels['org.opencontainers.image.version']} " in (ROOT / "CMakeLists.txt").read_text()
    assert labels["org.opencontainers.image.revision"] != "unknown"


def test_becomes_healthy(container: Container) -> None:
    until(container.healthy)


def test_has_no_privileges(container: Container) -> None:
    status = dict(line.split(":\t", 1) for line in container.execute("cat", "/proc/1/status").stdout.splitlines())
    assert status["Uid"].split() == ["65532"] * 4
    assert status["Gid"].split() == ["65532"] * 4
    for capabilities in ("CapInh", "CapPrm", "CapEff", "CapBnd", "CapAmb"):
        assert int(status[capabilities], 16) == 0
    assert status["NoNewPrivs"] == "1"


@pytest.mark.parametrize("path", ["/", "/tmp", "/var/tmp", "/run", "/home"])
def test_can_write_nothing(container: Container, path: str) -> None:
    written = container.execute("touch", f"{path}/x")
    assert written.returncode != 0
    assert "Read-only file system" in written.stderr or "Permission denied" in written.stderr


def test_serves_as_any_other_server(container: Container) -> None:
    grpc.channel_ready_future(grpc.insecure_channel(container.address)).result(timeout=30)
    environment = os.environ | {"STIEFEL_ADDRESS": container.address,
                                "PYTHONPATH": str(ROOT / "build/release/python")}
    done = subprocess.run([sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "tests/conformance"],
                          cwd=ROOT, env=environment, text=True, capture_output=True)
    print(done.stdout)
    assert done.returncode == 0


def test_ends_well_on_sigterm() -> None:
    running = Container()
    try:
        until(running.healthy)
        engine("kill", "--signal", "TERM", running.id)
        assert engine("wait", running.id) == "0", running.logs()
    finally:
        running.remove()


def test_by_default_it_is_reached_over_a_socket_alone() -> None:
    config = inspect("image", IMAGE)["Config"]
    assert "STIEFEL_LISTEN=unix:/run/stiefel/stiefel.sock" in config["Env"]
    assert "/run/stiefel" in config["Volumes"]
    assert not SERVICE.get("ports") and SERVICE["network_mode"] == "none"
    assert SERVICE["volumes"] == ["${STIEFEL_SOCKET:-socket}:/run/stiefel"]


def test_beyond_the_container_it_does_not_listen_without_tls() -> None:
    done = subprocess.run([ENGINE, "run", "--rm", *hardening(), "--network", "none", "--env", "STIEFEL_LISTEN=0.0.0.0:50551",
                           IMAGE], capture_output=True, text=True, timeout=60)
    assert done.returncode == 1 and "0.0.0.0:50551: other machines can reach it" in done.stderr
