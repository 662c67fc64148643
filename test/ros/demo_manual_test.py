#!/usr/bin/env python3
"""demo.launch drive:=manual: the robot stands until somebody drives it, as the instructions say."""

import math
import sys
import unittest

import rospy
import rostest
from bearing_calibration.msg import CalibrationEstimate
from geometry_msgs.msg import Twist

from calibration_world import wait_until
from demo_world import Demo

SPEED_MPS, TURN_RADPS = 0.2, 1.5
WATCHDOG_S = 0.5  # trajectory/command_timeout of the simulation


class DemoManualTest(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        rospy.init_node('demo_manual_test')
        cls.demo = Demo()
        cls.commands = rospy.Publisher('cmd_vel', Twist, queue_size=1)
        wait_until(cls.commands.get_num_connections, 'the robot listens')

    def drive(self, forward_mps, turn_radps, seconds):
        """As from a joystick, 20 times a second."""
        command = Twist()
        command.linear.x, command.angular.z = forward_mps, turn_radps
        end = rospy.get_time() + seconds
        while rospy.get_time() < end:
            self.commands.publish(command)
            rospy.sleep(0.05)

    def test_it_moves_as_it_is_told_and_its_mount_is_found(self):
        rospy.sleep(1.0)
        self.assertEqual(len(set(self.demo.way)), 1, 'it stands until it is told')

        self.drive(SPEED_MPS, 0.0, 1.0 / SPEED_MPS)
        self.demo.wait_until_it_stands()
        first, last = self.demo.way[0], self.demo.way[-1]
        # The watchdog lets the last command go on for its time.
        driven_m = math.hypot(last[0] - first[0], last[1] - first[1])
        self.assertGreater(driven_m, 0.9)
        self.assertLess(driven_m, 1.1 + WATCHDOG_S * SPEED_MPS)
        rospy.sleep(0.5)
        self.assertEqual(self.demo.way[-1], last, 'it stands when nobody drives')

        self.drive(0.0, TURN_RADPS, 2.5 * math.pi / TURN_RADPS)
        self.drive(SPEED_MPS, 0.0, 1.0)
        self.demo.wait_for_state(CalibrationEstimate.CONVERGING, 60.0)
        position_m, yaw_rad = self.demo.errors()
        self.assertLess(position_m, 0.02)
        self.assertLess(yaw_rad, math.radians(3.0))


if __name__ == '__main__':
    rostest.rosrun('bearing_calibration', 'demo_manual', DemoManualTest, sys.argv)
