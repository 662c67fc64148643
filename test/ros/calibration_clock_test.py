#!/usr/bin/env python3
"""Clocks that have not begun, that jump back, and stamps that jump back while the clock does not."""

import sys
import unittest

import rospy
import rostest
from bearing_calibration.msg import CalibrationEstimate
from diagnostic_msgs.msg import DiagnosticArray
from rosgraph_msgs.msg import Clock

from calibration_world import Node, World, wait_until

START_S = 5000.0


class CalibrationClockTest(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        rospy.init_node('calibration_clock_test')  # its own clock stands until it publishes one
        cls.clock = rospy.Publisher('/clock', Clock, queue_size=100)
        cls.heard = set()  # the times that the node has told, in ns
        rospy.Subscriber('/diagnostics', DiagnosticArray,
                         lambda message: cls.heard.add(message.header.stamp.to_nsec()))
        cls.node = Node()
        wait_until(lambda: cls.clock.get_num_connections() >= 2, 'the node and this test listen')

    def set_clock(self, seconds):
        """Publishes the time until the node tells it."""
        now = rospy.Time.from_sec(seconds)
        self.heard.clear()

        def is_heard():
            self.clock.publish(Clock(now))
            return now.to_nsec() in self.heard
        wait_until(is_heard, 'the node hears the clock')

    def drive(self, start_s, seconds):
        world = World(start_s)
        self.node.drive(world, seconds)
        return world

    def jumps(self):
        return self.node.warnings('jumped back', 'starts anew')

    # One story, in this order.
    def test_clock(self):
        self.drive(START_S, 0.2)
        wait_until(lambda: self.node.warnings('/clock has not begun'), 'it says what it waits for')
        estimate = self.node.estimate()
        self.assertEqual(estimate.state, CalibrationEstimate.WAITING_FOR_TICKS)
        self.assertEqual(estimate.rejections, '', 'input before the clock is no bad input')

        self.set_clock(START_S + 10.0)
        self.drive(START_S, 5.0)
        self.node.wait_for(lambda e: e.bearings_used == 50, 'the clock runs, bearings are used')
        self.assertEqual(self.jumps(), [])

        self.set_clock(START_S + 1.0)  # the bag loops
        self.node.wait_for(lambda e: e.bearings_used == 0, 'reset by the clock alone')
        self.set_clock(START_S + 10.0)
        self.drive(START_S, 5.0)
        self.node.wait_for(lambda e: e.bearings_used == 50, 'the same bearings are used again')
        wait_until(self.jumps, 'a warning')
        self.assertEqual(len(self.jumps()), 1, 'one warning: %s' % self.jumps())
        self.assertIn('clock', self.jumps()[0])

        self.drive(START_S + 2.0, 5.0)  # the bag loops, and nobody plays a clock
        self.node.wait_for(lambda e: 0 < e.ticks_used < 250 and e.bearings_used > 40,
                           'a new start with the stamps that came after the jump')
        wait_until(lambda: len(self.jumps()) > 1, 'another warning')
        self.assertEqual(len(self.jumps()), 2, self.jumps())
        self.assertIn('/wheel_ticks', self.jumps()[1])


if __name__ == '__main__':
    rostest.rosrun('bearing_calibration', 'calibration_clock', CalibrationClockTest, sys.argv)
