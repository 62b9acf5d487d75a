"""The program stiefel-server from outside: as a process, and as bytes on a socket."""
import json
import os
import resource
import socket
import subprocess
import sys
import time
from pathlib import Path

import grpc
import pytest

from stiefel import v1 as pb

sys.path[:0] = [str(Path(__file__).resolve().parents[1] / folder) for folder in ("support", "calls")]

SANITIZED = "STIEFEL_SANITIZED" in os.environ
SERVER = os.environ["STIEFEL_SERVER"]
PREFACE = b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n" + b"\0\0\0\4\0\0\0\0\0"  # and empty SETTINGS
# A step costs work, as those of the recommended method `exact` do not.
BODY = {"system": "rigid_body", "step": 0.05, "body": {"moments": [1, 2, 3], "angular_velocity": [0.1, 1, 0.2]},
        "method": {"name": "preprocessed_variational", "order": 14}}


def program(*arguments, **environment):
    """Runs `stiefel-server` to its end."""
    return subprocess.run([SERVER, *arguments], stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=60,
                          env={**os.environ, **environment})


def refused_at_the_start(*arguments, listen="127.0.0.1:0"):
    """What `stiefel-server check` and the server itself, which both refuse these arguments, write to stderr."""
    said = []
    for command in (["check"], []):
        done = program(*command, *arguments, "--listen", listen)
        assert done.returncode == 1, done.stderr
        said.append(done.stderr)
    return said


class Process:
    """A running stiefel-server; `address` is the first that it listens on."""

    def __init__(self, *arguments, listen="127.0.0.1:0", descriptors=None, stack=None):
        def limit():
            for kind, pair in ((resource.RLIMIT_NOFILE, descriptors), (resource.RLIMIT_STACK, stack)):
                if pair:
                    resource.setrlimit(kind, pair)
        self.child = subprocess.Popen(
            [SERVER, "--listen", listen, "--exit-with-parent", *arguments],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
            preexec_fn=limit if descriptors or stack else None)  # with one, Python forks beside the threads of gRPC
        line = self.child.stdout.readline()
        assert line.startswith("listening on "), self.child.communicate()[1]
        self.address = line.split()[-1]

    def channel(self, **options):
        return grpc.insecure_channel(self.address, **options)

    def connect(self):
        """A connection as the kernel makes it, that has said nothing."""
        if self.address.startswith("unix:"):
            connection = socket.socket(socket.AF_UNIX)
            connection.connect(self.address[len("unix:"):])
            return connection
        host, port = self.address.rsplit(":", 1)
        return socket.create_connection((host, int(port)), timeout=10)

    def speaking(self):
        """A connection that the server took as HTTP/2: its SETTINGS have come."""
        connection = self.connect()
        connection.settimeout(10)
        connection.sendall(PREFACE)
        return connection, connection.recv(4096)

    def status(self, name):
        """A number of /proc/PID/status."""
        with open(f"/proc/{self.child.pid}/status", encoding="ascii") as status:
            return next(int(line.split()[1]) for line in status if line.startswith(f"{name}:"))

    def memory(self):
        """The largest resident size so far, in bytes. Not of a server with a sanitizer, whose own memory is most of it."""
        if SANITIZED:
            pytest.skip("the server has a sanitizer in it")
        return self.status("VmHWM") * 1024

    def resident(self):
        """The resident size now, in bytes; like `memory`."""
        if SANITIZED:
            pytest.skip("the server has a sanitizer in it")
        return self.status("VmRSS") * 1024

    def processor_seconds(self):
        """Processor time so far, to nanoseconds, which other programs on the machine do not change."""
        return time.clock_gettime(~self.child.pid << 3 | 2)

    def computes(self, seconds=0.1):
        """Waits until it has computed for that long, from now on."""
        before = self.processor_seconds()
        assert eventually(lambda: self.processor_seconds() >= before + seconds), "nothing is computed"

    def open_descriptors(self):
        return len(os.listdir(f"/proc/{self.child.pid}/fd"))

    def log(self):
        """Ends it and returns its log of --log-format json as objects."""
        self.stop()
        return [json.loads(line) for line in self.child.stderr]

    def stop(self):
        if self.child.poll() is None and not self.child.stdin.closed:
            self.child.stdin.close()
        try:
            return self.child.wait(60)
        finally:
            self.child.kill()


@pytest.fixture
def serve():
    """Starts servers that end with the test."""
    started = []

    def serve(*arguments, **more):
        started.append(Process(*arguments, **more))
        return started[-1]
    yield serve
    for process in started:
        process.stop()


def eventually(holds, seconds=120.0):
    """True as soon as `holds()` is. The limit is for what never comes: a busy machine is slow, and no test is a clock."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if holds():
            return True
        time.sleep(0.02)
    return False


def reason(error):
    """The reason in the details of an error of gRPC."""
    status, info = pb.Status.FromString(dict(error.trailing_metadata())["grpc-status-details-bin"]), pb.ErrorInfo()
    info.ParseFromString(status.details[0].value)
    return info.reason
