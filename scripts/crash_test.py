#!/usr/bin/env python3
"""Kills a server under load again and again and checks that nothing it acknowledged is lost.

Each round starts the server on the same database, lets robots and mappers post for a random time
(by --seed), and ends it with SIGKILL. After the next start every acknowledgement is checked:

- a session expects the batch after the last acknowledged one, or the one after that when a batch
  was on its way; the last batch, posted again, gets the same answer, byte for byte;
- with --checkpoint-interval S, a session may also expect an older batch: at most the batches of the
  last S seconds are asked for again, and the session ends with the last scan of a whole batch;
- a map has the revision that was acknowledged or a newer one, and knows every acknowledged scan;
- a deleted session is gone, a created one is there.

With --full-disk FILE_SYSTEM (a small one, as a tmpfs) the database lies there, and in every second
round the disk is filled while robots post: then 507 and 503 are right, and nothing else changes.
With --postgresql the database is in a PostgreSQL server of its own, which is not killed.
"""

import argparse
import contextlib
import http.client
import json
import math
import os
import pathlib
import random
import signal
import subprocess
import sys
import tempfile
import threading
import time

SOURCE = pathlib.Path(__file__).resolve().parents[1]
BEAMS = 61
SCANS_PER_BATCH = 3
WRITING_S = 0.5  # Longest time to write a checkpoint, on a busy machine.
LIDAR = {"angle_min": -1.5, "angle_increment": 0.05, "range_min": 0.05, "range_max": 30.0}
START_TIMEOUT_S = 30
REFUSALS = (503, 507)  # Right when the disk is full.


class Lost(Exception):
    """Something that was acknowledged is not there, or is there twice."""


def scan(stamp, shift):
    """What a robot sees in a room of 8 x 6 m that it crosses slowly."""
    ranges = []
    for beam in range(BEAMS):
        angle = LIDAR["angle_min"] + beam * LIDAR["angle_increment"]
        dx, dy = math.cos(angle), math.sin(angle)
        x = (4.0 - shift) / dx if dx > 1e-9 else 1e9
        y = (3.0 if dy > 0 else -3.0) / dy if abs(dy) > 1e-9 else 1e9
        ranges.append(round(min(x, y), 4))
    return {"stamp": stamp, "ranges": ranges}


class Client:
    """One connection that is made again when it breaks."""

    def __init__(self, port):
        self.connection = http.client.HTTPConnection("127.0.0.1", port, timeout=30)

    def call(self, method, path, body=None):
        text = None if body is None else json.dumps(body)
        headers = {} if body is None else {"Content-Type": "application/json"}
        self.connection.request(method, path, text, headers)
        reply = self.connection.getresponse()
        return reply.status, reply.read()


class Server:
    def __init__(self, options, database, log):
        self.process = subprocess.Popen(
            [options.program, "serve", "--port", "0", "--db", str(database),
             "--checkpoint-interval-s", str(options.checkpoint_interval)],
            stdout=subprocess.PIPE, stderr=log, text=True)
        line = self.process.stdout.readline()
        if "http://" not in line:
            raise Lost(f"the server did not start: {line!r}, exit code {self.process.wait()}")
        self.port = int(line.rsplit(":", 1)[1])

    def kill(self):
        self.process.send_signal(signal.SIGKILL)
        self.process.wait()
        self.process.stdout.close()


