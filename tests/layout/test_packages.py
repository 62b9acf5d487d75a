"""docker/packages.sh with an apt-get and a dpkg of the test's own, which write down what they are asked."""
from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
LINES = [line.split() for line in (ROOT / "docker/packages.txt").read_text().splitlines() if line and line[0] != "#"]
DAEMONS = {line[1] for line in LINES if line[0] == "daemon"}
PROGRAMS = {
    "dpkg-query": 'for name; do :; done; grep -qx "$name" installed && printf installed',
    "apt-get": 'echo "$*" >> calls; case $1 in download) for name; do :; done; touch "$name.deb";; esac',
    "dpkg-deb": "mkdir -p usr/bin",
    "id": "echo 0",
}


@pytest.fixture
def packages(tmp_path):
    """Runs packages.sh and returns the lines of apt-get's arguments. `installed`: the packages that are there already."""
    (tmp_path / "docker").mkdir()
    (tmp_path / "bin").mkdir()
    for name in ("packages.sh", "packages.txt"):
        shutil.copy(ROOT / "docker" / name, tmp_path / "docker")
    for name, script in PROGRAMS.items():
        text = script.replace("installed &&", f"{tmp_path}/installed &&").replace("calls", f"{tmp_path}/calls")
        (tmp_path / "bin" / name).write_text(f"#!/bin/sh\n{text}\n")
        (tmp_path / "bin" / name).chmod(0o755)

    def run(*kinds, installed=()):
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
    assert {path.name for path in (tmp_path / "build/daemons").iterdir()} == DAEMONS
    assert not list(tmp_path.rglob("*.deb"))


def test_nothing_is_asked_for_what_is_there(packages):
    names = [line[1] for line in LINES]
    assert packages("build", "run", "test", "daemon", installed=names) == []
    packages("daemon")
    assert packages("daemon") == []  # unpacked


def test_what_runs_needs_no_package_of_the_tests(packages):
    install, = [call.split() for call in packages("build", "run") if call.startswith("install")]
    assert not {line[1] for line in LINES if line[0] in ("test", "daemon")} & set(install)


def test_the_script_reads_the_list_beside_it(packages, tmp_path):
    """In the image both are in another folder than here."""
    (tmp_path / "docker").rename(tmp_path / "share")
    (tmp_path / "docker").symlink_to("nowhere")
    run = [tmp_path / "share/packages.sh", "runtime"]
    environment = {**os.environ, "PATH": f"{tmp_path}/bin:{os.environ['PATH']}"}
    (tmp_path / "installed").touch()
    assert subprocess.run(run, capture_output=True, env=environment).returncode == 0
    assert "libprotobuf" in (tmp_path / "calls").read_text()
    (tmp_path / "share/packages.txt").unlink()
    done = subprocess.run(run, capture_output=True, text=True, env=environment)
    assert done.returncode == 1 and "packages.txt" in done.stderr


def test_every_line_names_a_kind_a_package_and_at_most_a_release():
    assert all(len(line) == 2 or (len(line) == 3 and line[2] in ("bookworm", "trixie")) for line in LINES)
    assert len({tuple(line) for line in LINES}) == len(LINES)
    # What one release has in place of a package of the other: as many for each.
    for kind in {line[0] for line in LINES}:
        of = [[line for line in LINES if line[0] == kind and line[2:] == [release]] for release in ("bookworm", "trixie")]
        assert len(of[0]) == len(of[1])
