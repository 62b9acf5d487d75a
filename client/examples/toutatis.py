"""Simulates asteroid (4179) Toutatis from its published spin state to the radar observations a month later.

    toutatis.py [--output FOLDER] [--server ADDRESS]

Simulates 39 days in steps of one second, so that every observation falls on a step, and compares the
attitude with the 17 observations of December 1992. The method is the one that the server recommends:
the closed form, which computes the states that are asked for and none between them. Then
compares three methods in steps of one hour by two things that are often taken for one: how well they
keep the energy, and how accurate the attitude is. Writes trajectory.npz and toutatis.png.
"""
from __future__ import annotations

import argparse
import json
import time
from contextlib import nullcontext
from datetime import datetime
from pathlib import Path
from typing import Any, Iterator, NamedTuple, Optional

import numpy as np
from numpy.typing import NDArray

import picture
import stiefel

DATA = Path(__file__).with_name("toutatis_observations.json")
DAY = 86400  # seconds
DAYS = 39
SAMPLE = 600  # seconds between the samples that are streamed
HOUR = 3600  # seconds
#: The methods that are compared, by their names in tables and pictures; None is the one that the server recommends.
METHODS: dict[str, Optional[stiefel.MethodName]] = {"recommended": None, "variational": "variational", "rk4": "rk4"}


class Comparison(NamedTuple):
    utc: str
    step: int  #: seconds since the epoch
    simulated: NDArray[Any]  #: 3 x 3, the body's axes in its columns
    observed: NDArray[Any]

    def angles(self) -> NDArray[Any]:
        """Returns the angle in degrees between each simulated axis and the observed one."""
        cosines = np.sum(self.simulated * self.observed, axis=0)
        sines = np.linalg.norm(np.cross(self.simulated, self.observed, axis=0), axis=0)
        between: NDArray[Any] = np.degrees(np.arctan2(sines, cosines))
        return between


class Accuracy(NamedTuple):
    """How well a method keeps the energy, and how far the attitude is from the exact motion."""

    method: str  #: with its order if it has one: "rk4 of order 4"
    days: NDArray[Any]
    drift: NDArray[Any]  #: of the energy, relative
    error: NDArray[Any]  #: of the attitude, in degrees; 0 where it is too small to tell


def attitude(euler: list[float]) -> NDArray[Any]:
    """Returns the rotation from body to space, Rz(e0) Rx(e1) Rz(e2), for 3-1-3 Euler angles in degrees."""
    def rotation(angle: float, i: int, j: int) -> NDArray[Any]:
        matrix = np.eye(3)
        matrix[[i, j, i, j], [i, j, j, i]] = [np.cos(angle)] * 2 + [-np.sin(angle), np.sin(angle)]
        return matrix

    first, second, third = np.radians(euler)
    product: NDArray[Any] = rotation(first, 0, 1) @ rotation(second, 1, 2) @ rotation(third, 0, 1)
    return product


def quaternion(euler: list[float]) -> list[float]:
    """Returns the quaternion w, x, y, z of the attitude for 3-1-3 Euler angles in degrees."""
    first, second, third = np.radians(euler) / 2
    return [np.cos(second) * np.cos(first + third), np.sin(second) * np.cos(first - third),
            np.sin(second) * np.sin(first - third), np.cos(second) * np.sin(first + third)]


def scene(data: dict[str, Any], method: Optional[stiefel.MethodName] = None, step: float = 1.0) -> stiefel.Scene:
    """Returns the scene of the published state, in seconds and radians. The moments are relative to the smallest.

    A scene without a method gets the one that the server recommends.
    """
    made: stiefel.Scene = {
        "system": "rigid_body",
        "body": {
            "moments": data["moments"],
            "attitude": quaternion(data["euler"]),
            "angular_velocity": np.radians(data["angular_velocity"]) / DAY,
        },
        "step": step,
    }
    if method:
        made["method"] = {"name": method}
    return made


def compare(session: stiefel.Session, data: dict[str, Any]) -> Iterator[Comparison]:
    epoch = datetime.fromisoformat(data["epoch"])
    for observation in data["observations"]:
        step = int((datetime.fromisoformat(observation["utc"]) - epoch).total_seconds())
        simulated = session.step(to=step, fields=["Q"])["Q"]
        yield Comparison(observation["utc"], step, simulated, attitude(observation["euler"]))


