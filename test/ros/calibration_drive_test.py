#!/usr/bin/env python3
"""The drive nodelet: it moves only when asked to, within its limits, and stops for every reason."""

import math
import sys
import time
import unittest

import rospy
import rostest
from actionlib_msgs.msg import GoalStatus
from bearing_calibration.msg import CalibrationDriveGoal, CalibrationDriveResult
from nav_msgs.msg import Path
from nodelet.srv import NodeletUnload

from calibration_world import wait_until
from drivable_robot import MOST_STOPPING_S, MOVING, SPEED, DrivableRobot, is_zero, wheels_of


class CalibrationDriveTest(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        rospy.init_node('calibration_drive_test')
        cls.robot = DrivableRobot()
        cls.robot.forget()

    def setUp(self):
        self.robot.forget()

    def assertEnds(self, end, since, within_s, status=GoalStatus.ABORTED):
        """The goal ends so, and the last command is to stand, this long after `since` at most."""
        self.assertTrue(self.robot.client.wait_for_result(rospy.Duration(within_s + 5.0)))
        result = self.robot.client.get_result()
        self.assertEqual(result.end, end, result.end_text)
        self.assertEqual(self.robot.client.get_state(), status)
        self.assertStands(since, within_s)

    def assertStands(self, since, within_s):
        self.assertEqual(self.robot.said_after_the_drive(), [], 'it is silent without a goal')
        last_motion = max(when for when, twist in self.robot.said() if not is_zero(twist))
        self.assertLess(last_motion - since, within_s)

    # Promise stands: nobody has asked for a drive
    def test_it_does_not_move_by_itself(self):
        time.sleep(1.0)
        self.assertEqual(self.robot.said(), [])

    # Promise stands: a goal that is cancelled
    def test_cancel_stops_it_and_the_limits_are_obeyed(self):
        sent = time.monotonic()
        self.robot.drive()
        since, cancelled = rospy.get_time(), time.monotonic()
        self.robot.client.cancel_goal()
        self.assertEnds(CalibrationDriveResult.CANCELLED, since, MOST_STOPPING_S,
                        GoalStatus.PREEMPTED)
        commands = [wheels_of(twist) for _, twist in self.robot.said()]
        self.assertLessEqual(max(abs(wheel) for both in commands for wheel in both), SPEED + 1e-9)
        # From standing to its speed, and back, takes 0.2 s, of which one control may be over at once.
        # A busy machine makes it more.
        least_s = 0.1
        moving = next(when for when, both in zip(self.robot.arrivals, commands)
                      if max(both) > MOVING * SPEED)
        self.assertGreater(moving - sent, least_s)
        self.assertGreater(self.robot.arrivals[-1] - cancelled, least_s, 'it brakes')

    def test_it_stops_when_converged(self):
        self.robot.drive()
        since = rospy.get_time()
        self.robot.claims_convergence = True
        estimate_period_s = 1.0
        self.assertEnds(CalibrationDriveResult.CONVERGED, since, estimate_period_s + MOST_STOPPING_S,
                        GoalStatus.SUCCEEDED)

    def test_the_services_start_and_stop_it(self):
        self.assertTrue(self.robot.start_service('dance', 0.0, 0.0).success)
        wait_until(self.robot.is_moving, 'the robot moves')
        again = self.robot.start_service('dance', 0.0, 0.0)
        self.assertFalse(again.success)
        self.assertIn('under way', again.message)
        since = rospy.get_time()
        self.assertTrue(self.robot.stop_service().success)
        self.assertStands(since, MOST_STOPPING_S)
        unknown = self.robot.start_service('waltz', 0.0, 0.0)
        self.assertFalse(unknown.success)
        self.assertIn("motion must be optimal, dance or corner_light, but is 'waltz'",
                      unknown.message)

    def test_a_new_goal_replaces_the_old_one(self):
        self.robot.drive()
        old = self.robot.client
        self.robot.client.send_goal(CalibrationDriveGoal(motion='dance', max_time_s=1.0))
        self.assertTrue(old.wait_for_result(rospy.Duration(10.0)))
        self.assertEqual(old.get_result().end, CalibrationDriveResult.TIME_OVER)

    # Promise stands: an enable that is taken away
    def test_enable_false_stops_and_forbids_it(self):
        self.robot.drive()
        since = rospy.get_time()
        self.robot.enable.say(False)
        self.assertEnds(CalibrationDriveResult.DISABLED, since, MOST_STOPPING_S)
        refused = self.robot.start_service('dance', 0.0, 0.0)
        self.assertFalse(refused.success)
        self.assertIn('~enable', refused.message)

    # Promise stands: an obstacle
    def test_an_obstacle_stops_it(self):
        self.robot.drive()
        since = rospy.get_time()
        self.robot.obstacle.say(True)
        self.assertEnds(CalibrationDriveResult.OBSTACLE, since, MOST_STOPPING_S)
        self.assertFalse(self.robot.start_service('dance', 0.0, 0.0).success)

    def assertStopsWithout(self, name, end, timeout_s):
        self.robot.drive()
        since = rospy.get_time()
        self.robot.cut.add(name)
        self.assertEnds(end, since, timeout_s + MOST_STOPPING_S)

    # Promise stands: wheel readings that stop coming
    def test_without_ticks_it_stops(self):
        self.assertStopsWithout('ticks', CalibrationDriveResult.TICKS_LOST, 0.5)

    # Promise stands: a light that is lost
    def test_without_the_light_it_stops(self):
        self.assertStopsWithout('light', CalibrationDriveResult.LIGHT_LOST, 1.0)

    def test_a_limited_field_of_view_is_known_from_the_bearings(self):
        """timeouts/bearings is 1 s: while nothing is known the light may be out of view in all of the first
        turn. With all of its other turns the drive converges."""
        self.robot.view_width = math.radians(60.0)
        self.robot.client.send_goal(CalibrationDriveGoal(motion='optimal'))
        self.assertTrue(self.robot.client.wait_for_result(rospy.Duration(150.0)))
        result = self.robot.client.get_result()
        self.assertEqual(result.end, CalibrationDriveResult.CONVERGED, result.end_text)

    # Promise stands: estimates that stop coming
    def test_without_estimates_it_stops(self):
        self.assertStopsWithout('estimate', CalibrationDriveResult.ESTIMATE_LOST, 1.5)

    # Promise stands: a robot that is pushed out of its region
    def test_the_regions_edge_stops_it(self):
        """Somebody pushes the robot over the border while it turns on the spot."""
        self.robot.drive('optimal')
        since = rospy.get_time()
        self.robot.push_mps = 1.2  # a circle of 1.5 m across: beyond the border, possible for the wheels
        self.assertEnds(CalibrationDriveResult.LEFT_REGION, since, 4.0)

    def test_it_plans_on_what_the_calibration_has_found(self):
        ways, feedback = [], []
        subscriber = rospy.Subscriber('calibration_drive/plan', Path, ways.append)
        self.robot.client.send_goal(CalibrationDriveGoal(motion='optimal'),
                                    feedback_cb=feedback.append)
        wait_until(lambda: any(f.expected_x_stddev_m < f.x_stddev_m for f in feedback),
                   'a plan that promises to know more', 60.0)
        wait_until(lambda: any(len(way.poses) > 1 for way in ways), 'a way ahead')
        self.robot.client.cancel_goal()
        self.assertTrue(self.robot.client.wait_for_result(rospy.Duration(5.0)))
        subscriber.unregister()

    # Promise stands: a nodelet that is unloaded while it drives
    def test_zz_unloaded_its_last_word_is_to_stand(self):
        """Runs last: the nodelet is gone afterwards."""
        self.robot.drive()
        unload = rospy.ServiceProxy('manager/unload_nodelet', NodeletUnload)
        self.assertTrue(unload(rospy.resolve_name('calibration_drive')).success)
        wait_until(self.robot.is_standing, 'the last command is to stand')
        result = wait_until(self.robot.client.get_result, 'its result')
        self.assertEqual(result.end, CalibrationDriveResult.SHUT_DOWN, result)


if __name__ == '__main__':
    rostest.rosrun('bearing_calibration', 'calibration_drive_stops', CalibrationDriveTest, sys.argv)
