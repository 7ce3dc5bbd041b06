#!/usr/bin/python3
"""The Python client against the real server."""
import argparse
import dataclasses
import gzip
import json
import math
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
import urllib.request

from real_server import CLIENT, SHORT_SIGHTED, SOURCE, WILLOW, RealServer, record_run

sys.path.insert(0, str(CLIENT))
from cornerfix import Client, Near, Pose, Problem, Robot, Scan, read_log  # noqa: E402
from python_stub import LIDAR, Clock, scan  # noqa: E402


def half_of(lidar, yaw):
    """A lidar of the middle half of the beams, turned by `yaw`."""
    return dataclasses.replace(lidar, angle_min=lidar.angle_min / 2.0, mount=Pose(0, 0, yaw))


def halves(whole):
    """A scan of a full turn, as two lidars take it that stand back to back."""
    quarter = len(whole.ranges) // 4
    rear = whole.ranges[-quarter:] + whole.ranges[:quarter]
    for name, ranges in (("rear", rear), ("front", whole.ranges[quarter:-quarter])):
        yield Scan(whole.stamp, ranges, None, whole.odom, lidar_name=name)


class RealServerTest(unittest.TestCase):
    cornerfix = None  # The command.

    @classmethod
    def setUpClass(cls):
        directory = tempfile.TemporaryDirectory()
        cls.addClassCleanup(directory.cleanup)
        cls.directory = pathlib.Path(directory.name)
        cls.map_log, cls.robot_log = (
            cls.directory / "map.jsonl.gz",
            cls.directory / "robot.jsonl.gz",
        )
        record_run(cls.cornerfix, cls.map_log, "--seed", "1", "--length", "60", "--step", "0.3")
        record_run(cls.cornerfix, cls.robot_log, *SHORT_SIGHTED, "--seed", "2", "--length", "4")
        cls.scans = list(read_log(cls.robot_log))
        cls.archive = cls.directory / "willow.cornerfix"
        server = RealServer(cls.cornerfix, cls.directory / "first.db")
        with Client(server.url) as client:
            cls.imported = client.import_map_server("willow", WILLOW)
            client.download_archive("willow", cls.archive)
        server.stop()

    def setUp(self):
        self.database = self.directory / f"{self.id().rsplit('.', 1)[1]}.db"
        self.server = RealServer(self.cornerfix, self.database)
        self.addCleanup(lambda: self.server.stop())
        self.client = Client(self.server.url)
        self.addCleanup(self.client.close)

    def put_willow(self):
        return self.client.upload_archive("willow", self.archive)

    def drive(self, robot, scans):
        """The answers to the batches of these scans."""
        return [answer for answer in map(robot.add, scans) if answer]

    def undisturbed(self):
        """What the server answers to the scans when nothing happens."""
        return self.drive(Robot(self.server.url, "other", map="willow"), self.scans)

    def assert_same(self, answers, expected):
        """But for 5 mm: a restored session has to search again before its pose is accepted."""
        self.assertEqual(
            [(each.sequence, each.status) for each in answers],
            [(each.sequence, each.status) for each in expected],
        )
        self.assertTrue(answers[-1].is_localized)
        for answer, other in zip(answers, expected):
            if answer.pose:
                self.assertEqual(answer.pose.epoch, other.pose.epoch)
                for name in ("stamp", "x", "y", "yaw"):
                    self.assertAlmostEqual(
                        getattr(answer.pose, name), getattr(other.pose, name), delta=0.005
                    )

    def test_manages_maps(self):
        self.assertGreater(self.imported["features"], 100)
        self.assertEqual(self.put_willow().digest, self.imported["digest"])
        with self.assertRaises(Problem) as raised:
            self.put_willow()
        self.assertEqual(raised.exception.code, "conflict")
        before = self.client.map_revisions("willow")[0]
        self.client.put_map("willow", lidar=LIDAR)
        rolled = self.client.roll_back("willow", before["revision"])
        self.assertEqual((rolled.revision, rolled.digest), (before["revision"] + 2, before["digest"]))
        self.client.put_map("office", description="Second floor", lidar=LIDAR)
        self.assertEqual([each.name for each in self.client.maps()], ["office", "willow"])
        self.assertEqual(self.client.map("office").description, "Second floor")
        self.client.delete_map("office")
        with self.assertRaises(Problem) as raised:
            self.client.map("office")
        self.assertEqual((raised.exception.status, raised.exception.code), (404, "not_found"))

    def test_imports_a_map_as_a_job(self):
        job = self.client.start_import("willow", WILLOW)
        self.assertEqual((job.kind, job.map, job.is_finished), ("import", "willow", False))
        done = self.client.wait_for_job(job.id, every_s=0.05)
        self.assertEqual((done.status, done.progress), ("succeeded", 1.0), done)
        self.assertEqual(self.client.job_result(job.id), self.imported)
        self.assertEqual([each.id for each in self.client.jobs()], [job.id])
        with self.assertRaises(Problem) as raised:
            self.client.cancel_job(job.id)
        self.assertEqual(raised.exception.code, "conflict")

    def test_reads_all_pages_of_a_list(self):
        names = [f"map-{i:03}" for i in range(101)]
        for name in names:
            self.client.put_map(name)
        self.assertEqual([each.name for each in self.client.maps()], names)

    def test_builds_a_map_from_a_recorded_run(self):
        self.client.put_map("willow")
        counts = self.client.add_scans("willow", read_log(self.map_log))
        self.assertEqual(counts["accepted"], len(list(read_log(self.map_log))))
        again = self.client.add_scans("willow", read_log(self.map_log))
        self.assertEqual((again["accepted"], again["duplicates"]), (0, counts["accepted"]))
        posed = next(read_log(self.map_log))
        answer = self.client.localize("willow", [Scan(posed.stamp, posed.ranges, posed.lidar)])
        self.assertIn(answer.status, ("localized", "ambiguous", "collecting"))

    def test_names_what_is_wrong_in_a_request(self):
        self.put_willow()
        with self.assertRaises(Problem) as raised:
            Robot(self.server.url, "r", map="nowhere", batch=1).add(scan(1.0))
        self.assertEqual(raised.exception.code, "not_found")
        with self.assertRaises(Problem) as raised:
            Robot(self.server.url, "r", map="willow", batch=1, colour="red").add(scan(1.0))
        self.assertEqual(
            (raised.exception.code, raised.exception.pointer), ("invalid_argument", "/colour")
        )

    def test_sends_the_token(self):
        config = self.directory / "config.json"
        config.write_text(
            json.dumps(
                {"tokens": [{"token": "correct-horse-battery", "role": "admin", "name": "me"}]}
            )
        )
        server = RealServer(self.cornerfix, self.directory / "guarded.db", "--config", config)
        self.addCleanup(server.stop)
        with self.assertRaises(Problem) as raised:
            Client(server.url).maps()
        self.assertEqual(raised.exception.code, "unauthorized")
        self.assertEqual(Client(server.url, token="correct-horse-battery").maps(), [])

    def test_a_robot_learns_its_pose(self):
        self.put_willow()
        with Robot(self.server.url, "robot-7", map="willow") as robot:
            last = self.drive(robot, self.scans)[-1]
            (session,) = self.client.sessions()
            self.assertEqual(
                (session.id, session.robot, session.status), (robot.session, "robot-7", "localized")
            )
        truth = next(each.pose for each in self.scans if each.stamp == last.pose.stamp)
        error = last.pose.as_pose().inverse() * truth
        self.assertLess(math.hypot(error.x, error.y), 0.1)
        self.assertLess(abs(error.yaw), math.radians(1))
        self.assertEqual(self.client.sessions(), [])

    def test_two_lidars_do_as_one_of_a_full_turn(self):
        self.put_willow()
        log = self.directory / "full_turn.jsonl.gz"
        record_run(
            self.cornerfix,
            log,
            *("--fov", "360", "--beams", "360", "--range-max", "12"),
            *("--seed", "2", "--length", "3"),
        )
        scans = list(read_log(log))
        lidars = {"front": half_of(scans[0].lidar, 0.0), "rear": half_of(scans[0].lidar, math.pi)}
        robot = Robot(self.server.url, "robot-7", map="willow", lidars=lidars)
        for whole in scans:
            for half in halves(whole):
                answer = robot.add(half) or robot.answer
        self.assertEqual(robot.dropped, 0)
        truth = next(each.pose for each in scans if each.stamp == answer.pose.stamp)
        error = answer.pose.as_pose().inverse() * truth
        self.assertLess(math.hypot(error.x, error.y), 0.1)
        self.assertLess(abs(error.yaw), math.radians(1))

    def test_a_robot_that_is_switched_on_near_a_place_is_searched_there(self):
        self.put_willow()
        truth = self.scans[0].pose
        here = Near(truth.x + 1.0, truth.y, 2.0, yaw=truth.yaw, yaw_tolerance_rad=0.5)
        with Robot(self.server.url, "robot-7", map="willow", near=here) as robot:
            answer = self.drive(robot, self.scans)[-1]
        self.assertEqual((answer.status, answer.given), ("localized", "near"))
        with Robot(self.server.url, "robot-7", map="willow") as robot:
            robot.add(self.scans[0])
            robot.reset(near=Near(truth.x - 20.0, truth.y, 2.0))
            answer = self.drive(robot, self.scans)[-1]
        self.assertEqual((answer.status, answer.reason), ("collecting", "prior_contradicted"))

    def test_an_older_session_of_a_robot_is_superseded(self):
        self.put_willow()
        older, newer = (Robot(self.server.url, "robot-7", map="willow") for _ in range(2))
        self.assertIsNone(older.state())
        self.drive(older, self.scans[:5])
        self.assertIsNone(older.state().superseded_by)
        self.drive(newer, self.scans[:5])
        self.assertEqual(older.state().superseded_by, newer.session)
        self.assertEqual((newer.state().superseded_by, newer.state().stale), (None, False))

    def test_goes_on_after_the_server_was_killed(self):
        self.put_willow()
        expected = self.undisturbed()
        robot = Robot(self.server.url, "robot-7", map="willow")
        answers = self.drive(robot, self.scans[:15])
        session = robot.session
        self.server.kill()
        with Clock(on_wait=self.restart_once()):
            answers += self.drive(robot, self.scans[15:])
        self.assertEqual(robot.session, session)
        self.assert_same(answers, expected)

    def restart_once(self):
        """The server is started while the client waits for the second time."""
        waits = []

        def wait():
            waits.append(None)
            if len(waits) == 2:
                self.server.start()

        return wait

    def test_an_answer_that_was_lost_comes_again(self):
        self.put_willow()
        expected = self.undisturbed()
        robot = Robot(self.server.url, "robot-7", map="willow")
        exchange, calls = robot.client._exchange, []

        def lose_each_third(*arguments):
            reply = exchange(*arguments)
            calls.append(None)
            if len(calls) % 3 == 0:
                self.server.kill()
                self.server.start()
                raise ConnectionResetError("cut")
            return reply

        robot.client._exchange = lose_each_third
        with Clock():
            answers = self.drive(robot, self.scans)
        self.assertGreater(len(calls), 3)
        self.assert_same(answers, expected)

    def test_sends_again_what_a_restored_backup_lacks(self):
        self.put_willow()
        expected = self.undisturbed()
        robot = Robot(self.server.url, "robot-7", map="willow")
        answers = self.drive(robot, self.scans[:10])
        self.server.stop()
        backup = self.database.with_suffix(".backup")
        shutil.copy(self.database, backup)
        self.server.start()
        answers += self.drive(robot, self.scans[10:20])
        self.server.stop()
        shutil.copy(backup, self.database)
        self.server.start()
        answers += self.drive(robot, self.scans[20:])
        self.assertEqual(answers[-1].pose.epoch, expected[-1].pose.epoch)
        self.assertLess(
            math.hypot(
                answers[-1].pose.x - expected[-1].pose.x, answers[-1].pose.y - expected[-1].pose.y
            ),
            0.05,
        )

    def test_continues_the_session_of_an_earlier_process(self):
        self.put_willow()
        expected = self.undisturbed()
        first = Robot(self.server.url, "robot-7", map="willow")
        answers = self.drive(first, self.scans[:10])
        second = Robot(self.server.url, "robot-7", session=first.session)
        self.assert_same(answers + self.drive(second, self.scans[10:]), expected)

    def test_goes_on_behind_a_batch_that_another_posted(self):
        self.put_willow()
        robot = Robot(self.server.url, "robot-7", map="willow")
        self.drive(robot, self.scans[:5])
        self.drive(Robot(self.server.url, "robot-7", session=robot.session), self.scans[5:10])
        answers = self.drive(robot, self.scans[10:])
        self.assertEqual(answers[0].sequence, 2)
        self.assertTrue(answers[-1].is_localized)

    def test_posts_a_log_as_the_command_does(self):
        carmen = self.directory / "run.log"
        carmen.write_text(
            "PARAM robot_frontlaser_offset 0.2\nPARAM laser_front_laser_fov 90.0\n"
            + "".join(
                "FLASER 5 1.0 81.9 3.25 4.0 5.0 1 2 0.5 {0} 2 0.1 100.{0} nohost 0.1\n".format(i)
                for i in range(1, 6)
            )
        )
        short = self.directory / "short.jsonl"
        with gzip.open(self.robot_log, "rt") as lines:
            short.write_text("".join(next(lines) for _ in range(6)))
        for log in (carmen, short):
            with self.subTest(log.name):
                scans = list(read_log(log))
                ours = [each.to_json(scans[0].lidar) for each in scans]
                self.assertEqual(len(ours), 5)
                for mine, theirs in zip(ours, self.posted_by_command(log)):
                    self.assert_alike(mine, theirs)

    def posted_by_command(self, log):
        printed = subprocess.run(
            [self.cornerfix, "replay", log, "--print-curl", "--keep-session"],
            stdout=subprocess.PIPE,
            text=True,
            check=True,
        ).stdout
        bodies = [json.loads(text) for text in re.findall(r"'(\{.*\})'", printed)]
        for file in re.findall(r"@(\S+)", printed):
            bodies.append(json.loads(pathlib.Path(file.strip("'\"")).read_text()))
        return [each for body in bodies for each in body.get("scans", [])]

    def assert_alike(self, mine, theirs):
        self.assertEqual((mine["stamp"], mine["ranges"]), (theirs["stamp"], theirs["ranges"]))
        for name in ("x", "y", "yaw"):
            self.assertAlmostEqual(mine["odom"][name], theirs["odom"][name])

    def test_the_binary_batch_of_the_guide_is_taken(self):
        self.put_willow()
        guide = (SOURCE / "docs" / "http-api.md").read_text()
        example = {}
        exec(re.search(r"```python\n(import struct.*?)```", guide, re.DOTALL).group(1), example)
        first = self.scans[0]
        ranges = [math.nan if each is None else each for each in first.ranges]
        odom = (first.odom.x, first.odom.y, first.odom.yaw)
        body = example["binary_batch"](0, [(first.stamp, odom, ranges)])
        session = self.client.create_session(
            {"robot": "cart-7", "map": "willow", "lidar": first.lidar.to_json()}
        )
        request = urllib.request.Request(
            f"{self.server.url}/v1/sessions/{session.id}/scans",
            body,
            {"Content-Type": "application/octet-stream"},
        )
        with urllib.request.urlopen(request) as answer:
            posted = json.load(answer)
        self.assertEqual(posted["local"]["scans"], 1)
        same = self.client.post_scans(session.id, 0, [first.to_json(first.lidar)])
        self.assertEqual(same.status, posted["status"])

    def test_the_example_of_the_readme_runs(self):
        self.put_willow()
        readme = (CLIENT / "README.md").read_text()
        example = re.search(r"```python\n(.*?)```", readme, re.DOTALL).group(1)
        self.assertLessEqual(len(example.strip().splitlines()), 10)
        program = example.replace("http://127.0.0.1:8080", self.server.url)
        self.assertNotEqual(program, example)
        done = subprocess.run(
            [sys.executable, "-c", program],
            cwd=self.directory,
            stdout=subprocess.PIPE,
            text=True,
            check=True,
            env={"PYTHONPATH": str(CLIENT)},
        )
        self.assertRegex(done.stdout, r"willow .*")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cornerfix", required=True)
    arguments, rest = parser.parse_known_args()
    RealServerTest.cornerfix = arguments.cornerfix
    unittest.main(argv=[sys.argv[0], *rest], verbosity=2, warnings="ignore")
