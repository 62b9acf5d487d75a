#!/usr/bin/env python3
"""Compares two builds of the server, alternately, over TLS with tokens: small calls, streams, and calls beside 64 endless ones.

    tests/bench/service/two_servers.py BESIDE SERVER_A SERVER_B [ROUNDS]

BESIDE is the program made of beside.cc. Prints for each figure the medians of both, in milliseconds, and their ratio; for
each part also the processor time of the servers, in seconds.
"""
from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
from collections import defaultdict
from pathlib import Path

PARTS = ["step", "drive", "million", "short", "idle", "beside"]


def measure(beside: str, server: str, part: str, folder: Path, tokens: list[str]) -> dict[str, float]:
    process = subprocess.Popen([server, "--listen", "127.0.0.1:0", "--log-level", "warn", "--tokens", str(folder / "tokens"),
                                "--tls-cert", str(folder / "cert.pem"), "--tls-key", str(folder / "key.pem")],
                               stdout=subprocess.PIPE, text=True)
    assert process.stdout
    address = process.stdout.readline().split()[-1]
    lines = subprocess.run([beside, address, part, *tokens, str(folder / "cert.pem")], check=True, timeout=300,
                           capture_output=True, text=True).stdout.splitlines()
    process.terminate()
    usage = os.wait4(process.pid, 0)[2]
    figures = {" ".join(line.split()[:-1]): float(line.split()[-1]) for line in lines}
    return {**figures, f"{part} processor time": usage.ru_utime + usage.ru_stime}


def prepare(server: str, folder: Path) -> list[str]:
    """Writes a certificate and the tokens of two principals; returns the tokens."""
    subprocess.run(["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2", "-subj", "/CN=localhost",
                    "-keyout", str(folder / "key.pem"), "-out", str(folder / "cert.pem"),
                    "-addext", "subjectAltName=DNS:localhost"], check=True, capture_output=True)
    made = [subprocess.run([server, "token", name], check=True, capture_output=True, text=True).stdout.splitlines()
            for name in ("other", "mine")]
    (folder / "tokens").write_text("".join(f"{line}\n" for _, line in made), encoding="ascii")
    return [token for token, _ in made]


def main(beside: str, servers: list[str], rounds: int) -> None:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        tokens = prepare(servers[0], folder)
        seen: dict[str, list[list[float]]] = defaultdict(lambda: [[], []])
        for number in range(rounds):
            for part in PARTS:
                for which in (0, 1) if number % 2 == 0 else (1, 0):
                    for figure, value in measure(beside, servers[which], part, folder, tokens).items():
                        seen[figure][which].append(value)
        for figure, both in seen.items():
            a, b = map(statistics.median, both)
            print(f"{figure:26} {a:9.3f} {b:9.3f} {b / a:6.2f} x")


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2:4], int(sys.argv[4]) if len(sys.argv) > 4 else 5)
