"""The engine that runs the image, and containers run as docker/compose.yaml says."""
from __future__ import annotations

import json
import os
import socket
import subprocess
from pathlib import Path
from typing import Any, Iterator

import pytest
import yaml

ROOT = Path(__file__).parents[2]
ENGINE = os.environ["CONTAINER_ENGINE"]
IMAGE = os.environ["STIEFEL_IMAGE"]
BASE = os.environ["STIEFEL_IMAGE_BASE"]
SERVICE: dict[str, Any] = yaml.safe_load((ROOT / "docker/compose.yaml").read_text())["services"]["stiefel"]


def engine(*arguments: str) -> str:
    done = subprocess.run([ENGINE, *arguments], capture_output=True, text=True)
    assert done.returncode == 0, f"{ENGINE} {' '.join(arguments)}: {done.stderr}"
    return done.stdout.strip()


def inspect(kind: str, name: str) -> dict[str, Any]:
    return json.loads(engine(kind, "inspect", name))[0]


def hardening() -> list[str]:
    """The settings of compose.yaml as options of `run`."""
    options = ["--memory", SERVICE["mem_limit"], "--pids-limit", str(SERVICE["pids_limit"])]
    options += ["--read-only"] if SERVICE["read_only"] else []
    options += [f"--cap-drop={name}" for name in SERVICE["cap_drop"]]
    options += [f"--security-opt={option.replace(':true', '')}" for option in SERVICE["security_opt"]]
    return options + (["--read-only-tmpfs=false"] if ENGINE == "podman" else [])


class Container:
    def __init__(self) -> None:
        # Published on this machine's loopback interface only, so that plaintext does not leave it.
        network = ["--publish", "127.0.0.1::50551", "--env", "STIEFEL_LISTEN=0.0.0.0:50551", "--env", "STIEFEL_INSECURE=1"]
        if ENGINE == "podman":  # Needs no bridge this way.
            self.address = f"127.0.0.1:{free_port()}"
            network = ["--network", "host", "--env", f"STIEFEL_LISTEN={self.address}"]
        self.id = engine("run", "--detach", *hardening(), *network, IMAGE)
        if ENGINE == "docker":
            self.address = engine("port", self.id, "50551")

    def execute(self, *command: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run([ENGINE, "exec", self.id, *command], capture_output=True, text=True)

    def healthy(self) -> bool:
        if ENGINE == "podman":  # Without systemd nothing runs the check by itself.
            command = [ENGINE, "healthcheck", "run", self.id]
            return subprocess.run(command, capture_output=True).returncode == 0
        return inspect("container", self.id)["State"]["Health"]["Status"] == "healthy"

    def logs(self) -> str:
        done = subprocess.run([ENGINE, "logs", self.id], capture_output=True, text=True)
        return done.stdout + done.stderr

    def remove(self) -> None:
        engine("rm", "--force", self.id)


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


@pytest.fixture(scope="session")
def container() -> Iterator[Container]:
    running = Container()
    yield running
    print(running.logs())
    running.remove()
