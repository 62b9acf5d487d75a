"""`method.scalar`: "double", or "float" where the catalogue offers it."""
import numpy as np

import scenes

BODY = scenes.free(3, 1, "variational")


def in_float(scene):
    return {**scene, "method": {**scene["method"], "scalar": "float"}}


def test_a_float_stays_near_the_double(client):
    with client.create(BODY) as double, client.create(in_float(BODY)) as single:
        assert double.scene["method"]["scalar"] == "double"
        assert single.scene["method"]["scalar"] == "float"
        one, other = single.step(50), double.step(50)
        for name, values in one.fields.items():
            np.testing.assert_allclose(values, other[name], atol=2e-5)
        assert not np.array_equal(one["Q"], other["Q"])
        assert {values.dtype for values in one.fields.values()} == {np.dtype("float32")}
        samples = single.trajectory(to=50)
        assert {values.dtype for values in samples.fields.values()} == {np.dtype("float32")}
        np.testing.assert_array_equal(samples["Q"][-1], one["Q"])


def test_a_fork_changes_the_scalar(client):
    with client.create(BODY) as session:
        session.step(10)
        with session.fork(at=10, method={"name": "variational", "scalar": "float"}) as fork:
            assert fork.scene["method"]["scalar"] == "float"
            np.testing.assert_allclose(fork.step(10)["M"], session.step(20)["M"], atol=1e-5)
