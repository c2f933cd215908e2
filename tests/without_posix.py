"""The packages and their tests on a Python that has nothing of POSIX, as that of Windows.

``pytest -p tests.without_posix``, or ``import tests.without_posix`` before all else in a process
of a test: what these packages import is then without the modules and functions that Windows lacks;
those of others see to that themselves. It is no Windows: paths, processes and signals stay those of
this system.
"""

import builtins
import os
import signal
from types import ModuleType

MODULES = {"fcntl", "grp", "pwd", "pty", "resource", "termios", "tty"}
#: "Availability: Unix" in Python's documentation.
NAMES = {
    "os": {
        *("O_NONBLOCK", "O_NOFOLLOW", "O_DIRECTORY", "O_CLOEXEC", "O_SYNC", "O_ACCMODE"),
        *("fchmod", "fchown", "chown", "lchown", "chroot", "mkfifo", "mknod", "openpty", "fork"),
        *("getuid", "geteuid", "getgid", "getegid", "getgroups", "getpgid", "getpgrp", "setsid"),
        *("killpg", "nice", "getloadavg", "sched_getaffinity", "uname", "sysconf", "statvfs"),
        *("wait", "waitid", "WNOHANG", "EX_OK"),
    },
    "signal": {
        *("SIGALRM", "SIGCHLD", "SIGCONT", "SIGHUP", "SIGKILL", "SIGPIPE", "SIGQUIT", "SIGSTOP"),
        *("SIGTSTP", "SIGUSR1", "SIGUSR2", "alarm", "setitimer", "pause", "pthread_sigmask"),
    },
}
OURS = {"tests"}  # and what begins with mgeo

calls = []  # of the stand-in for Windows' locks of files


def _msvcrt() -> ModuleType:
    """A stand-in for Windows' module of that name, by locks of this system."""
    import fcntl

    def locking(descriptor: int, mode: int, count: int) -> None:
        calls.append((mode, count))
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            raise PermissionError(13, "Permission denied") from error

    module = ModuleType("msvcrt")
    module.__dict__.update(LK_NBLCK=2, locking=locking)
    return module


def _without(module: ModuleType) -> ModuleType:
    rest = ModuleType(module.__name__)
    missing = NAMES[module.__name__]
    rest.__dict__.update({k: v for k, v in vars(module).items() if k not in missing})
    return rest


def _install() -> None:
    stand_ins = {"msvcrt": _msvcrt(), "os": _without(os), "signal": _without(signal)}
    real = builtins.__import__

    def imported(name, globals=None, locals=None, fromlist=(), level=0):
        importer = (globals or {}).get("__name__", "").partition(".")[0]
        if level == 0 and (importer in OURS or importer.startswith("mgeo")):
            if name in MODULES:
                raise ModuleNotFoundError(f"No module named {name!r}", name=name)
            if name in stand_ins:
                return stand_ins[name]
        return real(name, globals, locals, fromlist, level)

    builtins.__import__ = imported


_install()
