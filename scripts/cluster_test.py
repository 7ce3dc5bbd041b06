#!/usr/bin/python3
"""Servers on one PostgreSQL behind HAProxy, under faults: see cluster_test.sh."""

import argparse
import contextlib
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time

SOURCE = pathlib.Path(__file__).resolve().parents[1]
sys.path.insert(0, str(SOURCE / "tests" / "system"))
from cluster_fleet import SCANS_PER_BATCH, Client, Fleet, Run  # noqa: E402
from real_server import SHORT_SIGHTED, WILLOW, RealServer, record_run, run, skip  # noqa: E402
from replicas import NOT_INSTALLED, HaProxy, Postgresql  # noqa: E402

REPLICAS = 3
PROMISED_S = 5.0  # A robot is served again within it.
SILENT = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
DEADLINE_S = 60.0  # For anything to happen at all.
DISK_MB = 160  # Of the tmpfs with the database.
# A database that begins with little and needs its disk soon.
SMALL_DATABASE = "max_wal_size = 48MB\nmin_wal_size = 32MB\ncheckpoint_timeout = 30s\n"


class Broken(Exception):
    """A promise that was not kept."""


def wait_until(is_so, what):
    """What `is_so` returns once that is true."""
    deadline = time.monotonic() + DEADLINE_S
    while not (value := is_so()):
        if time.monotonic() > deadline:
            raise Broken(f"after {DEADLINE_S:.0f} s: {what}")
        time.sleep(0.02)
    return value


class Cluster:
    """PostgreSQL, `replicas` servers and HAProxy, until the end of a `with`."""

    def __init__(self, options, directory, replicas):
        self._stack = contextlib.ExitStack()
        self._directory = directory
        self.disk = self._mount() if options.full_disk else None
        self.database = Postgresql(directory / "postgresql")
        status = self.database.start()
        if status == NOT_INSTALLED:
            skip("PostgreSQL is not installed")
        assert status == 0, "PostgreSQL did not start"
        self._stack.callback(self.database.control, "stop")
        if self.disk:
            self._keep_small()
        url = self.database.new_database()
        self.replicas = []
        for _ in range(replicas):
            self.replicas.append(RealServer(options.cornerfix, url))
            self._stack.callback(self.replicas[-1].stop)
        self.proxy = HaProxy(directory, self.replicas, most_connections=4 * options.robots + 100)
        self._stack.callback(self.proxy.stop)
        with Client(self.proxy.url) as client:
            client.import_map_server("willow", WILLOW)
        self.wait_for_replicas()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._stack.close()

    def wait_for_replicas(self):
        wait_until(
            lambda: self.proxy.servers_up() == len(self.replicas), "the proxy misses a server"
        )

    def _mount(self):
        """A small file system for the database; None where that is not allowed."""
        disk = self._directory / "postgresql"
        disk.mkdir()
        done = subprocess.run(
            ["mount", "-t", "tmpfs", "-o", f"size={DISK_MB}m", "tmpfs", disk], capture_output=True
        )
        if done.returncode != 0:
            return None
        self._stack.callback(run, "umount", disk)
        return disk

    def _keep_small(self):
        with open(self.disk / "data" / "postgresql.conf", "a", encoding="utf-8") as settings:
            settings.write(SMALL_DATABASE)
        self.database.control("stop")
        assert self.database.start() == 0, "PostgreSQL did not start again"


# The faults. Each returns when the fault was over for robots whose server is in order: at its
# beginning where another replica takes over, else when the database was back.


def nothing(_cluster, _fleet):
    return time.monotonic()


def kill_a_replica(cluster, fleet):
    begin = time.monotonic()
    cluster.replicas[0].kill()
    wait_until(lambda: fleet.served_since(begin), "a robot of a killed replica is not served")
    cluster.replicas[0].start()
    cluster.wait_for_replicas()
    return begin


def cut_a_replica_off(cluster, fleet):
    begin = time.monotonic()
    cluster.replicas[1].pause()
    wait_until(lambda: fleet.served_since(begin), "a robot of a stopped replica is not served")
    cluster.replicas[1].go_on()
    cluster.wait_for_replicas()
    return begin


def restart_the_database(cluster, _fleet):
    cluster.database.control("stop")
    if cluster.database.start() != 0:
        raise Broken("PostgreSQL did not start again")
    return time.monotonic()


def fill_the_disk(cluster, fleet):
    filler = cluster.disk / "filler"
    with open(filler, "wb", buffering=0) as file, contextlib.suppress(OSError):
        while True:
            file.write(b"\0" * 65536)
    wait_for_silence(fleet)
    filler.unlink()
    # It stops by itself when its log has no room.
    cluster.database.control("stop")
    if cluster.database.start() != 0:
        raise Broken("PostgreSQL did not start after its disk had been full")
    return time.monotonic()


def wait_for_silence(fleet):
    """Until no batch was stored for two periods."""

    def nobody_was_served():
        before = fleet.batches()
        time.sleep(2 * fleet.period_s)
        return fleet.batches() == before

    wait_until(nobody_was_served, "batches are still acknowledged on a full disk")


def roll(cluster, fleet):
    """As an upgrade does: the next server when the proxy has the one before again."""
    begin = time.monotonic()
    for replica in cluster.replicas:
        stopped = time.monotonic()
        if replica.stop() != 0:
            raise Broken("a server did not end in order")
        wait_until(lambda: fleet.served_since(stopped), "a robot is not served")
        replica.start()
        cluster.wait_for_replicas()
    return begin


