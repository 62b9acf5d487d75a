import sys
from pathlib import Path

import pytest

import stiefel
from stiefel._wire.connection import Connection

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "calls"))

# Tests that make calls of a blocking stub or channel, give a client to a sweep, look at the caller's place, or start another
# process.
BLOCKING = ("test_times_are_the_server_s", "test_no_answer_prints_more_than_three_lines", "test_a_wrong_request_names_its_field",
            "test_a_checkpoint_goes_on_with_the_same_bytes", "test_a_cancelled_call_ends_soon", "test_a_channel_of_the_callers",
            "test_no_thread_of_grpc_s_is_left_that_watches_a_closed_channel", "test_a_closed_connection_rests_no_more",
            "test_an_unknown_variable_is_warned_of_once", "test_tls_and_token_by_the_environment",
            "test_a_sweep_ends_at_a_time_too", "test_a_warning_is_of_the_line_that_called")


def pytest_addoption(parser):
    parser.addoption("--aio", action="store_true", help="run the tests through stiefel.aio")
    parser.addoption("--long", action="store_true", help="run the tests that are marked `long`, and no other")


def pytest_configure(config):
    config.addinivalue_line("markers", "long: a study of minutes, which make test-long runs")
    if config.getoption("--aio"):
        sys.path.insert(0, str(Path(__file__).parent / "aio"))
        import facade  # which needs greenlet

        stiefel.Client, stiefel.Session = facade.client, facade.session


def pytest_collection_modifyitems(config, items):
    items[:] = [item for item in items if bool(item.get_closest_marker("long")) == config.getoption("--long")]
    if config.getoption("--aio"):
        items[:] = [item for item in items if not item.name.startswith(BLOCKING)]


@pytest.fixture(scope="session")
def client():
    with stiefel.Server.start() as server, stiefel.Client(server.address) as client:
        yield client


@pytest.fixture
def without_pauses(monkeypatch):
    """A client makes the next attempt at once, and a few of them."""
    monkeypatch.setattr(Connection, "waits", False)
    monkeypatch.setattr(Connection, "rest", lambda connection, seconds, away=False: None)
