#!/usr/bin/python3
"""The Python client against a stub that misbehaves, and against the real server."""
import argparse
import ast
import dataclasses
import email.utils
import gzip
import http.server
import json
import math
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import threading
import time
import unittest
from unittest import mock

from real_server import CLIENT, SHORT_SIGHTED, SOURCE, WILLOW, RealServer, record_run

sys.path.insert(0, str(CLIENT))
import cornerfix  # noqa: E402
from cornerfix import (
    Client,
    CornerfixError,
    Lidar,
    LogError,
    Near,
    Pose,
    Problem,
    Robot,
    Scan,  # noqa: E402
    Unreachable,
    read_log,
)

LIDAR = Lidar(-1.0, 0.5, 0.1, 20.0)
ANSWER = {
    "session": "s",
    "sequence": 0,
    "status": "collecting",
    "pose": None,
    "confidence": 0.0,
    "hypotheses": [],
    "reason": "few_features",
    "odometry": None,
}


class Clock:
    """Time that passes only while the client waits."""

    def __init__(self, on_wait=lambda: None):
        self.waits = []
        self._on_wait = on_wait

    def monotonic(self):
        return sum(self.waits)

    def sleep(self, seconds):
        self.waits.append(seconds)
        self._on_wait()

    def __enter__(self):
        self._patch = mock.patch.object(cornerfix, "time", self)
        self._patch.start()
        return self

    def __exit__(self, *_):
        self._patch.stop()


class Stub:
    """A server that gives the listed replies, one per request: (status, headers, body), or None to
    close the connection without an answer."""

    def __init__(self, *replies):
        self.replies = list(replies)
        self.requests = []
        stub = self

        class Handler(http.server.BaseHTTPRequestHandler):
            protocol_version = "HTTP/1.1"

            def answer(self):
                length = int(self.headers.get("Content-Length", 0))
                stub.requests.append((self.command, self.path, self.rfile.read(length)))
                reply = stub.replies.pop(0)
                if reply is None:
                    self.close_connection = True
                    return
                status, headers, body = reply
                data = body if isinstance(body, bytes) else json.dumps(body).encode()
                self.send_response(status)
                for name, value in {**headers, "Content-Length": str(len(data))}.items():
                    self.send_header(name, value)
                self.end_headers()
                self.wfile.write(data)

            do_GET = do_POST = do_PUT = do_DELETE = answer

            def log_message(self, *_):
                pass

        self._server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self._server.daemon_threads = True
        self._thread = threading.Thread(
            target=self._server.serve_forever, kwargs={"poll_interval": 0.01}
        )
        self.url = "http://127.0.0.1:%d" % self._server.server_address[1]

    def __enter__(self):
        self._thread.start()
        return self

    def __exit__(self, *_):
        self._server.shutdown()
        self._thread.join()
        self._server.server_close()

    def bodies(self):
        return [json.loads(body) for _, _, body in self.requests if body]


def problem(status, code, **members):
    return (
        status,
        {"Content-Type": "application/problem+json"},
        {"code": code, "detail": "why", **members},
    )


def scan(stamp):
    return Scan(stamp, [1.0, None, float("nan"), float("inf"), 2.00004], LIDAR)


def half_of(lidar, yaw):
    """A lidar of the middle half of the beams, turned by `yaw`."""
    return dataclasses.replace(lidar, angle_min=lidar.angle_min / 2.0, mount=Pose(0, 0, yaw))


def halves(whole):
    """A scan of a full turn, as two lidars take it that stand back to back."""
    quarter = len(whole.ranges) // 4
    rear = whole.ranges[-quarter:] + whole.ranges[:quarter]
    for name, ranges in (("rear", rear), ("front", whole.ranges[quarter:-quarter])):
        yield Scan(whole.stamp, ranges, None, whole.odom, lidar_name=name)


