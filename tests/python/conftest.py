import sys
from pathlib import Path

import pytest

import stiefel
from stiefel._wire.connection import Connection

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "calls"))


def pytest_addoption(parser):
    parser.addoption("--long", action="store_true", help="run the tests that are marked `long`, and no other")


def pytest_configure(config):
    config.addinivalue_line("markers", "long: a study of minutes, which make test-long runs")


def pytest_collection_modifyitems(config, items):
    items[:] = [item for item in items if bool(item.get_closest_marker("long")) == config.getoption("--long")]


@pytest.fixture(scope="session")
def client():
    with stiefel.Server.start() as server, stiefel.Client(server.address) as client:
        yield client


@pytest.fixture
def without_pauses(monkeypatch):
    """A client makes the next attempt at once, and a few of them."""
    monkeypatch.setattr(Connection, "waits", False)
    monkeypatch.setattr(Connection, "rest", lambda connection, seconds, away=False: None)
