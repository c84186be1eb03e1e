"""Maps of the mean temperatures: weighted over the depth, one scale, grey where there are no particles."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from fbcouple.postproc.figures.temperature import temperature
from fbcouple.results.reader import NotMeantError, open_results
from tests.postproc.whole_run import write_whole


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    return open_results(write_whole(tmp_path_factory.mktemp("warm") / "bed"))


def test_gas_is_weighted_by_voidage_and_particles_by_mass(results):
    solids = results.data["solids_fraction"].copy()
    n = solids.sizes["y"] // 2
    front, m = np.arange(solids.sizes["y"])[None, :, None] < n, solids.sizes["y"] - n
    solids.values = np.where(solids.values > 0.0, np.where(front, 0.1, 0.5), 0.0)
    warm = np.where(front, 300.0, 400.0) + 0.0 * solids.values
    data = results.data.assign(
        solids_fraction=solids,
        voidage=1.0 - solids,
        gas_temperature=solids.copy(data=warm),
        solids_temperature=solids.copy(data=np.where(solids.values > 0.0, warm, np.nan)),
    )
    picture = temperature(replace(results, data=data))
    gas, particles, bar = picture.axes
    assert [axes.get_title() for axes in (gas, particles)] == ["Gas", "Particles"]
    assert bar.get_ylabel() == "Temperature [K]"
    maps = [np.ma.filled(axes.collections[0].get_array(), np.nan) for axes in (gas, particles)]
    assert maps[0][0] == pytest.approx((0.9 * n * 300.0 + 0.5 * m * 400.0) / (0.9 * n + 0.5 * m))
    assert maps[0][-1] == pytest.approx((300.0 * n + 400.0 * m) / (n + m))
    assert maps[1][0] == pytest.approx((0.1 * n * 300.0 + 0.5 * m * 400.0) / (0.1 * n + 0.5 * m))
    assert np.isnan(maps[1][-1]).all()
    lowest, highest = gas.collections[0].get_clim()
    assert (lowest, highest) == pytest.approx((maps[0].min(), np.nanmax(maps[1])))


def test_results_without_heat_are_not_meant(results):
    with pytest.raises(NotMeantError):
        temperature(results)
