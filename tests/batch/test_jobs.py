"""Job scripts: what they ask for, what they do when run, and that nothing but names gets into them."""

from __future__ import annotations

import math
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from fbcouple.batch.jobs import Request, request_memory, write_job
from fbcouple.batch.schedulers import SCHEDULERS
from fbcouple.case.cost.coefficients import SHIPPED
from fbcouple.case.cost.memory import LAUNCHER
from fbcouple.case.cost.prediction import predict
from fbcouple.case.load import load_case, write_case
from fbcouple.cli.main import cli
from fbcouple.errors import CaseError
from fbcouple.run_folder.lock import STALE_AFTER, hold
from tests.batch.slurm_jobs import CASE, call, is_complete

HOUR = 3600
REAL_PYTHON = sys.executable
LONGEST = 120.0
"""Wall time [s] that a test waits for a script, on a machine that does much else."""
# Stands in for the interpreter that runs `fbcouple run`: notes its arguments, exits as the file `code` says.
PYTHON = """#!/bin/bash
echo "$@" >> {folder}/calls
trap 'exit 75' USR1 TERM
if [ -e {folder}/waits ]; then touch {folder}/waiting; sleep 120 & wait $!; fi
exit "$(cat {folder}/code)"
"""
NOTE = '#!/bin/bash\necho "$(basename "$0") $*" >> {folder}/calls\necho "{answer}"\n'


@pytest.fixture
def runs(tmp_path: Path) -> Path:
    """A folder of two runs, as `setup` of a set leaves them (the case file is all that a job looks at, and that there
    is a manifest)."""
    for name in ("a", "b"):
        (tmp_path / "set" / name).mkdir(parents=True)
        (tmp_path / "set" / name / "manifest.json").touch()
        write_case(load_case("patil/c2"), tmp_path / "set" / name / "case.toml")
    return tmp_path / "set"


