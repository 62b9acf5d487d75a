#!/usr/bin/env python3
"""Makes what a release consists of, from wheels that are there.

Usage: docker/dist.py WHEELS OUTPUT

OUTPUT gets the wheels, stiefel-VERSION.tar.gz with the sources of HEAD, stiefel-VERSION-image.tar.gz for
`docker load` (where a container engine is installed), NOTES.md from the changelog, and SHA256SUMS of all of them. It
refuses while tracked files differ from HEAD, because the wheels would be made of other sources than the archive, while the
places that name the version disagree, and while the committed descriptor of the protocol lacks something.
"""
from __future__ import annotations

import gzip
import hashlib
import re
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


def versions(root: Path = ROOT) -> dict[str, str]:
    """The version by the place that names it."""
    def found(file: str, pattern: str) -> str:
        match = re.search(pattern, (root / file).read_text(encoding="utf-8"), re.MULTILINE)
        return match[1] if match else "none"

    project = found("CMakeLists.txt", r"^project\(stiefel VERSION (\S+)")
    label = found("tests/docker/image.sh", r'--build-arg VERSION="\$\((.*?)\)"')
    return {"CMakeLists.txt": project,
            "the Python package": found("client/python/pyproject.toml.in", r'^version = "(.*)"').replace("@PROJECT_VERSION@", project),
            "CITATION.cff": found("CITATION.cff", r"^version: (\S+)"),
            "CHANGELOG.md": found("CHANGELOG.md", r"^## \[(\d\S*)\]"),
            "the image": subprocess.run(["bash", "-c", label], cwd=root, capture_output=True, text=True).stdout.strip()}


def notes(changelog: str, version: str) -> str:
    """The section of one version, without its heading."""
    section = re.search(rf"^## \[{re.escape(version)}\][^\n]*\n(.*?)(?=^## \[|^\[|\Z)", changelog, re.DOTALL | re.MULTILINE)
    if section is None:
        raise ValueError(f"CHANGELOG.md has no section [{version}]")
    return section[1].strip() + "\n"


def sums(files: list[Path]) -> str:
    """The lines of a file for `sha256sum --check`."""
    return "".join(f"{hashlib.sha256(file.read_bytes()).hexdigest()}  {file.name}\n" for file in sorted(files))


def archive(version: str, file: Path) -> None:
    """The tracked files of HEAD. The same commit gives the same bytes."""
    tar = subprocess.run(["git", "archive", "--format=tar", f"--prefix=stiefel-{version}/", "HEAD"], cwd=ROOT, check=True,
                         capture_output=True).stdout
    with open(file, "wb") as out, gzip.GzipFile(filename="", mode="wb", fileobj=out, mtime=0) as packed:
        packed.write(tar)


def engine() -> bool:
    """Whether something is installed that builds images: a Docker engine that answers, or buildah and podman."""
    if shutil.which("docker") and subprocess.run(["docker", "version"], capture_output=True).returncode == 0:
        return True
    return all(map(shutil.which, ("buildah", "podman")))


def main(wheels: Path, output: Path) -> int:
    named = versions()
    if len(set(named.values())) != 1:
        print("the versions disagree: " + ", ".join(f"{place} says {version}" for place, version in named.items()), file=sys.stderr)
        return 1
    changed = subprocess.run(["git", "status", "--porcelain", "--untracked-files=no"], cwd=ROOT, check=True,
                             capture_output=True, text=True).stdout
    if changed:
        print(f"these files differ from HEAD, commit them first:\n{changed}", file=sys.stderr, end="")
        return 1
    if subprocess.run([sys.executable, ROOT / "tests/proto/descriptor.py", "--check"]).returncode:
        return 1
    version = named["CMakeLists.txt"]
    shutil.rmtree(output, ignore_errors=True)
    output.mkdir(parents=True)
    for wheel in wheels.glob("*.whl"):
        shutil.copyfile(wheel, output / wheel.name)
    archive(version, output / f"stiefel-{version}.tar.gz")
    (output / "NOTES.md").write_text(notes((ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), version), encoding="utf-8")
    if engine():
        subprocess.run([ROOT / "tests/docker/image.sh", "--save", output / f"stiefel-{version}-image.tar.gz"], check=True)
    else:
        print("no image: neither a Docker engine nor buildah with podman is installed")
    (output / "SHA256SUMS").write_text(sums(list(output.iterdir())))
    for file in sorted(output.iterdir()):
        print(f"{file}  {file.stat().st_size / 1e6:.2f} MB")
    return 0


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    sys.exit(main(*(Path(name).resolve() for name in sys.argv[1:])))
