"""Builds the site of the documentation.

    build_site.py BUILD_FOLDER OUTPUT_FOLDER

Writes OUTPUT_FOLDER/source, what Sphinx reads: the pages of docs, and pages made of the Python package, the public
headers, the protocol and the programs in BUILD_FOLDER. Runs the tutorials and the scripts of the gallery. Then writes
OUTPUT_FOLDER/html. A warning of Sphinx is an error.
"""
from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def main(build: Path, output: Path) -> int:
    package, programs = build / "python", [build / "bin" / name for name in ("stiefel", "stiefel-server")]
    sys.path.insert(0, str(package))
    os.environ.setdefault("STIEFEL_SERVER", str(programs[1]))
    os.environ["PYTHONPATH"] = os.pathsep.join([str(package), *filter(None, [os.environ.get("PYTHONPATH")])])
    import command_pages, cpp_pages, gallery, protocol_pages, python_pages, stage, tutorials  # noqa: E401
    import stiefel

    source = output / "source"
    shutil.rmtree(source, ignore_errors=True)
    for name in ("python", "commands", "cpp", "protocol"):
        (source / "reference" / name).mkdir(parents=True)
    stage.stage(source)
    python_pages.write(source / "reference/python")
    command_pages.write(programs, source / "reference/commands")
    cpp_pages.write({"The engine": ROOT / "engine/include/stiefel", "The client": ROOT / "client/cpp/include/stiefel/client"},
                    source / "reference/cpp")
    protocol_pages.write(ROOT / "proto", source / "reference/protocol")
    tutorials.write(ROOT / "docs/tutorials", source / "docs/tutorials")
    gallery.write(ROOT / "docs/gallery", source / "docs")
    environment = {**os.environ, "SITE_PACKAGE": str(package), "SITE_VERSION": stiefel.__version__}
    here = Path(__file__).parent
    return subprocess.run([sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", "-E", "-b", "html", "-c", here,
                           "-d", output / "doctrees", source, output / "html"], env=environment).returncode


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    sys.exit(main(Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve()))
