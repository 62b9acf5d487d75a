"""The platform wheel holds all libraries that its programs need, as its name promises, and the licenses of all.

    audit.py FOLDER_OF_WHEELS
"""
from __future__ import annotations

import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

from environment import wheel_in

sys.path.insert(0, str(Path(__file__).parents[2] / "client/python/wheel"))
from bundle import common_licenses  # noqa: E402


def main(wheels: Path) -> None:
    wheel = wheel_in(wheels)
    assert "-py3-none-manylinux_2_17_x86_64." in wheel.name and ".musllinux_1_1_x86_64." in wheel.name, wheel.name
    with tempfile.TemporaryDirectory() as folder:
        with zipfile.ZipFile(wheel) as archive:
            archive.extractall(folder)
        programs = Path(folder, "stiefel/_programs")
        loader, = programs.glob("ld-linux-*")
        loader.chmod(0o755)
        found = subprocess.run([loader, "--library-path", programs, "--list", programs / "stiefel-server"], env={}, check=True,
                               capture_output=True, text=True).stdout
    outside = [line for line in found.splitlines() if str(programs) not in line and "linux-vdso" not in line]
    assert len(found.splitlines()) > 10 and not outside, f"not from the wheel: {outside}"

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
