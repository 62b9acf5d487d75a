"""The recipes of docs/sweeps.md: what they configure is well formed, and says what the page says."""
import ast
import re
import subprocess
from pathlib import Path

import pytest
import yaml

import stiefel
from stiefel._sweep.axes import COMMON, LISTS

ROOT = Path(__file__).parents[3]
PAGE = (ROOT / "docs/sweeps.md").read_text(encoding="utf-8")


def blocks(language):
    return re.findall(rf"^```{language}\n(.*?)^```", PAGE, re.DOTALL | re.MULTILINE)


MANIFESTS = {manifest["kind"]: manifest for manifest in map(yaml.safe_load, blocks("yaml")) if "kind" in manifest}


def containers(value):
    """Every container of a manifest, wherever it stands."""
    if isinstance(value, dict):
        yield from value.get("containers", [])
        for item in value.values():
            yield from containers(item)
    elif isinstance(value, list):
        for item in value:
            yield from containers(item)


@pytest.mark.parametrize("program", blocks("python"))
def test_programs_call_sweep_with_arguments_that_it_has(program):
    calls = [node for node in ast.walk(ast.parse(program)) if isinstance(node, ast.Call)
             and ast.unparse(node.func) == "stiefel.sweep"]
    assert len(calls) == 1
    known = stiefel.sweep.__code__.co_varnames[:stiefel.sweep.__code__.co_argcount + stiefel.sweep.__code__.co_kwonlyargcount]
    assert {keyword.arg for keyword in calls[0].keywords} <= set(known)


def test_the_first_program_runs(capsys):
    exec(blocks("python")[0], {})
    assert capsys.readouterr().out == "(30, 20)\n"


def test_the_jobs_of_slurm():
    slurm = next(yaml.safe_load(block) for block in blocks("yaml") if "jobqueue" in block)["jobqueue"]["slurm"]
    # The arguments of dask_jobqueue.SLURMCluster and of its base class.
    known = {"cores", "processes", "memory", "walltime", "queue", "job_extra_directives", "local_directory", "death_timeout"}
    assert slurm.keys() == known
    assert slurm["cores"] % slurm["processes"] == 0 and slurm["cores"] // slurm["processes"] == 4
    assert re.fullmatch(r"\d\d:\d\d:\d\d", slurm["walltime"])
    assert "Each of the 8 processes of a job is a worker with 4 threads" in PAGE and slurm["processes"] == 8


def test_the_job_of_mpi():
    script = blocks("sh")[0]
    subprocess.run(["bash", "-n"], input=script, text=True, check=True)
    assert re.findall(r"^#SBATCH --([\w-]+)=", script, re.MULTILINE) == ["nodes", "ntasks-per-node", "cpus-per-task", "time"]
    example = script.split("mpi4py.futures ")[1].split()
    assert (ROOT / example[0]).exists()
    help_text = (ROOT / example[0]).read_text(encoding="utf-8")
    assert all(f'"{option}"' in help_text for option in example if option.startswith("--"))


def test_the_cluster_of_dask():
    cluster = MANIFESTS["DaskCluster"]
    assert cluster["apiVersion"] == "kubernetes.dask.org/v1"
    worker, scheduler = cluster["spec"]["worker"], cluster["spec"]["scheduler"]
    assert worker["replicas"] > 0 and worker["spec"]["containers"][0]["args"][0] == "dask-worker"
    assert "$(DASK_WORKER_NAME)" in worker["spec"]["containers"][0]["args"]
    ports = {port["name"] for port in scheduler["spec"]["containers"][0]["ports"]}
    assert {port["targetPort"] for port in scheduler["service"]["ports"]} == ports
    assert scheduler["service"]["selector"]["dask.org/cluster-name"] == cluster["metadata"]["name"]


def test_the_cluster_of_ray():
    cluster = MANIFESTS["RayCluster"]
    assert cluster["apiVersion"] == "ray.io/v1"
    for group in cluster["spec"]["workerGroupSpecs"]:
        assert group["minReplicas"] <= group["replicas"] <= group["maxReplicas"] and "rayStartParams" in group


@pytest.mark.parametrize("kind", ["DaskCluster", "RayCluster"])
def test_workers_have_as_many_threads_as_cores(kind):
    found = list(containers(MANIFESTS[kind]))
    assert len(found) == 2 and len({one["image"] for one in found}) == 1
    worker = next(one for one in found if one["name"].endswith("worker"))
    assert worker["resources"]["requests"] == worker["resources"]["limits"]
    assert worker["resources"]["limits"]["cpu"] == "4"
    if kind == "DaskCluster":
        assert worker["args"][worker["args"].index("--nthreads") + 1] == "4"
    else:
        assert "stiefel.ray.Executor(num_cpus=4)" in PAGE


def test_the_table_of_axes_is_complete():
    listed = set(re.findall(r"`([\w.]+)`", PAGE.split("## Axes")[1].split("\n\n")[1]))
    assert {*LISTS, *COMMON} <= listed
