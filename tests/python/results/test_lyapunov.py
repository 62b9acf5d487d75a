"""Lyapunov exponents by the client: the numbers are those of the engine's tests; here is what the call promises."""
import numpy as np
import pytest

import stiefel
from fake import Breaks

INERTIA = np.array([1.0, 2, 5, 10])
BODY = {"system": "rigid_body", "method": {"name": "variational"}, "step": 0.1,
        "body": {"moments": [1, 2, 3], "angular_velocity": [0.3, 1, 0.2]}}


def geodesic(seed):
    random = np.random.default_rng(seed)
    Q = np.linalg.qr(random.normal(size=(len(INERTIA), 2)))[0].T
    V = random.normal(size=(2, len(INERTIA)))
    V -= (V @ Q.T + Q @ V.T) / 2 @ Q
    V /= np.sqrt(np.sum(V**2 * INERTIA))
    return {"system": "stiefel", "inertia": INERTIA, "step": 0.1, "method": {"name": "variational", "order": 4},
            "initial": {"Q": Q, "S": V * INERTIA}}


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


class BreaksAtCheckpoints(Breaks):
    """LyapunovSpectrum, whose first streams break when a checkpoint has come."""

    def __init__(self, call, streams):
        super().__init__(call, [])
        self.left, self.steps, self.checkpoints = streams, [], []

    def __iter__(self):
        stream = self.call(self.requests[-1])
        for message in stream:
            checkpoint = message.checkpoint
            yield message
            if self.left and checkpoint.data:
                self.left -= 1
                self.steps.append(checkpoint.step)
                self.checkpoints.append(checkpoint.data)
                stream.cancel()
                raise self


def test_a_broken_run_goes_on_from_its_checkpoints(client, monkeypatch, without_pauses):
    """It breaks at every checkpoint, before the last step and in the second motion."""
    to, options = 60_000, {"every": 10_000}
    with client.create(geodesic(1)) as session:
        whole = session.lyapunov(to=to, **options)
        breaks = BreaksAtCheckpoints(session._connection.stub.LyapunovSpectrum, 64)
        monkeypatch.setattr(session._connection.stub, "LyapunovSpectrum", breaks)
        again = session.lyapunov(to=to, **options)
    assert breaks.steps == sorted(breaks.steps) and 0 < breaks.steps[0] < to // 2
    before = sum(step < to - whole.interval for step in breaks.steps)
    assert before >= 10 and len(breaks.steps) - before >= 10 and len(breaks.requests) == len(breaks.steps) + 1
    assert [request.checkpoint for request in breaks.requests] == [b"", *breaks.checkpoints], "it goes on where it broke"
    assert again == whole and again.checkpoint == whole.checkpoint
    assert again.history.tobytes() == whole.history.tobytes()
    assert again.computed_steps >= whole.computed_steps


def test_what_cannot_be_is_refused(client):
    with client.create(BODY) as session:
        for arguments, field in (({"to": 10}, "to"), ({"to": 2000, "count": 0}, "count"), ({"to": 2000, "count": 7}, "count"),
                                 ({"to": 2000, "seed": -1}, "seed"), ({"to": 2000, "checkpoint": b"x"}, "checkpoint")):
            with pytest.raises(stiefel.InvalidArgument, match=field):
                session.lyapunov(**arguments)
    with client.create({**BODY, "method": {"name": "adaptive"}}) as session:
        with pytest.raises(stiefel.InvalidArgument, match="method"):
            session.lyapunov(to=2000)
