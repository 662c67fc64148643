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
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Twist

from calibration_world import Node, World, wait_until
from drivable_robot import DrivableRobot

CONTROL_PERIOD_S = 0.05  # 1 / drive/control_rate
MEASURED_S = 10.0
LONG_S = 0.5             # ten commands: what a fit must take for this test to say anything
FITS = 3                 # of which the mean is taken
SECOND_S = 0.05          # in which the other nodelet is shown a second of its record


class Busy:
    """A calibration whose bearings point anywhere, so that no mount and no level of noise explains
    them: its attempts at a start take long, one after the other."""

    def __init__(self):
        self.node = Node('busy', 'busy/wheel_ticks', 'busy/bearings')
        self.random = random.Random(1)
        self.fits = []  # when how many of them had ended
        rospy.Subscriber('/diagnostics', DiagnosticArray, self.diagnosed)
        threading.Thread(target=self.feed, daemon=True).start()

    def diagnosed(self, message):
        for status in message.status:
            if 'busy' in status.name:
                self.fits += [(time.monotonic(), int(each.value)) for each in status.values
                              if each.key == 'fits taken over']

    def fit_s(self):
        """How long a fit takes on average, of the last ones."""
        for now, count in self.fits[:-1]:
            if self.fits[-1][1] >= count + FITS:
                last, last_count = self.fits[-1]
                return (last - now) / (last_count - count)
        return 0.0

    def feed(self):
        world = World(1.0)
        while not rospy.is_shutdown():
            for _ in range(World.TICK_RATE):
                world.advance()
                self.node.wheels.publish(world.ticks())
                if world.step % World.TICKS_PER_BEARING == 0:
                    azimuth = self.random.uniform(-math.pi, math.pi)
                    self.node.bearings.publish(world.bearings(world.candidate(azimuth=azimuth)))
            time.sleep(SECOND_S)


class CalibrationDriveBusyTest(unittest.TestCase):

    # Promise unharmed: a long fit while it drives
    def test_commands_do_not_wait_for_a_fit(self):
        rospy.init_node('calibration_drive_busy_test')
        robot = DrivableRobot()
        robot.forget()
        busy = Busy()
        times = []
        rospy.Subscriber('cmd_vel', Twist, lambda _: times.append(time.monotonic()), tcp_nodelay=True)
        wait_until(lambda: busy.fit_s() > LONG_S, 'the other nodelet works')
        robot.client.send_goal(CalibrationDriveGoal(motion='optimal'))
        wait_until(lambda: times and times[-1] - times[0] > MEASURED_S, 'a drive of some seconds')
        robot.client.cancel_goal()
        gaps = sorted(b - a for a, b in zip(times, times[1:]))
        print('a fit takes %.2f s; gaps between commands: median %.3f s, 99 %% %.3f s, longest %.3f s' % (
            busy.fit_s(), gaps[len(gaps) // 2], gaps[len(gaps) * 99 // 100], gaps[-1]))
        self.assertLess(gaps[len(gaps) // 2], 2.0 * CONTROL_PERIOD_S)
        self.assertLess(gaps[-1], LONG_S)


if __name__ == '__main__':
    rostest.rosrun('bearing_calibration', 'calibration_drive_busy', CalibrationDriveBusyTest, sys.argv)
