"""Makes two wheels of the package in the build tree.

    make_wheels.py BUILD_FOLDER OUTPUT_FOLDER

`stiefel`, for Linux on this machine's processor and its glibc or a later one, holds `stiefel-server`, `stiefel` and the
libraries they need; `stiefel_client`, for every platform, holds neither, and its extra [server] is the first wheel.
Needs setuptools, wheel, patchelf and strip; takes licenses from /usr/share/doc, so that it runs on Debian only.
"""
from __future__ import annotations

import os
import platform
import re
import shutil
import subprocess
import sys
from pathlib import Path

from bundle import bundle, write_licenses

PROGRAMS = ("stiefel-server", "stiefel")
SOURCES = Path(__file__).resolve().parents[3]
# A wheel of programs and no Python extension: any Python 3, this platform.
SETUP = """\
from setuptools import setup
from setuptools.dist import Distribution
from wheel.bdist_wheel import bdist_wheel

class WithPrograms(Distribution):
    def has_ext_modules(self): return True

class ForAnyPython(bdist_wheel):
    def get_tag(self): return "py3", "none", {platform!r}

setup(distclass=WithPrograms, cmdclass={{"bdist_wheel": ForAnyPython}})
"""
SCRIPTS = """\
[project.scripts]
stiefel-server = "stiefel.programs:server"
stiefel = "stiefel.programs:command"

[tool.setuptools]
"""


def stage(build: Path, folder: Path) -> str:
    """The package of the build tree as a project; the text of its pyproject.toml."""
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(build / "python" / "stiefel", folder / "stiefel", ignore=shutil.ignore_patterns("__pycache__"))
    (folder / "licenses").mkdir()
    shutil.copyfile(SOURCES / "LICENSE", folder / "licenses" / "LICENSE")
    text = (build / "python" / "pyproject.toml").read_text()
    return text.replace("[tool.setuptools]\n", '[tool.setuptools]\nlicense-files = ["licenses/*"]\n')


def platform_tag() -> str:
    """"manylinux_2_36_x86_64": the oldest glibc that the programs run with is that they were linked with."""
    return f"manylinux_{platform.libc_ver()[1].replace('.', '_')}_{platform.machine()}"


def for_this_platform(build: Path, folder: Path) -> None:
    project = stage(build, folder)
    programs = folder / "stiefel" / "programs"
    needed = bundle([build / "bin" / name for name in PROGRAMS], programs)
    # libquadmath and the C++ headers are g++'s; the header-only libraries are part of the programs.
    compiled_in = [Path("/usr/include/eigen3/Eigen/Core"), Path("/usr/include/boost/version.hpp"),
                   Path("/usr/include/CLI/CLI.hpp"), Path("/usr/include/nlohmann/json.hpp")]
    write_licenses([*needed.values(), *compiled_in], folder / "licenses")
    project = project.replace("[tool.setuptools]\n", SCRIPTS)
    project = project.replace('stiefel = ["py.typed", "v1/*.pyi"]', 'stiefel = ["py.typed", "v1/*.pyi", "programs/*"]')
    (folder / "pyproject.toml").write_text(project)
    (folder / "setup.py").write_text(SETUP.format(platform=platform_tag()))


def for_every_platform(build: Path, folder: Path) -> None:
    project = stage(build, folder)
    version = re.search(r'^version = "(.*)"', project, re.MULTILINE)
    assert version is not None
    project = project.replace('name = "stiefel"', 'name = "stiefel-client"')
    project = project.replace("[project.optional-dependencies]\n",
                              f'[project.optional-dependencies]\nserver = ["stiefel=={version[1]}"]\n')
    (folder / "pyproject.toml").write_text(project)


def build_wheel(project: Path, output: Path) -> Path:
    """By setuptools, in a process of its own, because it works in the current folder."""
    program = "import sys; from setuptools import build_meta; print(build_meta.build_wheel(sys.argv[1]))"
    # Entries of the archive carry this time, so that one tree makes one wheel.
    environment = {**os.environ, "SOURCE_DATE_EPOCH": "1577836800", "PYTHONPATH": ""}
    done = subprocess.run([sys.executable, "-c", program, output], cwd=project, env=environment, capture_output=True, text=True)
    if done.returncode != 0:
        raise RuntimeError(f"setuptools made no wheel of {project}:\n{done.stdout}{done.stderr}")
    return output / done.stdout.split()[-1]


def main(build: Path, output: Path) -> None:
    output.mkdir(parents=True, exist_ok=True)
    for old in output.glob("*.whl"):
        old.unlink()
    for name, prepare in (("platform", for_this_platform), ("client", for_every_platform)):
        project = output / "stage" / name
        prepare(build, project)
        wheel = build_wheel(project, output.resolve())
        print(f"{wheel.relative_to(Path.cwd()) if wheel.is_relative_to(Path.cwd()) else wheel}  {wheel.stat().st_size / 1e6:.1f} MB")
    shutil.rmtree(output / "stage")


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve())
