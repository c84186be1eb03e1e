"""What of a job is the site's: nodes, launcher, binding, lines of its own in the header, and what is run first."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Any

from fbcouple.batch.schedulers import Scheduler
from fbcouple.case.problems import show
from fbcouple.machine.launchers import BINDINGS

_WORD = re.compile(r"[A-Za-z0-9][A-Za-z0-9._@+&|*,:!=\[\]()-]{0,199}")
_IMAGE = re.compile(r"/[A-Za-z0-9._/+:=@,-]{1,3000}")
_LINE = re.compile(r"[\x20-\x7e]{1,1000}")


@dataclass(frozen=True)
class Placement:
    """Where the ranks of a job go and how they get there.

    `tasks_per_node` None: the ranks over the nodes. `headers`: lines of the batch system's own, as they are, after its
    #-word. `prelude`: shell commands before the run, which is not started if one of them fails. `container`: an image
    of Apptainer that has fbcouple in it.
    """

    nodes: int = 1
    tasks_per_node: int | None = None
    launcher: str = "mpirun"
    bind: str = "none"
    headers: tuple[str, ...] = ()
    prelude: tuple[str, ...] = ()
    constraint: str | None = None
    qos: str | None = None
    mail: str | None = None
    container: str | None = None

    @property
    def places(self) -> int | None:
        """Ranks that there is a place for, None where nothing says how many there are on a node."""
        return self.tasks_per_node and self.tasks_per_node * self.nodes


def count_tasks(placement: Placement, ranks: int) -> int:
    """Ranks on each node."""
    return placement.tasks_per_node or math.ceil(ranks / placement.nodes)


def fill_nodes(placement: Placement, ranks: int) -> int:
    """`ranks`, or as many more as make each node have the same number of them."""
    return placement.nodes * math.ceil(ranks / placement.nodes)


def list_placement_problems(placement: Placement, ranks: int, system: Scheduler, scheduler: str) -> list[str]:
    """What of `placement` cannot be met or written into a script, a text each."""
    problems = []
    tasks = count_tasks(placement, ranks)
    if tasks * placement.nodes != ranks:
        text = f"{tasks} on each of {placement.nodes} nodes are {tasks * placement.nodes} places for {ranks} ranks"
        problems.append(f"--nodes: {text}; give --ranks, --nodes and --tasks-per-node that fit.")
    if placement.bind not in BINDINGS[placement.launcher][1]:
        allowed = ", ".join(BINDINGS[placement.launcher][1])
        problems.append(f"--bind: {placement.launcher} has no {placement.bind}, allowed: {allowed}; give one of them.")
    for option, given, lines in _list_words(placement, system):
        if not _WORD.fullmatch(given):
            text = "letters, digits and . _ @ + & | * , : ! = [ ] ( ) - are allowed"
            problems.append(f"{option}: {show(given)} is given, {text}; give the bare word.")
        elif not lines:
            problems.append(f"{option}: {scheduler} has no line for it; give the site's own by --header.")
    for option, texts in (("--header", placement.headers), ("--prelude", placement.prelude)):
        problems += [
            f"{option}: {show(line)} is given, one line of printable ASCII is allowed; give it several times."
            for line in texts
            if not _LINE.fullmatch(line)
        ]
    return problems + _list_container_problems(placement)


def describe_placement(placement: Placement, ranks: int, memory: int, system: Scheduler) -> dict[str, Any]:
    """What templates/batch need of it; `memory` [MiB] is that of all ranks."""
    lines = [line.format(given) for _, given, asked in _list_words(placement, system) for line in asked]
    return {
        "nodes": placement.nodes,
        "tasks": count_tasks(placement, ranks),
        "memory_per_node": math.ceil(memory / placement.nodes),
        "headers": [f"{system.lines.prefix} {line}" for line in (*lines, *placement.headers)],
        "prelude": placement.prelude,
        "launcher": placement.launcher,
        "bind": placement.bind,
        "names_launcher": (placement.launcher, placement.bind) != ("mpirun", "none"),
        "container": placement.container,
    }


def _list_container_problems(placement: Placement) -> list[str]:
    """The launcher is in the image, too: it knows neither the batch system nor other nodes."""
    if placement.container is None:
        return []
    problems = []
    if not _IMAGE.fullmatch(placement.container):
        text = "a path from the root of letters, digits and . _ / + : = @ , - is allowed"
        problems.append(f"--container: {show(placement.container)} is given, {text}; name the image's file.")
    if placement.nodes > 1 or placement.launcher not in ("mpirun", "mpiexec"):
        text = f"the mpirun of the image starts the ranks, on one node; --nodes {placement.nodes}"
        problems.append(f"--container: {text} and --launcher {placement.launcher} are given; take 1 and mpirun.")
    return problems


def _list_words(placement: Placement, system: Scheduler) -> list[tuple[str, str, tuple[str, ...]]]:
    """Option, what is given for it, and the batch system's lines with a place for that, none if it has none."""
    words = (
        ("--constraint", placement.constraint, system.lines.constraint),
        ("--qos", placement.qos, system.lines.qos),
        ("--mail", placement.mail, system.lines.mail),
    )
    listed = [(option, given, (line,) if isinstance(line, str) else line or ()) for option, given, line in words]
    return [(option, given, lines) for option, given, lines in listed if given is not None]
