"""Options of `fbcouple batch` that are the site's: nodes, launcher, header, prelude; and the file that has them."""

# ruff: noqa: PLC0415  (a command loads only what it needs)

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import Any

import click

from fbcouple.machine.launchers import BINDINGS

_WORDS = ("nodes", "tasks_per_node", "launcher", "bind", "headers", "prelude", "constraint", "qos", "mail", "container")
_NOT_OF_A_SITE = ("site", "trust", "help")
_AT_LEAST_1 = click.IntRange(min=1)


def list_site_options(command: click.Command) -> dict[str, click.Option]:
    """Options of `command` that may stand in a site file, by their words there."""
    options = {one.opts[-1].lstrip("-"): one for one in command.params if isinstance(one, click.Option)}
    return {word: one for word, one in options.items() if word not in _NOT_OF_A_SITE}


def _take_site(ctx: click.Context, _: click.Parameter, name: str | None) -> None:
    """Take what the site file has under `name` for what is not on the command line."""
    from fbcouple.batch.site import read_site

    if name is not None:
        options = list_site_options(ctx.command)
        given = read_site(name, {word: one.multiple for word, one in options.items()})
        ctx.default_map = {str(options[word].name): value for word, value in given.items()}


_OPTIONS = (
    click.option("--nodes", type=_AT_LEAST_1, default=1, show_default=True, help="Nodes that the ranks are on."),
    click.option("--tasks-per-node", type=_AT_LEAST_1, help="Ranks on each node; by default the ranks over the nodes."),
    click.option(
        "--launcher",
        type=click.Choice(list(BINDINGS)),
        default="mpirun",
        show_default=True,
        help="Program that starts the ranks.",
    ),
    click.option(
        "--bind",
        type=click.Choice(["none", "core", "socket", "numa"]),
        default="none",
        show_default=True,
        help="Bind each rank to it, where no other job shares the nodes.",
    ),
    click.option(
        "--header",
        "headers",
        multiple=True,
        metavar="LINE",
        help="Add this line after #SBATCH, #PBS or #BSUB.",
    ),
    click.option(
        "--prelude", multiple=True, metavar="COMMAND", help="Run this first, after the modules; stop if it fails."
    ),
    click.option("--constraint", help="Feature that the nodes must have."),
    click.option("--qos", help="Quality of service."),
    click.option("--mail", metavar="ADDRESS", help="Send mail at the end and at failures."),
    click.option("--container", metavar="IMAGE", help="Run in this image of Apptainer."),
    click.option(
        "--site",
        is_eager=True,
        expose_value=False,
        callback=_take_site,
        metavar="NAME",
        help="Take the options under [NAME] in ~/.config/fbcouple/site.toml for those that are not given.",
    ),
)


def take_placement(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options of a `Placement`, which the command gets as `placement`, and `--site`."""

    @wraps(command)
    def gather(**given: Any) -> Any:
        from fbcouple.batch.placement import Placement

        return command(placement=Placement(**{word: given.pop(word) for word in _WORDS}), **given)

    for option in reversed(_OPTIONS):
        gather = option(gather)
    return gather
