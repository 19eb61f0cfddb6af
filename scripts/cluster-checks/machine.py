"""A part of this machine by itself: only the loopback interface, and an end to all
that was started."""

import ctypes
import os
import pathlib
import signal
import socket
import subprocess
import sys

# See unshare(2) and prctl(2).
NEW_MOUNTS, NEW_HOST_NAME, NEW_USER = 0x0002_0000, 0x0400_0000, 0x1000_0000
NEW_PROCESSES, NEW_NETWORK = 0x2000_0000, 0x4000_0000
SIGNAL_WHEN_PARENT_ENDS = 1
LIBC = ctypes.CDLL(None, use_errno=True)

PREPARATIONS = (
    "mount --make-rprivate /",
    "mount -t proc proc /proc",
    "ip link set lo up",
    # With 127.0.0.1 alone getaddrinfo's AI_ADDRCONFIG, which Slurm asks for, finds nothing.
    "ip address add 127.0.0.2/8 dev lo",
)


def run_apart(work):
    """Runs `work` and returns its exit status; everything it started has ended then,
    also where this is broken off."""
    user, group = os.geteuid(), os.getegid()
    kinds = NEW_MOUNTS | NEW_HOST_NAME | NEW_PROCESSES | NEW_NETWORK | (NEW_USER if user else 0)
    if LIBC.unshare(kinds) != 0:
        why = os.strerror(ctypes.get_errno())
        print(f"test-cluster: cannot make namespaces ({why}); in a container run it privileged", file=sys.stderr)
        return 2
    if user:
        for name, text in {"setgroups": "deny", "uid_map": f"0 {user} 1", "gid_map": f"0 {group} 1"}.items():
            pathlib.Path("/proc/self", name).write_text(text)
    first = os.fork()
    if first == 0:
        _first_process(work)
    try:
        return _exit_status(os.waitpid(first, 0)[1])
    finally:
        _end(first)


def _end(first):
    """The kernel ends a namespace with its first process, and waits for it."""
    try:
        os.kill(first, signal.SIGKILL)
        os.waitpid(first, 0)
    except (ProcessLookupError, ChildProcessError):
        pass  # it had ended by itself


def _first_process(work):
    """Adopts what loses its parent, as a first process must."""
    LIBC.prctl(SIGNAL_WHEN_PARENT_ENDS, signal.SIGKILL)
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    child = os.fork()
    if child == 0:
        os._exit(_prepared(work))
    while True:
        ended, status = os.wait()
        if ended == child:
            os._exit(_exit_status(status))


def _prepared(work):
    # Ignored signals stay so in programs that are started.
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_DFL)
    socket.sethostname("localhost")
    for command in PREPARATIONS:
        subprocess.run(command.split(), check=True)
    return work()


def _exit_status(status):
    code = os.waitstatus_to_exitcode(status)
    return code if code >= 0 else 128 - code
