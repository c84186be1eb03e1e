"""The batch systems: how a job script is handed in, how it knows its place in an array, and whether it can requeue."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

Submit = Callable[[str], tuple[str, str]]
"""Job script (quoted for the shell) -> lines that hand in the first job, and one more that waits for it."""


@dataclass(frozen=True)
class Lines:
    """The word that lines of a job script's header begin with, and those for what not every batch system has: a feature
    of nodes, a quality of service, mail at the end and at failures; None where it has none of its own."""

    prefix: str
    constraint: str | None = None
    qos: str | None = None
    mail: tuple[str, ...] = ()


@dataclass(frozen=True)
class Scheduler:
    """`index`: shell expression for the run's number in an array, from 0; `requeues`: a job can start itself again."""

    submit: Submit
    index: str
    requeues: bool
    warns: bool
    """Whether it sends USR1 before the limit; otherwise the run watches the clock itself."""
    lines: Lines


SCHEDULERS: dict[str, Scheduler] = {}


def scheduler(name: str, index: str, requeues: bool, warns: bool, lines: Lines) -> Callable[[Submit], Submit]:
    """Register `submit`, with templates/batch/NAME.sh as its job script."""

    def register(submit: Submit) -> Submit:
        SCHEDULERS[name] = Scheduler(submit, index, requeues, warns, lines)
        return submit

    return register


_SLURM = Lines("#SBATCH", '--constraint="{}"', "--qos={}", ("--mail-user={}", "--mail-type=END,FAIL"))


@scheduler("slurm", index="${SLURM_ARRAY_TASK_ID:-0}", requeues=True, warns=True, lines=_SLURM)
def _slurm(job: str) -> tuple[str, str]:
    first = f"previous=$(sbatch --parsable {job})"
    return first, f'previous=$(sbatch --parsable --dependency=afterany:"${{previous%%;*}}" {job})'


_PBS = Lines("#PBS", mail=("-M {}", "-m ae"))


@scheduler("pbs", index="${PBS_ARRAY_INDEX:-0}", requeues=False, warns=False, lines=_PBS)
def _pbs(job: str) -> tuple[str, str]:
    return f"previous=$(qsub {job})", f'previous=$(qsub -W depend=afterany:"$previous" {job})'


_LSF = Lines("#BSUB", constraint='-R "select[{}]"', mail=("-u {}", "-N"))


@scheduler("lsf", index="$((${LSB_JOBINDEX:-0} > 0 ? LSB_JOBINDEX - 1 : 0))", requeues=True, warns=True, lines=_LSF)
def _lsf(job: str) -> tuple[str, str]:
    number = "| sed -n 's/^Job <\\([0-9]*\\)>.*/\\1/p'"
    return f"previous=$(bsub < {job} {number})", f'previous=$(bsub -w "ended($previous)" < {job} {number})'