class RetryTest(unittest.TestCase):
    def test_waits_as_long_as_retry_after_asks_for(self):
        for status, code in ((503, "busy"), (429, "too_many_sessions")):
            refused = (status, {"Retry-After": "7"}, {"code": code})
            with self.subTest(status), Stub(
                refused, (200, {}, {"name": "a"})
            ) as stub, Clock() as clock:
                self.assertEqual(Client(stub.url).map("a").name, "a")
                self.assertEqual(clock.waits, [7.0])

    def test_reads_a_date_in_retry_after(self):
        date = email.utils.formatdate(time.time() - 60, usegmt=True)
        refused = (503, {"Retry-After": date}, {"code": "busy"})
        with Stub(refused, (200, {}, {"name": "a"})) as stub, Clock() as clock:
            Client(stub.url).map("a")
            self.assertEqual(clock.waits, [0.0])

    def test_gives_up_when_it_would_wait_too_long(self):
        with Stub((503, {"Retry-After": "61"}, {"code": "draining"})) as stub, Clock() as clock:
            with self.assertRaises(Problem) as raised:
                Client(stub.url, give_up_after_s=60).map("a")
            self.assertEqual((raised.exception.code, clock.waits), ("draining", []))

    def test_repeats_a_request_whose_connection_broke(self):
        with Stub(None, (200, {}, {"name": "a"})) as stub, Clock() as clock:
            self.assertEqual(Client(stub.url).map("a").name, "a")
            self.assertEqual(clock.waits, [0.0])

    def test_repeats_a_request_whose_server_a_proxy_lost(self):
        for status in (502, 504):
            with self.subTest(status), Stub(
                (status, {}, {}), (200, {}, {"name": "a"})
            ) as stub, Clock() as clock:
                self.assertEqual(Client(stub.url).map("a").name, "a")
                self.assertEqual(clock.waits, [0.0])

    def test_backs_off_while_the_server_is_away(self):
        with Stub() as stub:
            url = stub.url
        with Clock() as clock, self.assertRaises(Unreachable):
            Client(url, give_up_after_s=30).maps()
        self.assertLessEqual(sum(clock.waits), 30.0)
        self.assertLess(clock.waits[1], 0.2)
        self.assertGreater(max(clock.waits), 1.0)
        self.assertLessEqual(max(clock.waits), 5.0)


class ErrorTest(unittest.TestCase):
    def test_carries_code_and_pointer(self):
        errors = [{"pointer": "/scans/0/ranges/1", "detail": "must be a number"}]
        with Stub(problem(422, "invalid_argument", errors=errors)) as stub:
            with self.assertRaises(Problem) as raised:
                Client(stub.url).map("a")
        error = raised.exception
        self.assertEqual(
            (error.status, error.code, error.pointer),
            (422, "invalid_argument", "/scans/0/ranges/1"),
        )
        self.assertEqual(
            str(error), "422 invalid_argument: why; /scans/0/ranges/1: must be a number"
        )

    def test_names_a_server_that_is_another(self):
        with Stub((200, {}, b"<html>")) as stub, self.assertRaisesRegex(
            CornerfixError, "is this a Cornerfix"
        ):
            Client(stub.url).map("a")

    def test_survives_an_error_that_is_no_problem_document(self):
        with Stub((403, {}, b"<html>forbidden")) as stub, self.assertRaisesRegex(
            Problem, "403 .*forbidden"
        ):
            Client(stub.url).map("a")

    def test_names_the_member_that_a_detail_leaves_out(self):
        errors = [{"pointer": "/yaml/negate", "detail": "expected 0 or 1"}]
        reply = problem(422, "invalid_argument", errors=errors)
        reply[2]["detail"] = "expected 0 or 1"
        with Stub(reply) as stub, self.assertRaisesRegex(Problem, "/yaml/negate: expected 0 or 1"):
            Client(stub.url).map("a")

    def test_refuses_an_url_without_a_host(self):
        with self.assertRaisesRegex(ValueError, "expected http://HOST:PORT"):
            Client("robot:8080")


