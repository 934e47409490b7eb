"""Processes and what they cost: wall and processor time, peak memory."""

import os
import platform
import subprocess
import tempfile
import time
from dataclasses import dataclass


@dataclass
class Outcome:
    """One finished process. Times in seconds, peak resident memory in bytes."""

    code: int
    output: str
    error: str
    wall: float
    cpu: float
    peak: int


def run(command):
    """Runs a command to its end; any exit code is an Outcome."""
    with tempfile.TemporaryFile() as output, tempfile.TemporaryFile() as error:
        start = time.monotonic()
        child = subprocess.Popen([str(word) for word in command], stdout=output, stderr=error)
        _, status, usage = os.wait4(child.pid, 0)
        wall = time.monotonic() - start
        child.returncode = os.waitstatus_to_exitcode(status)
        texts = []
        for stream in (output, error):
            stream.seek(0)
            texts.append(stream.read().decode(errors="replace"))
    return Outcome(child.returncode, texts[0], texts[1], wall,
                   usage.ru_utime + usage.ru_stime, usage.ru_maxrss * 1024)


def machine():
    """The machine in words, without its name."""
    return f"{os.cpu_count()}-core {platform.machine().replace('_', '-')}"


def load():
    """How many processes wanted a core on average, in the last minute."""
    return os.getloadavg()[0]
