#!/usr/bin/python3
"""What the ROS nodes share, without ROS: mount, odometry, gate, bridge to the real server."""
import argparse
import math
import pathlib
import queue
import sys
import tempfile
import unittest

from real_server import CLIENT, SHORT_SIGHTED, WILLOW, RealServer, record_run

sys.path.insert(0, str(CLIENT))
from cornerfix import (
    Answer,
    Client,
    LocalizedPose,
    Near,
    Pose,
    Problem,
    Scan,
    Unreachable,
    read_log,
)  # noqa: E402
from cornerfix_ros import (
    Bridge,
    Level,
    Mount,
    OdometryTrack,
    PoseGate,
    ScanQueue,
    Settings,  # noqa: E402
    covariance_6x6,
    diagnose,
    quaternion_of,
    yaw_of,
)

WAIT_S = 60  # For an answer that is sure to come.


def localized(epoch=1, confirmed=False, session="s"):
    pose = LocalizedPose("willow", 3, 12.5, 1.0, 2.0, 0.5, tuple(range(9)), epoch, confirmed)
    return Answer("localized", session=session, sequence=7, pose=pose, confidence=0.998)


class GeometryTest(unittest.TestCase):
    def test_yaw_and_quaternion_are_inverse(self):
        for yaw in (-3.0, -0.5, 0.0, 1.0, 3.1):
            self.assertAlmostEqual(yaw_of(quaternion_of(yaw)), yaw)

    def test_refuses_a_quaternion_that_was_not_filled_in(self):
        for wrong in ((0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 2.0), (math.nan, 0.0, 0.0, 1.0)):
            with self.subTest(wrong), self.assertRaisesRegex(ValueError, "a unit quaternion"):
                yaw_of(wrong)
        self.assertAlmostEqual(yaw_of((0.0, 0.0, 0.0, 0.99)), 0.0)

    def test_a_level_laser_keeps_its_angles(self):
        mount = Mount.of(0.2, -0.1, quaternion_of(1.0))
        lidar = mount.lidar(-1.5, 0.01, 0.1, math.inf)
        self.assertEqual(
            (lidar.angle_min, lidar.angle_increment, lidar.range_max), (-1.5, 0.01, None)
        )
        self.assertEqual((lidar.mount.x, lidar.mount.y), (0.2, -0.1))
        self.assertAlmostEqual(lidar.mount.yaw, 1.0)

    def test_a_laser_upside_down_turns_the_other_way(self):
        yaw = 0.7  # Rotation by yaw about z, after roll of pi about x.
        mount = Mount.of(0.2, 0.0, (math.cos(yaw / 2), math.sin(yaw / 2), 0.0, 0.0))
        lidar = mount.lidar(-1.5, 0.01, 0.1, 20.0)
        self.assertEqual((lidar.angle_min, lidar.angle_increment), (1.5, -0.01))
        self.assertAlmostEqual(lidar.mount.yaw, yaw)

    def test_a_tilted_laser_is_refused(self):
        with self.assertRaisesRegex(ValueError, "tilted by 30 deg"):
            Mount.of(0, 0, (0.0, math.sin(math.radians(15)), 0.0, math.cos(math.radians(15))))

    def test_covariance_is_that_of_x_y_and_yaw(self):
        out = covariance_6x6(localized().pose)
        self.assertEqual(
            [out[6 * row + column] for row in (0, 1, 5) for column in (0, 1, 5)], list(range(9))
        )
        self.assertEqual(sum(out), sum(range(9)))