@pytest.fixture
def site(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a stand-in interpreter and the commands of the three batch systems, first on the PATH."""
    folder = tmp_path / "site"
    folder.mkdir()
    answers = {"sbatch": "17;box", "qsub": "17.box", "bsub": "Job <17> is submitted to queue <q>.", "scontrol": ""}
    texts = {name: NOTE.format(folder=folder, answer=answer) for name, answer in answers.items()}
    for name, text in ({"python": PYTHON.format(folder=folder)} | texts).items():
        (folder / name).write_text(text)
        (folder / name).chmod(0o755)
    (folder / "code").write_text("0")
    monkeypatch.setenv("PATH", f"{folder}:{os.environ['PATH']}")
    monkeypatch.setattr("sys.executable", str(folder / "python"))
    return folder


def read_calls(site: Path) -> list[str]:
    calls = site / "calls"
    return calls.read_text().splitlines() if calls.exists() else []


def run_job(job: Path, **environment: str) -> int:
    return subprocess.run([job], env=os.environ | environment, check=False, timeout=LONGEST).returncode


def batch(*arguments: object) -> Result:
    return CliRunner().invoke(cli, ["batch", *map(str, arguments)])


def request_of(scheduler: str, **more: object) -> Request:
    chain = {} if SCHEDULERS[scheduler].requeues else {"chain": 3}
    return Request(**({"ranks": 4, "limit": 2 * HOUR} | chain | more))


@pytest.mark.parametrize(
    ("scheduler", "lines"),
    [
        (
            "slurm",
            [
                "#SBATCH --ntasks=4",
                "#SBATCH --mem-per-cpu=500M",
                "#SBATCH --time=02:00:00",
                "#SBATCH --signal=B:USR1@300",
                "#SBATCH --requeue",
                "#SBATCH --partition=short",
                "#SBATCH --account=beds",
                "#SBATCH --array=0-1",
            ],
        ),
        (
            "pbs",
            [
                "#PBS -l select=1:ncpus=4:mpiprocs=4:mem=2000mb",
                "#PBS -l walltime=02:00:00",
                "#PBS -q short",
                "#PBS -A beds",
                "#PBS -J 0-1",
            ],
        ),
        (
            "lsf",
            [
                '#BSUB -J "set[1-2]"',
                "#BSUB -n 4",
                '#BSUB -R "rusage[mem=2000MB]"',
                "#BSUB -W 120",
                "#BSUB -wa USR1",
                "#BSUB -wt 5",
                '#BSUB -Q "75"',
                "#BSUB -q short",
                "#BSUB -P beds",
            ],
        ),
    ],
)
def test_what_a_job_asks_for(runs, scheduler, lines):
    wanted = request_of(scheduler, memory=2000, modules=("openmpi/4.1",), queue="short", account="beds")
    job, submit = write_job(runs, scheduler, wanted)
    text = job.read_text().splitlines()
    assert text[0] == "#!/bin/bash" and set(lines) <= set(text)
    load = "module load openmpi/4.1 || stop 'module load openmpi/4.1' $?"
    assert load in text and text.index(load) < text.index("set -u")
    assert sum(f'run "$run" -n {wanted.ranks} ' in line for line in text) == 1
    for script in (job, submit):
        assert subprocess.run(["bash", "-n", script], check=False).returncode == 0
        assert os.access(script, os.X_OK)


@pytest.mark.parametrize("scheduler", SCHEDULERS)
def test_single_run_is_no_array_and_what_is_not_asked_for_leaves_no_trace(runs, scheduler):
    text = write_job(runs / "a", scheduler, request_of(scheduler))[0].read_text()
    for absent in ("--array", "#PBS -J", "[1-", "partition", "account", "#PBS -q", "#BSUB -q", "#BSUB -P", "module"):
        assert absent not in text


def test_memory_is_ranks_and_the_largest_case(runs):
    write_case(load_case("patil/c3"), runs / "b/case.toml")
    middle, fine = (load_case(f"patil/{name}") for name in ("c2", "c3"))
    told = predict(fine, 4, SHIPPED)
    four = math.ceil((told.memory + LAUNCHER) * told.memory_factor / 2**20)
    assert four == request_memory(fine, runs / "b", 4) > request_memory(middle, runs / "a", 4) > 4 * 300
    each = SHIPPED.rank_memory * told.memory_factor / 2**20
    assert four - request_memory(fine, runs / "b", 1) == pytest.approx(3 * each, abs=1.0)
    text = write_job(runs, "pbs", request_of("pbs"))[0].read_text()
    assert f":mem={four}mb" in text


def test_case_that_brings_code_needs_trust_which_the_job_hands_on(runs):
    run = runs / "a"
    (run / "law.py").write_text("def beta(voidage, slip, diameter, density, viscosity):\n    return diameter\n")
    settings = ["exchange.drag=own", "exchange.drag_file=law.py"]
    write_case(load_case(str(run), settings), run / "case.toml")
    with pytest.raises(CaseError, match=f"^{run}: exchange.drag_file: .*--trust"):
        write_job(runs, "slurm", request_of("slurm"))
    assert not (run / "batch").exists()
    job, _ = write_job(run, "slurm", request_of("slurm", trusted=True))
    assert 'run "$run" -n 4 --trust ' in job.read_text()


@pytest.mark.parametrize(("scheduler", "variable"), [("slurm", "SLURM_ARRAY_TASK_ID"), ("pbs", "PBS_ARRAY_INDEX")])
def test_array_job_takes_its_own_run(runs, site, scheduler, variable):
    job, _ = write_job(runs, scheduler, request_of(scheduler))
    assert [run_job(job, **{variable: str(number)}) for number in (1, 0)] == [0, 0]
    assert [call.split()[3] for call in read_calls(site)] == [str(runs / "b"), str(runs / "a")]


@pytest.mark.parametrize("variable", ["SLURM_ARRAY_TASK_ID", "PBS_ARRAY_INDEX", "LSB_JOBINDEX"])
def test_single_run_handed_in_from_an_array_job_takes_no_place_of_that(runs, site, variable):
    """Batch systems hand the variables of the shell that submits on to the job."""
    scheduler = {"S": "slurm", "P": "pbs", "L": "lsf"}[variable[0]]
    job, _ = write_job(runs / "a", scheduler, request_of(scheduler))
    assert run_job(job, **{variable: "3"}) == 0


def test_array_job_of_lsf_counts_from_one(runs, site):
    job, _ = write_job(runs, "lsf", request_of("lsf"))
    assert [run_job(job, LSB_JOBINDEX=number) for number in ("2", "1")] == [0, 0]
    assert [call.split()[3] for call in read_calls(site)] == [str(runs / "b"), str(runs / "a")]
    single, _ = write_job(runs / "a", "lsf", request_of("lsf"))
    (runs / "a/batch/state").unlink()
    assert run_job(single, LSB_JOBINDEX="0") == 0 and len(read_calls(site)) == 3


@pytest.mark.parametrize("scheduler", SCHEDULERS)
def test_jobs_go_on_until_the_run_is_done(runs, site, scheduler):
    run = runs / "a"
    job, _ = write_job(run, scheduler, request_of(scheduler, chain=3))
    (site / "code").write_text("75")
    assert run_job(job) == 75
    (run / "checkpoints").mkdir()
    assert run_job(job) == 75
    (site / "code").write_text("0")
    assert run_job(job) == 0
    assert run_job(job) == 0
    calls = read_calls(site)
    limit = "" if SCHEDULERS[scheduler].warns else f" --wall-limit {2 * HOUR - 300}"
    start = f"-m fbcouple.cli.main run {run} -n 4{limit}"
    assert calls == [f"{start} --resume"] * 3


@pytest.mark.parametrize("left", ["running", "75", "", "runn"])
def test_what_may_go_on_is_started_again(runs, site, left):
    """What was killed, stopped, or left a state cut short by a full disk."""
    run = runs / "a"
    job, _ = write_job(run, "slurm", request_of("slurm"))
    (run / "batch/state").write_text(f"{left}\n")
    assert run_job(job) == 0
    assert read_calls(site)[0].endswith("-n 4 --resume")


@pytest.mark.parametrize("code", ["1", "3", "4"])
def test_failed_run_is_not_tried_again(runs, site, code):
    job, submit = write_job(runs / "a", "slurm", request_of("slurm"))
    (site / "code").write_text(code)
    assert run_job(job) == int(code)
    again = subprocess.run([job], capture_output=True, text=True, check=False, timeout=LONGEST)
    assert again.returncode == int(code) and len(read_calls(site)) == 1
    told = f"{runs / 'a'}: a job before ended with exit code {code} ({runs / 'a/batch/state'}), the run is not started"
    assert told in again.stderr and again.stderr.endswith(f"to start it all the same: {submit}\n")


def test_job_of_a_run_that_is_done_says_so(runs, site):
    job, _ = write_job(runs / "a", "slurm", request_of("slurm"))
    assert run_job(job) == 0
    again = subprocess.run([job], capture_output=True, text=True, check=False, timeout=LONGEST)
    assert again.returncode == 0 and len(read_calls(site)) == 1
    assert (
        again.stdout
        == f"fbcouple batch: {runs / 'a'} is done, a job before brought it to its end ({runs / 'a/batch/state'})\n"
    )


@pytest.mark.parametrize("scheduler", SCHEDULERS)
def test_second_job_of_a_run_under_way_does_not_keep_the_first_from_going_on(runs, site, scheduler):
    """Submitted twice: the second is refused by the run's lock; the first loses its node and comes again."""
    run = runs / "a"
    job, submit = write_job(run, scheduler, request_of(scheduler))
    (run / "batch/state").write_text("running\n")
    done = subprocess.run([submit], check=False, timeout=LONGEST, capture_output=True, text=True)
    assert done.returncode == 0 and f"{run}: a job has begun it" in done.stdout
    assert (run / "batch/state").read_text() == "running\n"
    (site / "sleep").write_text("#!/bin/bash\n")
    (site / "sleep").chmod(0o755)
    (site / "calls").unlink()
    (site / "code").write_text("69")
    assert run_job(job) == 69 and len(read_calls(site)) == 2
    assert (run / "batch/state").read_text() == "running\n"
    (site / "code").write_text("0")
    assert run_job(job) == 0 and (run / "batch/state").read_text() == "0\n"


def test_second_job_is_refused_by_the_lock_and_the_first_comes_again(tmp_path):
    """With the real solvers, and the lock held as a run holds it."""
    run = tmp_path / "run"
    (tmp_path / "case.toml").write_text(CASE)
    call("setup", tmp_path / "case.toml", "-o", run)
    job, _ = write_job(run, "slurm", request_of("slurm", ranks=1))
    with hold(run):
        second = subprocess.run([job], capture_output=True, text=True, check=False, timeout=LONGEST)
    assert second.returncode == 69 and f"{run}: another run is under way in it" in second.stderr, second.stderr
    first = subprocess.run([job], capture_output=True, text=True, check=False, timeout=5 * LONGEST)
    assert first.returncode == 0 and is_complete(run), first.stderr


def test_lock_of_a_lost_node_is_waited_for(runs, site):
    """Refused at first, as the killed run's heartbeat is young; the wait is as long as it takes to be old."""
    run = runs / "a"
    job, _ = write_job(run, "slurm", request_of("slurm"))
    (run / "batch/state").write_text("running\n")
    (site / "code").write_text("69")
    (site / "sleep").write_text(f'#!/bin/bash\necho "sleep $1" >> {site}/calls\necho 0 > {site}/code\n')
    (site / "sleep").chmod(0o755)
    assert run_job(job) == 0
    calls = read_calls(site)
    assert len(calls) == 3 and float(calls[1].removeprefix("sleep ")) > STALE_AFTER


@pytest.mark.parametrize("code", ["0", "4"])
def test_what_the_other_job_came_to_in_the_wait_counts(runs, site, code):
    run = runs / "a"
    job, _ = write_job(run, "slurm", request_of("slurm"))
    (run / "batch/state").write_text("running\n")
    (site / "code").write_text("69")
    (site / "sleep").write_text(f"#!/bin/bash\necho {code} > {run}/batch/state\n")
    (site / "sleep").chmod(0o755)
    assert run_job(job) == int(code) and len(read_calls(site)) == 1
    assert (run / "batch/state").read_text() == f"{code}\n"


def test_killed_run_is_gone_on_with_by_the_next_job(runs, site):
    """As at the end of its time: the run is killed a moment before its job."""
    job, _ = write_job(runs / "a", "slurm", request_of("slurm", chain=2))
    (site / "code").write_text("137")
    assert run_job(job) == 137 and (runs / "a/batch/state").read_text() == "running\n"
    (site / "code").write_text("0")
    assert run_job(job) == 0


@pytest.mark.parametrize("scheduler", SCHEDULERS)
def test_moved_run_is_told(runs, site, scheduler):
    """Neither is the old place made anew nor does the copy hand in the jobs of what it was copied from."""
    job, submit = write_job(runs, scheduler, request_of(scheduler))
    moved = runs.with_name("moved")
    runs.rename(moved)
    done = subprocess.run([moved / "batch" / job.name], capture_output=True, text=True, check=False, timeout=LONGEST)
    assert done.returncode == 1 and f"{runs / 'a'} is no run folder" in done.stderr and not runs.exists()
    handed = subprocess.run([moved / "batch" / submit.name], capture_output=True, text=True, check=False)
    assert handed.returncode == 1 and f"was written for {runs / 'batch'}" in handed.stderr
    assert read_calls(site) == []


@pytest.mark.parametrize("code", ["138", "143"])
def test_notice_before_the_run_can_listen_is_no_failure(runs, site, code):
    """The interpreter is still starting, and ends by the signal: no step was taken, the next job does the work."""
    job, _ = write_job(runs / "a", "slurm", request_of("slurm"))
    (site / "code").write_text(code)
    assert run_job(job, SLURM_JOB_ID="42") == 75
    assert "scontrol requeue 42" in read_calls(site) and (runs / "a/batch/state").read_text() == "75\n"


def test_job_takes_no_code_of_the_folder_it_starts_in(runs, site, tmp_path):
    """With the real interpreter, search paths as people leave them, and modules of every name in the current folder."""
    job, _ = write_job(runs / "a", "slurm", request_of("slurm"))
    job.write_text(job.read_text().replace(str(site / "python"), REAL_PYTHON))
    (runs / "a/manifest.json").unlink()
    here = tmp_path / "here"
    here.mkdir()
    for name in ("fbcouple", "numpy", "argparse", "json"):
        (here / f"{name}.py").write_text("open('ran', 'w').close()")
    (here / "cat").write_text("#!/bin/sh\ntouch ran\n")
    (here / "cat").chmod(0o755)
    lists = {"PATH": f".:{os.environ['PATH']}:", "PYTHONPATH": ":lib", "LD_LIBRARY_PATH": ";.:/lib"}
    done = subprocess.run([job], cwd=here, env=os.environ | lists, capture_output=True, text=True, check=False)
    assert done.returncode == 1 and "is not a run folder" in done.stderr, done.stderr
    assert not (here / "ran").exists()


@pytest.mark.parametrize("chain", [None, 2])
def test_notice_becomes_a_checkpoint_and_a_requeue(runs, site, chain):
    job, _ = write_job(runs / "a", "slurm", request_of("slurm", chain=chain))
    (site / "waits").touch()
    started = subprocess.Popen([job], env=os.environ | {"SLURM_JOB_ID": "42"})
    deadline = time.monotonic() + LONGEST
    while not (site / "waiting").exists():
        assert started.poll() is None and time.monotonic() < deadline
        time.sleep(0.05)
    started.send_signal(signal.SIGUSR1)
    assert started.wait(timeout=LONGEST) == 75
    assert ("scontrol requeue 42" in read_calls(site)) is (chain is None)
    assert (runs / "a/batch/state").read_text() == "75\n"


@pytest.mark.parametrize("scheduler", SCHEDULERS)
@pytest.mark.parametrize(("number", "code"), [(signal.SIGTERM, 75), (signal.SIGINT, 75), (signal.SIGTERM, 3)])
def test_cancelled_job_stops_with_a_checkpoint_and_does_not_come_again(runs, site, scheduler, number, code):
    """`scancel`, `qdel`, `bkill`: not 75, by which LSF requeues, and no `scontrol requeue`. They reach the ranks, too:
    a run that still starts ends with 3, which is no fault of its own, and may be started again."""
    (site / "python").write_text((site / "python").read_text().replace("exit 75", f"exit {code}"))
    job, _ = write_job(runs / "a", scheduler, request_of(scheduler))
    (site / "waits").touch()
    heard = ["env", "--default-signal=INT", job]  # tests in the background of a shell ignore it, and so would the job
    started = subprocess.Popen(heard, env=os.environ | {"SLURM_JOB_ID": "42"})
    deadline = time.monotonic() + LONGEST
    while not (site / "waiting").exists():
        assert started.poll() is None and time.monotonic() < deadline
        time.sleep(0.05)
    started.send_signal(number)
    assert started.wait(timeout=LONGEST) == 143
    assert len(read_calls(site)) == 1 and (runs / "a/batch/state").read_text() == "75\n"


@pytest.mark.parametrize(
    ("scheduler", "calls"),
    [
        ("slurm", ["sbatch --parsable {job}", *["sbatch --parsable --dependency=afterany:17 {job}"] * 2]),
        ("pbs", ["qsub {job}", *["qsub -W depend=afterany:17.box {job}"] * 2]),
        ("lsf", ["bsub ", *["bsub -w ended(17)"] * 2]),
    ],
)
def test_chain_is_handed_in_one_after_the_other(runs, site, scheduler, calls):
    job, submit = write_job(runs / "a", scheduler, request_of(scheduler, chain=3))
    (runs / "a/batch/state").write_text("3\n")
    done = subprocess.run([submit], check=False, timeout=LONGEST, stdout=subprocess.PIPE, text=True)
    assert done.returncode == 0 and read_calls(site) == [call.format(job=job) for call in calls]
    number = {"slurm": "17;box", "pbs": "17.box", "lsf": "17"}[scheduler]
    assert done.stdout.splitlines() == [f"job {number}", *[f"job {number}, after the one before"] * 2]
    assert not (runs / "a/batch/state").exists()


@pytest.mark.parametrize("option", ["--module", "--queue", "--account"])
@pytest.mark.parametrize("name", ["a;rm -rf x", "$(touch x)", "a\n#SBATCH --x", "`x`", "-x", "", "a b", "x" * 200])
def test_name_that_is_none_is_refused(runs, option, name):
    done = batch(runs / "a", "--scheduler", "slurm", "--time", "01:00:00", f"{option}={name}")
    assert done.exit_code == 1 and f"{option}: " in done.stderr and len(done.stderr.splitlines()) == 1
    assert not (runs / "a/batch").exists()


@pytest.mark.parametrize("name", ["a b", "$(x)", "a\nb", "a;b", "a%j", "ü", "a'b"])
def test_path_that_a_script_would_misread_is_refused(tmp_path, name):
    (tmp_path / name).mkdir()
    (tmp_path / name / "manifest.json").touch()
    write_case(load_case("patil/c2"), tmp_path / name / "case.toml")
    with pytest.raises(CaseError, match="move it to a path"):
        write_job(tmp_path / name, "slurm", request_of("slurm"))
    assert not (tmp_path / name / "batch").exists()


@pytest.mark.parametrize("limit", ["1:2", "a:b:c", "00:00:00", "00:61:00", "01:00:61", "-1:00:00", "", "1e3:0:0"])
def test_time_that_is_none_is_a_usage_error(runs, limit):
    assert batch(runs, "--scheduler", "slurm", "--time", limit).exit_code == 2


def test_request_that_cannot_be_met_is_told_at_once(runs, tmp_path):
    done = batch(runs, "--scheduler", "pbs", "--time", "00:04:00", "--queue", "a b")
    assert done.exit_code == 1
    assert [line.split(":")[0] for line in done.stderr.splitlines()] == ["--queue", "--notice", "--chain"]
    assert batch(tmp_path / "nowhere", "--scheduler", "slurm", "--time", "01:00:00").exit_code == 1
    short = batch(runs, "--scheduler", "slurm", "--time", "00:00:30", "--notice", "5")
    assert short.exit_code == 1 and "at least a minute" in short.stderr


@pytest.mark.parametrize("scheduler", SCHEDULERS)
def test_command_line_writes_both_scripts(runs: Path, scheduler: str) -> None:
    done = batch(runs, "--scheduler", scheduler, "--time", "24:00:00", "-n", 2, "--chain", 2)
    assert done.exit_code == 0, done.stderr
    assert sorted(path.name for path in (runs / "batch").iterdir()) == [f"{scheduler}.sh", f"submit-{scheduler}.sh"]


@pytest.mark.parametrize(("ranks", "warned"), [(1, False), (8, False), (64, True)])
def test_more_ranks_than_there_is_work_for_are_told(tmp_path, ranks, warned):
    """2805 cells and 57 296 particles: 64 ranks have 43 cells and 895 particles each."""
    (tmp_path / "a").mkdir()
    (tmp_path / "a/manifest.json").touch()
    write_case(load_case("patil/c1"), tmp_path / "a" / "case.toml")
    done = batch(tmp_path / "a", "--scheduler", "slurm", "--time", "24:00:00", "-n", ranks)
    assert done.exit_code == 0, done.stderr
    assert ("2805 cells and 57296 particles on 64 ranks (43 and 895 a rank)" in done.output) is warned
    assert ("warning" in done.output) is warned


@pytest.mark.parametrize(("memory", "warned"), [(4, True), (100_000, False)])
def test_less_memory_than_is_predicted_is_told(tmp_path, memory, warned):
    (tmp_path / "a").mkdir()
    (tmp_path / "a/manifest.json").touch()
    write_case(load_case("patil/c1"), tmp_path / "a" / "case.toml")
    done = batch(tmp_path / "a", "--scheduler", "slurm", "--time", "24:00:00", "-n", 2, "--memory", memory)
    assert done.exit_code == 0, done.stderr
    assert ("warning" in done.output) is warned
    assert ("--memory: 4 MiB are given for all ranks, and without it" in done.output) is warned