class Robot:
    """Posts batches in one session, and knows what was acknowledged."""

    def __init__(self, name, interval_s):
        self.name = name
        self.interval_s = interval_s
        self.session = None
        self.acknowledged_at = []  # When each batch of the session was.
        self.next = 0  # First sequence without an acknowledgement.
        self.last = None  # Body and answer of the last acknowledged batch.
        self.gone = []  # Sessions whose deletion was acknowledged.
        self.batches = 0
        self.asked_again = 0
        self.in_flight = None  # "batch" or "delete": was sent, and may be stored.

    def batch(self, sequence):
        shift = 0.01 * (sequence % 200)
        return {"sequence": sequence, "scans": [
            dict(scan(stamp, shift), odom={"x": shift, "y": 0.0, "yaw": 0.0})
            for stamp in self.stamps(sequence)]}

    @staticmethod
    def stamps(sequence):
        return [1.0 + 0.2 * sequence + 0.05 * i for i in range(SCANS_PER_BATCH)]

    def step(self, client, draw):
        if self.session is None:
            status, body = client.call("POST", "/v1/sessions",
                                       {"robot": self.name, "map": "room", "lidar": LIDAR})
            if status == 201:
                self.session, self.next, self.last = json.loads(body)["id"], 0, None
                self.acknowledged_at = []
            return expect(status, 201)
        if draw.random() < 0.005:
            session = self.session
            self.in_flight = "delete"
            status, _ = client.call("DELETE", f"/v1/sessions/{session}")
            self.in_flight = None
            if status == 204:
                self.gone.append(session)
                self.session = None
            return expect(status, 204)
        body = self.batch(self.next)
        self.in_flight = "batch"
        status, answer = client.call("POST", f"/v1/sessions/{self.session}/scans", body)
        self.in_flight = None
        if status == 200:
            self.last = (body, answer)
            self.acknowledged_at.append(time.monotonic())
            self.next += 1
            self.batches += 1
        return expect(status, 200)

    def check(self, client):
        for session in self.gone[-3:]:
            status, _ = client.call("GET", f"/v1/sessions/{session}")
            if status != 404:
                raise Lost(f"{self.name}: deleted session {session} answers {status}")
        if self.session is None:
            return
        status, body = client.call("GET", f"/v1/sessions/{self.session}")
        if status == 404 and self.in_flight == "delete":
            self.session = self.in_flight = None
            return
        if status != 200:
            raise Lost(f"{self.name}: session {self.session} answers {status}: {body[:200]}")
        expected = json.loads(body)["expected"]
        most = self.next + (1 if self.in_flight == "batch" else 0)
        if not self.least_expected() <= expected <= most:
            raise Lost(f"{self.name}: expects {expected}, acknowledged up to {self.next - 1}")
        self.check_is_whole(client, expected)
        if self.last and expected == self.next:
            status, answer = client.call("POST", f"/v1/sessions/{self.session}/scans", self.last[0])
            if (status, answer) != (200, self.last[1]):
                raise Lost(f"{self.name}: batch {self.next - 1} has another answer: {status}")
        if expected != self.next:
            self.asked_again += max(0, self.next - expected)
            self.next, self.last = expected, None
            del self.acknowledged_at[expected:]
            # One that was on its way: when it was stored is not known.
            self.acknowledged_at += [time.monotonic()] * (expected - len(self.acknowledged_at))
        self.in_flight = None

    def least_expected(self):
        """The sequence that the server must have come to, by what it promises."""
        if self.interval_s == 0 or not self.acknowledged_at:
            return self.next
        since = self.acknowledged_at[-1] - self.interval_s - WRITING_S
        return sum(at < since for at in self.acknowledged_at)

    def check_is_whole(self, client, expected):
        """By the stamp of the last scan that the session has."""
        ahead = self.batch(expected + 100)
        status, body = client.call("POST", f"/v1/sessions/{self.session}/scans", ahead)
        last = json.loads(body).get("last_stamp")
        whole = self.stamps(expected - 1)[-1] if expected > 0 else None
        is_whole = last == whole or (last and whole and abs(last - whole) < 1e-6)
        if status != 409 or not is_whole:
            raise Lost(f"{self.name}: expects {expected}, but its last stamp is {last}")


class Mapper:
    """Grows a map by batches of scans at poses."""

    def __init__(self, name):
        self.path = f"/v1/maps/{name}"
        self.scans = []  # Acknowledged.
        self.revision = 0
        self.exists = False
        self.batches = 0

    def step(self, client, _draw):
        if not self.exists:
            status, _ = client.call("PUT", self.path, {"lidar": LIDAR})
            self.exists = status in (200, 201)
            return self.exists or expect(status, 201)
        # A ring, so that the map stays small.
        number = len(self.scans)
        at = 0.3 * (number % 12)
        body = {"scans": [dict(scan(10.0 + number, at), pose={"x": at, "y": 0.0, "yaw": 0.0})]}
        status, answer = client.call("POST", f"{self.path}/scans", body)
        if status == 200:
            self.scans.append(body["scans"][0])
            self.revision = json.loads(answer)["revision"]
            self.batches += 1
        return expect(status, 200)

    def check(self, client):
        status, body = client.call("GET", self.path)
        if status == 404 and not self.exists:
            return
        if status != 200:
            raise Lost(f"{self.path} answers {status}")
        revision = json.loads(body)["revision"]
        if revision < self.revision:
            raise Lost(f"{self.path} is at revision {revision}, acknowledged {self.revision}")
        last = self.scans[-50:]
        if not last:
            return
        status, answer = client.call("POST", f"{self.path}/scans", {"scans": last})
        if status != 200 or json.loads(answer)["duplicates"] != len(last):
            raise Lost(f"{self.path}: acknowledged scans are not there: {status} {answer[:200]}")


