#!/usr/bin/env python3
"""The counters of the wheels on a topic each: paired by time, and a missing partner is said."""

import sys
import time
import unittest

import rospy
import rostest

from calibration_world import (PIECE_S, Node, World, duckietownCount, errors_in_stddevs, taken_in,
                               wait_until)

TOPICS = 'left_wheel/tick', 'right_wheel/tick'


class CalibrationSeparateTicksTest(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        rospy.init_node('calibration_separate_ticks_test')
        cls.kind = duckietownCount()
        cls.right = rospy.Publisher(TOPICS[1], cls.kind, queue_size=10000)
        cls.node = Node(wheels=TOPICS[0], wheels_type=cls.kind)
        wait_until(cls.right.get_num_connections, 'the node subscribes to the right wheel, too')

    def setUp(self):
        self.node.reset()
        self.world = World(rospy.Time.now().to_sec() - 1000.0)

    def publish(self, sides='left right'):
        ticks = self.world.ticks()
        for side, publisher in (('left', self.node.wheels), ('right', self.right)):
            if side in sides:
                message = self.kind(data=getattr(ticks, side))
                message.header.stamp = ticks.header.stamp
                publisher.publish(message)

    def test_finds_the_mount_with_wheels_that_are_read_in_turns(self):
        for step in range(60 * World.TICK_RATE):
            self.world.advance()
            self.publish('right' if step % 2 else 'left')
            if step % World.TICKS_PER_BEARING == 0:
                self.node.bearings.publish(self.world.bearings())
                time.sleep(0.01)
            if (step + 1) % round(PIECE_S * World.TICK_RATE) == 0:
                sent = (step + 1) // World.TICKS_PER_BEARING
                estimate = self.node.wait_for(
                    lambda e: taken_in(e) >= sent - 5,
                    '%d bearings but those before the first readings are in' % sent)
        self.assertEqual(estimate.ticks_rejected, 0, estimate)
        for error in errors_in_stddevs(estimate, self.world):
            self.assertLess(error, 3.0, estimate)
        self.assertLess(estimate.x_stddev_m, 0.02)

    # Promise refused: counts of one wheel only
    def test_a_wheel_without_a_partner_is_said(self):
        driven_s, silent_s = 7, 5
        for _ in range(driven_s * World.TICK_RATE):
            self.world.advance()
            self.publish('left')
        refused = (driven_s - silent_s) * World.TICK_RATE - 1  # all of them: none is left for the next test
        estimate = self.node.wait_for(lambda e: e.ticks_rejected >= refused, 'readings are refused')
        self.assertIn('no reading of the other wheel', estimate.rejections)
        self.assertEqual(estimate.ticks_used, 0)
        wait_until(lambda: self.node.warnings('/left_wheel/tick with /right_wheel/tick',
                                              'the other wheel has no reading'), 'a warning')


if __name__ == '__main__':
    rostest.rosrun('bearing_calibration', 'calibration_separate_ticks',
                   CalibrationSeparateTicksTest, sys.argv)
