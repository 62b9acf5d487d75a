"""Provides the server of the suite: the one at STIEFEL_ADDRESS, or one that the suite starts."""
import os

import pytest

import stiefel


@pytest.fixture(scope="session")
def address():
    given = os.environ.get("STIEFEL_ADDRESS")
    if given:
        yield given
        return
    with stiefel.Server.start() as server:
        yield server.address


@pytest.fixture(scope="session")
def client(address):
    with stiefel.Client(address, timeout=600) as client:  # the default of 60 s is short on a busy machine
        yield client


@pytest.fixture
def other(address):
    """A client of a second server process of the same build."""
    if os.environ.get("STIEFEL_ADDRESS"):
        pytest.skip("needs a second server of the same build")
    with stiefel.Server.start() as server, stiefel.Client(server.address, timeout=600) as client:
        yield client
