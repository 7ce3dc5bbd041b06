"""A paced fleet for cluster_test.py: robots that know what was acknowledged to them."""

import json
import pathlib
import sys
import threading
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "clients" / "python"))
from cornerfix import Client, CornerfixError, Problem, read_log  # noqa: E402

SCANS_PER_BATCH = 5
ANSWER_TIMEOUT_S = 20.0
GIVE_UP_AFTER_S = 60.0
DISK_FULL = 507  # The client does not post again by itself then.
PAUSE_S = 0.5


class Run:
    """A recorded run as batches: along it, back again, and so on."""

    def __init__(self, log):
        scans = list(read_log(log))
        self.lidar = scans[0].lidar
        self._scans = [json.dumps(scan.to_json(self.lidar)).partition(",")[2] for scan in scans]

    def body(self, sequence):
        first = sequence * SCANS_PER_BATCH
        scans = (self._scan(first + i) for i in range(SCANS_PER_BATCH))
        return f'{{"sequence": {sequence}, "scans": [{", ".join(scans)}]}}'.encode()

    def _scan(self, number):
        last = len(self._scans) - 1
        step = number % (2 * last)
        return f'{{"stamp": {1.0 + 0.2 * number}, ' + self._scans[min(step, 2 * last - step)]


class Robot(threading.Thread):
    """Posts a batch whenever one is due, until the fleet ends. Then it checks its session."""

    def __init__(self, fleet, number):
        super().__init__()
        self._fleet = fleet
        self._client = Client(
            fleet.url, timeout_s=ANSWER_TIMEOUT_S, give_up_after_s=GIVE_UP_AFTER_S
        )
        self._name = f"robot-{number}"
        self._first_due = fleet.start + fleet.period_s * number / fleet.robots
        self._last = None  # Body and answer of the last acknowledged batch.
        self.served_at = []  # When each batch was acknowledged.
        self.failure = None

    def run(self):
        try:
            self._drive()
            self._check()
        except (CornerfixError, OSError) as error:
            self.failure = f"{self._name}: {error}"

    def _drive(self):
        session = self._client.create_session(
            {"robot": self._name, "map": "willow", "lidar": self._fleet.run.lidar.to_json()}
        )
        self._path = f"/v1/sessions/{session.id}"
        due = self._first_due
        while not self._fleet.ended.wait(max(0.0, due - time.monotonic())):
            body = self._fleet.run.body(len(self.served_at))
            self._last = (body, self._post(body))
            self.served_at.append(time.monotonic())
            due += self._fleet.period_s

    def _post(self, body):
        while True:
            try:
                path = self._path + "/scans"
                return self._client.request("POST", path, body, "application/json").body
            except Problem as problem:
                if "expected" in problem.members:
                    self._compare(problem.members["expected"])
                if problem.status != DISK_FULL:
                    raise
            time.sleep(PAUSE_S)

    def _compare(self, expected):
        mine = len(self.served_at)
        if expected != mine:
            raise CornerfixError(f"{mine} batches were acknowledged, the server expects {expected}")

    def _check(self):
        self._compare(self._client.call("GET", self._path)["expected"])
        if self._last and self._post(self._last[0]) != self._last[1]:
            raise CornerfixError("the last batch got another answer when it was posted again")


class Fleet:
    """Robots against one address."""

    def __init__(self, url, run, robots, rate):
        self.url = url
        self.run = run
        self.robots = robots
        self.period_s = 1.0 / rate
        self.ended = threading.Event()
        self.start = time.monotonic()
        self._all = [Robot(self, number) for number in range(robots)]
        for robot in self._all:
            robot.start()

    def batches(self):
        """Acknowledged so far."""
        return sum(len(robot.served_at) for robot in self._all)

    def failures(self):
        return [robot.failure for robot in self._all if robot.failure]

    def served_since(self, moment):
        """When each robot was first served after `moment`; None while one was not."""
        first = [next((t for t in robot.served_at if t > moment), None) for robot in self._all]
        return None if None in first else first

    def longest_silence(self, begin, end):
        """The longest time from one answer to the next of a robot [s], of those that end in it."""
        longest = 0.0
        for robot in self._all:
            times = list(robot.served_at)
            gaps = [b - a for a, b in zip(times, times[1:]) if begin <= b <= end]
            longest = max([longest, *gaps])
        return longest

    def end(self):
        self.ended.set()
        for robot in self._all:
            robot.join()
