"""Processor load of agent and server in the set-up of the original's measurement.

    python benchmarks/paper_setup.py [--personality NAME] [--seconds S]

The setup of the paper ran for 275 s of real time, with the load of the processes sampled every 2 s:
the agent in one process, the simulation in others, and rosbridge between them. Here `floorwalker
bridge` serves the trial `ariac2023` at speed 1, and `floorwalker bridge --connect` is its agent, in
separate processes. CPU time is that of the process and its descendants, from /proc, so that it
takes Linux. The costs of starting and loading are listed separately. 100 % is one core.
"""

from __future__ import annotations

import argparse
import itertools
import os
import platform
import subprocess
import sys
import tempfile
import time
from pathlib import Path

TRIAL = "ariac2023"
PERIOD = 2.0
"""Seconds between two samples, as in the original."""

TICK = os.sysconf("SC_CLK_TCK") if hasattr(os, "sysconf") else 100
PROC = Path("/proc")


def processes() -> dict[int, tuple[int, float]]:
    """Return the parent of every process, and its CPU seconds with those of ended children."""
    by_pid = {}
    for folder in PROC.iterdir():
        if not folder.name.isdecimal():
            continue
        try:
            stat = (folder / "stat").read_text()
        except OSError:  # it has just ended
            continue
        fields = stat.rpartition(")")[2].split()
        by_pid[int(folder.name)] = (int(fields[1]), sum(map(int, fields[11:15])) / TICK)
    return by_pid


def cpu_of(root: int) -> float:
    """Return the CPU seconds of a process and its descendants."""
    by_pid = processes()
    family = [root] if root in by_pid else []
    for member in family:
        family += [pid for pid, (parent, _) in by_pid.items() if parent == member]
    return sum(by_pid[pid][1] for pid in family)


def bridge(*arguments: str, folder: str, **streams: object) -> subprocess.Popen[str]:
    command = [sys.executable, "-m", "sim.cli", "bridge", TRIAL, *arguments]
    return subprocess.Popen(command, cwd=folder, text=True, **streams)  # type: ignore[call-overload, no-any-return]


def measure(personality: str, seconds: float) -> tuple[float, dict[str, list[float]]]:
    """Return the seconds measured, and the CPU seconds of each process at every sample."""
    with tempfile.TemporaryDirectory() as folder:
        server = bridge(
            *("--personality", "external", "--port", "0", "--speed", "1"),
            *("--duration", str(seconds), "--out", "run"),
            folder=folder,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
        )
        url = server.stderr.readline().split()[-1]
        agent = bridge(
            *("--connect", url, "--personality", personality),
            folder=folder,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        try:
            while "the trial begins" not in (line := server.stderr.readline()):
                if not line:
                    sys.exit(f"the server ended with code {server.wait()}")
            begin = time.monotonic()
            used: dict[str, list[float]] = {"agent": [], "server": []}
            samples = 0
            # The last sample comes before the end, while both are still there to be looked at.
            while samples * PERIOD < seconds:
                time.sleep(max(begin + samples * PERIOD - time.monotonic(), 0.0))
                if server.poll() is not None or agent.poll() is not None:
                    sys.exit("a process ended before its time")
                for name, process in (("agent", agent), ("server", server)):
                    used[name].append(cpu_of(process.pid))
                measured = time.monotonic() - begin
                samples += 1
            server.wait(60)
            agent.wait(60)
            return measured, used
        finally:
            agent.kill()
            server.kill()
            server.stderr.close()


def processor() -> str:
    for line in (PROC / "cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            return line.partition(":")[2].strip()
    return platform.machine()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--personality", default="antagonistic")
    parser.add_argument("--seconds", type=float, default=275.0)
    options = parser.parse_args()
    if not (PROC / "self" / "stat").exists():
        sys.exit("this reads CPU times from /proc, which is not there; run it on Linux")
    measured, used = measure(options.personality, options.seconds)
    print(f"{processor()}, {os.cpu_count()} cores, Python {platform.python_version()}")
    print(f"{TRIAL}, {options.personality}, {measured:.0f} s in real time, % of a core:")
    print(f"{'':8} {'mean':>6} {'worst 2 s':>10} {'CPU s to start':>15}")
    for name, seconds in used.items():
        shares = [(after - before) / PERIOD * 100 for before, after in itertools.pairwise(seconds)]
        mean = (seconds[-1] - seconds[0]) / measured * 100
        print(f"{name:8} {mean:6.2f} {max(shares):10.2f} {seconds[0]:15.2f}")


if __name__ == "__main__":
    main()
