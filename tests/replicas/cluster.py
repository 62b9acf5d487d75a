"""Three servers without a shared store behind a proxy, one of them killed every second."""
from __future__ import annotations

import copy
import os
import random
import signal
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import yaml

ROOT = Path(__file__).parents[2]
sys.path.append(str(ROOT / "tests/support"))
from daemons import find_daemon  # noqa: E402

REPLICAS = 3
DOWN = 0.4  # seconds between a kill and the start after it


def free_ports(count: int) -> list[int]:
    held = [socket.socket() for _ in range(count)]
    for each in held:
        each.bind(("127.0.0.1", 0))
    ports = [each.getsockname()[1] for each in held]
    for each in held:
        each.close()
    return ports


def answers(port: int) -> bool:
    try:
        socket.create_connection(("127.0.0.1", port), timeout=1).close()
    except OSError:
        return False
    return True


def wait_for(port: int, seconds: float = 60) -> None:
    end = time.monotonic() + seconds
    while not answers(port):
        assert time.monotonic() < end, f"nothing listens on port {port} after {seconds:g} s"
        time.sleep(0.02)


class Replica:
    def __init__(self, port: int):
        self.port = port
        self.start()

    def start(self) -> None:
        command = [os.environ["STIEFEL_SERVER"], "--listen", f"127.0.0.1:{self.port}", "--exit-with-parent",
                   "--threads", "2", "--log-level", "warn"]
        self.child: Any = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL)

    def kill(self) -> None:
        self.child.send_signal(signal.SIGKILL)
        self.child.wait()
        self.child.stdin.close()


class Cluster:
    """`address` is the proxy's. Between `with` and its end the servers are killed, one a second."""

    def __init__(self, folder: Path, proxy: str = "haproxy"):
        self.folder = folder
        *ports, local, tls = free_ports(REPLICAS + 2)
        self.address, self.tls = f"127.0.0.1:{local}", tls
        self.replicas = [Replica(port) for port in ports]
        self.kills = 0
        self._stop = threading.Event()
        self._random = random.Random(17)
        self.proxy = PROXIES[proxy](folder, ports, local, tls)
        try:
            for port in [*ports, local]:
                wait_for(port)
            time.sleep(1)  # the proxy has seen all of them
        except BaseException:
            self.stop()
            raise

    def __enter__(self) -> Cluster:
        self._killer = threading.Thread(target=self._kill)
        self._killer.start()
        return self

    def __exit__(self, *exception: object) -> None:
        self._stop.set()
        self._killer.join()

    def _kill(self) -> None:
        while not self._stop.wait(1 - DOWN):
            replica = self._random.choice(self.replicas)
            replica.kill()
            self.kills += 1
            time.sleep(DOWN)
            replica.start()
            wait_for(replica.port)  # so that on a slow machine two of three always run

    def stop(self) -> None:
        for replica in self.replicas:
            replica.kill()
        self.proxy.terminate()
        try:
            self.proxy.wait(5)
        except subprocess.TimeoutExpired:
            self.proxy.kill()
            self.proxy.wait()


def certificate(folder: Path) -> Path:
    """A certificate of localhost signed by itself, with its key."""
    pem = folder / "stiefel.pem"
    subprocess.run(["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes",
                    "-days", "2", "-subj", "/CN=localhost", "-addext", "subjectAltName=DNS:localhost,IP:127.0.0.1",
                    "-keyout", folder / "key.pem", "-out", folder / "cert.pem"], check=True, capture_output=True)
    pem.write_text((folder / "cert.pem").read_text() + (folder / "key.pem").read_text())
    return pem


def haproxy_environment(folder: Path, ports: list[int], local: int, tls: int) -> dict[str, str]:
    replicas = {f"STIEFEL_REPLICAS_{k}": f"127.0.0.1:{port}" for k, port in enumerate(ports, 1)}
    return {**os.environ, **replicas, "STIEFEL_LOCAL_BIND": f"127.0.0.1:{local}", "STIEFEL_TLS_BIND": f"127.0.0.1:{tls}",
            "STIEFEL_CERTIFICATE": str(certificate(folder))}


def find_haproxy() -> str:
    return find_daemon("haproxy") or "haproxy"


def start_haproxy(folder: Path, ports: list[int], local: int, tls: int) -> Any:
    return subprocess.Popen([find_haproxy(), "-db", "-f", ROOT / "docker/haproxy.cfg"],
                            env=haproxy_environment(folder, ports, local, tls), stdin=subprocess.DEVNULL,
                            stdout=(folder / "haproxy.log").open("w"), stderr=subprocess.STDOUT)


def envoy_configuration(folder: Path, ports: list[int], local: int, tls: int, calls_a_second: int | None = None) -> Path:
    """docker/envoy.yaml with these ports and files, and beside its listener one without TLS."""
    certificate(folder)
    tls_folder = folder / "tls"
    tls_folder.mkdir()
    (tls_folder / "tls.crt").write_bytes((folder / "cert.pem").read_bytes())
    (tls_folder / "tls.key").write_bytes((folder / "key.pem").read_bytes())
    (folder / "descriptor.binpb").write_bytes((ROOT / "proto/descriptor.binpb").read_bytes())
    for name, source in (("certificate.yaml", "envoy-certificate.yaml"), ("envoy.yaml", "envoy.yaml")):
        text = (ROOT / "docker" / source).read_text()
        text = text.replace("/etc/envoy", str(folder)).replace("/etc/stiefel-tls", str(tls_folder))
        (folder / name).write_text(text)
    configuration = yaml.safe_load((folder / "envoy.yaml").read_text())
    resources = configuration["static_resources"]
    listener, = resources["listeners"]
    listener["address"]["socket_address"] = {"address": "127.0.0.1", "port_value": tls}
    manager = listener["filter_chains"][0]["filters"][0]["typed_config"]
    limit = manager["http_filters"][0]["typed_config"]["token_bucket"]
    if calls_a_second:
        limit.update(max_tokens=2 * calls_a_second, tokens_per_fill=calls_a_second, fill_interval="1s")
    plain = copy.deepcopy(listener)
    plain["name"] = "local"
    plain["address"]["socket_address"]["port_value"] = local
    del plain["filter_chains"][0]["transport_socket"]
    resources["listeners"].append(plain)
    endpoints = resources["clusters"][0]["load_assignment"]["endpoints"][0]["lb_endpoints"]
    for endpoint, port in zip(endpoints, ports):
        endpoint["endpoint"]["address"]["socket_address"] = {"address": "127.0.0.1", "port_value": port}
    (folder / "envoy.yaml").write_text(yaml.safe_dump(configuration))
    return folder / "envoy.yaml"


def start_envoy(folder: Path, ports: list[int], local: int, tls: int) -> Any:
    return subprocess.Popen([os.environ["STIEFEL_ENVOY"], "-c", envoy_configuration(folder, ports, local, tls),
                             "--use-dynamic-base-id", "--log-level", "warn"], stdin=subprocess.DEVNULL,
                            stdout=(folder / "envoy.log").open("w"), stderr=subprocess.STDOUT)


PROXIES = {"haproxy": start_haproxy, "envoy": start_envoy}
