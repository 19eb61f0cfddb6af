"""Slurm of one node, and the array job of scripts/cluster on it."""

import os
import subprocess

from bench import EXAMPLES, PARTS, Failed, last_lines, output, wait_for

CONFIGURATION = """\
ClusterName=sweep
SlurmctldHost=localhost
SlurmUser=root
SlurmdUser=root
CommunicationParameters=NoCtldInAddrAny,NoInAddrAny
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MailProg=/bin/true
KillWait=5
ReturnToService=2
SchedulerParameters=batch_sched_delay=0,sched_min_interval=0,sched_interval=1
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SlurmdParameters=config_overrides
NodeName=localhost CPUs=2
PartitionName=all Nodes=ALL Default=YES
"""


class Slurm:
    def __init__(self, folder):
        self.folder, self.daemons = folder, {}
        self.environment = {**os.environ, "SLURM_CONF": str(folder / "slurm.conf")}

    def start(self):
        folder = self.folder
        for made in (folder, folder / "state", folder / "spool"):
            made.mkdir()
        (folder / "slurm.conf").write_text(CONFIGURATION.format(folder=folder))
        # From 23.11 on control groups are looked for even where nothing uses them; before,
        # this word was not known.
        if self._version() >= (23, 11):
            (folder / "cgroup.conf").write_text("CgroupPlugin=disabled\n")
        key = folder / "munge.key"
        key.write_bytes(os.urandom(1024))
        key.chmod(0o400)
        files = [f"--{what}-file={folder}/munge.{what}" for what in ("key", "pid", "seed", "log")]
        # By force, since the folder is closed to other users.
        self._start("munged", "--foreground", "--force", f"--socket={folder}/munge.socket", *files)
        self._wait_for("munged to be ready", (folder / "munge.socket").exists)
        self._start("slurmctld", "-D")
        self._start("slurmd", "-D")
        self._wait_for("the node to be idle", self._is_idle)

    def sweep(self, sweep):
        script = EXAMPLES / "sweep.sbatch"
        submit = ["sbatch", "--parsable", f"--array=1-{PARTS}", "--cpus-per-task=1", script, "small.toml"]
        environment = {**self.environment, "PATH": f"{sweep.bin}:{os.environ['PATH']}"}
        job = output(submit, cwd=sweep.folder, env=environment).strip()
        try:
            wait_for("the array to end", lambda: self._has_ended(job, sweep.marks))
        except Failed as failed:
            raise Failed(f"{failed}\n{self._ask('scontrol', 'show', 'job', '-o', job)}") from None
        said = "".join(log.read_text() for log in sorted(sweep.folder.glob("sweep-*.log")))
        states = self._ask("scontrol", "show", "job", "-o", job)
        if states.count("JobState=COMPLETED") != PARTS:
            raise Failed(f"found tasks that are not COMPLETED:\n{states}{said}")
        if f"when all are done: hil-sim merge sweeps/small-*-of-{PARTS} -o small.csv" not in said:
            raise Failed(f"found no word of how to merge in\n{said}")
        sweep.merge(sorted((sweep.folder / "sweeps").iterdir()))
        return said

    def _has_ended(self, job, marks):
        waiting = marks / "waiting"
        if waiting.exists():
            waiting.unlink()
            self._run_again(f"{job}_{(marks / 'part').read_text().strip()}")
        return not self._ask("squeue", "--noheader", "--jobs", job)

    def _run_again(self, task):
        self._ask("scontrol", "requeue", task)
        state = "squeue", "--noheader", "--format=%T %r", "--jobs", task
        wait_for(f"{task} to be requeued", lambda: self._ask(*state).strip() == "PENDING BeginTime")
        # By itself it waits for two minutes, until the old credential is void; the new one
        # must be younger by a second.
        self._ask("scontrol", "update", f"JobId={task}", "StartTime=now+3")

    def _version(self):
        year, month, *_ = output(["slurmd", "-V"]).split()[1].split(".")
        return int(year), int(month)

    def _is_idle(self):
        asked = subprocess.run(
            ["sinfo", "--noheader", "--format=%T"], env=self.environment, capture_output=True, text=True
        )
        return asked.stdout.strip() == "idle"

    def _ask(self, *command):
        return output(command, env=self.environment)

    def _start(self, *command):
        with open(self.folder / f"{command[0]}.log", "w") as log:
            self.daemons[command[0]] = subprocess.Popen(
                command, env=self.environment, stdin=subprocess.DEVNULL, stdout=log, stderr=log
            )

    def _wait_for(self, what, holds):
        try:
            wait_for(what, lambda: holds() or self._has_lost_a_daemon())
            lost = self._has_lost_a_daemon()
        except Failed as failed:
            lost = str(failed)
        if lost:
            said = (f"{name} said last:\n{last_lines(self.folder / f'{name}.log')}" for name in self.daemons)
            raise Failed("\n".join([lost, *said]))

    def _has_lost_a_daemon(self):
        return ", ".join(f"{name} has ended" for name, daemon in self.daemons.items() if daemon.poll() is not None)
