"""Room that a run needs: cores, memory, disk."""

import os
import re
import shutil
from pathlib import Path

from fbcouple.doctor.row import Row

_GIBIBYTE = 2**30
_MEMORY = 2.0
_DISK = 2.0


def list_room() -> list[Row]:
    """A row for each of them."""
    return [_cores(), _memory(), _disk()]


def _cores() -> Row:
    cores = len(os.sched_getaffinity(0))
    return Row("cores", str(cores), ">=1", cores >= 1, "give this process a core")


def _memory() -> Row:
    words = re.search(r"^MemAvailable:\s+(\d+) kB", Path("/proc/meminfo").read_text(encoding="utf-8"), re.MULTILINE)
    free = int(words[1]) * 1024 / _GIBIBYTE if words else 0.0
    return Row(
        "free memory",
        f"{free:.1f} GiB",
        f">={_MEMORY} GiB",
        free >= _MEMORY,
        "end other programs, or take a bigger machine",
    )


def _disk() -> Row:
    folder = Path.cwd()
    free = shutil.disk_usage(folder).free / _GIBIBYTE
    mend = f"free space in {folder}, or run fbcouple on another disk"
    return Row("free disk", f"{free:.1f} GiB", f">={_DISK} GiB", free >= _DISK, mend)
