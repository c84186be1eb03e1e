"""`fbcouple pool`: the means of replicas as one file."""

# ruff: noqa: PLC0415  (a command loads only what it needs)

from __future__ import annotations

from pathlib import Path

import click

from fbcouple.errors import CaseError
from fbcouple.paths import expand_replicas, list_replicas
from fbcouple.run_folder.plain_files import require_plain


@click.command()
@click.argument("runs", nargs=-1, required=True, metavar="RUN...", type=click.Path(path_type=Path))
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path, dir_okay=False),
    help="File, as pooled.nc; by default results.nc in the folder of the replicas.",
)
@click.option(
    "--reduced",
    is_flag=True,
    help="Keep depth averages alone, and of each replica what is needed to pool it with others later: a small file.",
)
@click.option(
    "--from",
    "start",
    type=click.FloatRange(min=0.0),
    metavar="SECONDS",
    help="Means of the blocks of the averaging window that begin at this time or after it, as if averages.start had "
    "been later: depth averages of the solids, as --reduced.",
)
def pool(runs: tuple[Path, ...], output: Path | None, reduced: bool, start: float | None) -> None:
    """Pool the means of RUNs of one case with different seeds: run folders, folders of replicas, reduced files.

    The file is one that `post`, `report`, `claims` and `validate --run` take like a run.
    """
    for run in runs:
        require_plain(run)
    from fbcouple.case.schema.reference import list_defaults
    from fbcouple.postproc.averaging import find_start_up_in_means
    from fbcouple.results.pools import write_pool
    from fbcouple.results.reader import open_results

    if output is None and not (len(runs) == 1 and list_replicas(runs[0])):
        raise CaseError(["-o: no file is given, and RUN is no folder of replicas; say where to, as -o pooled.nc."])
    path = output or runs[0] / "results.nc"
    data = write_pool(runs, path, reduced, start, list_defaults())
    for run in expand_replicas(runs) if start is None else [path]:
        try:
            mark = find_start_up_in_means(open_results(run))
        except CaseError:  # without means: the pool of its folder left it out, or there is nothing to say
            continue
        if mark:
            click.echo(f"warning: {run}: {mark.sentence}")
    count, seconds = int(data.attrs["replicas"]), float(data.attrs["averaged_seconds"])
    click.echo(f"{path}: {count} replicas, {seconds:.6g} s averaged; {data.attrs['pooled_errors']}")
