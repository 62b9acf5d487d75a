"""What the client does for large scenes and frames, counted: its work in Python does not grow with their numbers."""
import cProfile
import gc
import pickle

import numpy as np
import pytest

import stiefel
from stiefel.manifold import Stiefel

SCENE = {"system": "rigid_body", "step": 0.01, "method": {"name": "variational"}}


def attitudes(members):
    q = np.random.default_rng(1).normal(size=(members, 4))
    return q / np.linalg.norm(q, axis=1, keepdims=True)


FORMS = {
    "body": lambda B: {"body": {"moments": [1, 2, 3], "attitude": attitudes(B), "angular_velocity": np.ones((B, 3))}},
    "moments": lambda B: {"body": {"moments": np.tile([1, 2, 3], (B, 1)), "angular_velocity": np.ones((B, 3))}},
    "space": lambda B: {"body": {"moments": [1, 2, 3], "attitude": attitudes(B), "frame": "space", "angular_momentum": np.ones((B, 3))}},
    "blocks": lambda B: {"inertia": [3, 2, 1], "initial": {"M": np.tile(np.tri(3) - np.tri(3).T, (B, 1, 1))}},
}


def calls(function, *arguments):
    profile = cProfile.Profile()
    gc.collect()
    gc.disable()  # what it calls back is no work of the function
    result = profile.runcall(function, *arguments)
    gc.enable()
    return result, sum(entry.callcount for entry in profile.getstats())


@pytest.mark.parametrize("form", FORMS)
def test_the_members_of_an_ensemble_cost_no_call_each(form):
    counts = []
    for B in (20, 20, 20_000):  # the first call imports
        message, given = calls(stiefel.to_message, {**SCENE, "members": B, **FORMS[form](B)})
        description, written = calls(stiefel.to_dict, message)
        counts.append(given + written)
    assert counts[2] < counts[1] + 100
    assert len(np.ravel(description.get("initial", description.get("body"))[{"blocks": "M"}.get(form, "angular_velocity")])) >= 3 * B


@pytest.mark.parametrize("metric", ["euclidean", "canonical"])
def test_the_columns_of_frames_cost_no_call_each(client, metric, monkeypatch):
    sent = []
    call_all = client._connection.call_all
    monkeypatch.setattr(client._connection, "call_all", lambda rpc, request, timeout: sent.append(request.ByteSize()) or call_all(rpc, request, timeout))
    counts = []
    for N in (100, 10_000):
        manifold = Stiefel(3, N)
        Q = manifold.random(seed=1)
        P = manifold.exp(Q, 0.5 * manifold.random_tangent(Q, seed=2))
        for _ in range(2):  # the first call imports
            (found,), count = calls(lambda: client.geodesics([(Q, P)], metric=metric))
        counts.append(count)
    assert counts[1] < counts[0] + 100 and sent[-1] == sent[1] < 2000
    assert found.velocity.shape == (3, 10_000) and pickle.loads(pickle.dumps(found)) == found
    if metric == "euclidean":
        assert np.shape(found.scene["initial"]["Q"]) == (3, 10_000) and found.scene["inertia"] == [1.0] * 10_000
