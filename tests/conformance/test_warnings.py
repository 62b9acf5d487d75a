"""What is accepted with a warning: moments that no rigid body has, and steps of more than half a turn."""
import re
import warnings

import numpy as np
import pytest

import scenes
import stiefel


def texts(client, scene):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        with client.create(scene) as session:
            said = list(session._message.warnings)
            again = list(client.get(session.id)._message.warnings)
    assert said == again == [str(w.message) for w in caught]
    assert all(w.category is stiefel.SceneWarning for w in caught)
    return said


def inertia(*lam, **changes):
    N = len(lam)
    A = np.random.default_rng(1).standard_normal((N, N))
    return scenes.rigid_body(inertia=list(lam), method={"name": "rk4"}, initial={"Q": np.eye(N), "M": A - A.T}, **changes)


@pytest.mark.parametrize("moments, text", [
    ([1, 0.5, 2], "I1 + I2 = 1.5 < I3 = 2: no rigid body has these moments; are all three in one unit?"),
    ([7, 1, 2.5], "I2 + I3 = 3.5 < I1 = 7: no rigid body has these moments; are all three in one unit?"),
    ([0.25, 4, 0.5], "I1 + I3 = 0.75 < I2 = 4: no rigid body has these moments; are all three in one unit?"),
])
def test_moments_that_break_the_triangle_inequality(client, moments, text):
    assert texts(client, scenes.body(moments=moments)) == [text]


def test_a_tensor_is_judged_by_its_principal_moments(client):
    R = np.linalg.qr(np.random.default_rng(2).standard_normal((3, 3)))[0]
    tensor = lambda I: [(R * I @ R.T)[i] for i in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
    [text] = texts(client, scenes.body(moments=None, inertia_tensor=tensor([1.0, 2.0, 3.5])))
    assert text.startswith("I1 + I2 = ") and text.endswith(
        "no rigid body has these moments; are all six entries in one unit, and the products those of the matrix, Ixy = -∫ xy dm?")
    sum_, _, rest = text.removeprefix("I1 + I2 = ").partition(" < I3 = ")
    assert float(sum_) == pytest.approx(3) and float(rest.partition(":")[0]) == pytest.approx(3.5)
    assert texts(client, scenes.body(moments=None, inertia_tensor=tensor([1.0, 2.0, 2.9]))) == []


@pytest.mark.parametrize("moments", [[1, 2, 3], [0.1, 0.7, 0.8], [0.7, 0.1, 0.7 + 0.1], [1e-30, 2e-30, 3e-30], [2, 2, 2],
                                     [1, 1, 0.001]])
def test_bodies_that_exist(client, moments):
    """Bodies that exist get no warning, even flat ones, for which a moment is the sum of the others up to rounding."""
    assert texts(client, scenes.body(moments=moments)) == []


def test_a_flat_tensor(client):
    for seed in range(5):
        R = np.linalg.qr(np.random.default_rng(seed).standard_normal((3, 3)))[0]
        I = R * [1.3, 2.9, 1.3 + 2.9] @ R.T
        given = [I[i] for i in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
        assert texts(client, scenes.body(moments=None, inertia_tensor=given)) == []


def test_negative_lambda(client):
    assert texts(client, inertia(2.0, 1.0, -0.25)) == [
        "lambda3 = -0.25 < 0, I1 + I2 = 2.5 < I3 = 3: no rigid body has these moments"]
    assert texts(client, inertia(2.0, 1.0, 0.0)) == []
    assert texts(client, inertia(1.0, -0.5, 2.0, 3.0)) == [
        "lambda2 = -0.5 < 0: no rigid body has this second moment of mass"]
    assert texts(client, scenes.moser_veselov()) == []


def test_members_of_an_ensemble(client):
    scene = scenes.BIT_SCENES["ensemble"]
    assert texts(client, scene) == []
    every = np.tile([2.5, 1.5, 0.5], (5, 1))
    every[3] = every[4] = [2.5, 1.5, -0.5]
    assert texts(client, {**scene, "inertia": every}) == [
        "member 3: lambda3 = -0.5 < 0, I1 + I2 = 3 < I3 = 4: no rigid body has these moments "
        "(2 members have a warning like this)"]


def turning(omega, step, **changes):
    return {**scenes.body(angular_velocity=omega, attitude=None, **changes), "step": step}


@pytest.mark.parametrize("omega, step, degrees", [
    ([31, -8, 52], 0.1, 350), ([31, -8, 52], -1, 3500), ([0, 0, 3.15], 1, 180), ([0, 2, 0], 86400, 9.9e6), ([1e-3, 0, 0], 4e3, 229)])
def test_a_step_of_more_than_half_a_turn(client, omega, step, degrees):
    """|omega| |step| in degrees, as where an angular velocity was given in degrees a second."""
    assert degrees == pytest.approx(np.degrees(np.linalg.norm(omega) * abs(step)), rel=1e-2)
    [text] = [text for text in texts(client, turning(omega, step)) if "separatrix" not in text]
    found = re.fullmatch(r"a step of (\S+) s turns the body by (\S+) degrees: more than half a turn; angular_velocity is in rad/s", text)
    assert float(found[1]) == step and float(found[2]) == round(np.degrees(np.linalg.norm(omega) * abs(step)))


@pytest.mark.parametrize("omega, step", [([31, -8, 52], 0.05), ([0, 0, 3.14], 1), ([0, 0, 0], 1e9), ([0, 2, 0], -1.5)])
def test_a_step_of_up_to_half_a_turn(client, omega, step):
    assert [text for text in texts(client, turning(omega, step)) if "separatrix" not in text] == []


def test_members_that_turn_too_far(client):
    velocities = np.array([[0, 0, 1], [0, 0, 4], [0, 0, 2], [5, 0, 0]])
    [text] = texts(client, {**turning(velocities, 1.0), "members": 4})
    assert text == ("member 1: a step of 1 s turns the body by 229 degrees: more than half a turn; angular_velocity is in rad/s "
                    "(2 members have a warning like this)")
    both = texts(client, {**turning(velocities, 1.0, moments=[1, 1, 3]), "members": 4})
    assert len(both) == 2 and both[0].startswith("member 0: I1 + I2 = 2 < I3 = 3") and both[1] == text


def test_a_motion_next_to_a_separatrix_is_warned_of_unless_it_is_exact(client):
    near = {"system": "rigid_body", "step": 0.05, "body": {"moments": [1, 2, 3], "angular_velocity": [1e-6, 1, 1e-6]}}
    assert texts(client, near) == []  # the recommended method is the closed form
    [text] = texts(client, {**near, "method": {"name": "preprocessed_variational"}})
    assert text.startswith("the motion is next to a separatrix: 1 - k^2 = 2") and "other than exact" in text
    assert texts(client, {**near, "body": {"moments": [1, 2, 3], "angular_velocity": [0.1, 1, 0.1]},
                          "method": {"name": "preprocessed_variational"}}) == []


def test_a_member_next_to_a_separatrix_gets_the_closed_form_and_is_named(client):
    scene = {"system": "rigid_body", "step": 0.05, "members": 3,
             "body": {"moments": [1, 2, 3], "angular_velocity": [[1, 1, 1], [1e-9, 1, 1e-9], [0.1, 1, 0.1]]}}
    [text] = texts(client, scene)
    assert text.startswith("member 1: the motion is next to a separatrix")
    with client.create(scene) as session:
        assert session.scene["method"]["name"] == "exact"
