"""The Python client of the commit before this one works with the server of this one."""
import os
import shutil
import subprocess
import sys
import tarfile
from io import BytesIO
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PROGRAM = """
import sys
import stiefel

scene = {"system": "rigid_body", "step": 0.05,
         "body": {"moments": [1, 2, 3], "angular_velocity": [0.001, 1, 0.001]}}
with stiefel.Client(sys.argv[1]) as client:
    assert [system.name for system in client.describe().systems]
    with client.create(scene) as session:
        run = session.trajectory(to=100, every=10, fields=["angular_velocity", "quaternion"])
        assert run.outcome == "REACHED" and run["quaternion"].shape == (11, 1, 4)
        assert (session.step(to=100, fields=["quaternion"])["quaternion"] == run["quaternion"][-1]).all()
        assert max(i.drift for i in session.diagnose(to=100, invariants=["energy"]).invariants) < 1e-13
        with session.fork(at=50) as fork, session.drive() as drive:
            assert drive.step(3).step == 3 and fork.step(to=1).step == 1
        state = session.step(to=7, checkpoint=True)
        with client.create(session.scene, checkpoint=state.checkpoint) as again:
            assert again.step(to=7) == state
    assert client.convert(scene, "symmetric_rigid_body").scene["system"] == "symmetric_rigid_body"
    try:
        client.create({**scene, "step": 0})
    except stiefel.InvalidArgument as error:
        assert error.violations[0].field == "scene.step"
    else:
        raise AssertionError("a step of 0 was taken")
print(stiefel.__file__)
"""


@pytest.fixture(scope="module")
def package(tmp_path_factory):
    """The package of the commit before, its stubs generated from that commit's proto files."""
    protoc, plugin = shutil.which("protoc"), shutil.which("grpc_python_plugin")
    archive = subprocess.run(["git", "-C", ROOT, "archive", "HEAD~1", "client/python", "proto"], capture_output=True)
    if archive.returncode != 0 or not protoc or not plugin:
        pytest.skip("needs the commit before this one, protoc and grpc_python_plugin")
    folder = tmp_path_factory.mktemp("last")
    with tarfile.open(fileobj=BytesIO(archive.stdout)) as files:
        files.extractall(folder)
    python, protos = folder / "client/python", folder / "proto"
    names = [str(path.relative_to(protos)) for path in protos.glob("stiefel/v1/*.proto")]
    subprocess.run([protoc, f"-I{protos}", f"--python_out={python}", f"--grpc_python_out={python}",
                    f"--plugin=protoc-gen-grpc_python={plugin}", *names], check=True)
    version = python / "version.py.in"
    if version.exists():
        (python / "stiefel/version.py").write_text(version.read_text())
    return python


def test_the_client_of_the_last_commit(package, client):
    environment = {**os.environ, "PYTHONPATH": str(package)}
    done = subprocess.run([sys.executable, "-c", PROGRAM, client.address], env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == str(package / "stiefel/__init__.py")
