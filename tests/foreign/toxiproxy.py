"""Toxiproxy as a process, and its HTTP interface."""
from __future__ import annotations

import json
import socket
import subprocess
import time
import urllib.request
from pathlib import Path
from typing import Any, Optional


def free_port() -> int:
    with socket.socket() as held:
        held.bind(("127.0.0.1", 0))
        return int(held.getsockname()[1])


class Toxiproxy:
    """Proxies to one server; each is an address with toxics of its own. As a context manager it ends with its block."""

    def __init__(self, program: Path, upstream: str):
        self._upstream, self._proxies = upstream, 0
        port = free_port()
        self._api = f"http://127.0.0.1:{port}"
        self._child = subprocess.Popen([program, "-port", str(port)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        end = time.monotonic() + 30
        while True:
            try:
                self.ask("GET", "/version")
                return
            except OSError:
                assert self._child.poll() is None and time.monotonic() < end, "toxiproxy does not answer"
                time.sleep(0.05)

    def ask(self, method: str, path: str, message: Optional[dict[str, Any]] = None) -> Any:
        request = urllib.request.Request(self._api + path, method=method, data=json.dumps(message).encode() if message else None)
        with urllib.request.urlopen(request, timeout=10) as reply:
            text = reply.read()
        return json.loads(text) if text[:1] in (b"{", b"[") else text

    def proxy(self, **toxic: Any) -> Proxy:
        self._proxies += 1
        name = f"p{self._proxies}"
        made = self.ask("POST", "/proxies", {"name": name, "listen": "127.0.0.1:0", "upstream": self._upstream, "enabled": True})
        proxy = Proxy(self, name, made["listen"])
        if toxic:
            proxy.poison(**toxic)
        return proxy

    def __enter__(self) -> Toxiproxy:
        return self

    def __exit__(self, *_: object) -> None:
        self._child.terminate()
        self._child.wait(10)


class Proxy:
    def __init__(self, toxiproxy: Toxiproxy, name: str, address: str):
        self._toxiproxy, self._path, self.address = toxiproxy, f"/proxies/{name}", address

    def poison(self, type: str, stream: str = "both", toxicity: float = 1.0, **attributes: Any) -> None:
        """`stream`: "downstream" to the client, "upstream" to the server. "down" ends and refuses connections."""
        if type == "down":
            self._toxiproxy.ask("POST", self._path, {"enabled": False})
            return
        for one in ("downstream", "upstream") if stream == "both" else (stream,):
            self._toxiproxy.ask("POST", f"{self._path}/toxics", {"name": f"{type}.{one}", "type": type, "stream": one,
                                                                 "toxicity": toxicity, "attributes": attributes})

    def heal(self) -> None:
        """No toxics, and up."""
        for toxic in self._toxiproxy.ask("GET", f"{self._path}/toxics"):
            self._toxiproxy.ask("DELETE", f"{self._path}/toxics/{toxic['name']}")
        self._toxiproxy.ask("POST", self._path, {"enabled": True})

    def remove(self) -> None:
        self._toxiproxy.ask("DELETE", self._path)