class OdometryTest(unittest.TestCase):
    def test_is_interpolated_across_the_turn_of_the_angle(self):
        track = OdometryTrack()
        track.add(1.0, Pose(0, 0, 3.0))
        track.add(2.0, Pose(1, 2, -3.0))
        middle = track.at(1.5)
        self.assertEqual((middle.x, middle.y), (0.5, 1.0))
        self.assertAlmostEqual(abs(middle.yaw), math.pi)
        self.assertEqual((track.at(0.9), track.at(2.1)), (None, None))
        track.add(3.0, Pose(math.nan, 0, 0))
        self.assertEqual(track.newest, 2.0)

    def test_forgets_what_is_old_and_what_a_clock_set_back_left(self):
        track = OdometryTrack(kept_s=2.0)
        for stamp in range(10):
            track.add(float(stamp), Pose(stamp, 0, 0))
        self.assertEqual((track.at(6.5), track.at(8.0)), (None, Pose(8, 0, 0)))
        track.add(1.0, Pose())
        self.assertEqual((track.newest, track.at(8.0)), (1.0, None))

    def stamps(self, scans):
        return [(each.stamp, each.odom and each.odom.x) for each in scans]

    def test_scans_wait_for_the_odometry_of_their_stamps(self):
        scans = ScanQueue()
        self.assertEqual(self.stamps(scans.add_scan(Scan(0.9, [1.0]))), [(0.9, None)])
        scans.add_odometry(1.0, Pose(1, 0, 0))
        self.assertEqual(scans.add_scan(Scan(1.25, [1.0])), [])
        self.assertEqual(self.stamps(scans.add_odometry(1.5, Pose(2, 0, 0))), [(1.25, 1.5)])

    def test_scans_of_several_lidars_are_in_the_order_of_their_stamps(self):
        scans = ScanQueue()
        scans.add_odometry(1.0, Pose(1, 0, 0))
        scans.add_scan(Scan(1.2, [1.0], lidar_name="front"))
        scans.add_scan(Scan(1.1, [1.0], lidar_name="rear"))
        ready = scans.add_odometry(1.3, Pose(1, 0, 0))
        self.assertEqual([each.lidar_name for each in ready], ["rear", "front"])

    def test_forgets_scans_that_wait_when_the_clock_was_set_back(self):
        scans = ScanQueue()
        scans.add_odometry(10.0, Pose())
        self.assertEqual(scans.add_scan(Scan(10.1, [1.0])), [])
        self.assertEqual(self.stamps(scans.add_scan(Scan(1.0, [1.0]))), [(1.0, None)])

    def test_scans_do_not_wait_for_ever(self):
        scans = ScanQueue()
        scans.add_odometry(1.0, Pose())
        scans.add_scan(Scan(1.1, [1.0]))
        self.assertEqual(self.stamps(scans.add_scan(Scan(1.7, [1.0]))), [(1.1, None)])


class GateTest(unittest.TestCase):
    def test_lets_one_pose_of_each_epoch_pass(self):
        gate = PoseGate()
        answers = [
            Answer("collecting"),
            Answer("ambiguous"),
            localized(),
            localized(),
            Answer("lost"),
            localized(),
            localized(epoch=2),
            localized(epoch=2, session="t"),
        ]
        self.assertEqual(
            [gate.passes(each, 1) for each in answers],
            [False, False, True, False, False, False, True, True],
        )

    def test_waits_for_the_confirmation(self):
        gate = PoseGate(require_confirmed=True)
        answers = [localized(), localized(confirmed=True), localized(confirmed=True)]
        self.assertEqual([gate.passes(each, 1) for each in answers], [False, True, False])

    def test_keeps_a_pose_back_until_someone_listens(self):
        gate = PoseGate()
        self.assertEqual(
            [gate.passes(localized(), listeners) for listeners in (0, 0, 1)], [False, False, True]
        )

    def test_the_diagnosis_names_status_and_reason(self):
        well, unwell = diagnose(localized()), diagnose(Answer("collecting", reason="few_features"))
        self.assertEqual(
            (well.level, well.message, well.values["epoch"]), (Level.OK, "localized", "1")
        )
        self.assertEqual((unwell.level, unwell.message), (Level.WARN, "collecting: few_features"))


