#!/usr/bin/env python3
"""The end of the drive node while its robot brakes for two seconds."""

import os
import signal
import sys
import time
import unittest

import rospy
import rostest
from bearing_calibration.msg import CalibrationDriveResult

from calibration_world import wait_until
from drivable_robot import SILENCE_S, SPEED, DrivableRobot, is_running, pid_of, wheels_of


class CalibrationDriveBrakesTest(unittest.TestCase):

    # Promise stands: an end of the process while it brakes for two seconds
    def test_its_last_word_is_to_stand(self):
        rospy.init_node('calibration_drive_brakes_test')
        robot = DrivableRobot()
        robot.forget()
        robot.drive()
        pid = pid_of('calibration_drive')
        count = len(robot.said()) - 1
        os.kill(pid, signal.SIGINT)
        wait_until(lambda: not is_running(pid), 'the process ends')
        wait_until(robot.is_standing, 'its last word is to stand')
        time.sleep(SILENCE_S)  # what it has sent after that may be on its way
        said = [max(wheels_of(twist)) for _, twist in robot.said()[count:]]
        self.assertEqual(said[-1], 0.0, said)
        moving = said[:said.index(0.0)]
        self.assertEqual(set(said[len(moving):]), {0.0}, 'once it stands it does not move again')
        result = wait_until(robot.client.get_result, 'its result')
        self.assertEqual(result.end, CalibrationDriveResult.SHUT_DOWN, result)
        self.assertLess(moving[-1], 0.25 * SPEED, 'it brakes to the end')


if __name__ == '__main__':
    rostest.rosrun('bearing_calibration', 'calibration_drive_brakes', CalibrationDriveBrakesTest,
                   sys.argv)
