"""Ray of one node, and the script of scripts/cluster on it."""

import os
import pathlib
import subprocess
import sys

from bench import EXAMPLES, PARTS, Failed, last_lines, output, wait_for

ADDRESS = "127.0.0.1:6379"


class Ray:
    def __init__(self, folder):
        folder.mkdir()
        self.log = folder / "log"
        # Its token is kept in the home.
        self.environment = {**os.environ, "HOME": str(folder), "RAY_ADDRESS": ADDRESS, "RAY_USAGE_STATS_ENABLED": "0"}
        host, port = ADDRESS.split(":")
        command = [
            pathlib.Path(sys.executable).parent / "ray", "start", "--head", "--block", "--num-cpus=2",
            "--include-dashboard=false", "--object-store-memory=100000000",
            f"--node-ip-address={host}", f"--port={port}", f"--temp-dir={folder}",
        ]
        with open(self.log, "w") as log:
            self.head = subprocess.Popen(
                command, env=self.environment, stdin=subprocess.DEVNULL, stdout=log, stderr=log
            )

    def start(self):
        wait_for("Ray to be ready", self._is_ready)

    def sweep(self, sweep):
        command = [sys.executable, EXAMPLES / "sweep_ray.py", "small.toml", str(PARTS), "--hil-sim", sweep.hil_sim]
        return output(command, cwd=sweep.folder, env=self.environment)

    def _is_ready(self):
        if self.head.poll() is not None:
            raise Failed(f"Ray has ended; it said last:\n{last_lines(self.log)}")
        return "Ray runtime started" in self.log.read_text()
