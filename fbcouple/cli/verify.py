"""`fbcouple verify`: both solvers and the coupling against analytic and published numbers."""

# ruff: noqa: PLC0415  (a command loads only what it needs)

from __future__ import annotations

from pathlib import Path

import click

from fbcouple.cli.arguments import JSON_ELSEWHERE, take_json

DIVERGED = 4


@click.command()
@click.argument("names", nargs=-1, metavar="[NAME]...")
@click.option("--fast", is_flag=True, help="Run only the fast checks.")
@take_json
@click.pass_context
def verify(ctx: click.Context, names: tuple[str, ...], fast: bool, file: Path | None) -> None:
    """Check both solvers and the coupling against analytic and published numbers; exit code 4 if a check fails."""
    from fbcouple.results.tables import write_json
    from fbcouple.verify.suite import choose_checks, run_checks

    rows = []
    for row in run_checks(choose_checks(names, fast)):
        rows.append(row)
        verdict = "pass" if row["passed"] else "FAIL"
        unit = "" if row["unit"] == "1" else f" {row['unit']}"
        numbers = f"{row['value']:.6g}{unit}, expected {row['expected']:.6g} +- {row['tolerance']:.2g}"
        click.echo(f"{verdict}  {row['name']}: {numbers} ({row['seconds']:.1f} s)")
    if file:
        write_json(file, {"checks": rows}, {}, JSON_ELSEWHERE)
    failed = sum(not row["passed"] for row in rows)
    click.echo(f"{len(rows) - failed} passed, {failed} failed")
    if failed:
        ctx.exit(DIVERGED)
