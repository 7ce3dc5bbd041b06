#!/usr/bin/env python3
"""Plays a recorded run as /scan, /odom and /tf_static, as a robot's drivers would publish them.

    play_log.py robot.jsonl.gz [--rate 2]

The laser of a log is at `base_link`. Stamps are moved so that the first scan is now.
"""
import argparse

import rospy
import tf2_ros
from geometry_msgs.msg import TransformStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import LaserScan

from cornerfix import read_log
from cornerfix_ros import quaternion_of


def scan_message(scan, stamp):
    lidar = scan.lidar
    message = LaserScan(
        angle_min=lidar.angle_min,
        angle_increment=lidar.angle_increment,
        angle_max=lidar.angle_min + lidar.angle_increment * (len(scan.ranges) - 1),
        range_min=lidar.range_min,
        range_max=lidar.range_max or float("inf"),
        ranges=[float("inf") if r is None else r for r in scan.ranges],
    )
    message.header.stamp, message.header.frame_id = stamp, "laser"
    return message


def odometry_message(pose, stamp):
    message = Odometry(child_frame_id="base_link")
    message.header.stamp, message.header.frame_id = stamp, "odom"
    message.pose.pose.position.x, message.pose.pose.position.y = pose.x, pose.y
    q = message.pose.pose.orientation
    q.x, q.y, q.z, q.w = quaternion_of(pose.yaw)
    return message


def mount_message():
    message = TransformStamped(child_frame_id="laser")
    message.header.stamp, message.header.frame_id = rospy.Time.now(), "base_link"
    message.transform.rotation.w = 1.0
    return message


def play(log, rate):
    scans = rospy.Publisher("scan", LaserScan, queue_size=100)
    odometry = rospy.Publisher("odom", Odometry, queue_size=100)
    transforms = tf2_ros.StaticTransformBroadcaster()
    transforms.sendTransform(mount_message())
    begin, first_stamp = rospy.Time.now(), None
    for scan in read_log(log):
        first_stamp = scan.stamp if first_stamp is None else first_stamp
        stamp = begin + rospy.Duration((scan.stamp - first_stamp) / rate)
        rospy.sleep(stamp - rospy.Time.now())
        if rospy.is_shutdown():
            return
        if scan.odom:
            odometry.publish(odometry_message(scan.odom, stamp))
        scans.publish(scan_message(scan, stamp))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("log", help="recorded run, JSON lines or CARMEN")
    parser.add_argument("--rate", type=float, default=1.0, help="times the speed of the log")
    arguments = parser.parse_args(rospy.myargv()[1:])
    rospy.init_node("play_log")
    try:
        play(arguments.log, arguments.rate)
    except rospy.ROSInterruptException:
        pass
