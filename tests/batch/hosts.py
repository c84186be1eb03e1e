"""Hosts on this machine: each has a name and a network of its own, as kernel namespaces, and shares the files.

They reach each other and this machine by a switch, as the nodes of a cluster do. Root is needed.
"""

from __future__ import annotations

import contextlib
import shlex
import subprocess
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

NETWORK = "198.18.77"
"""First three numbers of the addresses, which are for tests of networks (RFC 2544); this machine is the first."""
_BECOME = """
{mounts}
hostname {name} && ip link set lo up
until ip link set {cable} up 2>/dev/null; do sleep 0.1; done
ip address add {address}/24 dev {cable} && exec sleep infinity
"""


@dataclass(frozen=True)
class Host:
    """A host; `process` is the number of the process that holds it open."""

    name: str
    address: str
    process: int

    def enter(self, *command: object) -> list[str]:
        """The command line that runs `command` on this host."""
        return ["nsenter", "-t", str(self.process), "--net", "--uts", "--mount", "--", *map(str, command)]


@contextlib.contextmanager
def open_hosts(folder: Path, names: list[str], others: Mapping[str, Path] | None = None) -> Iterator[list[Host]]:
    """Hosts of `names` that know each other by name; what is written for them lies in `folder`. Closed at the end.

    others: file or folder of this machine -> what the hosts have in its place."""
    addresses = [f"{NETWORK}.{number}" for number in range(2, 2 + len(names))]
    known = folder / "hosts"
    lines = [f"{address} {name}\n" for address, name in zip(addresses, names, strict=True)]
    known.write_text("127.0.0.1 localhost\n" + "".join(lines))
    mounts = "\n".join(
        f"mount --bind {shlex.quote(str(own))} {shlex.quote(path)}"
        for path, own in {"/etc/hosts": known, **(others or {})}.items()
    )
    holders: list[subprocess.Popen] = []
    with contextlib.ExitStack() as ends:
        switch = ends.enter_context(_switch(f"fb{folder.stat().st_ino % 10**8}"))
        for number, (name, address) in enumerate(zip(names, addresses, strict=True)):
            cable = f"{switch}-{number}"
            script = _BECOME.format(mounts=mounts, name=name, cable=cable, address=address)
            holders.append(subprocess.Popen(["unshare", "--net", "--uts", "--mount", "bash", "-ec", script]))
            ends.callback(_end, holders[-1])
            _run(f"ip link add {cable} type veth peer name {cable}p")
            _run(f"ip link set {cable}p master {switch} up")
            _await_network(holders[-1].pid)
            _run(f"ip link set {cable} netns {holders[-1].pid}")
        hosts = [Host(*told, one.pid) for *told, one in zip(names, addresses, holders, strict=True)]
        for host in hosts:
            _await_answer(host)
        yield hosts


def write_agent(folder: Path, hosts: list[Host]) -> Path:
    """A program that starts a command on a host as ssh does: a login of its own, so that nothing of what its caller has
    in the environment comes along."""
    agent = folder / "agent.sh"
    cases = "\n".join(f"    {host.name}) set -- {host.process} ;;" for host in hosts)
    agent.write_text(
        f"""#!/bin/bash
while [[ $1 == -* ]]; do shift; done
name=$1 told="${{*:2}}"
case "$name" in
{cases}
    *) echo "agent: no host $name" >&2; exit 255 ;;
esac
exec env -i HOME="$HOME" PATH=/usr/bin:/bin nsenter -t "$1" --net --uts --mount -- bash -c "$told"
"""
    )
    agent.chmod(0o755)
    return agent


@contextlib.contextmanager
def _switch(name: str) -> Iterator[str]:
    _run(f"ip link add {name} type bridge")
    try:
        _run(f"ip address add {NETWORK}.1/24 dev {name}")
        _run(f"ip link set {name} up")
        yield name
    finally:
        _run(f"ip link delete {name}")  # the cables go with the networks of their hosts


def _run(command: str) -> None:
    subprocess.run(command.split(), check=True, timeout=30)


def _await_network(process: int) -> None:
    """Until `process` has left the network of this machine."""
    here = Path("/proc/self/ns/net").readlink()
    deadline = time.monotonic() + 30.0
    while Path(f"/proc/{process}/ns/net").readlink() == here:
        assert time.monotonic() < deadline, process
        time.sleep(0.05)


def _await_answer(host: Host) -> None:
    deadline = time.monotonic() + 30.0
    while (
        host.address
        not in subprocess.run(host.enter("ip", "address"), capture_output=True, text=True, check=False).stdout
    ):
        assert time.monotonic() < deadline, host
        time.sleep(0.05)


def _end(process: subprocess.Popen) -> None:
    process.kill()
    process.wait()
