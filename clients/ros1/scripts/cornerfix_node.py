#!/usr/bin/env python3
"""ROS 1 node: sends scans and odometry to a Cornerfix server and publishes where the robot is.

README.md beside this file's folder lists topics, services and parameters.
"""
import functools
import math

import rospy
import tf2_ros
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import PoseWithCovarianceStamped
from nav_msgs.msg import Odometry
from nav_msgs.srv import LoadMap, LoadMapResponse
from sensor_msgs.msg import LaserScan
from std_srvs.srv import Trigger, TriggerResponse

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

TRANSFORM_WAIT = rospy.Duration(1.0)


class CornerfixNode:
    def __init__(self):
        self._settings = Settings.read(lambda name, default: rospy.get_param("~" + name, default))
        self._mounts = {}
        self._gate = PoseGate(self._settings.require_confirmed)
        self._initial_pose = rospy.Publisher("initialpose", PoseWithCovarianceStamped, queue_size=1)
        self._pose = rospy.Publisher("~pose", PoseWithCovarianceStamped, queue_size=10)
        self._diagnostics = rospy.Publisher("/diagnostics", DiagnosticArray, queue_size=10)
        self._bridge = Bridge(self._settings, self._publish_answer, self._publish_failure)
        self._transforms = tf2_ros.Buffer()
        self._listener = tf2_ros.TransformListener(self._transforms)
        rospy.Service("~reset", Trigger, self._reset)
        rospy.Service("~change_map", LoadMap, self._change_map)
        rospy.Subscriber("odom", Odometry, self._take_odometry, queue_size=100)
        for topic, name in self._settings.lidar_names.items():
            take_scan = functools.partial(self._take_scan, name)
            rospy.Subscriber(topic, LaserScan, take_scan, queue_size=100)
        rospy.on_shutdown(self._bridge.close)

    def _take_odometry(self, message):
        position, q = message.pose.pose.position, message.pose.pose.orientation
        try:
            pose = Pose(position.x, position.y, yaw_of((q.x, q.y, q.z, q.w)))
        except ValueError as error:
            self._publish_failure(ValueError(f"odometry: {error}"))
            return
        self._bridge.add_odometry(message.header.stamp.to_sec(), pose)

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
                message.header.stamp.to_sec(),
                message.ranges,
                lidar,
                time_increment=message.time_increment,
                lidar_name=lidar_name,
            )
        )

    def _mount(self, frame):
        """Of the first transform that there is: a lidar does not move on its robot."""
        if frame not in self._mounts:
            found = self._transforms.lookup_transform(
                self._settings.base_frame, frame, rospy.Time(0), TRANSFORM_WAIT
            )
            t, q = found.transform.translation, found.transform.rotation
            self._mounts[frame] = Mount.of(t.x, t.y, (q.x, q.y, q.z, q.w))
        return self._mounts[frame]

    def _publish_answer(self, answer):
        if answer.pose:
            message = self._pose_message(answer.pose)
            self._pose.publish(message)
            if self._gate.passes(answer, self._initial_pose.get_num_connections()):
                self._initial_pose.publish(message)
                rospy.loginfo(
                    "localized in %s at x %.2f m, y %.2f m, yaw %.1f deg",
                    answer.pose.map,
                    answer.pose.x,
                    answer.pose.y,
                    math.degrees(answer.pose.yaw),
                )
        self._publish_diagnosis(diagnose(answer))

    def _publish_failure(self, error):
        rospy.logwarn_throttle(10.0, str(error))
        self._publish_diagnosis(Diagnosis(Level.ERROR, str(error), {}))

    def _pose_message(self, pose):
        message = PoseWithCovarianceStamped()
        message.header.stamp = rospy.Time.from_sec(pose.stamp)
        message.header.frame_id = self._settings.map_frame
        message.pose.pose.position.x, message.pose.pose.position.y = pose.x, pose.y
        q = message.pose.pose.orientation
        q.x, q.y, q.z, q.w = quaternion_of(pose.yaw)
        message.pose.covariance = covariance_6x6(pose)
        return message

    def _publish_diagnosis(self, diagnosis):
        message = DiagnosticArray()
        message.header.stamp = rospy.Time.now()
        message.status = [
            DiagnosticStatus(
                level=int(diagnosis.level),
                name=rospy.get_name().lstrip("/") + ": localization",
                message=diagnosis.message,
                hardware_id=self._settings.robot,
                values=[KeyValue(key, value) for key, value in diagnosis.values.items()],
            )
        ]
        self._diagnostics.publish(message)

    def _reset(self, _):
        try:
            self._bridge.reset()
        except CornerfixError as error:
            return TriggerResponse(False, str(error))
        return TriggerResponse(True, "")

    def _change_map(self, request):
        """`map_url` is the name of a map on the server, or empty for all of them."""
        response = LoadMapResponse(result=LoadMapResponse.RESULT_SUCCESS)
        try:
            self._bridge.change_map(request.map_url)
        except CornerfixError as error:
            rospy.logwarn("change_map %s: %s", request.map_url, error)
            response.result = (
                LoadMapResponse.RESULT_MAP_DOES_NOT_EXIST
                if isinstance(error, Problem) and error.code == "not_found"
                else LoadMapResponse.RESULT_UNDEFINED_FAILURE
            )
        return response


if __name__ == "__main__":
    rospy.init_node("cornerfix")
    CornerfixNode()
    rospy.spin()
