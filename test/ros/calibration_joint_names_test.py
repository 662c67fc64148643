#!/usr/bin/env python3
"""Joint states whose joints are not the wheels': said with the names that are there, counted, and
not mistaken for those of an arm that shares the topic."""

import sys
import time
import unittest

import rospy
import rostest
from sensor_msgs.msg import JointState

from calibration_world import Node, World, wait_until


class CalibrationJointNamesTest(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        rospy.init_node('calibration_joint_names_test')
        cls.node = Node(wheels='joint_states')

    def setUp(self):
        self.node.reset()
        self.world = World(rospy.Time.now().to_sec() - 1000.0)

    def publish(self, message):
        self.node.wheels.publish(message)

    # Promise refused: joint states without the wheels
    def test_wrong_names_are_said_with_those_that_are_there(self):
        self.world.advance()
        self.publish(self.world.joint_state('wheel_l', 'wheel_r'))
        estimate = self.node.wait_for(lambda e: e.ticks_rejected == 1, 'one refused joint state')
        self.assertEqual(estimate.ticks_used, 0)
        self.assertIn('joint states without the wheels: 1', estimate.rejections)
        wait_until(lambda: self.node.warnings('/joint_states', 'left_wheel_joint',
                                              '(arm, wheel_l, wheel_r)', 'ignored'), 'a warning')

    # Promise refused: joint states without positions
    def test_a_missing_position_or_wheel_is_refused(self):
        self.world.advance()
        without_positions = self.world.joint_state()
        without_positions.position = []
        self.publish(without_positions)
        self.world.advance()
        self.publish(self.world.joint_state(right_joint='caster'))
        self.world.advance()
        self.publish(self.world.joint_state())
        estimate = self.node.wait_for(lambda e: e.ticks_used == 1, 'the whole one')
        self.assertEqual(estimate.ticks_rejected, 2, estimate)

    # Promise refused: a joint position that is not a number
    def test_positions_that_are_not_finite_are_refused(self):
        self.world.advance()
        message = self.world.joint_state()
        message.position[2] = float('nan')
        self.publish(message)
        estimate = self.node.wait_for(lambda e: e.ticks_rejected == 1, 'NaN refused')
        self.assertIn('joint position not finite: 1', estimate.rejections)
        wait_until(lambda: self.node.warnings('/joint_states', 'nan', 'left out'), 'a warning')

    # Promise unharmed: joint states of an arm on the same topic
    def test_another_publisher_on_the_topic_is_no_fault(self):
        for _ in range(5):
            self.world.advance()
            self.publish(self.world.joint_state())
            arm = JointState(name=['arm'], position=[0.1])
            arm.header.stamp = self.world.stamp()
            self.publish(arm)
            time.sleep(0.01)
        estimate = self.node.wait_for(lambda e: e.ticks_used == 5, 'five wheel readings')
        self.assertEqual(estimate.ticks_rejected, 0, estimate)


if __name__ == '__main__':
    rostest.rosrun('bearing_calibration', 'calibration_joint_names', CalibrationJointNamesTest,
                   sys.argv)
