"""What all checks share: the sweep, what it must give, stand-ins for hil-sim, waiting."""

import pathlib
import subprocess
import time

PARTS = 4
PLAN = """\
name = "small"
scenario = "dac-friction"
set = ["duration_s=0.5", "expect=[]"]
seeds = 3
[[vary]]
key = "period_s"
values = [0.005, 0.01]
[[vary]]
key = "robot.load.mass_kg"
from = 0
to = 160
count = 3
"""
EXAMPLES = pathlib.Path(__file__).resolve().parent.parent / "cluster"
LIMIT_S = 120


class Failed(Exception):
    """What was found and what was expected."""


def wait_for(what, holds, limit_s=LIMIT_S):
    end = time.monotonic() + limit_s
    while not holds():
        if time.monotonic() > end:
            raise Failed(f"waited {limit_s} s for {what}")
        time.sleep(0.02)


def output(command, **options):
    """Runs a command to its end and returns what it printed."""
    said = subprocess.run(
        command, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL,
        timeout=LIMIT_S, **options,
    )
    if said.returncode != 0:
        raise Failed(f"{' '.join(map(str, command))}: exit status {said.returncode}\n{said.stdout}")
    return said.stdout


def last_lines(path, count=15):
    return "\n".join(path.read_text(errors="replace").splitlines()[-count:]) if path.exists() else ""


# The part a stand-in is asked for, by its arguments or its engine.
PART = """\
[[ $1 == sweep ]] || exec @hil_sim "$@"
part=${SLURM_ARRAY_TASK_ID:-$((${JOB_COMPLETION_INDEX:--1} + 1))}
[[ "$*" =~ --shard\\ ([0-9]+)/ ]] && part=${BASH_REMATCH[1]}
"""

# Odd parts wait for the even ones after them: two at once are enough.
OUT_OF_ORDER = PART + """\
if ((part % 2)); then
    until [[ -e @marks/$((part + 1)) ]]; do sleep 0.02; done
fi
@hil_sim "$@" || exit
touch "@marks/$part"
"""

# The first that comes is killed amid a row, as one that may write no more. Slurm is told
# to run it again while it still runs: a task that has failed is not, by itself.
KILLED = PART + """\
mkdir @marks/killed 2>/dev/null || exec @hil_sim "$@"
echo "$part" >@marks/part
ulimit -c 0
[[ ${SLURM_JOB_ID-} ]] || exec prlimit --fsize=@bytes @hil_sim "$@"
prlimit --fsize=@bytes @hil_sim "$@"
touch @marks/waiting
exec sleep infinity
"""


class Sweep:
    """One sweep by one engine in a folder of its own, with its hil-sim in `bin`."""

    def __init__(self, parent, hil_sim, plan, whole, name, stand_in=None):
        self.folder = folder = parent / name
        self.plan, self.whole = plan, whole
        self.marks, self.bin = folder / "marks", folder / "bin"
        self.hil_sim = self.bin / "hil-sim"
        for made in (self.marks, self.bin):
            made.mkdir(parents=True)
        (folder / "small.toml").write_text(plan)
        if stand_in is None:
            self.hil_sim.symlink_to(hil_sim)
            return
        header, row = (len(line) for line in whole.splitlines(keepends=True)[:2])
        for name, value in {"hil_sim": hil_sim, "marks": self.marks, "bytes": header + row * 3 // 2}.items():
            stand_in = stand_in.replace(f"@{name}", str(value))
        self.hil_sim.write_text(f"#!/bin/bash\n{stand_in}")
        self.hil_sim.chmod(0o755)

    def merge(self, parts):
        output([self.hil_sim, "merge", *parts, "-o", self.merged], cwd=self.folder)

    @property
    def merged(self):
        return self.folder / "small.csv"

    def is_whole(self):
        merged = self.merged.read_bytes()
        if merged != self.whole:
            raise Failed(f"found {len(merged)} bytes merged, expected the {len(self.whole)} of one process")

    def ended_out_of_order(self):
        ended = sorted(self.marks.iterdir(), key=lambda mark: mark.stat().st_mtime_ns)
        order = [int(mark.name) for mark in ended]
        if not order or any(order.index(part) < order.index(part + 1) for part in order if part % 2):
            raise Failed(f"found parts that end as {order}, expected each even one before the odd one below it")

    def went_on(self, said):
        if not (self.marks / "killed").exists():
            raise Failed("no part was killed")
        if "1 of " not in said or "runs were done before" not in said:
            raise Failed(f"found no part that goes on with the one row it had; it said\n{said}")
