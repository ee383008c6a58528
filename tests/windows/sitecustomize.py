"""Lets ballesta's modules see Windows in this process: what it has not, they cannot have here.

Python imports this file by its name at the start of every process that has its folder in
PYTHONPATH, so also in those that ballesta starts. Modules that only POSIX has can be imported by
nobody, but by psutil and filelock before. Our packages, and they alone, are told that the platform
is Windows and get os, signal, ctypes, subprocess and selectors without what these lack there:
libraries are built for each system, and the ones here are for this one.
"""

import builtins
import multiprocessing.connection
import os
import sys
import types

import filelock
import psutil

assert filelock.FileLock
assert psutil.Process

OURS = {"ballesta", "checks", "fatigue", "fem", "geometry", "loads", "reports"}
POSIX_ONLY = ("fcntl", "grp", "pty", "pwd", "readline", "resource", "syslog", "termios", "tty")
# https://docs.python.org/3/library/os.html and signal.html, "Availability: Unix"
OF_OS = """
    CLD_DUMPED CLD_EXITED CLD_KILLED O_CLOEXEC O_DIRECTORY O_NOFOLLOW O_NONBLOCK O_SYNC P_ALL P_PGID
    P_PID WEXITED WIFEXITED WIFSIGNALED WNOHANG WNOWAIT WTERMSIG chown chroot fchmod fork forkpty
    getegid geteuid getgid getgroups getloadavg getpgid getpgrp getpriority getsid getuid initgroups
    killpg lchown mkfifo mknod nice openpty posix_spawn posix_spawnp pread preadv pwrite pwritev
    register_at_fork sched_getaffinity sched_setaffinity sched_yield sendfile setpgid setpriority
    setsid setuid statvfs sync sysconf uname wait wait3 wait4 waitid
"""
OF_SIGNAL = """
    ITIMER_REAL SIGALRM SIGBUS SIGCHLD SIGCONT SIGHUP SIGKILL SIGPIPE SIGQUIT SIGSTOP SIGUSR1
    SIGUSR2 alarm pause pthread_kill setitimer siginterrupt sigpending sigwait
"""


class Windows(types.ModuleType):
    """A module as it is on Windows: without some names, with others in their place."""

    def __init__(self, real, missing=(), **instead):
        super().__init__(real.__name__)
        self.__dict__.update(instead)
        self.__dict__.update(_real=real, _missing=frozenset(missing))

    def __setattr__(self, name, value):
        setattr(self._real, name, value)  # such as sys.stdout, of which a process has one

    def __getattr__(self, name):
        if name in self._missing:
            raise AttributeError(f"Windows has no {self._real.__name__}.{name}")
        return getattr(self._real, name)


def _ctypes():
    import ctypes

    def of_a_file(kind):
        def load(name, *args, **options):
            if name is None:
                raise TypeError("Windows opens no library without a name")
            return kind(name, *args, **options)

        return load

    return Windows(ctypes, CDLL=of_a_file(ctypes.CDLL), PyDLL=of_a_file(ctypes.PyDLL))


def _subprocess():
    import subprocess

    class Popen(subprocess.Popen):
        """Without sessions, which Windows passes over, and what it refuses; handles are files."""

        def __init__(self, *args, start_new_session=False, **options):
            refused = {"preexec_fn", "process_group", "pass_fds"} & set(options)
            if refused:
                raise ValueError(f"Windows has no {', '.join(refused)}")
            options.pop("creationflags", 0)
            started = options.pop("startupinfo", None)
            handles = [] if started is None else started.lpAttributeList["handle_list"]
            super().__init__(*args, pass_fds=handles, **options)

    class STARTUPINFO:
        """What a process inherits."""

        def __init__(self, *, lpAttributeList):
            self.lpAttributeList = lpAttributeList

    return Windows(
        subprocess,
        Popen=Popen,
        STARTUPINFO=STARTUPINFO,
        CREATE_NEW_PROCESS_GROUP=0x200,
        CREATE_NO_WINDOW=1 << 27,
    )


def _selectors():
    import selectors

    def none(*_):
        raise OSError(10038, "Windows selects sockets only")

    return Windows(selectors, DefaultSelector=none)


MADE = {
    "sys": lambda: Windows(sys, platform="win32"),
    "os": lambda: Windows(os, OF_OS.split(), name="nt", set_handle_inheritable=os.set_inheritable),
    "signal": lambda: Windows(__import__("signal"), OF_SIGNAL.split()),
    "ctypes": _ctypes,
    "subprocess": _subprocess,
    "selectors": _selectors,
    "select": _selectors,
}
_known = {}
_import = builtins.__import__


def import_as_on_windows(name, globals=None, locals=None, fromlist=(), level=0):
    """What the statement `import` calls, with the module that imports in `globals`."""
    module = _import(name, globals, locals, fromlist, level)
    if level or name.partition(".")[0] not in MADE or not _is_ours(globals or {}):
        return module
    if name not in MADE:  # a module of a package, such as os.path
        return module if fromlist else _made(name.partition(".")[0])
    return _made(name)


def _made(name):
    if name not in _known:
        _known[name] = MADE[name]()
    return _known[name]


def _is_ours(globals):
    name = globals.get("__name__")
    if name == "__main__" and globals.get("__spec__") is not None:
        name = globals["__spec__"].name  # of python -m
    return str(name).partition(".")[0] in OURS


multiprocessing.connection.PipeConnection = multiprocessing.connection.Connection
for blocked in POSIX_ONLY:
    sys.modules[blocked] = None
builtins.__import__ = import_as_on_windows
