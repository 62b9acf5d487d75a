"""Lyapunov exponents by the client: the numbers are those of the engine's tests; here is what the call promises."""
import numpy as np
import pytest

import stiefel

BODY = {"system": "rigid_body", "method": {"name": "variational"}, "step": 0.1,
        "body": {"moments": [1, 2, 3], "angular_velocity": [0.3, 1, 0.2]}}


def test_numbers_on_the_way_and_a_regular_body(client):
    with client.create(BODY) as session:
        found = session.lyapunov(to=20_000, every=4000, count=2)
        assert found.verdict is stiefel.Verdict.REGULAR, found.reason
        assert found.history.shape == (5, 2) and found.log_gali_history.shape == (5, 1)
        assert found.steps[-1] == 20_000 and (found.steps[:-1] % found.interval == 0).all()
        assert (found.steps[:-1] - 4000 * np.arange(1, 5) < found.interval).all()
        np.testing.assert_allclose(found.times, found.steps * 0.1)
        half = session.lyapunov(to=int(found.steps[1]), count=2)
        assert (half.exponents == found.history[1]).all() and (half.log_gali == found.log_gali_history[1]).all()


def test_what_cannot_be_is_refused(client):
    with client.create(BODY) as session:
        for arguments, field in (({"to": 10}, "to"), ({"to": 2000, "count": 0}, "count"), ({"to": 2000, "count": 7}, "count"),
                                 ({"to": 2000, "seed": -1}, "seed"), ({"to": 2000, "checkpoint": b"x"}, "checkpoint")):
            with pytest.raises(stiefel.InvalidArgument, match=field):
                session.lyapunov(**arguments)
    with client.create({**BODY, "method": {"name": "adaptive"}}) as session:
        with pytest.raises(stiefel.InvalidArgument, match="method"):
            session.lyapunov(to=2000)
