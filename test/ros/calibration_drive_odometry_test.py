#!/usr/bin/env python3
"""The drive node follows a robot that publishes its odometry alone, and stops without it."""

import math
import sys
import unittest

import rospy
import rostest
from bearing_calibration.msg import CalibrationDriveResult, WheelTicks
from nav_msgs.msg import Odometry

from calibration_world import wait_until
from drivable_robot import SEPARATION, TICKS_PER_METRE, DrivableRobot


class Driver:
    """Integrates the robot's ticks, by the heading at the middle of each step."""

    def __init__(self):
        self.x = self.y = self.heading = 0.0
        self.last = None
        self.is_silent = False
        self.publisher = rospy.Publisher('odom', Odometry, queue_size=100)
        rospy.Subscriber('robot/wheel_ticks', WheelTicks, self.integrate, tcp_nodelay=True)

    def integrate(self, ticks):
        last, self.last = self.last or ticks, ticks
        left, right = ((getattr(ticks, side) - getattr(last, side)) / TICKS_PER_METRE
                       for side in ('left', 'right'))
        turn = (right - left) / SEPARATION
        self.x += 0.5 * (left + right) * math.cos(self.heading + 0.5 * turn)
        self.y += 0.5 * (left + right) * math.sin(self.heading + 0.5 * turn)
        self.heading += turn
        message = Odometry(header=ticks.header, child_frame_id='base_link')
        message.header.frame_id = 'odom'
        message.pose.pose.position.x, message.pose.pose.position.y = self.x, self.y
        message.pose.pose.orientation.z = math.sin(0.5 * self.heading)
        message.pose.pose.orientation.w = math.cos(0.5 * self.heading)
        if not self.is_silent:
            self.publisher.publish(message)


class CalibrationDriveOdometryTest(unittest.TestCase):

    # Promise stands: odometry that stops coming
    def test_it_drives_by_odometry_and_stops_without_it(self):
        rospy.init_node('calibration_drive_odometry_test')
        robot, driver = DrivableRobot(), Driver()
        wait_until(driver.publisher.get_num_connections, 'the drive node subscribes to odometry')
        robot.forget()
        x, y, _ = robot.place()
        robot.drive()
        wait_until(lambda: math.hypot(robot.base.position.x - x, robot.base.position.y - y) > 0.3,
                   'it drives for longer than timeouts/ticks')
        self.assertTrue(robot.is_moving())
        driver.is_silent = True
        self.assertTrue(robot.client.wait_for_result(rospy.Duration(10.0)))
        result = robot.client.get_result()
        self.assertEqual(result.end, CalibrationDriveResult.TICKS_LOST, result.end_text)
        # what it has followed: no less than then, no more than the straight metre at the beginning
        self.assertGreater(result.path_m, 0.25)
        self.assertLess(result.path_m, 1.0)


if __name__ == '__main__':
    rostest.rosrun('bearing_calibration', 'calibration_drive_odometry', CalibrationDriveOdometryTest,
                   sys.argv)
