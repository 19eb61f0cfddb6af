#!/usr/bin/env python3
"""A sweep on Ray: a part for each task, made one at the end.

  sweep_ray.py load.toml 8                       here, or where RAY_ADDRESS says
  sweep_ray.py load.toml 100 --threads 4 --hil-sim /shared/bin/hil-sim

All nodes must see the plan, the folder and hil-sim under the same paths. A part whose
node is lost, or that is killed, goes on where it was, and so do all of them when the
same command is run again.
"""

import argparse
import pathlib
import subprocess
import sys

import ray


# Of hil-sim that was told to end, as where its node is drained.
INTERRUPTED = 130


class Ended(Exception):
    """A signal ended hil-sim."""


@ray.remote(max_retries=5, retry_exceptions=[Ended])
def sweep(hil_sim, plan, part, parts, folder, threads):
    command = [hil_sim, "sweep", plan, "--shard", f"{part}/{parts}", "--out", folder, "--threads", str(threads)]
    status = subprocess.run(command).returncode
    if status < 0 or status == INTERRUPTED:
        raise Ended(f"part {part} of {parts}: exit status {status}")
    return status


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("plan", metavar="PLAN.toml", type=pathlib.Path)
    parser.add_argument("parts", metavar="PARTS", type=int, help="how many; several a processor share the load well")
    parser.add_argument("--hil-sim", default="hil-sim", metavar="PATH", help="the program, without it that of PATH")
    parser.add_argument("--threads", type=int, default=1, metavar="N", help="of each part; default 1")
    parser.add_argument("--out", type=pathlib.Path, default="sweeps", metavar="DIR", help="of parts; default sweeps")
    options = parser.parse_args()
    plan = options.plan.resolve()
    folders = [f"{options.out.resolve()}/{plan.stem}-{part}-of-{options.parts}" for part in range(1, options.parts + 1)]

    task = sweep.options(num_cpus=options.threads)
    statuses = ray.get([
        task.remote(options.hil_sim, str(plan), part, options.parts, out, options.threads)
        for part, out in enumerate(folders, start=1)
    ])
    if any(statuses):
        sys.exit(max(statuses))
    sys.exit(subprocess.run([options.hil_sim, "merge", *folders, "-o", f"{plan.stem}.csv"]).returncode)


if __name__ == "__main__":
    main()
