import os
import stat
from pathlib import Path

import pytest
from small_studies import SPEED, case, run_members_here

import pellucid
from pellucid.errors import UsageError
from pellucid.studies import pool
from pellucid.studies.members import members_of
from pellucid.studies.pool import Workers, read_slurm

SBATCH = """#!{python}
import pathlib, subprocess, sys
script = pathlib.Path(sys.argv[-1]).read_text()  # its file is deleted when this command ends
with (pathlib.Path(__file__).parent / "job.log").open("a") as log:
    subprocess.Popen(["bash", "-c", script], stdout=log, stderr=log, start_new_session=True)
print("Submitted batch job 1")
"""


def test_options_of_slurm_are_read() -> None:
    assert read_slurm("queue=short, cores=8,memory=16GB") == {"queue": "short", "cores": "8", "memory": "16GB"}
    assert read_slurm(None) == {}


@pytest.mark.parametrize("text", ["queue", "queue=", "queue=short", "cores=8"])
def test_bad_options_of_slurm_are_refused(text: str) -> None:
    with pytest.raises(UsageError, match="--slurm"):
        read_slurm(text)


@pytest.mark.parametrize("workers", [Workers(at_once=0), Workers(threads=0), Workers(scheduler="a", slurm={"cores": "1"})])
def test_impossible_workers_are_refused(workers: Workers) -> None:
    with pytest.raises(UsageError):
        workers.check()


def test_threads_are_shared_out_by_cost(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pool, "free_cores", lambda: 7)
    members = members_of(case(), [{"time.step": 0.03}, {"time.step": 0.003}, {"time.step": 0.001}])
    costs = [pool._costs(members)[member.digest] for member in members]
    assert [cost / costs[0] for cost in costs] == pytest.approx([1, 334 / 34, 1000 / 34])
    assert [pool._share(cost / sum(costs)) for cost in costs] == [1, 1, 5]
    assert pool._share(1.0) == 8


def test_a_scheduler_that_does_not_answer_is_told(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(pool, "WAIT", 0.5)
    with pytest.raises(UsageError, match=r"--scheduler tcp://127\.0\.0\.1:9: no scheduler answers"):
        pellucid.sweep(case(), {SPEED: [1.0]}, out=tmp_path, scheduler="tcp://127.0.0.1:9")


def test_members_run_on_the_cluster_of_a_scheduler(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    from distributed import LocalCluster

    begun = run_members_here(monkeypatch)
    options = {"n_workers": 1, "threads_per_worker": 1, "processes": False, "dashboard_address": "127.0.0.1:0"}
    with LocalCluster(protocol="tcp", host="127.0.0.1", **options) as cluster:
        table = pellucid.sweep(case(), {SPEED: [1.0, 2.0]}, out=tmp_path, scheduler=cluster.scheduler_address)
    assert list(table["state"]) == ["done", "done"]
    assert len(begun) == 2


@pytest.mark.slow
def test_members_run_as_jobs_of_slurm(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """With an `sbatch` that begins the job at once on this machine."""
    import sys

    for name, text in (("sbatch", SBATCH.format(python=sys.executable)), ("scancel", "#!/bin/sh\n")):
        (tmp_path / name).write_text(text)
        (tmp_path / name).chmod(stat.S_IRWXU)
    monkeypatch.setenv("PATH", f"{tmp_path}{os.pathsep}{os.environ['PATH']}")
    slurm = {"cores": "1", "memory": "1GB", "interface": "lo"}
    short = pellucid.load("basics/colliding-discs").quick_variant()
    try:
        table = pellucid.sweep(short, {"time.courant": [0.3, 0.4]}, out=tmp_path / "s", until=0.1, workers=1, slurm=slurm)
    finally:
        sys.stdout.write((tmp_path / "job.log").read_text())  # shown where the test fails
    assert list(table["state"]) == ["done", "done"]


def test_a_job_of_slurm_may_start_slowly() -> None:
    """A worker that gives up is not replaced: with the minute that dask_jobqueue allows, a study on busy nodes never ended."""
    with pool._slurm({"cores": "1", "memory": "1GB", "interface": "lo"}) as cluster:
        assert "--death-timeout 600" in cluster.job_script()
