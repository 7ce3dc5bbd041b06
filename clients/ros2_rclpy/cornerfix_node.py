#!/usr/bin/env python3
"""ROS 2 node: sends scans and odometry to a Cornerfix server and publishes where the robot is.

Documented source: Debian has no rclpy, so the tests run the shared module cornerfix_ros.py only.
README.md beside this file lists topics, services and parameters.
"""
import functools
import math

import rclpy
import tf2_ros
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import PoseWithCovarianceStamped
from nav_msgs.msg import Odometry
from nav_msgs.srv import LoadMap
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from rclpy.time import Time
from sensor_msgs.msg import LaserScan
from std_srvs.srv import Trigger

from cornerfix import CornerfixError, Pose, Problem, Scan
from cornerfix_ros import (
    Bridge,
    Diagnosis,
    Level,
    Mount,
    PoseGate,
    Settings,
    covariance_6x6,
    diagnose,
    quaternion_of,
    yaw_of,
)


def seconds(stamp):
    return stamp.sec + 1e-9 * stamp.nanosec


class CornerfixNode(Node):
    def __init__(self):
        super().__init__("cornerfix")
        self._settings = Settings.read(
            lambda name, default: self.declare_parameter(name, default).value
        )
        self._gate = PoseGate(self._settings.require_confirmed)
        self._mounts = {}
        self._initial_pose = self.create_publisher(PoseWithCovarianceStamped, "initialpose", 1)
        self._pose = self.create_publisher(PoseWithCovarianceStamped, "~/pose", 10)
        self._diagnostics = self.create_publisher(DiagnosticArray, "/diagnostics", 10)
        self._bridge = Bridge(self._settings, self._publish_answer, self._publish_failure)
        self._transforms = tf2_ros.Buffer()
        self._listener = tf2_ros.TransformListener(self._transforms, self)
        # A service waits for the server, so it must not hold up the scans.
        services = MutuallyExclusiveCallbackGroup()
        self.create_service(Trigger, "~/reset", self._reset, callback_group=services)
        self.create_service(LoadMap, "~/change_map", self._change_map, callback_group=services)
        self.create_subscription(Odometry, "odom", self._take_odometry, qos_profile_sensor_data)
        for topic, name in self._settings.lidar_names.items():
            take_scan = functools.partial(self._take_scan, name)
            self.create_subscription(LaserScan, topic, take_scan, qos_profile_sensor_data)

    def close(self):
        self._bridge.close()

    def _take_odometry(self, message):
        position, q = message.pose.pose.position, message.pose.pose.orientation
        try:
            pose = Pose(position.x, position.y, yaw_of((q.x, q.y, q.z, q.w)))
        except ValueError as error:
            self._publish_failure(ValueError(f"odometry: {error}"))
            return
        self._bridge.add_odometry(seconds(message.header.stamp), pose)

    def _take_scan(self, lidar_name, message):
        try:
            mount = self._mount(message.header.frame_id)
        except (tf2_ros.TransformException, ValueError) as error:
            self._publish_failure(error)
            return
        lidar = mount.lidar(
            message.angle_min, message.angle_increment, message.range_min, message.range_max
        )
        self._bridge.add_scan(
            Scan(
                seconds(message.header.stamp),
                message.ranges,
                lidar,
                time_increment=message.time_increment,
                lidar_name=lidar_name,
            )
        )

    def _mount(self, frame):
        """Of the first transform that there is: a lidar does not move on its robot."""
        if frame not in self._mounts:
            found = self._transforms.lookup_transform(self._settings.base_frame, frame, Time())
            t, q = found.transform.translation, found.transform.rotation
            self._mounts[frame] = Mount.of(t.x, t.y, (q.x, q.y, q.z, q.w))
        return self._mounts[frame]

    def _publish_answer(self, answer):
        if answer.pose:
            message = self._pose_message(answer.pose)
            self._pose.publish(message)
            if self._gate.passes(answer, self._initial_pose.get_subscription_count()):
                self._initial_pose.publish(message)
                self.get_logger().info(
                    f"localized in {answer.pose.map} at x {answer.pose.x:.2f} m, "
                    f"y {answer.pose.y:.2f} m, yaw {math.degrees(answer.pose.yaw):.1f} deg"
                )
        self._publish_diagnosis(diagnose(answer))

    def _publish_failure(self, error):
        self.get_logger().warning(str(error), throttle_duration_sec=10.0)
        self._publish_diagnosis(Diagnosis(Level.ERROR, str(error), {}))

    def _pose_message(self, pose):
        message = PoseWithCovarianceStamped()
        message.header.stamp = Time(nanoseconds=round(pose.stamp * 1e9)).to_msg()
        message.header.frame_id = self._settings.map_frame
        message.pose.pose.position.x, message.pose.pose.position.y = pose.x, pose.y
        q = message.pose.pose.orientation
        q.x, q.y, q.z, q.w = quaternion_of(pose.yaw)
        message.pose.covariance = covariance_6x6(pose)
        return message

    def _publish_diagnosis(self, diagnosis):
        message = DiagnosticArray()
        message.header.stamp = self.get_clock().now().to_msg()
        message.status = [
            DiagnosticStatus(
                level=bytes([diagnosis.level]),
                name=self.get_name() + ": localization",
                message=diagnosis.message,
                hardware_id=self._settings.robot,
                values=[KeyValue(key=key, value=value) for key, value in diagnosis.values.items()],
            )
        ]
        self._diagnostics.publish(message)

    def _reset(self, _, response):
        try:
            self._bridge.reset()
            response.success = True
        except CornerfixError as error:
            response.success, response.message = False, str(error)
        return response

    def _change_map(self, request, response):
        """`map_url` is the name of a map on the server, or empty for all of them."""
        response.result = LoadMap.Response.RESULT_SUCCESS
        try:
            self._bridge.change_map(request.map_url)
        except CornerfixError as error:
            self.get_logger().warning(f"change_map {request.map_url}: {error}")
            response.result = (
                LoadMap.Response.RESULT_MAP_DOES_NOT_EXIST
                if isinstance(error, Problem) and error.code == "not_found"
                else LoadMap.Response.RESULT_UNDEFINED_FAILURE
            )
        return response


def main():
    rclpy.init()
    node = CornerfixNode()
    executor = MultiThreadedExecutor(num_threads=2)
    executor.add_node(node)
    try:
        executor.spin()
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        node.close()


if __name__ == "__main__":
    main()
