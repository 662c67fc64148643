#!/usr/bin/env python3
"""Time and stamps that begin anew while the drive node lives: in a drive they end it, and the next one
drives."""

import os
import signal
import sys
import unittest

import rospy
import rostest
from bearing_calibration.msg import CalibrationDriveActionGoal
from rosgraph_msgs.msg import Log

from calibration_world import wait_until
from drivable_robot import DrivableRobot, pid_of

OLD_S = 15.0  # a time that a drive in the new one does not come to


class CalibrationDriveClockTest(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        rospy.init_node('calibration_drive_clock_test')
        cls.robot = DrivableRobot()
        cls.logs = []
        rospy.Subscriber('/rosout', Log, lambda log: cls.logs.append(log.msg))

    def setUp(self):
        self.robot.forget()
        del self.logs[:]

    def start(self):
        """By the service, which knows no stamps."""
        self.assertTrue(self.robot.start_service('dance', 0.0, 0.0).success)
        wait_until(self.robot.is_moving, 'the robot moves')

    def wait_for_log(self, words):
        wait_until(lambda: any(words in log for log in self.logs), 'it says: ' + words)

    def assertDrives(self):
        """For longer than timeouts/ticks."""
        self.start()
        began = rospy.get_time()
        wait_until(lambda: rospy.get_time() > began + 1.0, 'a second')
        self.assertTrue(self.robot.is_moving())
        self.robot.stop_service()
        wait_until(self.robot.is_standing, 'the last command is to stand')

    def restart_time(self):
        os.kill(pid_of('simulation'), signal.SIGKILL)
        wait_until(lambda: 0.0 < rospy.get_time() < OLD_S, 'time begins anew')

    # Promise stands: a clock that begins anew, between two drives and in one
    def test_after_time_has_begun_anew_it_drives(self):
        for in_a_drive in (False, True):
            with self.subTest(in_a_drive=in_a_drive):
                self.robot.forget()
                wait_until(lambda: rospy.get_time() > OLD_S, 'an old time')
                if in_a_drive:
                    self.start()
                self.restart_time()
                if in_a_drive:
                    self.wait_for_log('CLOCK_LOST')
                    wait_until(self.robot.is_standing, 'the last command is to stand')
                self.robot.forget()
                self.assertDrives()

    # Promise stands: a goal of an earlier stamp than the one before it
    def test_a_goal_of_an_earlier_stamp_is_driven(self):
        """It is the newest one all the same: of a computer whose clock is late, or of a time that has begun anew."""
        goals = rospy.Publisher('calibration_drive/drive/goal', CalibrationDriveActionGoal, queue_size=1)
        wait_until(goals.get_num_connections, 'the action server')
        for ahead_s in (1000.0, 0.0):
            with self.subTest(ahead_s=ahead_s):
                self.robot.forget()
                goal = CalibrationDriveActionGoal()
                goal.goal_id.id = 'ahead by %g s' % ahead_s
                goal.goal_id.stamp = rospy.Time.now() + rospy.Duration(ahead_s)
                goal.goal.motion = 'dance'
                goals.publish(goal)
                wait_until(self.robot.is_moving, 'the robot moves')
                self.robot.stop_service()
                wait_until(self.robot.is_standing, 'the last command is to stand')

    # Promise stands: stamps of wheel readings that begin anew
    def test_after_the_wheels_stamps_have_begun_anew_it_drives(self):
        self.robot.ticks_ahead_s = 600.0
        self.start()
        self.robot.ticks_ahead_s = 0.0
        self.wait_for_log('TICKS_LOST')
        self.wait_for_log("the wheels' stamps have begun anew")
        self.robot.forget()
        self.assertDrives()


if __name__ == '__main__':
    rostest.rosrun('bearing_calibration', 'calibration_drive_clock', CalibrationDriveClockTest, sys.argv)
