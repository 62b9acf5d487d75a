"""Copies the programs of the platform wheel, all shared libraries that they need with their loader, and their licenses."""
from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

COMMON_LICENSES = Path("/usr/share/common-licenses")  # where Debian keeps the texts that many packages need


def libraries(program: Path) -> dict[str, Path]:
    """Returns the files of the shared libraries that `program` needs, and of their loader, by file name."""
    lines = subprocess.run(["ldd", program], check=True, capture_output=True, text=True).stdout
    missing = re.findall(r"(\S+) => not found", lines)
    if missing:
        raise FileNotFoundError(f"{program}: {', '.join(missing)}: not found")
    found = re.findall(r"^\s*(?:\S+ => )?(/\S+) ", lines, re.MULTILINE)  # the loader has no "=>"
    return {Path(file).name: Path(file) for file in found}


def bundle(programs: list[Path], folder: Path) -> dict[str, Path]:
    """Copies the programs, stripped, and their libraries into one folder."""
    needed: dict[str, Path] = {}
    for program in programs:
        needed.update(libraries(program))
    for name, file in [*needed.items(), *((program.name, program) for program in programs)]:
        copy = folder / name
        shutil.copyfile(file, copy)
        copy.chmod(0o755)
    for program in programs:
        subprocess.run(["strip", "--strip-unneeded", folder / program.name], check=True)
    return needed


def write_licenses(files: list[Path], folder: Path) -> None:
    """Copies the copyright file of every Debian package that the files come from, and the license texts to which these
    point instead of having them, such as that of the LGPL, under which libquadmath is."""
    for package in sorted({package_of(file) for file in files}):
        copy = folder / f"{package}.copyright"
        shutil.copyfile(Path("/usr/share/doc", package, "copyright"), copy)
        for name in common_licenses(copy.read_text(encoding="utf-8", errors="replace")):
            shutil.copyfile(COMMON_LICENSES / name, folder / name)


def common_licenses(copyright: str) -> set[str]:
    """Returns the names of the files in /usr/share/common-licenses to which a copyright file points. Where it names no
    version, as in ".../LGPL", these are the files of all versions, because the text says which one and later ones."""
    named = set(re.findall(rf"{COMMON_LICENSES}/([A-Za-z]+(?:-\d+(?:\.\d+)*)?)", copyright))
    versions = {file.name for name in named for file in COMMON_LICENSES.glob(f"{name}-*") if "-" not in name}
    return versions | {name for name in named if (COMMON_LICENSES / name).exists()}


def package_of(file: Path) -> str:
    """Returns the Debian package of a file. Tries several paths, because dpkg knows a file by the path at which it was
    installed, which may lead through a link such as /lib."""
    names = {str(file), str(file.resolve()), str(file).removeprefix("/usr"), f"/usr{file}", f"/usr{file.resolve()}"}
    for name in sorted(names):
        found = subprocess.run(["dpkg-query", "--search", name], capture_output=True, text=True)
        if found.returncode == 0:
            return found.stdout.split(":")[0]
    raise FileNotFoundError(f"no Debian package has {file}, so its license is not known")
