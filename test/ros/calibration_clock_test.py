#!/usr/bin/env python3
"""Clocks that have not begun, that step or jump back, and stamps that do so while the clock does not."""

import math
import os
import shutil
import sys
import unittest

import rospy
import rostest
import yaml
from bearing_calibration.msg import CalibrationEstimate
from diagnostic_msgs.msg import DiagnosticArray
from rosgraph_msgs.msg import Clock
from tf2_msgs.msg import TFMessage

from calibration_world import Node, World, wait_until

START_S = 5000.0
BEARING_STDDEV = math.radians(0.1)  # converges soon


class CalibrationClockTest(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        rospy.init_node('calibration_clock_test')  # its own clock stands until it publishes one
        cls.clock = rospy.Publisher('/clock', Clock, queue_size=100)
        cls.heard = set()  # the times that the node has told, in ns
        rospy.Subscriber('/diagnostics', DiagnosticArray,
                         lambda message: cls.heard.add(message.header.stamp.to_nsec()))
        cls.node = Node()
        cls.transforms = []
        rospy.Subscriber('/tf', TFMessage, lambda m: cls.transforms.extend(m.transforms))
        wait_until(lambda: cls.clock.get_num_connections() >= 2, 'the node and this test listen')
        cls.folder = rospy.get_param('calibration/output/folder')

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.folder, ignore_errors=True)

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
        world = self.drive(START_S, 0.2)
        wait_until(lambda: self.node.warnings('/clock has not begun'), 'it says what it waits for')
        estimate = self.node.estimate()
        self.assertEqual(self.transforms, [])
        self.assertEqual(estimate.state, CalibrationEstimate.WAITING_FOR_TICKS)
        self.assertEqual(estimate.rejections, '', 'input before the clock is no bad input')

        self.set_clock(START_S + 10.0)
        self.node.drive(world, 4.8)
        self.node.wait_for(lambda e: e.bearings_used == 50 and e.ticks_used == 250,
                           'the clock runs: all inputs are used, those before it too')
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

    def converge(self, world):
        for _ in range(20):
            self.node.drive(world, 10.0)
            if self.node.estimate().state == CalibrationEstimate.CONVERGED:
                break
        return self.node.wait_for(lambda e: e.state == CalibrationEstimate.CONVERGED and
                                  e.ticks_used == world.step, 'CONVERGED')

    def assert_lived_through(self, world, before, overlapping_s):
        """What overlaps is refused and counted, and nothing else is; the estimate goes on."""
        overlapping = math.floor(overlapping_s * World.TICK_RATE)
        self.node.drive(world, 10.0)
        after = self.node.wait_for(
            lambda e: e.ticks_used + e.ticks_rejected == before.ticks_used +
            before.ticks_rejected + 10 * World.TICK_RATE, 'every reading is used or refused')
        self.assertEqual(self.jumps(), [])
        self.assertEqual(after.ticks_rejected - before.ticks_rejected, overlapping)
        self.assertEqual(after.state, CalibrationEstimate.CONVERGED, after.advice)
        self.assertGreaterEqual(after.bearings_used + after.bearings_gated,
                                before.bearings_used + before.bearings_gated +
                                round(10 * (10.0 - overlapping_s)) - 2)
        self.assertLessEqual(after.bearings_gated - before.bearings_gated, 2, 'no motion is lost')
        return after

    def wait_a_second(self):
        """~estimate comes once a second, whatever the clock says."""
        count = len(self.node.estimates)
        wait_until(lambda: len(self.node.estimates) >= count + 2, 'a second')

    def assert_transform_at(self, seconds):
        """One that is stamped so, and none after it while the clock stands still."""
        wait_until(lambda: self.transforms and
                   self.transforms[-1].header.stamp == rospy.Time.from_sec(seconds), 'TF')
        count = len(self.transforms)
        self.wait_a_second()
        self.assertEqual(len(self.transforms), count, 'silent while the clock stands still')

    # After test_clock, too.
    # Promise refused: bearings after a clock that jumped back during a pause
    def test_jump_back_during_a_pause(self):
        self.set_clock(START_S + 500.0)
        self.node.reset()
        self.drive(START_S, 2.0)
        self.assertTrue(self.node.pause_service(True).success)
        self.node.wait_for(lambda e: e.state == CalibrationEstimate.PAUSED, 'paused')
        self.set_clock(START_S + 400.0)
        wait_until(self.jumps, 'the jump is said')
        self.node.wait_for(lambda e: e.ticks_used == 0, 'from the beginning')
        world = self.drive(START_S, 2.0)
        paused = self.node.wait_for(lambda e: e.ticks_used == world.step, 'the wheels are followed')
        self.assertEqual(paused.state, CalibrationEstimate.PAUSED)
        self.assertEqual(paused.bearings_used, 0)
        self.assertTrue(self.node.pause_service(False).success)
        self.node.drive(world, 2.0)
        self.node.wait_for(lambda e: e.bearings_used > 0, 'bearings are fused again')

    # After test_clock, which begins without a clock.
    def test_tf_goes_by_the_clock(self):
        now_s = START_S + 20.0
        self.set_clock(now_s)
        self.node.reset()
        del self.transforms[:]
        self.drive(START_S, World.FOUND_S)
        self.node.wait_for(lambda e: not math.isnan(e.x_m), 'an estimate')
        self.set_clock(now_s + 0.5)
        self.assert_transform_at(now_s + 0.5)
        self.set_clock(now_s + 1.0)
        self.assert_transform_at(now_s + 1.0)
        count = len(self.transforms)
        self.set_clock(now_s + 0.25)
        self.wait_a_second()
        self.assertEqual(len(self.transforms), count, 'a stamp is never sent twice, nor an earlier')
        self.set_clock(now_s + 1.25)
        self.assert_transform_at(now_s + 1.25)
        self.set_clock(START_S + 16.0)  # a jump: the stamps begin anew with the calibration
        self.node.wait_for(lambda e: e.bearings_used == 0, 'reset')
        self.wait_a_second()
        self.assertEqual(self.transforms[-1].header.stamp, rospy.Time.from_sec(now_s + 1.25))
        self.drive(START_S, World.FOUND_S)
        self.node.wait_for(lambda e: not math.isnan(e.x_m), 'an estimate')
        self.set_clock(START_S + 16.5)
        self.assert_transform_at(START_S + 16.5)

    # After test_clock, too.
    # Promise unharmed: clocks and stamps that step back by less than a second
    def test_small_steps(self):
        self.set_clock(START_S + 1000.0)
        self.node.reset()
        world = World(START_S, bearing_stddev=BEARING_STDDEV)
        estimate = self.converge(world)
        self.assertEqual(estimate.rejections, '')

        world.start_stamp_s -= 0.25
        self.set_clock(START_S + 999.75)  # network time steps
        estimate = self.assert_lived_through(world, estimate, 0.25)
        self.assertIn('ticks stamp not after the last: 12', estimate.rejections)
        world.start_stamp_s -= 0.875  # a driver's own clock
        estimate = self.assert_lived_through(world, estimate, 0.875)
        self.set_clock(START_S + 999.25)  # the clock of stamps that come from elsewhere
        self.assert_lived_through(world, estimate, 0.0)

        result = os.path.join(self.folder, 'result.yaml')
        os.remove(result)  # saved when it had become CONVERGED
        self.set_clock(START_S + 997.5)
        self.node.wait_for(lambda e: e.ticks_used == 0, 'a jump beyond the limit')
        said = wait_until(self.jumps, 'it says so')
        self.assertEqual(len(said), 1, said)
        self.assertIn('clock/max_step_back (1 s)', said[0])
        self.assertIn(result, said[0])
        with open(result) as file:
            self.assertEqual(yaml.safe_load(file)['state'], 'CONVERGED')


if __name__ == '__main__':
    rostest.rosrun('bearing_calibration', 'calibration_clock', CalibrationClockTest, sys.argv)
