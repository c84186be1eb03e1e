"""A SLURM of one node in a folder: Debian's packages unpacked, not installed; three processes, ended at the end."""

from __future__ import annotations

import contextlib
import os
import pwd
import socket
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

PACKAGES = ("slurmctld", "slurmd", "slurm-client", "munge")
CONF = """
ClusterName=box
SlurmctldHost={host}(127.0.0.1)
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
AuthInfo=socket={box}/munge.sock
CredType=cred/munge
PluginDir={plugins}
SlurmctldPort={port}
SlurmdPort={next_port}
StateSaveLocation={box}/state
SlurmdSpoolDir={box}/spool
SlurmctldPidFile={box}/slurmctld.pid
SlurmdPidFile={box}/slurmd.pid
SlurmctldLogFile={box}/slurmctld.log
SlurmdLogFile={box}/slurmd.log
ProctrackType=proctrack/pgid
TaskPlugin=task/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
ReturnToService=2
SchedulerParameters=batch_sched_delay=1,sched_interval=2
NodeName={host} NodeAddr=127.0.0.1 CPUs=2 RealMemory=4000 State=UNKNOWN
PartitionName=main Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""


def unpack(folder: Path) -> Path:
    """Fetch what of `PACKAGES` and their dependencies is not installed, and unpack it under `folder`."""
    wanted = ["apt-get", "install", "--simulate", "--no-install-recommends", *PACKAGES]
    plan = subprocess.run(wanted, capture_output=True, text=True, check=True).stdout
    names = [line.split()[1] for line in plan.splitlines() if line.startswith("Inst ")]
    (folder / "debs").mkdir(parents=True)
    subprocess.run(["apt-get", "download", *names], cwd=folder / "debs", capture_output=True, check=True, timeout=300)
    for package in (folder / "debs").glob("*.deb"):
        subprocess.run(["dpkg", "-x", package, folder / "root"], check=True)
    return folder / "root"


def find_ports() -> int:
    """A port that is free now, and the one after it."""
    while True:
        with socket.socket() as one, socket.socket() as other:
            one.bind(("127.0.0.1", 0))
            port = int(one.getsockname()[1])
            with contextlib.suppress(OSError, OverflowError):
                other.bind(("127.0.0.1", port + 1))
                return port


@contextlib.contextmanager
def open_slurm(folder: Path) -> Iterator[dict[str, str]]:
    """Start munged, slurmctld and slurmd in `folder`; yields the environment in which sbatch and squeue see them."""
    root, box, port = unpack(folder), folder / "box", find_ports()
    libraries = root / "usr/lib/x86_64-linux-gnu"
    plugins = libraries / "slurm-wlm"
    for part in ("state", "spool"):
        (box / part).mkdir(parents=True)
    box.chmod(0o700)
    (box / "munge.key").write_bytes(os.urandom(1024))
    (box / "munge.key").chmod(0o400)
    user, host = pwd.getpwuid(os.geteuid()).pw_name, socket.gethostname().split(".")[0]
    conf = CONF.format(host=host, user=user, box=box, plugins=plugins, port=port, next_port=port + 1)
    (box / "slurm.conf").write_text(conf)
    environment = os.environ | {
        "LD_LIBRARY_PATH": f"{libraries}:{plugins}",
        "PATH": f"{root}/usr/bin:{os.environ['PATH']}",
        "SLURM_CONF": f"{box}/slurm.conf",
    }
    files = {"key-file": "key", "socket": "sock", "pid-file": "pid", "log-file": "log", "seed-file": "seed"}
    munge = [f"--{option}={box}/munge.{end}" for option, end in files.items()]
    commands = [
        [root / "usr/sbin/munged", "--foreground", "--force", *munge],
        [root / "usr/sbin/slurmctld-wlm", "-D", "-f", box / "slurm.conf"],
        [root / "usr/sbin/slurmd-wlm", "-D", "-f", box / "slurm.conf", "-d", root / "usr/sbin/slurmstepd-wlm"],
    ]
    processes: list[subprocess.Popen] = []
    try:
        for command in commands:
            processes.append(
                subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            )
            time.sleep(1.0)
        _await_node(environment)
        yield environment
    finally:
        subprocess.run(["scancel", "--user", user], env=environment, capture_output=True, check=False, timeout=30)
        time.sleep(1.0)
        for process in reversed(processes):
            process.terminate()
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(timeout=10)
            process.kill()


def _await_node(environment: dict[str, str]) -> None:
    deadline = time.monotonic() + 60.0
    while time.monotonic() < deadline:
        done = subprocess.run(["sinfo", "-h", "-o", "%T"], env=environment, capture_output=True, text=True, check=False)
        if done.stdout.strip() == "idle":
            return
        time.sleep(1.0)
    raise TimeoutError(f"SLURM's node is not up after a minute: {done.stdout} {done.stderr}")
