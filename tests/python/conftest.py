import pytest

import stiefel
from stiefel._wire.connection import Connection


@pytest.fixture(scope="session")
def client():
    with stiefel.Server.start() as server, stiefel.Client(server.address) as client:
        yield client


@pytest.fixture
def without_pauses(monkeypatch):
    """A client makes the next attempt at once."""
    monkeypatch.setattr(Connection, "rest", lambda connection, seconds: None)
