"""A systemd unit's restrictions of system calls, as a seccomp filter for one process: a test needs no
running systemd. systemd-analyze expands the groups, libseccomp makes the filter."""

import ctypes
import errno
import pathlib
import subprocess

KILL, ALLOW, REFUSE = 0x80000000, 0x7FFF0000, 0x00050000
MASKED_EQUAL = 7
EQUAL = 4
PROT_WRITE, PROT_EXEC = 2, 4
# CLONE_NEWTIME, NEWNS, NEWCGROUP, NEWUTS, NEWIPC, NEWUSER, NEWPID, NEWNET
NAMESPACES = 0x80 | 0x20000 | 0x2000000 | 0x4000000 | 0x8000000 | 0x10000000 | 0x20000000 | 0x40000000
FAMILIES = {"AF_UNIX": 1, "AF_INET": 2, "AF_INET6": 10, "AF_NETLINK": 16}
PR_SET_NO_NEW_PRIVS = 38


def read_unit(path):
    """The values of each key of [Service], in their order."""
    keys, section = {}, ""
    for line in pathlib.Path(path).read_text(encoding="utf-8").splitlines():
        line = line.strip()
        if line.startswith("["):
            section = line
        elif section == "[Service]" and "=" in line and not line.startswith("#"):
            key, _, value = line.partition("=")
            keys.setdefault(key, []).append(value)
    return keys


def groups():
    """The names in each group of system calls; names of other groups are in them as they are."""
    text = subprocess.run(
        ["systemd-analyze", "--no-pager", "syscall-filter"], check=True, capture_output=True, text=True
    ).stdout
    found, name = {}, None
    for line in text.splitlines():
        word = line.strip()
        if line.startswith("@"):
            name = word
            found[name] = []
        elif name and line.startswith(" ") and word and not word.startswith("#"):
            found[name].append(word)
        elif not line.startswith(" "):
            name = None
    return found


def expand(word, known):
    """The system calls of a name or a group."""
    if not word.startswith("@"):
        return {word}
    return set().union(*(expand(part, known) for part in known[word]))


def allowed_calls(unit, known):
    """The calls that its SystemCallFilter allows, in the order of its lines, as systemd.exec(5) says."""
    allowed = expand("@default", known)
    for line in unit["SystemCallFilter"]:
        removes = line.startswith("~")
        for word in line.lstrip("~").split():
            calls = expand(word, known)
            allowed = allowed - calls if removes else allowed | calls
    return allowed


class _Compare(ctypes.Structure):
    _fields_ = [
        ("arg", ctypes.c_uint),
        ("op", ctypes.c_int),
        ("a", ctypes.c_uint64),
        ("b", ctypes.c_uint64),
    ]


class Filter:
    """The filter of a unit. `otherwise`: KILL, or REFUSE as the unit's SystemCallErrorNumber=EPERM."""

    def __init__(self, unit, otherwise=KILL):
        self._seccomp = ctypes.CDLL("libseccomp.so.2", use_errno=True)
        self._libc = ctypes.CDLL(None, use_errno=True)
        self._seccomp.seccomp_init.restype = ctypes.c_void_p
        self._seccomp.seccomp_init.argtypes = [ctypes.c_uint32]
        self._seccomp.seccomp_load.argtypes = [ctypes.c_void_p]
        self._seccomp.seccomp_rule_add_array.argtypes = [
            ctypes.c_void_p, ctypes.c_uint32, ctypes.c_int, ctypes.c_uint, ctypes.POINTER(_Compare),
        ]
        action = otherwise | errno.EPERM if otherwise == REFUSE else otherwise
        self._context = self._seccomp.seccomp_init(action)
        calls = allowed_calls(unit, groups())
        if unit.get("MemoryDenyWriteExecute") == ["yes"]:
            calls -= {"mmap", "mprotect", "pkey_mprotect", "shmat"}
            self._allow("mmap", (2, MASKED_EQUAL, PROT_WRITE, 0))
            self._allow("mmap", (2, MASKED_EQUAL, PROT_EXEC, 0))
            self._allow("mprotect", (2, MASKED_EQUAL, PROT_EXEC, 0))
        if unit.get("RestrictNamespaces") == ["yes"]:
            calls -= {"clone", "clone3", "unshare", "setns"}
            self._allow("clone", (0, MASKED_EQUAL, NAMESPACES, 0))
            # Its flags cannot be seen: libraries then call clone.
            self._rule(REFUSE | errno.ENOSYS, "clone3")
        calls -= {"socket"}
        for family in " ".join(unit["RestrictAddressFamilies"]).split():
            self._allow("socket", (0, EQUAL, FAMILIES[family], 0))
        if unit.get("LockPersonality") == ["yes"]:
            calls -= {"personality"}
        for call in calls:
            self._allow(call)

    def _rule(self, action, call, *conditions):
        number = self._seccomp.seccomp_syscall_resolve_name(call.encode())
        if number < 0:
            return  # of another machine
        array = (_Compare * max(1, len(conditions)))(*(_Compare(*one) for one in conditions))
        code = self._seccomp.seccomp_rule_add_array(self._context, action, number, len(conditions), array)
        if code != 0:
            raise OSError(-code, f"no rule for {call}")

    def _allow(self, call, *conditions):
        self._rule(ALLOW, call, *conditions)

    def enter(self):
        """Restricts this process from here on: for a child before it starts its program."""
        if self._libc.prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0:
            raise OSError(ctypes.get_errno(), "no PR_SET_NO_NEW_PRIVS")
        code = self._seccomp.seccomp_load(self._context)
        if code != 0:
            raise OSError(-code, "no filter")
