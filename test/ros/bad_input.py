"""What the tests of bad input share: an estimate before the input, and what must not change by it."""

import math
import unittest

import rospy
from diagnostic_msgs.msg import DiagnosticArray

from calibration_world import Node, World, taken_in, wait_until


def later(message, seconds):
    message.header.stamp += rospy.Duration.from_sec(seconds)
    return message


class BadInput(unittest.TestCase):
    """A node that has an estimate before each test; of a subclass its wheels."""

    WHEELS = READING = None  # topic, and a method of World

    @classmethod
    def setUpClass(cls):
        rospy.init_node('calibration_bad_input_test')
        cls.node = Node(wheels=cls.WHEELS)
        cls.statuses = []
        rospy.Subscriber('/diagnostics', DiagnosticArray,
                         lambda message: cls.statuses.extend(message.status))

    def setUp(self):
        self.node.reset()
        self.world = World(rospy.Time.now().to_sec() - 1000.0)
        self.node.feed(self.world, World.FOUND_S, wheels=self.READING)
        count = len(self.node.estimates)
        # once a second: by the second one nothing works on the last bearings any more
        wait_until(lambda: len(self.node.estimates) >= count + 2, 'two more estimates')
        self.before = self.node.wait_for(
            lambda e: e.ticks_used == self.world.step and not math.isnan(e.x_m), 'a start without faults')

    def assert_refused(self, reason, *said):
        """Refused, counted, said; and neither the estimate nor the other counts have changed."""
        estimate = self.node.wait_for(lambda e: reason + ': 1' in e.rejections, reason)
        self.assertEqual(estimate.rejections, reason + ': 1', 'and nothing else is counted')
        for field in ('x_m', 'y_m', 'yaw_rad', 'covariance_x_y_yaw', 'D_m', 'bearings_used',
                      'bearings_gated', 'ticks_used', 'distance_travelled_m'):
            self.assertEqual(getattr(estimate, field), getattr(self.before, field), field)
        wait_until(lambda: self.node.warnings(*said), 'a warning with %s, but there is only %s'
                   % (said, self.node.warnings('/')))
        wait_until(lambda: any(value.key == 'inputs refused' and reason in value.value
                               for status in self.statuses for value in status.values),
                   'the count in /diagnostics')
        self.assert_lives_on()

    def assert_lives_on(self):
        """Good input is taken as before."""
        taken = taken_in(self.node.estimate())
        self.node.drive(self.world, 1.0, wheels=self.READING)
        self.node.wait_for(lambda e: taken_in(e) == taken + 10, 'ten more bearings')
