"""Makes two wheels of the package in the build tree.

    make_wheels.py BUILD_FOLDER OUTPUT_FOLDER

`stiefel`, for Linux on this machine's processor with any C library, holds `stiefel-server` and all libraries it needs, with
their loader; `stiefel_client`, for every platform, holds none, and its extra [server] is the first wheel. Both have the
command. Needs setuptools, wheel and strip; takes licenses from /usr/share/doc, so that it runs on Debian only.
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

PROGRAMS = ("stiefel-server",)
SOURCES = Path(__file__).resolve().parents[3]
# The wheel holds programs and no Python extension: it is for any Python 3 on this platform.
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
SCRIPT = 'stiefel-server = "stiefel._programs:server"\n'


def stage(build: Path, folder: Path) -> str:
    """Copies the package of the build tree as a project and returns the text of its pyproject.toml."""
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(build / "python" / "stiefel", folder / "stiefel", ignore=shutil.ignore_patterns("__pycache__"))
    (folder / "licenses").mkdir()
    shutil.copyfile(SOURCES / "LICENSE", folder / "licenses" / "LICENSE")
    text = (build / "python" / "pyproject.toml").read_text()
    return text.replace("[tool.setuptools]\n", '[tool.setuptools]\nlicense-files = ["licenses/*"]\n')


def platform_tag() -> str:
    """Returns the tags of the oldest systems that the wheel's dependencies know: its programs bring their C library, so they
    need none of the system. A pip before 20.3 knows the second name alone."""
    return ".".join(f"{system}_{platform.machine()}" for system in ("manylinux_2_17", "manylinux2014", "musllinux_1_1"))


def for_this_platform(build: Path, folder: Path) -> None:
    project = stage(build, folder)
    programs = folder / "stiefel" / "_programs"
    needed = bundle([build / "bin" / name for name in PROGRAMS], programs)
    # The programs contain these header-only libraries. libquadmath and the C++ headers belong to g++.
    compiled_in = [Path("/usr/include/eigen3/Eigen/Core"), Path("/usr/include/boost/version.hpp"),
                   Path("/usr/include/CLI/CLI.hpp"), Path("/usr/include/nlohmann/json.hpp")]
    write_licenses([*needed.values(), *compiled_in], folder / "licenses")
    project = project.replace("[project.scripts]\n", "[project.scripts]\n" + SCRIPT)
    project = project.replace('stiefel = ["py.typed", ', 'stiefel = ["py.typed", "_programs/*", ')
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
    """Builds a wheel with setuptools, in another process, because setuptools works in the current folder."""
    program = "import sys; from setuptools import build_meta; print(build_meta.build_wheel(sys.argv[1]))"
    # Entries of the archive have this time, so that the same tree gives the same wheel.
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