def drifts(run: stiefel.Trajectory, data: dict[str, Any]) -> tuple[NDArray[Any], NDArray[Any]]:
    """Returns the relative drift of the energy, (samples,), and the drift of the spatial momentum Q m relative to its
    norm, (samples, 3). Both are computed here from the samples."""
    momentum = run["M"][:, [2, 0, 1], [1, 2, 0]]  # M = hat(m)
    energy = np.sum(momentum**2 / data["moments"], axis=1) / 2
    spatial = np.einsum("sij,sj->si", run["Q"], momentum)
    return abs(energy / energy[0] - 1), abs(spatial - spatial[0]) / np.linalg.norm(spatial[0])


def hourly(client: stiefel.Client, data: dict[str, Any], method: Optional[stiefel.MethodName]) -> Accuracy:
    """Runs a method in steps of one hour, at which methods differ, and looks at its energy and attitude once a day."""
    with client.create(scene(data, method, HOUR)) as session:
        chosen: Any = session.scene.get("method", {})
        days = np.arange(DAYS + 1)
        diagnoses = [session.diagnose(to=int(day) * DAY // HOUR, invariants="energy", estimate_error=True) for day in days]
    order = f" of order {chosen['order']}" if "order" in chosen else ""
    return Accuracy(chosen["name"] + order, days,
                    np.array([diagnosis.invariants[0].drift for diagnosis in diagnoses]),
                    np.array([error_in_degrees(diagnosis) for diagnosis in diagnoses]))


def error_in_degrees(diagnosis: stiefel.Diagnosis) -> float:
    """Returns the estimated angle between the attitude and the exact one; 0 where it is too small to tell."""
    estimate = diagnosis.estimated_error
    assert estimate is not None and estimate.reference, estimate
    return float(np.degrees(estimate.angle or 0.0))


def report(comparisons: list[Comparison], energy: NDArray[Any], momentum: NDArray[Any]) -> None:
    angles = np.array([comparison.angles() for comparison in comparisons])
    print("angle between simulated and observed axes, degrees")
    print(f"{'observed (UTC)':<20}{'x':>7}{'y':>7}{'z':>7}")
    for comparison, row in zip(comparisons, angles):
        print(f"{comparison.utc:<20}" + "".join(f"{angle:7.2f}" for angle in row))
    print(f"median {np.median(angles):.2f}, worst {angles.max():.2f}; "
          f"median of each day's worst axis {np.median(angles.max(axis=1)):.2f}\n")
    print(f"largest drift in {DAYS} days: energy {energy.max():.1e}, "
          "spatial momentum " + " ".join(f"{name} {drift:.1e}" for name, drift in zip("xyz", momentum.max(axis=0))))


def report_methods(methods: dict[str, Accuracy]) -> None:
    print(f"\n{'in steps of one hour, ' + str(DAYS) + ' days':<52}{'energy drift':>14}{'attitude error':>20}")
    for name, found in methods.items():
        label = f"{name}: {found.method}" if name == "recommended" else found.method
        print(f"{label:<52}{found.drift.max():>14.1e}{found.error.max():>12.1e} degrees")
    print()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--output", type=Path, default=Path("build/run"), help="folder for what is written")
    parser.add_argument("--server", help="address of a running server; otherwise one is started")
    arguments = parser.parse_args()
    arguments.output.mkdir(parents=True, exist_ok=True)
    data = json.loads(DATA.read_text(encoding="utf-8"))

    with nullcontext() if arguments.server else stiefel.Server.start() as server, \
            stiefel.Client(server.address if server else arguments.server) as client, \
            client.create(scene(data)) as session:
        print(f"{data['body']}, {DAYS} days from {data['epoch']} UTC in steps of 1 s")
        start = time.perf_counter()
        run = session.trajectory(to=DAYS * DAY, every=SAMPLE, fields=["Q", "M"], progress=True)
        seconds = time.perf_counter() - start
        chosen: Any = session.scene["method"]
        print(f"{run.samples} states in {seconds:.2f} s, with the method {chosen['name']}\n")
        comparisons = list(compare(session, data))
        error = error_in_degrees(session.diagnose(to=DAYS * DAY, estimate_error=True))
        methods = {name: hourly(client, data, method) for name, method in METHODS.items()}

    energy, momentum = drifts(run, data)
    report(comparisons, energy, momentum)
    print(f"estimated error of the last attitude: {error:.1e} degrees")
    report_methods(methods)
    run.save(arguments.output / "trajectory.npz")
    picture.toutatis(arguments.output / "toutatis.png", run, comparisons, methods)
    print(f"wrote {arguments.output}/trajectory.npz and {arguments.output}/toutatis.png")


if __name__ == "__main__":
    main()
