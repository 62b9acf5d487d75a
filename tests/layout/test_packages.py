"""docker/packages.sh with an apt-get and a dpkg of the test's own, which write down what they are asked."""
from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
LINES = [line.split() for line in (ROOT / "docker/packages.txt").read_text().splitlines() if line and line[0] != "#"]
ALL = {name for line in LINES for name in line[1:]}
DAEMONS = {line[1] for line in LINES if line[0] == "daemon"}
PROGRAMS = {
    "dpkg-query": 'for name; do :; done; grep -qx "$name" installed && printf installed',
    "apt-get": 'echo "$*" >> calls; case $1 in download) for name; do :; done; touch "$name.deb";; esac',
    "dpkg-deb": "case $1 in --field) echo 'adduser, libc6 (>= 2.36), libjs-moment, liblua5.4-0 (>= 5.4) | liblua' ;; *) mkdir -p usr/bin ;; esac",
    # Says of a name that others only provide that it is there, on stderr.
    "apt-cache": 'if grep -qx "$2" offered; then echo "Package: $2"; else echo "N: purely virtual" >&2; fi',
    "id": "echo 0",
}


@pytest.fixture
def packages(tmp_path):
    """Runs packages.sh and returns the lines of apt-get's arguments. `installed`: the packages that are there already.
    `offered`: those of which apt knows, where a line has several names; by default all."""
    (tmp_path / "docker").mkdir()
    (tmp_path / "bin").mkdir()
    for name in ("packages.sh", "packages.txt"):
        shutil.copy(ROOT / "docker" / name, tmp_path / "docker")
    for name, script in PROGRAMS.items():
        text = script.replace("installed &&", f"{tmp_path}/installed &&").replace("calls", f"{tmp_path}/calls").replace(
            "offered;", f"{tmp_path}/offered;")
        (tmp_path / "bin" / name).write_text(f"#!/bin/sh\n{text}\n")
        (tmp_path / "bin" / name).chmod(0o755)

    def run(*kinds, installed=(), offered=ALL):
        (tmp_path / "offered").write_text("\n".join(offered) + "\n")
        (tmp_path / "installed").write_text("\n".join(installed) + "\n")
        (tmp_path / "calls").write_text("")
        subprocess.run([tmp_path / "docker/packages.sh", *kinds], check=True, capture_output=True,
                       env={**os.environ, "PATH": f"{tmp_path}/bin:{os.environ['PATH']}"})
        return (tmp_path / "calls").read_text().splitlines()
    return run


def test_a_daemon_is_unpacked_and_not_installed(packages, tmp_path):
    calls = packages("build", "run", "test", "daemon")
    install, = [call.split() for call in calls if call.startswith("install")]
    assert DAEMONS and not DAEMONS & set(install) and {"g++", "python3-numpy", "libgtest-dev"} <= set(install)
    assert {"libc6", "liblua5.4-0"} <= set(install) and "libjs-moment" not in install, "the libraries of the daemons"
    assert {path.name for path in (tmp_path / "build/daemons").iterdir()} == DAEMONS
    assert not list(tmp_path.rglob("*.deb"))


def test_nothing_is_asked_for_what_is_there(packages):
    names = [*(line[-1] for line in LINES), "libc6", "liblua5.4-0"]
    packages("daemon")
    assert packages("build", "run", "test", "daemon", "runtime", installed=names) == []  # the daemons are unpacked


RELEASES = {"Debian 12": ["libgrpc++1.51", "libprotobuf32", "libspdlog1.10", "libssl3"],
            "Debian 13": ["libgrpc++1.51t64", "libprotobuf32t64", "libspdlog1.15", "libssl3t64"],
            "Ubuntu 24.04": ["libgrpc++1.51t64", "libprotobuf32t64", "libspdlog1.12", "libssl3t64"]}


@pytest.mark.parametrize("release", RELEASES)
def test_of_several_names_the_one_is_taken_that_apt_offers(packages, release):
    """Whatever the system calls itself: a derivative of Debian has the names of the release from which it comes."""
    assert {name for names in RELEASES.values() for name in names} == {name for line in LINES if len(line) > 2 for name in line[1:]}
    calls = packages("runtime", offered=RELEASES[release])
    install, = [call.split() for call in calls if call.startswith("install")]
    assert set(install) & {name for names in RELEASES.values() for name in names} == set(RELEASES[release])
    assert [call for call in calls if call.startswith("update")] == calls[:1], "what apt offers is known after an update"


def test_a_package_that_apt_does_not_offer_is_named(packages, tmp_path):
    with pytest.raises(subprocess.CalledProcessError) as failed:
        packages("runtime", offered=())
    assert "apt offers no package libgrpc++1.51t64|libgrpc++1.51" in failed.value.stderr.decode()
    assert not [call for call in (tmp_path / "calls").read_text().splitlines() if call.startswith("install")]


def test_make_run_configures_no_tests():
    """They need packages that `make run` does not install."""
    def configures(*targets):
        done = subprocess.run(["make", "--dry-run", "--always-make", *targets], cwd=ROOT, capture_output=True, text=True, check=True)
        return [line for line in done.stdout.splitlines() if "cmake --preset" in line]

    run, = configures("run")
    assert "--preset release -DSTIEFEL_TESTS=OFF " in run
    first, then = configures("test")
    assert first == run and "--preset release -DSTIEFEL_TESTS=ON " in then
    assert all("STIEFEL_TESTS" not in line for line in configures("sanitize"))
