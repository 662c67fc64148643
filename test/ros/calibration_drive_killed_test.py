#!/usr/bin/env python3
"""When the drive node is killed, the robot's own watchdog stops the wheels: assumed of every robot,
and the simulated one has it."""

import os
import signal
import sys
import time
import unittest
import xmlrpc.client

import rosgraph
import rospy
import rostest

from drivable_robot import DrivableRobot

WATCHDOG_S = 0.5  # trajectory/command_timeout of the simulation


class CalibrationDriveKilledTest(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        rospy.init_node('calibration_drive_killed_test')
        cls.robot = DrivableRobot()
        cls.robot.forget()

    def test_the_robot_stands(self):
        self.robot.drive()
        node = rosgraph.Master('/test').lookupNode('/manager')
        _, _, pid = xmlrpc.client.ServerProxy(node).getPid('/test')
        os.kill(pid, signal.SIGKILL)
        time.sleep(WATCHDOG_S + 0.5)
        before = self.robot.place()
        time.sleep(0.5)
        for now, then in zip(self.robot.place(), before):
            self.assertAlmostEqual(now, then, delta=1e-6)


if __name__ == '__main__':
    rostest.rosrun('bearing_calibration', 'calibration_drive_killed', CalibrationDriveKilledTest,
                   sys.argv)
