#!/usr/bin/env python3
"""Eight lights at 10 Hz and ticks at 100 Hz, as they come, with fits beside: nothing is lost."""

import math
import shutil
import sys
import time
import unittest

import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray

from calibration_world import Node, World, taken_in, wait_until

SECONDS = 60.0
BEHIND_S = 0.2  # of ticks, for which the last bearings wait


class EightLights(World):
    """The lights stand around the drive, and the sensor tells them apart."""

    TICK_RATE = 100
    TICKS_PER_BEARING = 10
    BEARING_RATE = TICK_RATE // TICKS_PER_BEARING
    LIGHTS = 8
    RADIUS = 3.0  # [m] of the circle that they stand on

    def bearings(self, *candidates):
        if not candidates:
            candidates = []
            for light in range(self.LIGHTS):
                angle = 2.0 * math.pi * light / self.LIGHTS
                self.light = (2.0 + self.RADIUS * math.cos(angle), self.RADIUS * math.sin(angle))
                candidates.append(self.candidate(light_id=light))
        return super().bearings(*candidates)


class CalibrationBesideTest(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        rospy.init_node('calibration_beside_test')
        cls.node = Node()
        cls.fits = []
        rospy.Subscriber('/diagnostics', DiagnosticArray, cls.diagnosed)
        cls.folder = rospy.get_param('calibration/output/folder')

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.folder, ignore_errors=True)

    @classmethod
    def diagnosed(cls, message):
        for status in message.status:
            cls.fits += [int(v.value) for v in status.values if v.key == 'fits taken over']

    # Promise unharmed: inputs during long fits
    def test_nothing_is_lost(self):
        world = EightLights(rospy.Time.now().to_sec() - 1000.0)
        begin = time.monotonic()
        steps = round((SECONDS + BEHIND_S) * world.TICK_RATE)
        for step in range(steps):
            world.advance()
            self.node.wheels.publish(world.ticks())
            if world.step <= SECONDS * world.TICK_RATE and world.step % world.TICKS_PER_BEARING == 0:
                self.node.bearings.publish(world.bearings())
            time.sleep(max(0.0, begin + step / world.TICK_RATE - time.monotonic()))
        everything = world.LIGHTS * round(SECONDS * world.BEARING_RATE)
        estimate = self.node.wait_for(
            lambda e: e.ticks_used == steps and taken_in(e) == everything,
            '%d ticks and %d bearings are taken in' % (steps, everything))
        self.assertEqual(estimate.rejections, '')
        self.assertEqual(len(estimate.lights), world.LIGHTS)
        wait_until(lambda: self.fits and self.fits[-1] > 0, 'fits are taken over')
        rospy.loginfo('%d fits taken over in %g s', self.fits[-1], SECONDS)


if __name__ == '__main__':
    rostest.rosrun('bearing_calibration', 'calibration_beside', CalibrationBesideTest, sys.argv)
