"""Bodies without method or tolerance at the hardest places: next to the middle axis, moments that no body has, nearly
symmetric. The right values in hard_bodies.json are Taylor series in 50 digits."""
import json
from pathlib import Path

import numpy as np
import pytest

BODIES = json.loads(Path(__file__).with_name("hard_bodies.json").read_text(encoding="utf-8"))


def numbers(texts):
    return np.array([float(text) for text in texts])


def errors(session, right, moments=1.0):
    """The relative error of the angular velocity, or of the momentum if `moments` are given, and the error of the quaternion
    up to its sign."""
    now = session.step(to=right["step"], fields=["angular_velocity", "quaternion"])
    omega, q = numbers(right["angular_velocity"]) * moments, numbers(right["quaternion"])
    found = now["quaternion"].ravel()
    return (abs(now["angular_velocity"].ravel() * moments - omega).max() / abs(omega).max(),
            abs(found * np.sign(found @ q) - q).max())


@pytest.mark.parametrize("body", BODIES, ids=[body["name"] for body in BODIES])
def test_the_recommended_method_is_right_to_the_last_bits(client, body):
    with client.create({"system": "rigid_body", "step": body["step"], "body": body["body"]}) as session:
        # Omega is computed from M by sums of Lambda, which cancel where a moment is far below the others.
        moments = np.array(body["body"]["moments"])
        for right in body["right"]:
            omega, q = errors(session, right)
            assert omega < 1e-15 * max(1, moments.max() / moments.min() / 3) and q < 1e-15


@pytest.mark.parametrize("tolerance", [1e-3, 1e-6, 1e-9, 1e-12])
@pytest.mark.parametrize("body", BODIES, ids=[body["name"] for body in BODIES])
def test_a_choice_stays_within_its_tolerance(client, body, tolerance):
    horizon = body["right"][-1]["step"] * body["step"]
    scene = {"system": "rigid_body", "step": body["step"], "body": body["body"], "tolerance": tolerance, "horizon": horizon}
    with client.create(scene) as session:
        assert session.choice.error <= tolerance
        for right in body["right"]:
            # A rotation by a small angle a changes the quaternion by a/2 and an element of Q by a/2 or more.
            assert max(errors(session, right, np.array(body["body"]["moments"]))) < tolerance
