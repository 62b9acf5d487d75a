"""What `log_to_rerun` logs, read back by Rerun: a trajectory, a stream batch by batch, an ensemble, and a frame."""
from __future__ import annotations

import os
import subprocess

import pytest
import tools

SCRIPT = """
import sys
import numpy as np
import rerun
from rerun.chunk import RrdReader
import stiefel

recording = rerun.RecordingStream("stiefel_test")
recording.save("run.rrd")
three = {"system": "rigid_body", "members": 3, "step": 0.1, "body": {"moments": [3, 1, 2], "angular_velocity": np.eye(3) + 0.1}}
with stiefel.Server.start() as server, stiefel.Client(server.address) as client:
    with client.create("envisat") as session:
        run = session.trajectory(to=30, fields=["quaternion", "angular_velocity", "Q", "M", "momentum_space"])
        run.log_to_rerun(recording=recording)
        for batch in session.stream(to=30):
            batch.log_to_rerun(session.scene, entity="stream", recording=recording)
    with client.create(three) as session:
        many = session.trajectory(to=20, fields=["quaternion", "angular_velocity"])
        many.log_to_rerun(entity="many", recording=recording)
    with client.create("stiefel") as session:
        frames = session.trajectory(to=20)
        frames.log_to_rerun(entity="frame", recording=recording)
recording.flush()
recording.disconnect()

parts = {}
for chunk in RrdReader("run.rrd").stream():
    batch = chunk.to_record_batch()
    for name, values in zip(batch.schema.names, batch.columns):
        parts.setdefault((chunk.entity_path, name), []).extend(values.to_pylist())

# The columns of a matrix come one after another. The box's axes are principal, so that the tensor is diagonal in them.
turned = np.array([value[0] for value in parts["/stiefel/body", "Transform3D:mat3x3"]]).reshape(-1, 3, 3).transpose(0, 2, 1)
xx, yy, zz, xy, xz, yz = run.scene["body"]["inertia_tensor"]
tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
axes = np.einsum("sji,sjk->sik", run["Q"], turned)
assert np.allclose(np.linalg.det(turned), 1, atol=1e-6) and np.allclose(axes, axes[0], atol=1e-6)
principal = axes[0].T @ tensor @ axes[0]
assert abs(principal - np.diag(np.diag(principal))).max() < 1e-2 * principal.max() and (np.diff(np.diag(principal)) > 0).all()
momentum = np.array([value[0] for value in parts["/stiefel/momentum", "Arrows3D:vectors"]])
expected = 1.4 * run["momentum_space"] / np.linalg.norm(run["momentum_space"], axis=1, keepdims=True)
assert np.allclose(momentum, expected, atol=1e-5)
assert parts["/stiefel/body", "step"] == list(range(31))
assert [one.total_seconds() for one in parts["/stiefel/body", "time"]] == run.time.tolist()
for name in ("quaternion", "angular_velocity", "Q"):
    logged = np.array(parts[f"/stiefel/fields/{name}", "Scalars:scalars"])
    assert np.array_equal(logged, run[name].reshape(31, -1)), name
assert parts["/stream/body", "Transform3D:mat3x3"] == parts["/stiefel/body", "Transform3D:mat3x3"]
for member in range(3):
    logged = np.array(parts[f"/many/{member}/fields/angular_velocity", "Scalars:scalars"])
    assert np.array_equal(logged, many["angular_velocity"][:, member])
assert np.allclose(np.array(parts["/frame/frame", "Arrows3D:vectors"]), frames["Q"][:, :, :3], atol=1e-6)
print("read back")
"""


@pytest.fixture(scope="session")
def python():
    return tools.from_pypi("rerun") / "python"


def test_what_is_logged_is_read_back(python, tmp_path):
    done = subprocess.run([python, "-c", SCRIPT], cwd=tmp_path, capture_output=True, text=True, timeout=300,
                          env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1"})
    assert done.returncode == 0 and done.stdout == "read back\n", done.stderr
