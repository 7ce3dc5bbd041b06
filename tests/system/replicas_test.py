#!/usr/bin/python3
"""Several real servers on one real PostgreSQL: they take over each other's sessions, see each
other's maps, and go on when the database was away. Exits with 77 where PostgreSQL is missing."""
import argparse
import os
import pathlib
import subprocess
import sys
import tempfile
import time
import unittest

from real_server import CLIENT, SHORT_SIGHTED, WILLOW, RealServer, record_run, run, skip
from replicas import NOT_INSTALLED, HaProxy, Postgresql

sys.path.insert(0, str(CLIENT))
from cornerfix import Client, Problem, Robot, read_log  # noqa: E402


class ReplicasTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        log = cls.directory / "robot.jsonl"
        record_run(cls.cornerfix, log, *SHORT_SIGHTED, "--seed", "2", "--length", "4")
        cls.scans = list(read_log(log))
        cls.file = cls.directory / "alone.db"
        server = RealServer(cls.cornerfix, cls.file)
        with Client(server.url) as client:
            client.import_map_server("willow", WILLOW)
        robot = Robot(server.url, "robot-7", map="willow")
        cls.expected = [answer for answer in map(robot.add, cls.scans) if answer]
        server.stop()
        assert cls.expected[-1].is_localized

    def setUp(self):
        self.database = self.postgresql.new_database()
        run(self.cornerfix, "database", "copy", self.file, self.database)
        self.first, self.second = self.serve(), self.serve()

    def serve(self):
        server = RealServer(self.cornerfix, self.database)
        self.addCleanup(server.stop)
        return server

    def drive(self, servers, session=None):
        """The answers when each batch goes to the server that `servers` gives for its number."""
        answers = []
        for number in range(len(self.expected)):
            batch = self.scans[5 * number : 5 * number + 5]
            robot = Robot(servers(number).url, "robot-8", map="willow", session=session)
            answers += [answer for answer in map(robot.add, batch) if answer]
            session = robot.session
            robot.client.close()
        return answers

    def assert_as_alone(self, answers):
        """But for 5 mm: a restored session has to search again before its pose is accepted."""
        self.assertEqual(
            [(each.sequence, each.status) for each in answers],
            [(each.sequence, each.status) for each in self.expected],
        )
        for answer, other in zip(answers, self.expected):
            if other.pose:
                for name in ("stamp", "x", "y", "yaw"):
                    mine, theirs = getattr(answer.pose, name), getattr(other.pose, name)
                    self.assertAlmostEqual(mine, theirs, delta=0.005)

    def test_another_server_takes_the_session_of_a_killed_one_over(self):
        half = len(self.expected) // 2

        def server_of(number):
            if number == half:
                self.first.kill()
                self.addCleanup(self.first.start)  # For the clean-up that stops it.
            return self.first if number < half else self.second

        self.assert_as_alone(self.drive(server_of))

    def test_a_robot_may_change_the_server_with_every_batch(self):
        self.assert_as_alone(self.drive(lambda number: (self.first, self.second)[number % 2]))

    def test_a_robot_goes_on_after_the_database_was_restarted(self):
        half = len(self.expected) // 2

        def server_of(number):
            if number == half:
                self.postgresql.control("stop")
                with self.assertRaises(Problem):
                    Client(self.first.url, give_up_after_s=0).maps()
                self.assertEqual(self.postgresql.start(), 0)
            return self.first

        self.assert_as_alone(self.drive(server_of))

    def test_a_server_sees_at_once_what_another_one_did_to_a_map(self):
        first, second = Client(self.first.url), Client(self.second.url)
        robot = Robot(self.second.url, "robot-9", map="willow")
        for scan in self.scans[:5]:
            robot.add(scan)
        first.put_map("willow", description="First floor")
        self.assertEqual(second.map("willow").description, "First floor")
        first.delete_map("willow")
        self.assertEqual(second.maps(), [])
        with self.assertRaises(Problem) as raised:
            for scan in self.scans[5:10]:
                robot.add(scan)
        self.assertEqual(raised.exception.code, "conflict")

    def test_another_server_takes_the_job_of_a_killed_one_over(self):
        job = Client(self.first.url).start_import("again", WILLOW)
        second = Client(self.second.url)
        while second.job(job.id).status == "queued":
            time.sleep(0.01)
        self.first.kill()
        self.addCleanup(self.first.start)
        self.assertEqual(second.job(job.id).status, "running")
        done = second.wait_for_job(job.id)
        self.assertEqual(done.status, "succeeded", done)
        self.assertEqual(second.map("again").digest, second.map("willow").digest)
        self.assertEqual(second.job_result(job.id)["digest"], second.map("willow").digest)

    def test_robots_behind_haproxy_lose_no_batch_when_a_server_is_killed(self):
        proxy = self.start_haproxy()
        robots = [Robot(proxy, f"robot-{number}", map="willow") for number in range(8)]
        half = len(self.expected) // 2 * 5
        answers = [
            [answer for answer in map(robot.add, self.scans[:half]) if answer] for robot in robots
        ]
        self.first.kill()
        self.addCleanup(self.first.start)
        for robot, mine in zip(robots, answers):
            self.assertEqual(robot.client.session(robot.session).expected, half // 5)
            mine += [answer for answer in map(robot.add, self.scans[half:]) if answer]
            self.assert_as_alone(mine)

    def start_haproxy(self):
        """The URL of a proxy before the two servers."""
        if not HaProxy.program():
            self.assertNotIn("CORNERFIX_REQUIRE_TOOLS", os.environ, "haproxy is not installed")
            self.skipTest("haproxy is not installed")
        proxy = HaProxy(self.directory, [self.first, self.second])
        self.addCleanup(proxy.stop)
        return proxy.url

    def test_a_copy_goes_back_into_a_file(self):
        back = self.directory / "back.db"
        with Client(self.first.url) as client:
            digest = client.map("willow").digest
        self.first.stop()
        self.addCleanup(self.first.start)
        printed = run(self.cornerfix, "database", "copy", self.database, back)
        self.assertRegex(printed, r"^1 maps, 1 sessions, 0 tokens: copied to .*back\.db")
        server = RealServer(self.cornerfix, back)
        self.addCleanup(server.stop)
        self.assertEqual(Client(server.url).map("willow").digest, digest)

    def test_a_copy_needs_a_source_and_an_empty_target(self):
        nowhere = self.directory / "nowhere.db"
        for source, words in ((self.file, "holds maps"), (nowhere, "does not exist")):
            done = subprocess.run(
                [self.cornerfix, "database", "copy", source, self.database],
                capture_output=True,
                text=True,
            )
            self.assertNotEqual(done.returncode, 0)
            self.assertIn(words, done.stderr)
        self.assertFalse(nowhere.exists())


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--cornerfix", required=True)
    arguments, rest = parser.parse_known_args()
    with tempfile.TemporaryDirectory() as name:
        directory = pathlib.Path(name)
        directory.chmod(0o755)  # The server runs as another user.
        ReplicasTest.directory = directory
        ReplicasTest.postgresql = Postgresql(directory / "postgresql")
        ReplicasTest.cornerfix = arguments.cornerfix
        status = ReplicasTest.postgresql.start()
        if status == NOT_INSTALLED:
            skip("PostgreSQL is not installed")
        assert status == 0, "PostgreSQL did not start"
        try:
            unittest.main(argv=[sys.argv[0], *rest])
        finally:
            ReplicasTest.postgresql.control("stop")


if __name__ == "__main__":
    main()
