"""The daemons that tests start."""
from __future__ import annotations

import os
import shutil
from pathlib import Path
from typing import Optional

UNPACKED = Path(__file__).resolve().parents[2] / "build/daemons"  # by docker/packages.sh


def find_daemon(program: str) -> Optional[str]:
    """The path of an unpacked or installed program; None where there is neither."""
    folders = [*map(str, UNPACKED.glob("*/usr/*bin")), os.environ.get("PATH", ""), "/usr/sbin"]
    return shutil.which(program, path=os.pathsep.join(folders))
