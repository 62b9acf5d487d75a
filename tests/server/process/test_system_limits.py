"""What the system gives a process: stacks, threads, address space."""
import os
import resource
import shutil
import subprocess
import tempfile

import numpy as np
import pytest

import stiefel
from conftest import SANITIZED

SERVER = os.environ["STIEFEL_SERVER"]
NOBODY = 61_733  # a user without processes, so that RLIMIT_NPROC counts this test's alone

pytestmark = pytest.mark.skipif(SANITIZED, reason="a sanitizer takes address space and stacks of its own")


def body(N, method):
    A = np.random.default_rng(N).normal(size=(N, N)) / N
    return {"system": "rigid_body", "inertia": list(1 + np.arange(N) / N), "step": 1e-3, "method": {"name": method},
            "initial": {"Q": np.eye(N), "M": A - A.T}}


@pytest.fixture(scope="module")
def public_server():
    """A copy of the program where every user reaches it: the build tree may be in a home of mode 0700."""
    with tempfile.TemporaryDirectory(dir="/tmp") as folder:
        os.chmod(folder, 0o755)
        os.chmod(shutil.copy(SERVER, folder), 0o755)
        yield os.path.join(folder, os.path.basename(SERVER))


def limited(limits, *arguments, program=SERVER, user=None):
    """Starts a server with these (resource, number) limits."""
    def prepare():
        if user:
            os.setgid(user)
            os.setuid(user)
        for one, number in limits:
            resource.setrlimit(one, (number, number))
    return subprocess.Popen([program, "--listen", "127.0.0.1:0", "--exit-with-parent", "--log-level", "warn", *arguments],
                            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                            preexec_fn=prepare)


@pytest.mark.parametrize("kilobytes", [128, 1024])
def test_small_stacks_are_enough(kilobytes, tmp_path):
    """`ulimit -s`: Eigen puts up to 4 MiB on the stack of a thread. The second server restores the sessions."""
    for restored in (False, True):
        child = limited([(resource.RLIMIT_STACK, kilobytes * 1024)], "--store", str(tmp_path / "store"))
        try:
            line = child.stdout.readline()
            assert line.startswith("listening on "), child.communicate()[1]
            with stiefel.Client(line.split()[-1]) as client:
                for N, method in ((256, "rk4"), (256, "variational"), (512, "rk4")):
                    id = f"{method}-{N}"
                    session = client.get(id) if restored else client.create(body(N, method), id=id)
                    assert session.step(to=1).step == 1
            assert child.poll() is None
        finally:
            child.communicate()
        assert child.returncode == 0


def is_refused(child, reason):
    out, err = child.communicate(timeout=60)
    assert (child.returncode, out) == (1, ""), err
    assert err.startswith("stiefel-server: cannot start: ") and reason in err and err.count("\n") == 1, err


@pytest.mark.parametrize("megabytes", [60, 150, 280])
def test_without_address_space_it_says_why_it_does_not_start(megabytes):
    is_refused(limited([(resource.RLIMIT_AS, megabytes << 20)]), f"ulimit -v: {megabytes << 20}")


@pytest.mark.skipif(os.getuid() != 0, reason="to become a user without processes needs root")
@pytest.mark.parametrize("threads", [1, 5, 20])
def test_without_threads_it_says_why_it_does_not_start(threads, public_server):
    is_refused(limited([(resource.RLIMIT_NPROC, threads)], program=public_server, user=NOBODY), f"ulimit -u: {threads}")


def test_check_finds_the_same():
    def prepare():
        resource.setrlimit(resource.RLIMIT_AS, (150 << 20, 150 << 20))
    done = subprocess.run([SERVER, "check", "--listen", "127.0.0.1:0"], capture_output=True, text=True, preexec_fn=prepare)
    assert done.returncode == 1 and "--threads: the system gives " in done.stderr
