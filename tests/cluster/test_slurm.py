"""Jobs run on a real Slurm, give the tables that they give here, and survive being ended."""

from .conftest import LONG, LONG_FORCES, QUICK, QUICK_TABLES, Run, wait_until
from .slurm import PARTITION, Job, Slurm

LONG_LOG = "logs/long/simulate_plan/sweep/parquet.log"


def jobs_of(run: Run, slurm: Slurm) -> list[Job]:
    """Slurm's record of the jobs of a run."""
    numbers = run.submitted()
    wait_until(lambda: {*numbers} <= {job.number for job in slurm.ended()})
    return [job for job in slurm.ended() if job.number in numbers]


def test_the_quick_study_is_simulated_on_slurm(slurm, checkout, made_locally):
    run = checkout.on_slurm(QUICK, QUICK_TABLES)
    run.succeeds()
    jobs = jobs_of(run, slurm)
    # Every part of every plan, and nothing else: plans, gathering and fits stay where snakemake is.
    parts = list((checkout.folder / "benchmarks/quick").glob("simulate*/**/*.tsv"))
    assert len(jobs) == len(parts) > 4
    assert {(job.state, job.partition) for job in jobs} == {("COMPLETED", PARTITION)}
    for name in QUICK_TABLES:
        assert (checkout.folder / name).read_bytes() == made_locally(name), name
    (cache,) = (slurm.folder / "scratch").glob("squeezefilm-*/*/pocl")
    assert any(cache.iterdir()), "kernels were not kept on the node"


def test_a_cancelled_job_is_tried_again(slurm, checkout, made_locally):
    run = checkout.on_slurm(LONG, [LONG_FORCES])
    wait_until(lambda: (checkout.folder / LONG_LOG).exists(), of=run)
    (number,) = slurm.running()
    slurm.run("scancel", number)
    run.succeeds()
    jobs = jobs_of(run, slurm)
    assert [job.state for job in jobs] == ["CANCELLED", "COMPLETED"]
    assert jobs[0].number == number
    assert (checkout.folder / LONG_FORCES).read_bytes() == made_locally(LONG_FORCES)


def test_a_run_goes_on_after_snakemake_was_killed_though_its_job_writes_later(
    slurm, checkout, made_locally
):
    first = checkout.on_slurm(LONG, [LONG_FORCES])
    wait_until(lambda: (checkout.folder / LONG_LOG).exists(), of=first)
    first.process.kill()
    first.process.wait()
    (old,) = slurm.running()
    # So that it writes after the new one, however busy we are.
    slurm.run("scontrol", "suspend", old)
    second = checkout.resume(LONG, LONG_FORCES)
    second.succeeds()
    assert [job.state for job in jobs_of(second, slurm)] == ["COMPLETED"]
    table = (checkout.folder / LONG_FORCES).read_bytes()
    assert table == made_locally(LONG_FORCES)
    slurm.run("scontrol", "resume", old)
    assert [job.number for job in jobs_of(first, slurm)] == [old]
    assert (checkout.folder / LONG_FORCES).read_bytes() == table


def test_another_scheduler_is_reached_by_its_own_commands(slurm, checkout, made_locally):
    table = QUICK_TABLES[0]
    profile = ("--workflow-profile", "profiles/generic", "--latency-wait", "5")
    run = checkout.start(table, "--configfile", QUICK, *profile)
    run.succeeds()
    (job,) = jobs_of(run, slurm)
    assert job.state == "COMPLETED"
    assert job.name == "squeezefilm-simulate_plan"
    assert (checkout.folder / table).read_bytes() == made_locally(table)