class SequenceTest(unittest.TestCase):
    CREATED = (201, {}, {"id": "s", "robot": "r", "status": "collecting", "expected": 0})
    TAKEN = (200, {}, ANSWER)

    def sent(self, stub):
        return [
            (body["sequence"], [each["stamp"] for each in body["scans"]])
            for body in stub.bodies()
            if "sequence" in body
        ]

    def test_sends_no_return_as_null_and_the_geometry_once(self):
        with Stub(self.CREATED, self.TAKEN) as stub:
            Robot(stub.url, "r", batch=1).add(scan(1.0))
            session, batch = stub.bodies()
        self.assertEqual(session, {"robot": "r", "lidar": LIDAR.to_json()})
        self.assertEqual(batch["scans"], [{"stamp": 1.0, "ranges": [1.0, None, None, None, 2.0]}])

    def test_sends_again_what_a_server_lost(self):
        conflict = problem(409, "sequence_conflict", expected=1)
        with Stub(self.CREATED, *[self.TAKEN] * 3, conflict, self.TAKEN) as stub:
            robot = Robot(stub.url, "r", batch=1)
            for stamp in (1.0, 2.0, 3.0, 4.0):
                robot.add(scan(stamp))
            self.assertEqual(self.sent(stub)[3:], [(3, [4.0]), (1, [2.0, 3.0, 4.0])])

    def test_skips_what_a_server_has(self):
        conflict = problem(409, "sequence_conflict", expected=5, last_stamp=2.0)
        with Stub(self.CREATED, conflict, self.TAKEN) as stub:
            robot = Robot(stub.url, "r", batch=3)
            for stamp in (1.0, 2.0, 3.0, 4.0, 5.0):
                robot.add(scan(stamp))
            self.assertEqual(self.sent(stub), [(0, [1.0, 2.0, 3.0]), (5, [3.0, 4.0, 5.0])])

    def test_raises_a_conflict_that_does_not_end(self):
        conflict = problem(409, "sequence_conflict", expected=5)
        with Stub(self.CREATED, *[conflict] * 4) as stub, self.assertRaises(Problem):
            Robot(stub.url, "r", batch=1).add(scan(1.0))

    def test_makes_a_new_session_when_the_server_has_lost_it(self):
        gone = problem(404, "not_found")
        other = (201, {}, {"id": "t", "robot": "r", "status": "collecting", "expected": 0})
        with Stub(self.CREATED, self.TAKEN, gone, other, self.TAKEN) as stub:
            robot = Robot(stub.url, "r", batch=1)
            robot.add(scan(1.0))
            robot.add(scan(2.0))
            self.assertEqual((robot.session, self.sent(stub)[-1]), ("t", (0, [2.0])))

    def test_does_not_take_a_scan_that_cannot_be_sent(self):
        with Stub(self.CREATED, self.TAKEN) as stub:
            robot = Robot(stub.url, "r", batch=1)
            for wrong, message in (
                (Scan(math.nan, [1.0], LIDAR), "stamp: nan, expected seconds"),
                (Scan(1.0, [], LIDAR), "ranges: none"),
                (Scan(1.0, [1.0], LIDAR, odom=(1, 2, 3)), "expected a Pose or None"),
                (Scan(1.0, [1.0], {"angle_min": 1.0}), "expected a Lidar or None"),
            ):
                with self.subTest(message), self.assertRaisesRegex(ValueError, message):
                    robot.add(wrong)
            self.assertIsNotNone(robot.add(scan(1.0)))
            self.assertEqual(self.sent(stub), [(0, [1.0])])

    def test_drops_a_batch_with_a_range_that_is_no_number(self):
        with Stub(self.CREATED, self.TAKEN) as stub:
            robot = Robot(stub.url, "r", batch=1)
            with self.assertRaises(TypeError):
                robot.add(Scan(1.0, ["far"], LIDAR))
            self.assertIsNotNone(robot.add(scan(2.0)))
            self.assertEqual(self.sent(stub), [(0, [2.0])])

    def test_sends_the_geometry_and_mount_of_another_lidar(self):
        other = dataclasses.replace(LIDAR, mount=Pose(0.2, 0.0, 0.0), roll=math.pi)
        with Stub(self.CREATED, self.TAKEN, self.TAKEN) as stub:
            robot = Robot(stub.url, "r", batch=1)
            robot.add(scan(1.0))
            robot.add(dataclasses.replace(scan(2.0), lidar=other))
            sent = stub.bodies()[-1]["scans"][0]
        self.assertEqual(sent["mount"], {"x": 0.2, "y": 0.0, "yaw": 0.0, "roll": math.pi})
        self.assertEqual(sent["angle_increment"], LIDAR.angle_increment)

    def lidar_scan(self, name, stamp, lidar=None):
        return Scan(stamp, [1.0, 2.0], lidar, lidar_name=name)

    def sent_lidars(self, stub):
        return [
            [(each["lidar"], each["stamp"]) for each in body["scans"]]
            for body in stub.bodies()
            if "sequence" in body
        ]

    def test_sends_scans_of_several_lidars_in_the_order_of_their_stamps(self):
        lidars = {"front": LIDAR, "rear": dataclasses.replace(LIDAR, mount=Pose(0, 0, 3.0))}
        with Stub(self.CREATED, self.TAKEN) as stub:
            robot = Robot(stub.url, "r", batch=3, lidars=lidars)
            for name, stamp in (("front", 1.0), ("rear", 1.05), ("rear", 1.15)):
                robot.add(self.lidar_scan(name, stamp))
            self.assertEqual(self.sent_lidars(stub), [], "the front lidar is not as far")
            robot.add(self.lidar_scan("front", 1.1))
            self.assertEqual(
                self.sent_lidars(stub), [[("front", 1.0), ("rear", 1.05), ("front", 1.1)]]
            )
            session, batch = stub.bodies()
        self.assertEqual(session["lidars"]["rear"]["mount"], {"x": 0, "y": 0, "yaw": 3.0})
        self.assertNotIn("lidar", session)
        self.assertNotIn("mount", batch["scans"][0], "the session has it")

    def test_does_not_wait_for_a_lidar_that_is_silent(self):
        with Stub(self.CREATED, *[self.TAKEN] * 3) as stub:
            robot = Robot(stub.url, "r", batch=1, lidars={"front": LIDAR, "rear": LIDAR})
            robot.add(self.lidar_scan("rear", 0.9))
            robot.add(self.lidar_scan("front", 1.0))
            self.assertEqual(self.sent_lidars(stub), [[("rear", 0.9)]])
            robot.add(self.lidar_scan("front", 1.5))
            self.assertEqual(self.sent_lidars(stub)[-1], [("front", 1.0), ("front", 1.5)])
            robot.add(self.lidar_scan("rear", 1.4))
            self.assertEqual(robot.dropped, 1, "it is earlier than what was sent")

    def test_lidars_known_by_name_bring_their_geometry(self):
        rear = dataclasses.replace(LIDAR, angle_min=-2.0, mount=Pose(0, 0, 3.0))
        with Stub(self.CREATED, self.TAKEN) as stub:
            robot = Robot(stub.url, "r", batch=2, lidars=["front", "rear"])
            robot.add(self.lidar_scan("rear", 1.0, rear))
            robot.add(self.lidar_scan("front", 1.0, LIDAR))
            session, batch = stub.bodies()
        self.assertEqual(set(session["lidars"]), {"front", "rear"})
        self.assertEqual([each["angle_min"] for each in batch["scans"]], [-2.0, LIDAR.angle_min])
        self.assertEqual([each["mount"]["yaw"] for each in batch["scans"]], [3.0, 0.0])

    def test_names_a_lidar_that_is_not_the_robots(self):
        robot = Robot("http://127.0.0.1:1", "r", lidars=["front", "rear"])
        for wrong, message in (
            (self.lidar_scan("top", 1.0), "'top', expected one of front, rear"),
            (self.lidar_scan(None, 1.0), "None, expected one of front, rear"),
            (self.lidar_scan("rear", 1.0), "no geometry of 'rear'"),
        ):
            with self.subTest(message), self.assertRaisesRegex(ValueError, message):
                robot.add(wrong)
        with self.assertRaisesRegex(ValueError, "the robot has no `lidars`"):
            Robot("http://127.0.0.1:1", "r").add(self.lidar_scan("rear", 1.0))

    def test_sends_where_the_robot_may_be_with_the_first_session_only(self):
        gone = problem(404, "not_found")
        with Stub(self.CREATED, self.TAKEN, gone, self.CREATED, self.TAKEN) as stub:
            robot = Robot(stub.url, "r", batch=1, near=Near(1.0, 2.0, 3.0))
            robot.add(scan(1.0))
            robot.add(scan(2.0))
            sessions = [body for body in stub.bodies() if "robot" in body]
        self.assertEqual(sessions[0]["near"], {"x": 1.0, "y": 2.0, "radius_m": 3.0})
        self.assertNotIn("near", sessions[1], "it has moved since")

    def test_resets_to_a_place(self):
        reset = (200, {}, {"id": "s", "robot": "r", "status": "collecting", "expected": 1})
        with Stub(self.CREATED, self.TAKEN, reset) as stub:
            robot = Robot(stub.url, "r", batch=1)
            robot.add(scan(1.0))
            robot.reset(near=Near(1.0, 2.0, 3.0, yaw=0.5))
            self.assertEqual(
                stub.bodies()[-1], {"near": {"x": 1.0, "y": 2.0, "radius_m": 3.0, "yaw": 0.5}}
            )

    def test_drops_a_repeated_stamp_and_resets_when_the_clock_was_set_back(self):
        reset = (200, {}, {"id": "s", "robot": "r", "status": "collecting", "expected": 1})
        with Stub(self.CREATED, self.TAKEN, reset, self.TAKEN) as stub:
            robot = Robot(stub.url, "r", batch=1)
            for stamp in (10.0, 10.0, 9.0, 1.0):
                robot.add(scan(stamp))
            self.assertEqual(robot.dropped, 2)
            self.assertEqual(stub.requests[2][1], "/v1/sessions/s/reset")
            self.assertEqual(self.sent(stub)[-1], (1, [1.0]))

    def test_keeps_scans_while_the_server_is_away(self):
        with Stub(
            self.CREATED, *[problem(503, "busy")] * 2, self.TAKEN, self.TAKEN
        ) as stub, Clock():
            robot = Robot(Client(stub.url, give_up_after_s=0.0), "r", batch=1)
            with self.assertRaises(Problem):
                robot.add(scan(1.0))
            self.assertIsNotNone(robot.add(scan(2.0)))
            self.assertEqual(self.sent(stub)[-2:], [(0, [1.0]), (1, [2.0])])


