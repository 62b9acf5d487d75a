"""auditwheel finds in the platform wheel what its name promises.

    audit.py FOLDER_OF_WHEELS
"""
from __future__ import annotations

import os
import re
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

from environment import environment, wheel_in

sys.path.insert(0, str(Path(__file__).parents[2] / "client/python/wheel"))
from bundle import common_licenses  # noqa: E402


def main(wheels: Path) -> None:
    wheel = wheel_in(wheels)
    promised = re.search(r"-manylinux_(\d+)_(\d+)_x86_64\.whl$", wheel.name)
    assert promised, f"{wheel.name}: must be a wheel for manylinux on x86_64"
    with tempfile.TemporaryDirectory() as folder:
        python = environment(Path(folder), "auditwheel")
        path = f"/usr/bin:{os.environ['PATH']}"  # for patchelf
        said = subprocess.run([python.with_name("auditwheel"), "show", wheel], env={**os.environ, "PATH": path}, check=True,
                              capture_output=True, text=True).stdout
    said = " ".join(said.split())
    found = re.search(r'consistent with the following platform tag: "manylinux_(\d+)_(\d+)_x86_64"', said)
    assert found, said
    assert tuple(map(int, found.groups())) <= tuple(map(int, promised.groups())), said
    print(f"{wheel.name} runs where {found[0].split()[-1]} does")

    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
        libraries = [name for name in names if ".so." in name]
        licenses = [name for name in names if name.endswith(".copyright")]
        pointers = {text for name in licenses
                    for text in common_licenses(archive.read(name).decode("utf-8", errors="replace"))}
        texts = {Path(name).name: archive.read(name) for name in names if Path(name).name in pointers}
    assert libraries and licenses and any(name.endswith("dist-info/LICENSE") for name in names)
    assert all(name.startswith("stiefel/_programs/") for name in libraries)
    assert pointers <= texts.keys(), f"the wheel lacks the license texts {', '.join(sorted(pointers - texts.keys()))}"
    assert any(Path(name).name.startswith("libquadmath") for name in libraries)
    assert b"GNU LESSER GENERAL PUBLIC LICENSE" in texts["LGPL-2.1"], "libquadmath's license"
    print(f"{len(libraries)} libraries, {len(licenses)} licenses of packages, {len(texts)} texts to which they point")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
