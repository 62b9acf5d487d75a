"""The tests of the Python client with the wheel and the oldest or the newest packages that PyPI has for it.

    packages.py oldest|newest FOLDER_OF_WHEELS

pip reads in the wheel which it needs; the client itself and the programs are those of the build tree, which PYTHONPATH and
STIEFEL_SERVER name. A warning of a line of the package is an error.
"""
from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path

from environment import environment, wheel_in

TESTS = Path(__file__).resolve().parents[1] / "python"
NEEDED = ("pytest", "psutil", "pyyaml")  # by the tests alone
#: The least that pyproject.toml asks for, or the first for this Python.
OLDEST = ("grpcio==1.51.1", "protobuf==4.21.1", "numpy==1.21.6" if sys.version_info < (3, 11) else "numpy==1.23.2",
          "scipy<1.10", "matplotlib<3.7", "greenlet<2.1", "xarray<2023", "pandas<2", "zarr<2.14", "numcodecs<0.12", "tqdm<4.65")


def main(age: str, wheels: Path) -> int:
    wheel = wheel_in(wheels)
    packages = (f"{wheel}[aio,dask,plot,progress,xarray]",) if age == "newest" else (str(wheel), *OLDEST)
    with tempfile.TemporaryDirectory(prefix=f"stiefel-{age}.") as folder:
        python = environment(Path(folder) / "there", *packages, *NEEDED)
        subprocess.run([python, "-m", "pip", "list", "--disable-pip-version-check"])
        return subprocess.run([python, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-o", r"filterwarnings=error:::stiefel(\..*)?$", TESTS],
                              env={**os.environ, "MPLCONFIGDIR": folder}).returncode


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], Path(sys.argv[2])))
