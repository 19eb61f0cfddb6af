"""GNU parallel, as the README calls it."""

import os

from bench import PARTS, output


class Parallel:
    def sweep(self, sweep):
        command = ["parallel", "--jobs", "2", "--retries", "3", "hil-sim sweep small.toml --shard {}/%d" % PARTS, ":::"]
        environment = {**os.environ, "HOME": str(sweep.folder), "PATH": f"{sweep.bin}:{os.environ['PATH']}"}
        said = output([*command, *map(str, range(1, PARTS + 1))], cwd=sweep.folder, env=environment)
        sweep.merge(sorted((sweep.folder / "sweeps").iterdir()))
        return said