FAULTS = {
    "none": nothing,
    "kill -9 of a replica": kill_a_replica,
    "a replica is cut off": cut_a_replica_off,
    "PostgreSQL restarts": restart_the_database,
    "disk of PostgreSQL is full": fill_the_disk,
    "rolling restart": roll,
}
OF_THE_DATABASE = ("PostgreSQL restarts", "disk of PostgreSQL is full")


def suffer(name, cluster, fleet, seconds):
    """Prints how the fleet fared; the promise that was broken, or None."""
    before, begin = fleet.batches(), time.monotonic()
    over = FAULTS[name](cluster, fleet)
    served = wait_until(
        lambda: fleet.failures() or fleet.served_since(over), "a robot is not served again"
    )
    if fleet.failures():
        raise Broken("; ".join(fleet.failures()[:3]))
    time.sleep(max(0.0, begin + seconds - time.monotonic()))
    end = time.monotonic()
    silence, again = fleet.longest_silence(begin, end), max(served) - over
    print(
        f"{name:28}{end - begin:9.1f}{fleet.batches() - before:9}{silence:11.2f}{again:10.2f}",
        flush=True,
    )
    worst = again if name in OF_THE_DATABASE else silence
    return f"{name}: a robot waited {worst:.1f} s" if worst > PROMISED_S else None


def test_faults(options, directory):
    log = directory / "robot.jsonl"
    record_run(options.cornerfix, log, *SHORT_SIGHTED, "--seed", "2", "--length", "40")
    broken = []
    with Cluster(options, directory, REPLICAS) as cluster:
        faults = [name for name in FAULTS if cluster.disk or name != "disk of PostgreSQL is full"]
        if not cluster.disk:
            print("disk of PostgreSQL is full: skipped, no right to mount")
        print(f"{'fault':28}{'seconds':>9}{'batches':>9}{'silence s':>11}{'again s':>10}")
        fleet = Fleet(cluster.proxy.url, Run(log), options.robots, options.rate)
        try:
            wait_until(lambda: fleet.served_since(0.0), "a robot cannot begin")
            for name in faults:
                broken.append(suffer(name, cluster, fleet, options.seconds / len(faults)))
        except Broken as promise:
            broken.append(str(promise))
        finally:
            fleet.end()
        broken += fleet.failures()
        print(f"{fleet.batches()} acknowledged batches, {len(fleet.failures())} robots lost some")
    return [promise for promise in broken if promise]


def throughput(options, directory, replicas):
    """Offers more than can be served; prints what was served, and with how much processor."""
    log = directory / "load.jsonl"
    record_run(options.cornerfix, log, "--fov", "360", "--beams", "360", "--length", "40")
    command = [options.cornerfix, "load", log, "--map", "willow", "--batch", "5", "--ramp", "5"]
    command += ["--robots", str(options.robots), "--rate", "50", "--seconds", "3600"]
    with Cluster(options, directory / str(replicas), replicas) as cluster:
        command += ["--server", cluster.proxy.url]
        with subprocess.Popen(command, **SILENT) as load:
            time.sleep(10.0)  # Until all robots are on, and localized.
            before, begin = readings(cluster), time.monotonic()
            time.sleep(options.seconds)
            after, end = readings(cluster), time.monotonic()
            load.kill()
    batches, *cpu_s = [(b - a) / (end - begin) for a, b in zip(before, after)]
    cores = " ".join(f"{share:.2f}" for share in cpu_s)
    per_batch_ms = 1e3 * sum(cpu_s) / batches
    print(f"{replicas:8}{batches:12.0f}{per_batch_ms:15.2f}   {cores}", flush=True)


def readings(cluster):
    """Batches served by all replicas so far, and the processor time of each."""
    scans = 0.0
    for replica in cluster.replicas:
        with Client(replica.url) as client:
            text = client.request("GET", "/metrics").body.decode()
        scans += float(re.search(r"^cornerfix_scans_total (\S+)", text, re.MULTILINE).group(1))
    return [scans / SCANS_PER_BATCH, *(replica.cpu_s() for replica in cluster.replicas)]


def measure_throughput(options, directory):
    print(f"{os.cpu_count()} cores for all: servers, PostgreSQL, HAProxy and {options.robots} robots")
    print(f"{'replicas':>8}{'batches/s':>12}{'ms per batch':>15}   cores that each had")
    for replicas in range(1, REPLICAS + 1):
        (directory / str(replicas)).mkdir(mode=0o755)
        throughput(options, directory, replicas)
    return []


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cornerfix", required=True, help="the program")
    parser.add_argument("--robots", type=int, default=30)
    parser.add_argument("--rate", type=float, default=2.0, help="batches per second and robot")
    parser.add_argument("--seconds", type=float, default=60.0, help="of all faults, at least")
    parser.add_argument(
        "--no-full-disk", dest="full_disk", action="store_false", help="do not fill a disk"
    )
    parser.add_argument(
        "--throughput", action="store_true", help="batches per second of 1 to 3 replicas instead"
    )
    options = parser.parse_args()
    options.full_disk &= not options.throughput
    if not HaProxy.program():
        skip("haproxy is not installed")
    with tempfile.TemporaryDirectory() as name:
        directory = pathlib.Path(name)
        directory.chmod(0o755)  # PostgreSQL runs as another user.
        measure = measure_throughput if options.throughput else test_faults
        broken = measure(options, directory)
    for promise in broken:
        print(f"broken: {promise}", file=sys.stderr)
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main())
