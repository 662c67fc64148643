#!/usr/bin/env python3
"""An error inside of the drive node ends the drive: it is not left active with nobody to steer it."""

import sys
import unittest

import rospy
import rostest
from actionlib_msgs.msg import GoalStatus
from bearing_calibration.msg import CalibrationDriveGoal, CalibrationDriveResult
from std_msgs.msg import String

from calibration_world import wait_until
from drivable_robot import DrivableRobot


class CalibrationDriveFailedTest(unittest.TestCase):

    # Promise stands: an exception while it drives
    def test_an_exception_in_a_callback_ends_the_drive(self):
        """A message that is no count at all makes the callback of the left wheel throw."""
        rospy.init_node('calibration_drive_failed_test')
        robot = DrivableRobot()
        robot.forget()
        wheel = rospy.Publisher('left_ticks', String, queue_size=10)
        wait_until(wheel.get_num_connections, 'the drive node subscribes')
        robot.client.send_goal(CalibrationDriveGoal(motion='dance'))
        wait_until(lambda: (wheel.publish('text'), robot.client.get_result())[1], 'the drive ends')
        result = robot.client.get_result()
        self.assertEqual(result.end, CalibrationDriveResult.FAILED, result.end_text)
        self.assertIn('std_msgs/String is no wheel', result.end_text)
        self.assertIn('FAILED: an error inside the drive node, which its log names', result.end_text)
        self.assertNotEqual(result.x_stddev_m, 0.0, 'nothing is known so well')
        self.assertEqual(robot.client.get_state(), GoalStatus.ABORTED)
        self.assertEqual(robot.said_after_the_drive(), [], 'it is silent without a goal')


if __name__ == '__main__':
    rostest.rosrun('bearing_calibration', 'calibration_drive_failed', CalibrationDriveFailedTest,
                   sys.argv)
