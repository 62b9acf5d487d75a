"""Starts servers."""
import os

import pytest

import stiefel

LONG = os.environ.get("STIEFEL_EXTREMES") == "long"
SANITIZED = "STIEFEL_SANITIZED" in os.environ  # whether the server is built with a sanitizer, which takes memory


@pytest.fixture(scope="session")
def server():
    with stiefel.Server.start(arguments=["--threads", "2"]) as server:
        yield server


@pytest.fixture(scope="session")
def client(server):
    with stiefel.Client(server.address, timeout=None) as client:
        yield client
