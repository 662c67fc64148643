#!/usr/bin/env python3
"""demo.launch drive:=paper: the robot drives the paper's second trajectory until it has converged."""

import math
import sys
import unittest

import rospy
import rostest
from bearing_calibration.msg import CalibrationEstimate

from demo_world import Demo

NEAR_M = 0.03


class DemoPaperTest(unittest.TestCase):

    def test_the_dance_converges(self):
        rospy.init_node('demo_paper_test')
        demo = Demo()
        x, y, yaw = (rospy.get_param('simulation/start/' + name) for name in ('x', 'y', 'yaw'))
        demo.wait_for_state(CalibrationEstimate.CONVERGED, 300.0)
        position_m, yaw_rad = demo.errors()
        self.assertLess(position_m, 0.01)
        self.assertLess(yaw_rad, math.radians(1.0))

        # A metre, a turn and a quarter to the left, and a metre square to the first.
        corner = (x + math.cos(yaw), y + math.sin(yaw))
        distances = [math.hypot(each[0] - corner[0], each[1] - corner[1]) for each in demo.way]
        at_corner = next(i for i, distance in enumerate(distances) if distance < NEAR_M)
        left = next(i for i, distance in enumerate(distances) if i > at_corner and
                    distance > 0.3)
        turned = sum(math.remainder(b[2] - a[2], 2.0 * math.pi)
                     for a, b in zip(demo.way[at_corner:left], demo.way[at_corner + 1:left + 1]))
        self.assertAlmostEqual(turned, 2.5 * math.pi, delta=math.radians(5.0))
        along = (demo.way[left][0] - corner[0]) * math.cos(yaw) + (
            demo.way[left][1] - corner[1]) * math.sin(yaw)
        self.assertAlmostEqual(along, 0.0, delta=2.0 * NEAR_M)


if __name__ == '__main__':
    rostest.rosrun('bearing_calibration', 'demo_paper', DemoPaperTest, sys.argv)