class SettingsTest(unittest.TestCase):
    def test_are_read_with_their_defaults(self):
        given = {"map": "willow", "retry_s": 2}
        settings = Settings.read(lambda name, default: given.get(name, default))
        self.assertEqual(settings, Settings(map="willow", retry_s=2.0))

    def test_name_the_lidars_of_several_topics(self):
        self.assertEqual(Settings().lidar_names, {"scan": None})
        self.assertEqual(
            Settings(scans="front/scan  /rear/scan").lidar_names,
            {"front/scan": "front.scan", "/rear/scan": "rear.scan"},
        )
        with self.assertRaisesRegex(ValueError, "parameter scans: empty"):
            Settings.read(lambda name, default: " " if name == "scans" else default)

    def test_say_where_the_robot_is_switched_on(self):
        self.assertIsNone(Settings(near_x=1.0).near)
        self.assertEqual(Settings(near_x=1.0, near_radius_m=3.0).near, Near(1.0, 0.0, 3.0))
        self.assertEqual(
            Settings(near_radius_m=3.0, near_yaw=0.5, near_yaw_tolerance_rad=0.2).near,
            Near(0.0, 0.0, 3.0, yaw=0.5, yaw_tolerance_rad=0.2),
        )

    def test_name_what_is_wrong(self):
        with self.assertRaisesRegex(ValueError, "parameter batch: '5', expected int"):
            Settings.read(lambda name, default: "5" if name == "batch" else default)


class BridgeTest(unittest.TestCase):
    cornerfix = None  # The command.

    @classmethod
    def setUpClass(cls):
        directory = tempfile.TemporaryDirectory()
        cls.addClassCleanup(directory.cleanup)
        cls.directory = pathlib.Path(directory.name)
        log = cls.directory / "robot.jsonl.gz"
        record_run(cls.cornerfix, log, *SHORT_SIGHTED, "--seed", "2", "--length", "4")
        cls.scans = list(read_log(log))
        cls.server = RealServer(cls.cornerfix, cls.directory / "maps.db")
        cls.addClassCleanup(lambda: cls.server.stop())
        with Client(cls.server.url) as client:
            client.import_map_server("willow", WILLOW)

    def setUp(self):
        self.answers, self.failures = queue.Queue(), queue.Queue()
        settings = Settings(server=self.server.url, robot="robot-7", map="willow", retry_s=0.2)
        self.bridge = Bridge(settings, self.answers.put, self.failures.put)
        self.addCleanup(self.bridge.close)

    def hand_over(self, scans):
        for scan in scans:
            self.bridge.add_odometry(scan.stamp, scan.odom)
            self.bridge.add_scan(Scan(scan.stamp, scan.ranges, scan.lidar))

    def drive(self, scans):
        """The answers, one per batch of 5 scans."""
        self.hand_over(scans)
        return [self.answers.get(timeout=WAIT_S) for _ in range(len(scans) // 5)]

    def test_localizes_and_resets(self):
        answer = self.drive(self.scans[:40])[-1]
        truth = self.scans[39].pose
        self.assertLess(math.hypot(answer.pose.x - truth.x, answer.pose.y - truth.y), 0.1)
        self.assertEqual(answer.odometry, "used")
        self.bridge.reset()
        again = self.drive(self.scans[:40])[-1]
        self.assertEqual(again.session, answer.session)
        self.assertGreater(again.pose.epoch, answer.pose.epoch)

    def test_reports_an_outage_and_sends_the_scans_later(self):
        self.drive(self.scans[:5])
        self.server.kill()
        try:
            self.hand_over(self.scans[5:10])
            self.assertIsInstance(self.failures.get(timeout=WAIT_S), Unreachable)
        finally:
            self.server.start()
        self.hand_over(self.scans[10:11])
        self.assertEqual(self.answers.get(timeout=WAIT_S).sequence, 1)

    def test_changes_the_map(self):
        first = self.drive(self.scans[:5])[-1]
        with self.assertRaises(Problem) as raised:
            self.bridge.change_map("nowhere")
        self.assertEqual(raised.exception.code, "not_found")
        self.assertEqual(self.drive(self.scans[5:10])[-1].session, first.session)
        self.bridge.change_map("")
        self.assertNotEqual(self.drive(self.scans[10:15])[-1].session, first.session)
        with Client(self.server.url) as client:
            self.assertEqual([each.maps for each in client.sessions()], [None])


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cornerfix", required=True)
    arguments, rest = parser.parse_known_args()
    BridgeTest.cornerfix = arguments.cornerfix
    unittest.main(argv=[sys.argv[0], *rest], verbosity=2, warnings="ignore")
