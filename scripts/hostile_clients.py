#!/usr/bin/env python3
"""Attacks a server with hostile connections while a robot posts, and prints what the robot noticed.

    scripts/hostile_clients.py [PROGRAM] [CONNECTIONS]

Each attack holds its connections while a robot posts 20 batches on a connection of its own per
batch. Exit code 1 when a batch was not answered with 200, when the server died, or when SIGTERM
under attack took longer than its deadline.
"""

import http.client
import json
import os
import resource
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time

BATCHES = 20
STOP_DEADLINE_S = 8  # drain_timeout_s, two seconds for batches in work, and one for the machine
LIDAR = {"angle_min": -3.1, "angle_increment": 0.017, "range_min": 0.05, "range_max": 30.0}
RANGES = [2.0 + beam % 7 * 0.1 for beam in range(360)]
ROUTE = "POST /v1/sessions HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"

# What each connection sends at once, and what it then drips.
ATTACKS = {
    "none": (None, None),
    "idle": (b"", None),
    "a byte of a head per second": (b"G", b"E"),
    "headers without end": (b"GET / HTTP/1.1\r\n", b"a: b\r\n"),
    "half a body of 60 kB": (f"{ROUTE}Content-Length: 60000\r\n\r\n".encode() + b" " * 30000, None),
    "bodies of 16 MB, slowly": (f"{ROUTE}Content-Length: 16000000\r\n\r\n".encode(), b" " * 20000),
    "chunks without end": (f"{ROUTE}Transfer-Encoding: chunked\r\n\r\n".encode(), b"1\r\n \r\n"),
    "answers that nobody reads": (b"GET /openapi.json HTTP/1.1\r\nHost: localhost\r\n\r\n" * 30,
                                  None),
}


class Server:
    def __init__(self, program, directory):
        self.process = subprocess.Popen(
            [program, "serve", "--port", "0", "--db", os.path.join(directory, "test.db")],
            stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        self.port = int(self.process.stdout.readline().rsplit(":", 1)[1])

    def call(self, method, path, body=None):
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=60)
        connection.request(method, path, json.dumps(body), {"Content-Type": "application/json"})
        reply = connection.getresponse()
        text = reply.read()
        connection.close()
        return reply.status, text

    def memory_mb(self):
        with open(f"/proc/{self.process.pid}/status", encoding="ascii") as status:
            line = next(line for line in status if line.startswith("VmRSS"))
        return int(line.split()[1]) // 1024

    def threads(self):
        return len(os.listdir(f"/proc/{self.process.pid}/task"))

    def stop(self):
        begin = time.monotonic()
        self.process.send_signal(signal.SIGTERM)
        exit_code = self.process.wait(60)
        return exit_code, time.monotonic() - begin


class Robot:
    def __init__(self, server):
        self.server = server
        _, text = server.call("POST", "/v1/sessions", {"robot": "cart-7", "lidar": LIDAR})
        self.path = f"/v1/sessions/{json.loads(text)['id']}/scans"
        self.sequence = 0

    def post_batches(self):
        """How many were served, and the longest time to an answer [ms]."""
        served, longest = 0, 0.0
        for _ in range(BATCHES):
            scans = [{"stamp": 5 * self.sequence + i, "ranges": RANGES} for i in range(5)]
            begin = time.monotonic()
            status, _ = self.server.call("POST", self.path,
                                         {"sequence": self.sequence, "scans": scans})
            longest = max(longest, time.monotonic() - begin)
            served += status == 200
            self.sequence += status == 200
        return served, 1e3 * longest


class Attack:
    """Connections that are held until the end of a `with`."""

    def __init__(self, port, connections, at_once, drip):
        self.sockets = []
        self.ended = threading.Event()
        self.dripper = threading.Thread(target=self.run, args=(drip,))
        for _ in range(0 if at_once is None else connections):
            one = socket.create_connection(("127.0.0.1", port), timeout=10)
            one.setblocking(False)
            self.sockets.append(one)
            self.send(one, at_once)

    @staticmethod
    def send(one, data):
        try:
            one.send(data)
        except OSError:
            pass  # The server has closed it, or reads no more.

    def run(self, drip):
        while drip and not self.ended.wait(1.0):
            for one in self.sockets:
                self.send(one, drip)

    def __enter__(self):
        self.dripper.start()
        return self

    def __exit__(self, *_):
        self.ended.set()
        self.dripper.join()
        for one in self.sockets:
            one.close()


def main():
    program = sys.argv[1] if len(sys.argv) > 1 else "build/release/bin/cornerfix"
    connections = int(sys.argv[2]) if len(sys.argv) > 2 else 9000
    _, most = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (most, most))
    good = True
    with tempfile.TemporaryDirectory() as directory:
        server = Server(program, directory)
        robot = Robot(server)
        print(f"{'attack':32}{'served':>8}{'max ms':>8}{'MB':>6}{'threads':>9}")
        for name, (at_once, drip) in ATTACKS.items():
            with Attack(server.port, connections, at_once, drip):
                served, longest = robot.post_batches()
                print(f"{name:32}{served:>8}{longest:>8.0f}{server.memory_mb():>6}"
                      f"{server.threads():>9}", flush=True)
            good &= served == BATCHES
        at_once, drip = ATTACKS["bodies of 16 MB, slowly"]
        with Attack(server.port, min(connections, 300), at_once, drip):
            exit_code, seconds = server.stop()
        print(f"SIGTERM under attack: exit code {exit_code} after {seconds:.1f} s")
        good &= exit_code == 0 and seconds < STOP_DEADLINE_S
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
