"""Whatever a test of the fault matrix starts ends with it."""

from collections.abc import Iterator

import pytest
from small_bed import end_started


@pytest.fixture(autouse=True)
def nothing_left() -> Iterator[None]:
    """End the runs that a failed test left."""
    yield
    end_started()
