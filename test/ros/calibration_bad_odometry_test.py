#!/usr/bin/env python3
"""Odometry that is none of wheels, or not well formed: refused with a reason that names it."""

import math
import sys

import rospy
import rostest

from bad_input import BadInput, later
from calibration_world import NAN, World, taken_in, wait_until


class CalibrationBadOdometryTest(BadInput):

    WHEELS = 'odom'
    READING = staticmethod(World.odometry)

    def publish(self, change=None, seconds=0.01):
        """The newest odometry once more, some time later, changed."""
        message = later(self.world.odometry(), seconds)
        if change:
            change(message)
        self.node.wheels.publish(message)

    # Promise refused: an odometry position that is not a number
    def test_position_nan(self):
        self.publish(lambda message: setattr(message.pose.pose.position, 'y', NAN))
        self.assert_refused("ticks odometry's pose not finite", '/odom', 'nan', 'left out')

    # Promise refused: an odometry orientation that is not a number
    def test_orientation_nan(self):
        self.publish(lambda message: setattr(message.pose.pose.orientation, 'w', NAN))
        self.assert_refused("ticks odometry's pose not finite", '/odom', 'nan', 'left out')

    # Promise refused: a quaternion of zeros
    def test_a_quaternion_that_nobody_filled_in(self):
        self.publish(lambda message: message.pose.pose.orientation.__init__())
        self.assert_refused("ticks odometry's quaternion not of length 1", '/odom',
                            'length 0 instead of 1')

    # Promise refused: a quaternion of length 2
    def test_a_quaternion_that_is_not_of_unit_length(self):
        def double(message):
            message.pose.pose.orientation.z *= 2.0
            message.pose.pose.orientation.w *= 2.0
        self.publish(double)
        self.assert_refused("ticks odometry's quaternion not of length 1", '/odom', 'length 2')

    # Promise refused: odometry without a stamp
    def test_stamp_zero(self):
        self.publish(lambda message: setattr(message.header, 'stamp', rospy.Time()))
        self.assert_refused('ticks stamp is zero', '/odom', 'stamp is zero', 'left out')

    # Promise refused: odometry with a stamp in the future
    def test_stamp_in_the_future(self):
        self.publish(seconds=1005.0)  # the world is 1000 s ago
        self.assert_refused('ticks stamp in the future', '/odom', 'after the time of receipt')

    # Promise refused: odometry older than the last
    def test_stamp_that_goes_back(self):
        self.publish(seconds=-0.5)
        self.assert_refused('ticks stamp not after the last', '/odom', '0.5', 'left out')

    # Promise refused: odometry that changes its frame
    def test_parent_frame_changed(self):
        self.publish(lambda message: setattr(message.header, 'frame_id', 'map'))
        self.assert_refused("ticks odometry's frames changed", '/odom', 'header.frame_id')

    # Promise refused: odometry that changes its child frame
    def test_child_frame_changed(self):
        self.publish(lambda message: setattr(message, 'child_frame_id', 'base_footprint'))
        self.assert_refused("ticks odometry's frames changed", '/odom', 'child_frame_id')
        wait_until(lambda: self.node.warnings('/odom', "'base_footprint' is not frames/base 'base_link'"),
                   'a warning that names both')

    def moveBy(self, forward_m, left_m):
        def move(message):
            orientation = message.pose.pose.orientation
            heading = 2.0 * math.atan2(orientation.z, orientation.w)
            position = message.pose.pose.position
            position.x += forward_m * math.cos(heading) - left_m * math.sin(heading)
            position.y += forward_m * math.sin(heading) + left_m * math.cos(heading)
        return move

    # Promise refused: odometry that jumps
    def test_a_jump_that_no_wheel_makes(self):
        self.publish(self.moveBy(0.5, 0.0))  # in 10 ms: 50 m/s, the wheels reach 2
        self.assert_refused('ticks wheel faster than possible', '/odom', '0.5 m', 'max_speed')

    # Promise refused: odometry that moves sideways
    def test_a_step_sideways(self):
        self.publish(self.moveBy(0.0, -0.02))
        self.assert_refused('ticks odometry moves sideways', '/odom', '-0.02', 'sideways')

    # Promise unharmed: odometry that begins anew at zero
    def test_a_reset_of_the_pose_is_followed(self):
        """As a reset of a counter: what moved meanwhile is unknown, and nothing else is lost."""
        world, taken = self.world, taken_in(self.before)
        world.advance()
        world.start = world.x, world.y, world.heading
        self.node.wheels.publish(world.odometry())
        estimate = self.node.wait_for(lambda e: 'counter reset' in e.rejections, 'it is noticed')
        self.assertEqual(estimate.rejections, 'ticks counter reset: 1')
        self.node.feed(world, 5.0, wheels=self.READING)
        estimate = self.node.estimate()
        self.assertEqual(taken_in(estimate), taken + 50)
        self.assertEqual(estimate.rejections, 'ticks counter reset: 1')

    # Promise refused: odometry whose pose stands while its twist moves
    def test_a_driver_that_fills_in_the_twist_only(self):
        pose = self.world.odometry().pose
        for _ in range(3 * World.TICK_RATE):
            self.world.advance()
            message = self.world.odometry()
            message.pose = pose
            message.twist.twist.linear.x = World.WHEEL_SPEED
            self.node.wheels.publish(message)
        reason = "ticks odometry's pose stands while its twist moves"
        # 0.2 m at 0.2 m/s are let pass, as they may be the twist's delay
        estimate = self.node.wait_for(lambda e: reason in e.rejections and e.ticks_rejected > 95,
                                      'two of three seconds are refused')
        self.assertEqual(estimate.distance_travelled_m, self.before.distance_travelled_m)
        wait_until(lambda: self.node.warnings('/odom', 'twist', 'only poses are used'), 'a warning')


if __name__ == '__main__':
    rostest.rosrun('bearing_calibration', 'calibration_bad_odometry', CalibrationBadOdometryTest,
                   sys.argv)
