"""On what a benchmark ran."""

import datetime
import os
import pathlib
import platform
import subprocess

from . import common


def field_of(path, name):
    for line in pathlib.Path(path).read_text().splitlines():
        if line.startswith(name):
            return line.partition(":")[2].strip()
    return "unknown"


def told(*command):
    return subprocess.run(command, cwd=common.ROOT, check=True, capture_output=True, text=True).stdout.strip()


def commit():
    changed = told("git", "status", "--porcelain", "--untracked-files=no")
    return told("git", "rev-parse", "--short=10", "HEAD") + (" with changes" if changed else "")


def described():
    """What and what it was, in order."""
    memory_kib = int(field_of("/proc/meminfo", "MemTotal").split()[0])
    return {
        "date": datetime.datetime.now(datetime.timezone.utc).strftime("%Y-%m-%d %H:%M UTC"),
        "commit": commit(),
        "processor": f"{field_of('/proc/cpuinfo', 'model name')}, {len(os.sched_getaffinity(0))} cores",
        "memory": f"{memory_kib / 1024**2:.1f} GiB",
        "kernel": f"{platform.system()} {platform.release()}",
        "compiler": told("rustc", "--version"),
        "load before": f"{os.getloadavg()[0]:.1f}",
    }
