#!/usr/bin/python3
"""The Python client against a stub that misbehaves."""
import dataclasses
import email.utils
import fractions
import math
import sys
import time
import unittest

from real_server import CLIENT

sys.path.insert(0, str(CLIENT))
from cornerfix import (  # noqa: E402
    Client,
    CornerfixError,
    Near,
    Pose,
    Problem,
    Robot,
    Scan,
    Unreachable,
)
from python_stub import LIDAR, Clock, Stub, problem, scan  # noqa: E402

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

    def test_names_the_target_of_a_redirection(self):
        moved = (301, {"Location": "https://robots.example/v1/maps/a"}, b"<html>")
        with Stub(moved) as stub, self.assertRaisesRegex(
            CornerfixError, "answers 301, a redirection to https://robots.example"
        ):
            Client(stub.url).delete_map("a")

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
                (Scan(1.0, [1.0], LIDAR, odom=Pose(math.nan, 0, 0)), "odom: .* finite numbers"),
                (Scan(1.0, [1.0], LIDAR, odom=Pose(0, 0, None)), "odom: .* finite numbers"),
                (Scan(1.0, [1.0], dataclasses.replace(LIDAR, angle_min=math.inf)), "lidar: "),
                (Scan(1.0, [1.0], LIDAR, time_increment=math.nan), "time_increment: nan"),
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

    def test_sends_numbers_of_other_libraries(self):
        third = fractions.Fraction(1, 4)  # A numbers.Real that json does not know, as numpy's.
        with Stub(self.CREATED, self.TAKEN) as stub:
            Robot(stub.url, "r", batch=1).add(
                Scan(third, [third], LIDAR, odom=Pose(third, third, third))
            )
            sent = stub.bodies()[-1]["scans"][0]
        self.assertEqual((sent["stamp"], sent["ranges"]), (0.25, [0.25]))
        self.assertEqual(sent["odom"], {"x": 0.25, "y": 0.25, "yaw": 0.25})

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


if __name__ == "__main__":
    unittest.main(verbosity=2, warnings="ignore")
