#!/usr/bin/python3
"""The ROS 1 node under a ROS master: simulated scans, odometry and tf in, /initialpose out.

Exits with 77 where ROS is missing, unless CORNERFIX_REQUIRE_TOOLS is set.
"""
import argparse
import copy
import math
import os
import pathlib
import queue
import signal
import subprocess
import sys
import tempfile
import unittest

from real_server import CLIENT, SHORT_SIGHTED, SOURCE, WILLOW, RealServer, record_run, skip

sys.path[:0] = [str(CLIENT), str(SOURCE / "clients" / "ros1" / "scripts")]
sys.dont_write_bytecode = True
HOME = tempfile.TemporaryDirectory()
os.environ.update(
    ROS_HOME=HOME.name, ROS_IP="127.0.0.1", PYTHONPATH=str(CLIENT), PYTHONDONTWRITEBYTECODE="1"
)
os.environ.pop("ROS_HOSTNAME", None)
os.environ.pop("ROS_NAMESPACE", None)
try:
    import rosmaster.master
    import rospy
    import tf2_ros
    from diagnostic_msgs.msg import DiagnosticArray
    from geometry_msgs.msg import PoseWithCovarianceStamped
    from nav_msgs.msg import Odometry
    from nav_msgs.srv import LoadMap, LoadMapResponse
    from sensor_msgs.msg import LaserScan
    from std_srvs.srv import Trigger
except ImportError as error:
    skip(
        f"the ROS 1 node was not tested: {error}; scripts/install_dependencies.sh test installs ROS"
    )

from cornerfix import Client, Pose, read_log  # noqa: E402
from cornerfix_ros import quaternion_of, yaw_of  # noqa: E402
from play_log import mount_message, odometry_message, scan_message  # noqa: E402

NODE = SOURCE / "clients" / "ros1" / "scripts" / "cornerfix_node.py"
MOUNT = Pose(0.25, -0.1, 0.5)  # `laser` in `base_link`.
RIGHT_TURN = -0.5  # Of `laser_right` in `laser` [rad].
BATCH = 5
WAIT_S = 60  # For a message that is sure to come.


