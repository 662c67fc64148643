#!/usr/bin/env python3
"""The simulation's own time: /clock runs, faster than the wall's, and ends with the trajectory."""

import sys
import time
import unittest

import rospy
import rostest
from bearing_calibration.msg import WheelTicks
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Image

from calibration_world import wait_until

DEADLINE_S = 150.0
END_S = 41.0  # the clock begins at 1 s, the trajectory lasts for 40 s
RATE = 4.0


class SimulationClockTest(unittest.TestCase):

    def test_clock(self):
        clocks, ticks, images = [], [], []
        rospy.Subscriber('/clock', Clock,
                         lambda m: clocks.append((time.monotonic(), m.clock.to_sec())), queue_size=10000)
        rospy.Subscriber('/wheel_ticks', WheelTicks, ticks.append, queue_size=10000)
        rospy.Subscriber('/camera/image_raw', Image,
                         lambda m: images.append(m.header.stamp.to_nsec()), queue_size=1000)
        rospy.init_node('simulation_clock_test')

        wait_until(lambda: clocks and clocks[-1][1] > END_S - 1e-6, 'the end of the clock', DEADLINE_S)
        wait_until(lambda: images and images[-1] == int(END_S * 1e9), 'the last image')
        time.sleep(0.5)  # what would come after the end

        self.assertAlmostEqual(clocks[-1][1], END_S, places=6)
        steps = {round((after[1] - before[1]) * 1e9) for before, after in zip(clocks, clocks[1:])}
        # A subscriber that falls behind is spared the clock messages in between: their queue is short.
        self.assertEqual(min(steps), 10 ** 7, 'shortest step of /clock [ns]')
        self.assertEqual({step % 10 ** 7 for step in steps}, {0}, 'steps of /clock [ns]: %s' % steps)
        # A message may be late, but none can be early: the least late ones tell the rate.
        quarter = len(clocks) // 4
        begin, end = (min(part, key=lambda clock: clock[0] - clock[1] / RATE)
                      for part in (clocks[:quarter], clocks[-quarter:]))
        rate = (end[1] - begin[1]) / (end[0] - begin[0])
        self.assertLess(rate, 1.05 * RATE, 'as fast as asked for')
        self.assertGreater(rate, 1.0, 'faster than the wall, on a busy machine too')

        stamps = [message.header.stamp.to_nsec() for message in ticks]
        self.assertEqual({b - a for a, b in zip(stamps, stamps[1:])}, {10 ** 7}, 'no tick is lost')
        self.assertEqual({b - a for a, b in zip(images, images[1:])}, {10 ** 8},
                         'no image is lost: the robot waits for the renderer')
        self.assertEqual(stamps[-1], int(END_S * 1e9))


if __name__ == '__main__':
    rostest.rosrun('bearing_calibration', 'simulation_clock', SimulationClockTest, sys.argv)
