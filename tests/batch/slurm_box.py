"""A SLURM in a folder: Debian's packages unpacked, not installed; a few processes, ended at the end.

Its node is this machine, or its nodes are hosts as `open_hosts` gives them.
"""

from __future__ import annotations

import contextlib
import os
import pwd
import socket
import subprocess
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

from tests.batch.hosts import NETWORK, Host

PACKAGES = ("slurmctld", "slurmd", "slurm-client", "munge")
CONF = """
ClusterName=box
SlurmctldHost={host}({address})
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
AuthInfo=socket={box}/munge.sock
CredType=cred/munge
PluginDir={plugins}
SlurmctldPort={port}
SlurmdPort={next_port}
StateSaveLocation={box}/state
SlurmdSpoolDir={box}/spool/%n
TmpFS={box}/tmp/%n
SlurmctldPidFile={box}/slurmctld.pid
SlurmdPidFile={box}/slurmd-%n.pid
SlurmctldLogFile={box}/slurmctld.log
SlurmdLogFile={box}/slurmd-%n.log
ProctrackType=proctrack/pgid
TaskPlugin=task/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
ReturnToService=2
SchedulerParameters=batch_sched_delay=1,sched_interval=2
{nodes}
PartitionName=main Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""

NODE = "NodeName={name} NodeAddr={address} CPUs=2 RealMemory=4000 State=UNKNOWN"


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
def open_slurm(folder: Path, hosts: Sequence[Host] = ()) -> Iterator[dict[str, str]]:
    """Start munged, slurmctld and a slurmd a node in `folder`; yields the environment in which sbatch sees them.

    hosts: the nodes; without any this machine is the node."""
    root, box, port = unpack(folder), folder / "box", find_ports()
    libraries = root / "usr/lib/x86_64-linux-gnu"
    here = socket.gethostname().split(".")[0]
    nodes = {host.name: host.address for host in hosts} or {here: "127.0.0.1"}
    for part in ("state", *(f"{each}/{name}" for each in ("spool", "tmp") for name in nodes)):
        (box / part).mkdir(parents=True)
    box.chmod(0o700)
    (box / "munge.key").write_bytes(os.urandom(1024))
    (box / "munge.key").chmod(0o400)
    user = pwd.getpwuid(os.geteuid()).pw_name
    told = {"host": here, "address": f"{NETWORK}.1" if hosts else "127.0.0.1", "user": user, "box": box}
    told |= {"nodes": "\n".join(NODE.format(name=name, address=address) for name, address in nodes.items())}
    told |= {"port": port, "next_port": port + 1, "plugins": libraries / "slurm-wlm"}
    (box / "slurm.conf").write_text(CONF.format(**told))
    environment = os.environ | {
        "LD_LIBRARY_PATH": f"{libraries}:{libraries}/slurm-wlm",
        "PATH": f"{root}/usr/bin:{os.environ['PATH']}",
        "SLURM_CONF": f"{box}/slurm.conf",
    }
    processes: list[subprocess.Popen] = []
    try:
        for command in _list_daemons(root / "usr/sbin", box, hosts):
            nothing = subprocess.DEVNULL
            processes.append(subprocess.Popen(command, env=environment, stdout=nothing, stderr=nothing))
            time.sleep(1.0)
        _await_nodes(environment, len(nodes))
        yield environment
    finally:
        subprocess.run(["scancel", "--user", user], env=environment, capture_output=True, check=False, timeout=30)
        time.sleep(1.0)
        for process in reversed(processes):
            process.terminate()
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(timeout=10)
            process.kill()


def _list_daemons(programs: Path, box: Path, hosts: Sequence[Host]) -> Iterator[list[str]]:
    files = {"key-file": "key", "socket": "sock", "pid-file": "pid", "log-file": "log", "seed-file": "seed"}
    conf = f"{box}/slurm.conf"
    munge = [f"--{option}={box}/munge.{end}" for option, end in files.items()]
    yield [f"{programs}/munged", "--foreground", "--force", *munge]
    yield [f"{programs}/slurmctld-wlm", "-D", "-f", conf]
    node = [f"{programs}/slurmd-wlm", "-D", "-f", conf, "-d", f"{programs}/slurmstepd-wlm"]
    if not hosts:
        yield node
    for host in hosts:
        yield host.enter(*node, "-N", host.name)


def _await_nodes(environment: dict[str, str], count: int) -> None:
    deadline, asked = time.monotonic() + 60.0, ["sinfo", "-h", "-N", "-o", "%T"]
    while time.monotonic() < deadline:
        done = subprocess.run(asked, env=environment, capture_output=True, text=True, check=False)
        if done.stdout.split() == ["idle"] * count:
            return
        time.sleep(1.0)
    raise TimeoutError(f"SLURM's nodes are not up after a minute: {done.stdout} {done.stderr}")
