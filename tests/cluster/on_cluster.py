"""A sweep on a real cluster of Dask or Ray with the wheel in an environment of its own: the bytes, the cost, the deaths.

    on_cluster.py dask|ray FOLDER_OF_WHEELS [BODIES]

Without BODIES as many as STIEFEL_SWEEP_BODIES says, else 100 000: about ten minutes on two cores for a cluster.
"""
from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path

from environment import environment, wheel_in


def main(cluster: str, wheels: Path, bodies: str) -> int:
    with tempfile.TemporaryDirectory(prefix="stiefel-cluster.") as folder:
        python = environment(Path(folder) / "there", f"{wheel_in(wheels)}[{cluster},xarray]", "psutil")
        # Ray writes into the home folder.
        program = Path(__file__).with_name("soak.py")
        return subprocess.run([python, program, cluster, "--bodies", bodies], cwd=folder,
                              env={"PATH": "/usr/bin:/bin", "HOME": folder}).returncode


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], Path(sys.argv[2]), sys.argv[3] if len(sys.argv) > 3 else os.environ.get("STIEFEL_SWEEP_BODIES", "100000")))