class LogTest(unittest.TestCase):
    def setUp(self):
        directory = tempfile.TemporaryDirectory()
        self.addCleanup(directory.cleanup)
        self.path = pathlib.Path(directory.name) / "run.log"

    HEADER = {"beams": 2, "angle_min": 0, "angle_increment": 0.1, "range_min": 0, "range_max": None}

    def read(self, *lines):
        self.path.write_text("".join(f"{line}\n" for line in lines))
        return list(read_log(self.path))

    def test_reads_json_lines(self):
        one, two = self.read(
            json.dumps(self.HEADER),
            '{"t": 1, "ranges": [1, null], "odom": [1, 2, 7]}',
            "",
            '{"t": 2, "ranges": [1], "angle_min": 1, "pose": [0, 0, 0]}',
        )
        self.assertEqual(one.lidar, Lidar(0, 0.1, 0, None))
        self.assertAlmostEqual(one.odom.yaw, 7 - 2 * math.pi)
        self.assertEqual((one.pose, two.pose, two.lidar.angle_min), (None, Pose(), 1))

    def test_names_the_line_that_is_wrong(self):
        for line, what in (
            ('{"t": 1, "ranges": [1]}', "1 values, expected 2"),
            ('{"t": 1', "line 2"),
            ("[1, 2]", "line 2: "),
            ('{"t": 1, "ranges": [1, 2], "odom": [1, 2]}', r"\[1, 2\], expected \[x, y, yaw\]"),
            ('{"ranges": [1, 2]}', "line 2: t: missing"),
        ):
            with self.subTest(line), self.assertRaisesRegex(LogError, what):
                self.read(json.dumps(self.HEADER), line)

    def test_reads_what_there_is_of_a_file_that_is_cut_off(self):
        lines = [json.dumps(self.HEADER)] + [
            '{"t": %d, "ranges": [1.5, null]}' % i for i in range(5000)
        ]
        packed = gzip.compress("\n".join(lines).encode())
        self.path.write_bytes(packed[: len(packed) // 2])
        self.assertGreater(len(list(read_log(self.path))), 1000)

    def test_refuses_a_file_that_is_no_log(self):
        with self.assertRaisesRegex(LogError, "neither JSON lines nor a CARMEN log"):
            self.read("hello")
        with self.assertRaisesRegex(LogError, "holds no whole line"):
            self.read()


class MapImageTest(unittest.TestCase):
    def image_of(self, line, *files):
        with tempfile.TemporaryDirectory() as directory:
            path = pathlib.Path(directory)
            (path / "map.yaml").write_bytes(line.encode("latin-1") + b"\r\nresolution: 0.05\r\n")
            for file in files:
                (path / file).touch()
            return cornerfix._image_of(path / "map.yaml").relative_to(path)

    def test_is_read_as_yamls_are_written(self):
        for line, image in (
            ("image: map.pgm", "map.pgm"),
            ("# caf\xe9\nimage: 'second floor.pgm'  # new", "second floor.pgm"),
            ("image: second floor.pgm # new", "second floor.pgm"),
            ('"image":   "a#b.png"', "a#b.png"),
        ):
            with self.subTest(line):
                self.assertEqual(str(self.image_of(line, image)), image)

    def test_lies_beside_the_yaml_of_another_computer(self):
        for line in ("image: /home/someone/maps/map.pgm", "image: C:\\maps\\map.pgm"):
            with self.subTest(line):
                self.assertEqual(str(self.image_of(line, "map.pgm")), "map.pgm")

    def test_is_asked_for_where_none_is_named(self):
        with self.assertRaisesRegex(ValueError, "names no image; expected a line like"):
            self.image_of("origin: [0, 0, 0]")


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
            robot.reset(near=Near(truth.x + 20.0, truth.y, 2.0))
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


class PackageTest(unittest.TestCase):
    def test_can_be_installed_without_a_network(self):
        with tempfile.TemporaryDirectory() as directory:
            source, target = pathlib.Path(directory, "source"), pathlib.Path(directory, "target")
            shutil.copytree(CLIENT, source, ignore=shutil.ignore_patterns("__pycache__"))
            subprocess.run(
                [
                    sys.executable,
                    "-m",
                    "pip",
                    "install",
                    "--quiet",
                    "--no-index",
                    "--no-build-isolation",
                    "--no-warn-script-location",
                    "--root-user-action=ignore",
                    "--target",
                    target,
                    source,
                ],
                check=True,
            )
            subprocess.run(
                [sys.executable, "-c", "import cornerfix, cornerfix_ros"],
                check=True,
                cwd=directory,
                env={"PYTHONPATH": str(target)},
            )

    def test_keeps_to_the_syntax_of_python_3_8(self):
        files = sorted((SOURCE / "clients").rglob("*.py"))
        self.assertGreaterEqual(len(files), 4)
        for file in files:
            ast.parse(file.read_text(), str(file), feature_version=(3, 8))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cornerfix", required=True)
    arguments, rest = parser.parse_known_args()
    RealServerTest.cornerfix = arguments.cornerfix
    unittest.main(argv=[sys.argv[0], *rest], verbosity=2, warnings="ignore")
