"""Runs Debian's Prometheus with the rules of docker/prometheus. It scrapes servers twice a second."""
from __future__ import annotations

import json
import socket
import subprocess
import urllib.parse
import urllib.request
from pathlib import Path
from typing import Any, Optional

import yaml

from daemons import find_daemon

DOCKER = Path(__file__).resolve().parents[2] / "docker"


def free_port() -> int:
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


class Prometheus:
    """A running Prometheus. `folder`: takes its files; `targets`: the servers as host:port."""

    def __init__(self, folder: Path, targets: list[str]):
        config = yaml.safe_load((DOCKER / "prometheus/prometheus.yaml").read_text(encoding="utf-8"))
        config["global"] = {"scrape_interval": "500ms", "scrape_timeout": "500ms", "evaluation_interval": "500ms"}
        config["rule_files"] = [str(DOCKER / "prometheus/rules.yaml")]
        config["scrape_configs"][0]["static_configs"] = [{"targets": targets}]
        (folder / "prometheus.yaml").write_text(yaml.safe_dump(config))
        self.address = f"127.0.0.1:{free_port()}"
        self._child = subprocess.Popen(
            [find_daemon("prometheus") or "prometheus", f"--config.file={folder}/prometheus.yaml",
             f"--storage.tsdb.path={folder}/data", f"--web.listen-address={self.address}", "--log.level=error"],
            stdout=subprocess.DEVNULL)

    def ask(self, path: str, **parameters: str) -> Any:
        """Asks Prometheus's API and returns the data of the answer; None while there is no answer."""
        try:
            with urllib.request.urlopen(f"http://{self.address}/api/v1/{path}?{urllib.parse.urlencode(parameters)}",
                                        timeout=10) as answer:
                return json.load(answer)["data"]
        except OSError:
            return None

    def has_data(self, expression: str) -> bool:
        answer = self.ask("query", query=expression)
        return bool(answer and answer["result"])

    def values(self, expression: str, at: Optional[float] = None) -> dict[str, float]:
        """Returns the values of an expression by their labels as JSON. `at`: seconds since 1970; None: now."""
        when = {} if at is None else {"time": f"{at:.3f}"}
        answer = self.ask("query", query=expression, **when)
        return {json.dumps(one["metric"]): float(one["value"][1]) for one in answer["result"]}

    def stop(self) -> None:
        self._child.terminate()
        self._child.wait(20)
