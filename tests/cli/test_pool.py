"""`fbcouple pool`, and what takes a pool: real replicas of a few beads."""

from __future__ import annotations

import json

import pytest
from click.testing import CliRunner

from fbcouple.cli.main import cli
from fbcouple.decks.set_up import lay_out
from fbcouple.results.reader import open_results

BED = """
title = "beads that fall"
end_time = 0.03
[domain]
size = [0.01, 0.006, 0.02]
cells = [5, 3, 10]
[particles]
diameter = 1e-3
density = 2500.0
count = 60
[contact]
stiffness = 100.0
restitution = 0.9
wall_restitution = 0.9
friction = 0.1
wall_friction = 0.1
[start]
[averages]
start = 0.01
every = 1e-3
blocks = 4
[output]
record_every = 1e-3
"""


def call(*arguments):
    return CliRunner().invoke(cli, list(map(str, arguments)), catch_exceptions=False)


@pytest.fixture(scope="module")
def three(tmp_path_factory):
    """A folder of three replicas that are complete."""
    folder = tmp_path_factory.mktemp("pool")
    (folder / "case.toml").write_text(BED, encoding="utf-8")
    lay_out(str(folder), folder / "three", (), False, forced=True)
    done = call("run", folder / "three", "--replicas", 3, "-j", 2)
    assert done.exit_code == 0, done.output
    return folder / "three"


def test_replicas_are_pooled_into_their_folder_and_twice(three):
    for _ in range(2):
        done = call("pool", three)
        assert done.exit_code == 0, done.output
        assert "results.nc: 3 replicas, 0.06" in done.output and "uncertain by 50 %" in done.output
    assert open_results(three / "results.nc").replicas == 3
    samples = [open_results(three / f"replica-{n}").data.attrs["averaging_samples"] for n in (1, 2, 3)]
    assert all(19 <= count <= 21 for count in samples)
    assert open_results(three).data.attrs["averaging_samples"] == sum(samples)


@pytest.mark.parametrize("place", ["replica-2/results.nc", "../three/replica-1/results.nc"])
def test_no_replica_s_own_results_are_written_over(three, tmp_path, place):
    kept = (three / place).read_bytes()
    done = call("pool", three, "-o", three / place)
    assert done.exit_code == 1 and "is one of the files that are pooled" in done.output
    link = tmp_path / "link.nc"
    link.symlink_to(three / place)
    done = call("pool", three, "-o", link)
    assert done.exit_code == 1 and "is one of the files that are pooled" in done.output
    assert (three / place).read_bytes() == kept


def test_no_other_run_s_results_are_written_over(three):
    """Two of three are pooled; the third is a run, too."""
    kept = (three / "replica-3/results.nc").read_bytes()
    done = call("pool", three / "replica-1", three / "replica-2", "-o", three / "replica-3/results.nc")
    assert done.exit_code == 1 and "holds the results of the run in that folder" in done.output
    assert (three / "replica-3/results.nc").read_bytes() == kept


def test_solids_are_kept_by_the_pool(three):
    """The mean solids volume is that of 60 beads, in the pool as in each replica."""
    for path in (three, three / "replica-1"):
        volume = open_results(path).mean("solids_fraction").sum() * 0.002**3
        assert float(volume) == pytest.approx(60 * 3.14159265 / 6 * 1e-9, rel=1e-6)


def test_what_takes_a_run_takes_replicas_and_files(three, tmp_path):
    file = tmp_path / "small.nc"
    assert call("pool", three, "-o", file, "--reduced").exit_code == 0
    for path, home in ((three, three), (file, tmp_path / "small")):
        assert call("post", path, "--only", "solids_fraction").exit_code == 0
        assert (home / "figures/solids_fraction.png").is_file()
        assert call("report", path).exit_code == 0
        told = json.loads((home / "report.json").read_text(encoding="utf-8"))["runs"][0]
        assert {"what": "replicas", "value": 3} in told["solved"] and told["label"] == path.stem
        assert call("claims", path).exit_code == 0


def test_runs_of_different_days_add_up(three, tmp_path):
    first, both = tmp_path / "first.nc", tmp_path / "both.nc"
    assert call("pool", three / "replica-1", "-o", first, "--reduced").exit_code == 0
    done = call("pool", first, three / "replica-2", "-o", both)
    assert done.exit_code == 0 and "2 replicas" in done.output and "little worth" in done.output
    assert open_results(both).replicas == 2 and open_results(both).data.sizes["y"] == 1
    again = call("pool", both, three / "replica-2", "-o", tmp_path / "no.nc")
    assert again.exit_code == 1 and "is the same run as replica-2" in again.output


def test_a_run_that_went_on_is_no_second_replica(three, tmp_path):
    run, early = tmp_path / "one", tmp_path / "early.nc"
    assert call("setup", three / "replica-1", "-o", run, "--set", "checkpoint.moment_steps=1").exit_code == 0
    assert call("run", run, "--until", 0.02).exit_code == 0
    assert call("pool", run, "-o", early, "--reduced").exit_code == 0
    assert call("run", run, "--resume").exit_code == 0
    done = call("pool", early, run, "-o", tmp_path / "no.nc")
    assert done.exit_code == 1 and not (tmp_path / "no.nc").exists()
    assert "one: is the same run as one, maybe at another of its times" in done.output
    assert "start.seed = 1" in done.output and "the same set-up" in done.output


def test_a_file_has_to_be_named_for_runs(three):
    done = call("pool", three / "replica-1", three / "replica-2")
    assert done.exit_code == 1 and "say where to, as -o pooled.nc" in done.output