class Node:
    """The node in a namespace of its own, and what it publishes."""

    def __init__(self, namespace, server, **parameters):
        self.namespace = namespace
        self.diagnoses, self.initial_poses = queue.Queue(), queue.Queue()
        for name, value in {
            "server": server.url,
            "robot": namespace,
            "batch": BATCH,
            **parameters,
        }.items():
            rospy.set_param(f"/{namespace}/cornerfix/{name}", value)
        self._subscribers = [
            rospy.Subscriber(
                f"/{namespace}/diagnostics", DiagnosticArray, self._take_diagnosis, queue_size=100
            ),
            rospy.Subscriber(
                f"/{namespace}/initialpose", PoseWithCovarianceStamped, self.initial_poses.put
            ),
        ]
        self._scans = rospy.Publisher(f"/{namespace}/scan", LaserScan, queue_size=100)
        self._right_scans = None  # Of the second of two lidars.
        publishers = [self._scans]
        if "scans" in parameters:
            self._right_scans = rospy.Publisher(
                f"/{namespace}/right/scan", LaserScan, queue_size=100
            )
            publishers.append(self._right_scans)
        self._odometry = rospy.Publisher(f"/{namespace}/odom", Odometry, queue_size=100)
        # On a topic of its own no diagnosis is lost to a subscription of an earlier node.
        self._process = subprocess.Popen(
            [
                sys.executable,
                NODE,
                f"__ns:={namespace}",
                f"/diagnostics:=/{namespace}/diagnostics",
            ]
        )
        for topic in (*publishers, self._odometry, *self._subscribers):
            self._wait_for_connection(topic)

    def _take_diagnosis(self, message):
        for status in message.status:
            if status.hardware_id == self.namespace:
                self.diagnoses.put(({each.key: each.value for each in status.values}, status))

    @staticmethod
    def _wait_for_connection(topic):
        deadline = rospy.get_time() + WAIT_S
        while topic.get_num_connections() == 0:
            assert rospy.get_time() < deadline, f"no connection to {topic.name}"
            rospy.rostime.wallsleep(0.01)

    def drive(self, scans, frame="laser"):
        """Publishes odometry and scans of one batch; the diagnosis of the answer to it."""
        assert len(scans) == BATCH
        for scan in scans:
            stamp = rospy.Time.from_sec(scan.stamp)
            self._odometry.publish(odometry_message(scan.odom * MOUNT.inverse(), stamp))
            message = scan_message(scan, stamp)
            message.header.frame_id = frame
            if self._right_scans:
                self._right_scans.publish(right_half(message))
                message.ranges = message.ranges[len(message.ranges) // 2 :]
                message.angle_min = 0.0
            self._scans.publish(message)
        return self.diagnoses.get(timeout=WAIT_S)

    def drive_until_localized(self, scans, frame="laser"):
        """Diagnoses up to the first one that is localized; nothing may be published before."""
        for begin in range(0, len(scans) - BATCH, BATCH):
            published = self.initial_poses.qsize()
            values, status = self.drive(scans[begin : begin + BATCH], frame)
            if values["status"] == "localized":
                return values, scans[begin + BATCH - 1], begin + BATCH
            assert published == 0, f"a pose was published while {values['status']}"
            assert status.level == status.WARN
        raise AssertionError(f"not localized: {values}")

    def call(self, service, kind, *arguments):
        name = f"/{self.namespace}/cornerfix/{service}"
        rospy.wait_for_service(name, timeout=WAIT_S)
        return rospy.ServiceProxy(name, kind)(*arguments)

    def stop(self):
        self._process.send_signal(signal.SIGINT)
        code = self._process.wait(timeout=WAIT_S)
        for topic in (*self._subscribers, self._scans, self._odometry):
            topic.unregister()
        return code


def right_half(message):
    """As a lidar takes it that is turned by RIGHT_TURN."""
    right = copy.deepcopy(message)
    right.header.frame_id = "laser_right"
    right.angle_min -= RIGHT_TURN
    right.ranges = message.ranges[: len(message.ranges) // 2]
    return right


def base_pose(scan):
    """The truth of a log is the laser's."""
    return scan.pose * MOUNT.inverse()


def pose_of(message):
    position, q = message.pose.pose.position, message.pose.pose.orientation
    return Pose(position.x, position.y, yaw_of((q.x, q.y, q.z, q.w)))


class Ros1NodeTest(unittest.TestCase):
    cornerfix = None  # The command.

    @classmethod
    def setUpClass(cls):
        cls.directory = pathlib.Path(HOME.name)
        log = cls.directory / "robot.jsonl.gz"
        record_run(cls.cornerfix, log, *SHORT_SIGHTED, "--seed", "2", "--length", "9")
        cls.scans = list(read_log(log))
        cls.server = RealServer(cls.cornerfix, cls.directory / "maps.db")
        cls.addClassCleanup(lambda: cls.server.stop())
        cls.client = Client(cls.server.url)
        cls.client.import_map_server("willow", WILLOW)
        subprocess.run([cls.cornerfix, "scene", "office", cls.directory / "office"], check=True)
        cls.client.import_map_server("office", cls.directory / "office.yaml")
        cls.transforms = tf2_ros.StaticTransformBroadcaster()
        cls.transforms.sendTransform(
            [
                cls.mount("laser", quaternion_of(MOUNT.yaw)),
                cls.mount("laser_right", quaternion_of(MOUNT.yaw + RIGHT_TURN)),
                cls.mount(
                    "laser_upside_down",
                    (math.cos(MOUNT.yaw / 2), math.sin(MOUNT.yaw / 2), 0.0, 0.0),
                ),
            ]
        )

    @staticmethod
    def mount(frame, quaternion):
        message = mount_message()
        message.child_frame_id = frame
        message.transform.translation.x, message.transform.translation.y = MOUNT.x, MOUNT.y
        q = message.transform.rotation
        q.x, q.y, q.z, q.w = quaternion
        return message

    def start(self, namespace, **parameters):
        node = Node(namespace, self.server, **parameters)
        self.addCleanup(node.stop)
        return node

    def assert_published_once_at(self, node, scan):
        message = node.initial_poses.get(timeout=WAIT_S)
        self.assertEqual(message.header.frame_id, "map")
        self.assertAlmostEqual(message.header.stamp.to_sec(), scan.stamp, places=6)
        error = pose_of(message).inverse() * base_pose(scan)
        self.assertLess(math.hypot(error.x, error.y), 0.1)
        self.assertLess(abs(error.yaw), math.radians(1))
        covariance = message.pose.covariance
        for i in (0, 7, 35):  # x, y and yaw; z, roll and pitch are not estimated.
            self.assertGreater(covariance[i], 0.0)
        self.assertEqual([covariance[i] for i in (14, 21, 28)], [0.0] * 3)
        self.assertTrue(node.initial_poses.empty())

    def test_publishes_the_pose_once_it_is_localized(self):
        node = self.start("plain", map="willow")
        values, scan, driven = node.drive_until_localized(self.scans)
        self.assertEqual((values["map"], values["odometry"]), ("willow", "used"))
        self.assert_published_once_at(node, scan)
        node.drive(self.scans[driven : driven + BATCH])
        self.assertTrue(node.initial_poses.empty())

        self.assertTrue(node.call("reset", Trigger).success)
        again, scan, _ = node.drive_until_localized(self.scans)
        self.assertEqual(again["session"], values["session"])
        self.assert_published_once_at(node, scan)

    def test_reads_a_laser_that_hangs_upside_down(self):
        for scan in self.scans:
            scan.ranges = list(reversed(scan.ranges))
        self.addCleanup(self.turn_back)
        node = self.start("hanging", map="willow")
        _, scan, _ = node.drive_until_localized(self.scans, "laser_upside_down")
        self.assert_published_once_at(node, scan)

    def test_joins_the_scans_of_two_lidars(self):
        node = self.start("two", map="willow", scans="scan right/scan", batch=2 * BATCH)
        _, scan, _ = node.drive_until_localized(self.scans)
        self.assert_published_once_at(node, scan)
        (session,) = (each for each in self.client.sessions() if each.robot == "two")
        self.assertEqual(set(session.raw["lidars"]), {"scan", "right.scan"})

    def test_is_searched_where_it_is_switched_on(self):
        dock = base_pose(self.scans[0])
        near = {"near_x": dock.x, "near_y": dock.y, "near_radius_m": 2}
        node = self.start("docked", map="willow", **near)
        _, scan, _ = node.drive_until_localized(self.scans)
        self.assert_published_once_at(node, scan)
        (session,) = (each for each in self.client.sessions() if each.robot == "docked")
        self.assertEqual(session.last_answer.given, "near")

    def turn_back(self):
        for scan in self.scans:
            scan.ranges = list(reversed(scan.ranges))

    def test_waits_for_the_confirmation_if_asked_to(self):
        node = self.start("careful", map="willow", require_confirmed=True)
        _, _, driven = node.drive_until_localized(self.scans)
        confirmed = False
        while not confirmed:
            self.assertTrue(node.initial_poses.empty())
            batch = self.scans[driven : driven + BATCH]
            values, _ = node.drive(batch)
            confirmed, driven = values.get("confirmed") == "true", driven + BATCH
        self.assert_published_once_at(node, batch[-1])

    def test_publishes_no_pose_in_another_building_and_changes_the_map(self):
        node = self.start("lost", map="office")
        for begin in range(0, 50, BATCH):
            values, _ = node.drive(self.scans[begin : begin + BATCH])
            self.assertNotEqual(values["status"], "localized")
        self.assertTrue(node.initial_poses.empty())

        self.assertEqual(
            node.call("change_map", LoadMap, "nowhere").result,
            LoadMapResponse.RESULT_MAP_DOES_NOT_EXIST,
        )
        self.assertEqual(
            node.call("change_map", LoadMap, "willow").result, LoadMapResponse.RESULT_SUCCESS
        )
        other, scan, _ = node.drive_until_localized(self.scans)
        self.assertNotEqual(other["session"], values["session"])
        self.assert_published_once_at(node, scan)

    def test_reports_a_laser_without_transform(self):
        node = self.start("unmounted", map="willow")
        node.drive(self.scans[:BATCH], "nowhere")
        _, status = node.diagnoses.get(timeout=WAIT_S)
        self.assertEqual(status.level, status.ERROR)
        self.assertIn("nowhere", status.message)

    def test_ends_its_session_when_it_is_stopped(self):
        node = Node("brief", self.server, map="willow")
        node.drive(self.scans[:BATCH])
        self.assertIn("brief", [each.robot for each in self.client.sessions()])
        self.assertEqual(node.stop(), 0)
        self.assertNotIn("brief", [each.robot for each in self.client.sessions()])


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cornerfix", required=True)
    arguments, rest = parser.parse_known_args()
    Ros1NodeTest.cornerfix = arguments.cornerfix
    master = rosmaster.master.Master(port=0)
    master.start()
    os.environ["ROS_MASTER_URI"] = master.uri
    rospy.init_node("ros1_node_test", disable_signals=True)
    tests = unittest.main(argv=[sys.argv[0], *rest], verbosity=2, warnings="ignore", exit=False)
    rospy.signal_shutdown("done")
    master.stop()
    sys.exit(0 if tests.result.wasSuccessful() else 1)


if __name__ == "__main__":
    main()
