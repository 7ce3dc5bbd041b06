"""The real server on a free port, for tests in Python. It can be killed and started again."""
import os
import pathlib
import re
import signal
import subprocess
import sys

SKIPPED = 77  # Exit code of a test that cannot run here.
SOURCE = pathlib.Path(__file__).resolve().parents[2]
CLIENT = SOURCE / "clients" / "python"
WILLOW = SOURCE / "tests" / "data" / "willow_full_0.05.yaml"

# A lidar that does not localize a robot at once: a robot of seed 2 needs 1.5 m.
SHORT_SIGHTED = ("--fov", "120", "--beams", "121", "--range-max", "6")


def skip(reason):
    """Ends a test that lacks a program; a failure where CORNERFIX_REQUIRE_TOOLS is set."""
    if os.environ.get("CORNERFIX_REQUIRE_TOOLS"):
        sys.exit(f"FAILED: {reason}")
    print(f"SKIPPED: {reason}", file=sys.stderr)
    sys.exit(SKIPPED)


def run(*command):
    """What a command prints; all of it is shown if it fails."""
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert done.returncode == 0, f"{command}: {done.returncode}\n{done.stdout}{done.stderr}"
    return done.stdout


def record_run(cornerfix, log, *options):
    """A simulated run in the Willow Garage building."""
    run(cornerfix, "simulate", WILLOW, log, *options)


class RealServer:
    def __init__(self, cornerfix, database, *options):
        self._command = [cornerfix, "serve", "--db", database, *options]
        self._port = "0"
        self.start()

    def start(self):
        """Comes back at the same address."""
        self._process = subprocess.Popen(
            [*self._command, "--port", self._port],
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
        )
        line = self._process.stdout.readline()
        self.url = re.search(r"http://\S+", line).group()
        self._port = self.url.rsplit(":", 1)[1]

    def kill(self):
        """As kill -9 does: nothing is put in order."""
        with self._process:
            self._process.send_signal(signal.SIGKILL)

    def stop(self):
        with self._process:
            self._process.terminate()
        return self._process.returncode

    def pause(self):
        """As a server that was cut off: connections stay open, and nothing is answered."""
        self._process.send_signal(signal.SIGSTOP)

    def go_on(self):
        self._process.send_signal(signal.SIGCONT)

    def cpu_s(self):
        """Processor time so far."""
        with open(f"/proc/{self._process.pid}/stat", encoding="ascii") as stat:
            fields = stat.read().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
