"""Processes and what they cost: wall and processor time, peak memory."""

import contextlib
import json
import os
import platform
import signal
import subprocess
import sys
import tempfile
import threading
import time
from dataclasses import asdict, dataclass


@dataclass
class Outcome:
    """One finished process. Times in seconds, peak resident memory in bytes."""

    code: int
    output: str
    error: str
    wall: float
    cpu: float
    peak: int
    timed_out: bool = False


def run(command, timeout=None, folder=None):
    """Runs a command to its end, or for `timeout` seconds; any exit code is an Outcome."""
    with tempfile.TemporaryFile() as output, tempfile.TemporaryFile() as error:
        start = time.monotonic()
        child = subprocess.Popen([str(word) for word in command], stdout=output, stderr=error,
                                 cwd=folder, start_new_session=True)
        expired = threading.Event()
        timer = threading.Timer(timeout or threading.TIMEOUT_MAX, end, (child.pid, expired))
        timer.daemon = True
        timer.start()
        try:
            _, status, usage = os.wait4(child.pid, 0)
        except KeyboardInterrupt:
            end(child.pid, expired)
            raise
        finally:
            timer.cancel()
        wall = time.monotonic() - start
        child.returncode = os.waitstatus_to_exitcode(status)
        texts = []
        for stream in (output, error):
            stream.seek(0)
            texts.append(stream.read().decode(errors="replace"))
    return Outcome(child.returncode, texts[0], texts[1], wall,
                   usage.ru_utime + usage.ru_stime, usage.ru_maxrss * 1024, expired.is_set())


def run_apart(command, timeout=None, folder=None):
    """As `run`, by a small process of its own: a child is born with the peak memory of its parent,
    which may have loaded much."""
    asked = json.dumps([[str(word) for word in command], timeout, str(folder) if folder else None])
    answer = subprocess.run([sys.executable, "-S", "-B", __file__, asked], capture_output=True,
                            text=True, check=True)
    return Outcome(**json.loads(answer.stdout))


def end(process_id, expired):
    """Ends a process and those that it started."""
    expired.set()
    with contextlib.suppress(ProcessLookupError):
        os.killpg(process_id, signal.SIGKILL)


def machine():
    """The machine in words, without its name."""
    return f"{os.cpu_count()}-core {platform.machine().replace('_', '-')}"


def load():
    """How many processes wanted a core on average, in the last minute."""
    return os.getloadavg()[0]


if __name__ == "__main__":
    print(json.dumps(asdict(run(*json.loads(sys.argv[1])))))
