#!/usr/bin/env python3
"""~markers for RViz: the light where it stands, in frames with one parent each, also for those who
come late."""

import math
import sys
import unittest

import rosgraph
import rospy
import rostest
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import Marker, MarkerArray

from calibration_world import Node, World, wait_until

BASE, START = 'base_link', 'calibration_start'


def in_frame_of(base, point):
    """A point of the world in the frame of a World's base."""
    dx, dy = point[0] - base.x, point[1] - base.y
    cosine, sine = math.cos(base.heading), math.sin(base.heading)
    return cosine * dx + sine * dy, -sine * dx + cosine * dy


class CalibrationMarkersTest(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        rospy.init_node('calibration_markers_test')
        cls.node = Node()
        start = rospy.Time.now().to_sec() - 1000.0
        cls.first = World(start)
        while cls.first.step < World.TICKS_PER_BEARING:  # of the first image
            cls.first.advance()
        cls.world = World(start)
        cls.estimate = cls.node.feed(cls.world, 30.0)
        cls.topics_before = {topic for topic, _ in
                             rosgraph.Master(rospy.get_name()).getSystemState()[0]}
        cls.transforms, cls.arrays = [], []
        rospy.Subscriber('/tf', TFMessage, lambda m: cls.transforms.extend(m.transforms))
        rospy.Subscriber('calibration/markers', MarkerArray, cls.arrays.append)
        # The first markers may be the latched ones, from before the last bearings.
        wait_until(lambda: cls.transforms and len(cls.arrays) > 1,
                   'markers and their frame, though late')

    def marker(self, name, number):
        return next(marker for marker in self.arrays[-1].markers
                    if (marker.ns, marker.id) == (name, number))

    def test_nobody_gets_transforms_that_nobody_looks_at(self):
        self.assertIn('/calibration/markers', self.topics_before)
        self.assertNotIn('/tf', self.topics_before)

    def test_every_frame_has_one_parent(self):
        self.assertEqual({(t.header.frame_id, t.child_frame_id) for t in self.transforms},
                         {(BASE, START)})
        frames = {marker.ns: marker.header.frame_id for marker in self.arrays[-1].markers}
        self.assertEqual(frames, {'robot': BASE, 'sensor': BASE, 'light': START, 'ray': START,
                                  'path': START, 'state': START})

    def test_the_light_stands_where_it_is(self):
        light = self.marker('light', 0)
        self.assertEqual(light.action, Marker.ADD)
        x, y = in_frame_of(self.first, self.world.light)
        variances = [self.estimate.covariance_with_clock_and_wheels[i] for i in (0, 10)]
        off = math.hypot(light.pose.position.x - x, light.pose.position.y - y)
        # Wheels are exact here, so the light is as well known in the start frame as in the base's.
        self.assertLess(off, 3.5 * math.sqrt(sum(variances)))

    def test_the_start_is_where_the_base_was(self):
        transform = self.transforms[-1].transform
        x, y = in_frame_of(self.world, (self.first.x, self.first.y))
        self.assertAlmostEqual(transform.translation.x, x, delta=1e-3)  # ticks are whole numbers
        self.assertAlmostEqual(transform.translation.y, y, delta=1e-3)
        yaw = 2.0 * math.atan2(transform.rotation.z, transform.rotation.w)
        turn = self.first.heading - self.world.heading
        self.assertAlmostEqual(math.remainder(yaw - turn, 2.0 * math.pi), 0.0, delta=1e-3)

    def test_the_sensors_ellipse_has_its_size(self):
        def is_size_of(estimate):  # a fit that ran beside may have changed both
            farthest = max(math.hypot(p.x - estimate.x_m, p.y - estimate.y_m)
                           for p in self.marker('sensor', 1).points)
            xx, xy, yy = [estimate.covariance_x_y_yaw[i] for i in (0, 1, 4)]
            largest = 0.5 * (xx + yy) + math.hypot(0.5 * (xx - yy), xy)  # eigenvalue of 2x2
            return abs(farthest - 3.0 * math.sqrt(largest)) < 0.01 * farthest
        self.node.wait_for(is_size_of, 'three standard deviations of the newest estimate')

    def test_zz_a_reset_deletes_what_is_no_longer_known(self):
        self.node.reset()
        self.node.drive(World(self.world.start_stamp_s), 0.5)
        wait_until(lambda: self.marker('light', 0).action == Marker.DELETE, 'the light is deleted')
        self.assertEqual(self.marker('robot', 0).action, Marker.ADD)


if __name__ == '__main__':
    rostest.rosrun('bearing_calibration', 'calibration_markers', CalibrationMarkersTest, sys.argv)
