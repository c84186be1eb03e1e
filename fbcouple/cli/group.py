"""How every command ends: errors become lines on stderr and an exit code, whatever went wrong."""

from __future__ import annotations

import signal
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import click

from fbcouple.errors import CaseError, FbcoupleError, LeftOutWarning
from fbcouple.machine.output import drop
from fbcouple.machine.stop_signals import SIGNALS
from fbcouple.machine.unexpected import EXIT_CODE, report

INTERRUPTED = 130
NO_READER = 128 + signal.SIGPIPE


WORKFLOW = {
    "Prepare": ("cases", "options", "init", "check", "plan", "setup"),
    "Run": ("run", "status", "batch"),
    "Results": ("pool", "post", "report", "claims"),
    "Studies and checks": ("study", "bench", "verify", "validate"),
    "Machine": ("doctor",),
}
"""Headings of the list of commands in `fbcouple --help`, in the order of the work."""
LONGEST_SENTENCE = 1000


class WholeSentences(click.Group):
    """A group whose list of commands gives the first sentence of each in full, over several lines where needed."""

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the list of commands under their headings."""
        for heading, names in self.list_headings(ctx).items():
            found = [(name, self.get_command(ctx, name)) for name in names]
            rows = [(name, command.get_short_help_str(LONGEST_SENTENCE)) for name, command in found if command]
            if rows:
                with formatter.section(heading):
                    formatter.write_dl(rows)

    def list_headings(self, ctx: click.Context) -> dict[str, list[str]]:
        """Heading -> names of the commands below it."""
        return {"Commands": self.list_commands(ctx)}


class Commands(WholeSentences):
    """The commands, with errors of fbcouple turned into one line a problem on stderr and their exit code."""

    def list_headings(self, ctx: click.Context) -> dict[str, list[str]]:
        """The headings of the workflow; a command that is on none of them comes last."""
        placed = [name for names in WORKFLOW.values() for name in names]
        others = [name for name in self.list_commands(ctx) if name not in placed]
        return {heading: list(names) for heading, names in WORKFLOW.items()} | {"Others": others}

    def invoke(self, ctx: click.Context) -> Any:
        try:
            with telling_what_is_left_out():
                return super().invoke(ctx)
        except FbcoupleError as error:
            tell(*(error.problems if isinstance(error, CaseError) else [str(error)]))
            ctx.exit(error.exit_code)
        except KeyboardInterrupt:
            tell("interrupted")
            ctx.exit(INTERRUPTED)
        except (click.ClickException, click.exceptions.Exit, click.Abort):
            raise
        except BrokenPipeError:
            drop(sys.stdout)
            ctx.exit(NO_READER)
        except Exception as error:
            tell(report(error))
            raise SystemExit(EXIT_CODE) from error


@contextmanager
def telling_what_is_left_out() -> Iterator[None]:
    """Print each LeftOutWarning as a line on stderr; others are shown as Python shows them."""
    with warnings.catch_warnings():
        show = warnings.showwarning

        def tell_or_show(message: Warning | str, category: type[Warning], *place: Any, **more: Any) -> None:
            if issubclass(category, LeftOutWarning):
                tell(f"warning: {message}")
            else:
                show(message, category, *place, **more)

        warnings.showwarning = tell_or_show
        yield


def tell(*problems: str) -> None:
    """Print lines on stderr; where that is gone, the exit code alone tells."""
    try:
        for problem in problems:
            click.echo(problem, err=True)
    except OSError:
        drop(sys.stderr)


def finish(code: Any) -> Any:
    """Bring what was printed to its file, and return the exit code: `code`, unless that was 0 and printing failed.

    How the command ended is settled: from here on a signal does not change it.
    """
    for number in SIGNALS:
        signal.signal(number, signal.SIG_IGN)
    for stream in filter(None, (sys.stdout, sys.stderr)):
        try:
            stream.flush()
        except OSError as error:
            drop(stream)
            code = code or (NO_READER if isinstance(error, BrokenPipeError) else EXIT_CODE)
    return code
