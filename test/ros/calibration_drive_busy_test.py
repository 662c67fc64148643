#!/usr/bin/env python3
"""The drive node's commands go on at their rate while another nodelet of its manager, which has one
thread and one core, works on a fit."""

import math
import random
import sys
import threading
import time
import unittest

import rospy
import rostest
from bearing_calibration.msg import CalibrationDriveGoal
from geometry_msgs.msg import Twist

from calibration_world import Node, World, wait_until
from drivable_robot import DrivableRobot

CONTROL_PERIOD_S = 0.05  # 1 / drive/control_rate
MEASURED_S = 10.0
SCATTER = 8.0            # of the bearings, over what they state
LONG_S = 0.5             # ten commands: what a fit must take for this test to say anything


class Busy:
    """A calibration whose bearings no mount explains: its attempts at a start take long."""

    def __init__(self):
        self.node = Node('busy', 'busy/wheel_ticks', 'busy/bearings')
        self.random = random.Random(1)
        self.longest_wait_s = 0.0
        threading.Thread(target=self.feed, daemon=True).start()

    def feed(self):
        """Asks for an answer after each second of the record: it comes when all of that is done."""
        world = World(1.0)
        while not rospy.is_shutdown():
            for _ in range(World.TICK_RATE):
                world.advance()
                self.node.wheels.publish(world.ticks())
                if world.step % World.TICKS_PER_BEARING == 0:
                    azimuth = world.azimuth() + self.random.gauss(0.0, SCATTER * world.bearing_stddev)
                    self.node.bearings.publish(world.bearings(world.candidate(azimuth=azimuth)))
            began = time.monotonic()
            self.node.pause_service(False)
            self.longest_wait_s = max(self.longest_wait_s, time.monotonic() - began)


class CalibrationDriveBusyTest(unittest.TestCase):

    def test_commands_do_not_wait_for_a_fit(self):
        rospy.init_node('calibration_drive_busy_test')
        robot = DrivableRobot()
        robot.forget()
        busy = Busy()
        times = []
        rospy.Subscriber('cmd_vel', Twist, lambda _: times.append(time.monotonic()), tcp_nodelay=True)
        wait_until(lambda: busy.longest_wait_s > LONG_S, 'the other nodelet works')
        robot.client.send_goal(CalibrationDriveGoal(motion='optimal'))
        wait_until(lambda: times and times[-1] - times[0] > MEASURED_S, 'a drive of some seconds')
        robot.client.cancel_goal()
        gaps = sorted(b - a for a, b in zip(times, times[1:]))
        print('longest fit %.2f s; gaps between commands: median %.3f s, 99 %% %.3f s, longest %.3f s' % (
            busy.longest_wait_s, gaps[len(gaps) // 2], gaps[len(gaps) * 99 // 100], gaps[-1]))
        self.assertLess(gaps[len(gaps) // 2], 2.0 * CONTROL_PERIOD_S)
        self.assertLess(gaps[-1], LONG_S)


if __name__ == '__main__':
    rostest.rosrun('bearing_calibration', 'calibration_drive_busy', CalibrationDriveBusyTest, sys.argv)
