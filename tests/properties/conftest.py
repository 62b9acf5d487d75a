"""Provides one server for all properties, and the number of examples for each."""
import os
import zlib

import pytest
from hypothesis import HealthCheck, settings

import scenes
import stiefel

FORM = os.environ.get("HYPOTHESIS_PROFILE", "short")
_SAME_EVERY_TIME = dict(derandomize=True, database=None, deadline=None, print_blob=False,
                        suppress_health_check=list(HealthCheck))
settings.register_profile("short", max_examples=3, **_SAME_EVERY_TIME)
settings.register_profile("long", max_examples=20, **_SAME_EVERY_TIME)
settings.load_profile(FORM)


@pytest.fixture(scope="session")
def client():
    with stiefel.Server.start() as server, stiefel.Client(server.address) as client:
        yield client


def pytest_generate_tests(metafunc):
    """Parametrizes `pair` with every system, method and order that Describe lists. In the short form each test takes a
    fifth of the pairs, different tests different fifths."""
    if "pair" in metafunc.fixturenames:
        pairs = scenes.every_pair()
        if FORM == "short":
            pairs = pairs[zlib.crc32(metafunc.function.__name__.encode()) % 5::5]
        metafunc.parametrize("pair", pairs, ids=map(str, pairs))
