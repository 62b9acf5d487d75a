"""Euler angles and their rates as fields: beside SciPy's sequences, along a run, at gimbal lock, in events."""
import itertools

import numpy as np
import pytest

import scenes
import stiefel

SEQUENCES = ["".join(letters) for axes in ("XYZ", "xyz") for letters in itertools.product(axes, repeat=3)
             if letters[0] != letters[1] != letters[2]]
BODY = {**scenes.body(moments=[1, 2, 3], attitude=[0.5, 0.1, -0.7, 0.5], angular_velocity=[0.8, -0.5, 0.9]),
        "method": {"name": "exact"}, "step": 0.01}


def test_are_those_of_scipy_and_their_rates_the_derivatives(client):
    Rotation = pytest.importorskip("scipy.spatial.transform", reason="python3-scipy is not installed").Rotation
    assert len(SEQUENCES) == 24
    names = [f"euler_{kind}_{sequence}" for sequence in SEQUENCES for kind in ("angles", "rates")]
    with client.create(BODY) as session:
        run = session.trajectory(to=400, every=1, fields=["quaternion", *names])
        step = session.step(to=3, fields=["euler_angles_ZXZ"])["euler_angles_ZXZ"]
    assert np.array_equal(step.ravel(), run["euler_angles_ZXZ"][3].ravel())
    attitude = Rotation.from_quat(run["quaternion"][:, [1, 2, 3, 0]])
    for sequence in SEQUENCES:
        angles, rates = (np.asarray(run[f"euler_{kind}_{sequence}"]).reshape(-1, 3) for kind in ("angles", "rates"))
        expected = attitude.as_euler(sequence)
        off = (angles - expected + np.pi) % (2 * np.pi) - np.pi
        assert abs(off).max() < 1e-11 and abs(angles).max() <= np.pi, sequence
        middle = expected[:, 1]
        far = abs(np.sin(middle) if sequence[0] == sequence[2] else np.cos(middle)) > 0.3
        f = np.unwrap(angles, axis=0)
        slope = (8 * (f[3:-1] - f[1:-3]) - (f[4:] - f[:-4])) / 0.12
        calm = far[2:-2] & far[:-4] & far[4:]
        assert calm.sum() > 50 and abs(slope - rates[2:-2])[calm].max() < 1e-5, sequence


@pytest.mark.parametrize("sequence, angles, expected", [("ZXZ", [0.3, 0, 0.4], [0.7, 0, 0]), ("zxz", [0.3, 0, 0.4], [0.7, 0, 0]),
                                                        ("XYZ", [0.3, np.pi / 2, 0.4], [0.7, np.pi / 2, 0]),
                                                        ("xyz", [0.3, np.pi / 2, 0.4], [-0.1, np.pi / 2, 0])])
def test_the_third_is_0_at_gimbal_lock_and_rates_are_finite(client, sequence, angles, expected):
    Rotation = pytest.importorskip("scipy.spatial.transform", reason="python3-scipy is not installed").Rotation
    attitude = Rotation.from_euler(sequence, angles).as_quat()[[3, 0, 1, 2]]
    scene = {**BODY, "body": {**BODY["body"], "attitude": attitude}}
    with client.create(scene) as session:
        at = session.step(to=0, fields=[f"euler_angles_{sequence}", f"euler_rates_{sequence}"])
    np.testing.assert_allclose(at[f"euler_angles_{sequence}"].ravel(), expected, rtol=0, atol=1e-7)
    rates = at[f"euler_rates_{sequence}"].ravel()
    assert np.isfinite(rates).all() and abs(rates[[0, 2]]).max() > 1e7 and abs(rates[1]) < 2


def test_events_do_not_take_the_jump_for_a_zero(client):
    """A symmetric body about the vertical: the first angle grows evenly, phi = 2 t - 1, and passes pi many times."""
    scene = {"system": "rigid_body", "step": 0.1, "body": {"moments": [1, 1, 2], "attitude": [np.cos(0.5), 0, 0, -np.sin(0.5)],
                                                           "angular_velocity": [0, 0, 2]}}
    with client.create(scene) as session:
        for level in (0.0, 0.7, 3.1, np.pi, -3.1):
            event = {"field": "euler_angles_ZYX", "coefficients": [-1.5, 0, 0], "level": -1.5 * level}
            found = session.events(1000, [event, {**event, "direction": "rising"}], fields="euler_angles_ZYX")
            expected = ((level + 1) % (2 * np.pi) + 2 * np.pi * np.arange(32)) / 2
            expected = expected[(expected > 0) & (expected <= 100)]
            assert found.time == pytest.approx(expected, rel=1e-12), level
            assert (found.event == 0).all()


def test_are_there_for_every_member_and_in_every_call(client):
    one, other = BODY["body"], {**BODY["body"], "angular_velocity": [0.1, 0.9, -0.4]}
    both = {name: np.array([one[name], other[name]], float) for name in one}
    with client.create({**BODY, "body": both, "members": 2}) as session:
        run = session.trajectory(to=30, fields=["euler_angles_zyx"])
        last = session.summarize(30, {"euler_angles_zyx": ["last", "min"]})["euler_angles_zyx"]["last"]
        at = session.trajectory(times=[0.105], fields=["euler_angles_zyx", "euler_rates_XYX"])
    assert np.asarray(run["euler_angles_zyx"]).size == len(run.step) * 2 * 3
    assert np.array_equal(np.ravel(last), np.ravel(run["euler_angles_zyx"][-1]))
    assert np.asarray(at["euler_rates_XYX"]).size == 6
    with client.create({**BODY, "body": other}) as session:
        alone = session.trajectory(to=30, fields=["euler_angles_zyx"])["euler_angles_zyx"]
    assert np.array_equal(np.reshape(run["euler_angles_zyx"], (-1, 2, 3))[:, 1], np.reshape(alone, (-1, 3)))


@pytest.mark.parametrize("name", ["euler_angles_ZZX", "euler_angles_Zxz", "euler_rates_XY", "euler_angles_ABC"])
def test_an_unknown_sequence_is_refused_with_the_fields_that_are_taken(client, name):
    with client.create(BODY) as session:
        with pytest.raises(stiefel.InvalidArgument, match="euler_angles_SEQUENCE") as refused:
            session.step(to=1, fields=[name])
        assert name in str(refused.value)
        with pytest.raises(stiefel.InvalidArgument, match="euler_angles_SEQUENCE"):
            session.events(10, {"field": name, "coefficients": [1, 0, 0]})
    with client.create(scenes.rigid_body(initial={"M": scenes.M3})) as session:  # which has no attitude
        with pytest.raises(stiefel.InvalidArgument, match="must be one of M, Omega, angular_velocity"):
            session.step(to=1, fields=["euler_angles_ZXZ"])


def test_two_angles_that_jump_need_equal_coefficients(client):
    with client.create(BODY) as session:
        session.events(10, {"field": "euler_angles_ZXZ", "coefficients": [1, 3, -1]})
        with pytest.raises(stiefel.InvalidArgument, match=r"coefficients.*must be 0 or, without its sign, 1"):
            session.events(10, {"field": "euler_angles_ZXZ", "coefficients": [1, 0, 2]})