def expect(status, wanted):
    """False when the server refused in a way that a full disk explains."""
    if status == wanted:
        return True
    if status in REFUSALS:
        return False
    raise Lost(f"expected {wanted}, got {status}")


def post_until_dead(actor, port, seed, failures):
    draw = random.Random(seed)
    client = Client(port)
    try:
        while True:
            if not actor.step(client, draw):
                time.sleep(0.005)
    except (OSError, http.client.HTTPException):
        pass  # Killed.
    except Lost as lost:
        failures.append(str(lost))


def fill(directory, draw):
    """Leaves little room on the disk; returns the file that fills it."""
    path = directory / "filler"
    free = os.statvfs(directory)
    size = free.f_bavail * free.f_frsize - draw.randrange(0, 200_000)
    with open(path, "wb") as file:
        try:
            file.write(b"\0" * max(0, size))
        except OSError:
            pass  # Full.
    return path


def run_round(options, number, directory, actors, log):
    draw = random.Random(options.seed * 1_000_003 + number)
    server = Server(options, options.database, log)
    client = Client(server.port)
    for actor in actors:
        actor.check(client)
    failures = []
    threads = [threading.Thread(target=post_until_dead,
                                args=(actor, server.port, draw.random(), failures))
               for actor in actors]
    for thread in threads:
        thread.start()
    filler = None
    if options.full_disk and number % 2 == 1:
        time.sleep(draw.uniform(0.0, 0.2))
        filler = fill(directory, draw)
    time.sleep(draw.uniform(0.02, options.longest))
    server.kill()
    for thread in threads:
        thread.join()
    if filler:
        filler.unlink()
    if failures:
        raise Lost("; ".join(failures))


def make_room(options, log):
    """The map that robots look in."""
    server = Server(options, options.database, log)
    mapper = Mapper("room")
    client = Client(server.port)
    for _ in range(12):
        if not mapper.step(client, None):
            raise Lost("the map cannot be made")
    server.kill()
    return mapper


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default="build/release/bin/cornerfix")
    parser.add_argument("--rounds", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--robots", type=int, default=8)
    parser.add_argument("--longest", type=float, default=0.4, help="seconds of load per round")
    parser.add_argument("--full-disk", metavar="DIRECTORY", help="on a small file system")
    parser.add_argument("--checkpoint-interval", type=int, default=0, metavar="SECONDS")
    parser.add_argument("--postgresql", action="store_true")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(dir=options.full_disk) as name:
        directory = pathlib.Path(name)
        directory.chmod(0o755)  # PostgreSQL runs as another user.
        with open_database(options, directory), open(os.devnull, "w") as log:
            return run_rounds(options, directory, log)


def run_rounds(options, directory, log):
    robots = [Robot(f"cart-{i}", options.checkpoint_interval) for i in range(options.robots)]
    actors = [*robots, make_room(options, log), Mapper("grown")]
    for number in range(options.rounds):
        try:
            run_round(options, number, directory, actors, log)
        except Lost as lost:
            print(f"round {number}, seed {options.seed}: {lost}", file=sys.stderr)
            return 1
    # What the last round acknowledged is checked as well.
    server = Server(options, options.database, log)
    for actor in actors:
        actor.check(Client(server.port))
    server.kill()
    acknowledged = sum(actor.batches for actor in actors)
    asked_again = sum(robot.asked_again for robot in robots)
    print(f"{options.rounds} rounds, {acknowledged} acknowledged batches: 0 lost, 0 doubled, "
          f"0 refused starts, {asked_again} asked for again as promised")
    return 0


@contextlib.contextmanager
def open_database(options, directory):
    """Sets `options.database` to where the database is."""
    if not options.postgresql:
        options.database = directory / "crash.db"
        yield
        return
    sys.path.insert(0, str(SOURCE / "tests" / "system"))
    from replicas import NOT_INSTALLED, Postgresql
    postgresql = Postgresql(directory / "postgresql")
    if postgresql.start() == NOT_INSTALLED:
        sys.exit(NOT_INSTALLED)
    options.database = postgresql.new_database()
    try:
        yield
    finally:
        postgresql.control("stop")


if __name__ == "__main__":
    sys.exit(main())
