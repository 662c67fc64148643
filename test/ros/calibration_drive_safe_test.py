#!/usr/bin/env python3
"""The drive nodelet never moves against anybody's will: a goal that comes while another one drives or
brakes can be stopped in every way, a safety input that falls silent stops the robot, and no number of
a goal is without bounds."""

import itertools
import signal
import subprocess
import sys
import time
import unittest

import rospy
import rostest
from actionlib_msgs.msg import GoalStatus
from bearing_calibration.msg import CalibrationDriveGoal, CalibrationDriveResult

from calibration_world import wait_until
from drivable_robot import MOST_STOPPING_S, REPEAT_HZ, DrivableRobot, is_zero, wait_until_active

LIMIT_S = 1.0  # timeouts/enable and timeouts/obstacle of drive_overrides.yaml
GOAL = CalibrationDriveGoal(motion='optimal')


def start_drive(motion):
    return subprocess.Popen(['rosrun', 'bearing_calibration', 'start_drive', motion],
                            stdout=subprocess.PIPE)


class CalibrationDriveSafeTest(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        rospy.init_node('calibration_drive_safe_test')
        cls.robot = DrivableRobot()
        cls.robot.obstacle.say(False)  # only enable has not spoken
        rospy.sleep(0.3)
        cls.before_enable = cls.robot.start_service('dance', 0.0, 0.0)

    def setUp(self):
        self.robot.forget()

    def assertStaysStanding(self):
        """It stands, and nobody moves it any more."""
        self.assertEqual(self.robot.said_after_the_drive(), [], 'it is silent without a goal')

    def assertEnds(self, client, end):
        self.assertTrue(client.wait_for_result(rospy.Duration(10.0)), 'the goal ends')
        self.assertEqual(client.get_result().end, end, client.get_result().end_text)

    # A goal B while goal A drives or brakes: whatever happens to it, it happens to the robot.

    def driveA(self):
        self.robot.drive()

    def brakeA(self):
        self.robot.drive()
        self.robot.client.cancel_goal()

    def stopA(self):
        self.robot.drive()
        self.robot.stop_service()

    # Promise stands: a second goal, waiting when the first is stopped
    def test_goal_b_is_dropped_by_everything_that_stops(self):
        result = CalibrationDriveResult
        stops = {
            'cancel': (lambda b: b.cancel_goal(), result.CANCELLED),
            'cancel twice': (lambda b: (b.cancel_goal(), b.cancel_goal()), result.CANCELLED),
            'stop': (lambda b: self.robot.stop_service(), result.CANCELLED),
            'obstacle': (lambda b: self.robot.obstacle.say(True), result.OBSTACLE),
            'enable false': (lambda b: self.robot.enable.say(False), result.DISABLED)}
        for state, stop in itertools.product((self.driveA, self.brakeA, self.stopA), stops):
            with self.subTest(a=state.__name__, b=stop):
                self.robot.forget()
                state()
                b = self.robot.new_client()
                b.send_goal(GOAL)
                wait_until_active(b)
                self.assertEnds(self.robot.client, result.CANCELLED)
                act, end = stops[stop]
                act(b)
                self.assertEnds(b, end)
                self.assertStaysStanding()

    # Promise stands: a goal that comes after a stop but was sent before
    def test_goal_b_is_refused_when_the_stop_was_first(self):
        says_no = {'obstacle': lambda: self.robot.obstacle.say(True),
                   'enable false': lambda: self.robot.enable.say(False)}
        for state, stop in itertools.product((self.driveA, self.brakeA, self.stopA), says_no):
            with self.subTest(a=state.__name__, b=stop):
                self.robot.forget()
                state()
                says_no[stop]()
                wait_until(self.robot.is_standing, 'the stop has come')
                b = self.robot.new_client()
                b.send_goal(GOAL)
                self.assertTrue(b.wait_for_result(rospy.Duration(10.0)))
                self.assertEqual(b.get_state(), GoalStatus.ABORTED)
                self.assertStaysStanding()

    def test_goal_b_after_a_stop_drives(self):
        """Who asks after the stop means it."""
        for state in (self.driveA, self.brakeA, self.stopA):
            with self.subTest(a=state.__name__):
                self.robot.forget()
                state()
                b = self.robot.new_client()
                b.send_goal(GOAL)
                self.assertEnds(self.robot.client, CalibrationDriveResult.CANCELLED)
                wait_until(lambda: any(is_zero(twist) for _, twist in self.robot.said()[5:]),
                           'it brakes first')
                wait_until(self.robot.is_moving, 'B drives')
                wait_until_active(b)
                b.cancel_goal()
                self.assertEnds(b, CalibrationDriveResult.CANCELLED)
                self.assertStaysStanding()

    # Promise stands: a new goal with impossible numbers
    def test_a_goal_that_is_refused_stops_the_one_before_it(self):
        self.robot.drive()
        b = self.robot.new_client()
        b.send_goal(CalibrationDriveGoal(motion='waltz'))
        self.assertTrue(b.wait_for_result(rospy.Duration(10.0)))
        refused = b.get_result()
        self.assertIn('waltz', b.get_goal_status_text())
        self.assertEqual((refused.end, refused.end_text), (0, b.get_goal_status_text()))
        self.assertNotEqual(refused.x_stddev_m, 0.0, 'nothing is known so well')
        self.assertEnds(self.robot.client, CalibrationDriveResult.CANCELLED)
        self.assertStaysStanding()

    # Promise stands: a terminal that is closed, or a connection that breaks, in which start_drive runs
    def test_it_stops_when_nobody_can_watch_start_drive(self):
        closings = {'terminal': lambda program: program.send_signal(signal.SIGHUP),
                    'connection': lambda program: program.stdout.close()}
        for name, close in closings.items():
            with self.subTest(name):
                self.robot.forget()
                with start_drive('dance') as program:
                    wait_until(self.robot.is_moving, 'the robot moves')
                    close(program)
                    self.assertEqual(program.wait(10.0), 1)
                self.assertStaysStanding()

    def test_a_second_start_drive_replaces_the_first(self):
        with start_drive('dance') as first, start_drive('optimal') as second:
            ended = wait_until(lambda: next((a for a in (first, second) if a.poll() is not None), None),
                               'one has replaced the other')
            other = second if ended is first else first
            wait_until(self.robot.is_moving, 'the robot moves')
            time.sleep(1.0)
            self.assertTrue(self.robot.is_moving())
            self.assertIsNone(other.poll())
            other.send_signal(signal.SIGINT)
            self.assertEqual((first.wait(10.0), second.wait(10.0)), (1, 1))
        self.assertStaysStanding()

    # Silence.

    # Promise stands: a required enable that never came
    def test_a_required_enable_must_come_before_it_moves(self):
        self.assertFalse(self.before_enable.success)
        self.assertIn('~enable is silent', self.before_enable.message)

    def assertSilenceStops(self, silence, end):
        self.robot.drive()
        since = rospy.get_time()
        silence()
        self.assertEnds(self.robot.client, end)
        last_motion = max(when for when, twist in self.robot.said() if not is_zero(twist))
        self.assertLess(last_motion - since, 1.0 / REPEAT_HZ + LIMIT_S + MOST_STOPPING_S)
        self.assertStaysStanding()
        refused = self.robot.start_service('dance', 0.0, 0.0)
        self.assertFalse(refused.success)
        self.assertIn('is silent', refused.message)

    # Promise stands: an enable that falls silent
    def test_it_stops_when_enable_falls_silent(self):
        self.assertSilenceStops(self.robot.enable.fall_silent, CalibrationDriveResult.ENABLE_LOST)

    # Promise stands: an obstacle sensor that falls silent
    def test_it_stops_when_obstacle_falls_silent(self):
        self.assertSilenceStops(self.robot.obstacle.fall_silent,
                                CalibrationDriveResult.OBSTACLE_LOST)

    def test_the_documents_button_is_a_dead_mans(self):
        """driving.md's rostopic pub, killed."""
        self.robot.enable.fall_silent()
        button = subprocess.Popen(['rostopic', 'pub', '-r', '10', rospy.resolve_name(
            'calibration_drive/enable'), 'std_msgs/Bool', 'data: true'], stdout=subprocess.DEVNULL)
        self.addCleanup(button.wait)
        self.addCleanup(button.kill)
        wait_until(lambda: self.robot.start_service('dance', 0.0, 0.0).success, 'enabled again')
        wait_until(self.robot.is_moving, 'the robot moves')
        button.kill()
        wait_until(lambda: '~enable is silent' in self.robot.start_service(
            'dance', 0.0, 0.0).message, 'the drive has ended')
        self.assertStaysStanding()

    # Promise stands: numbers of a goal out of their bounds
    def test_every_number_of_a_goal_has_bounds(self):
        nan = float('nan')
        for time_s, path_m in ((1e300, 0.0), (0.0, 1e300), (float('inf'), 0.0), (nan, 0.0),
                               (-1.0, 0.0), (0.0, -1.0), (0.0, nan), (86401.0, 0.0)):
            with self.subTest(time_s=time_s, path_m=path_m):
                answer = self.robot.start_service('dance', time_s, path_m)
                self.assertFalse(answer.success, answer.message)
                self.assertIn('max_path_m' if time_s == 0.0 else 'max_time_s', answer.message)
        self.assertEqual(self.robot.said(), [])


if __name__ == '__main__':
    rostest.rosrun('bearing_calibration', 'calibration_drive_safe', CalibrationDriveSafeTest,
                   sys.argv)
