#!/usr/bin/env python3
"""Images and camera_info of a camera without a mirror (the parameter ~lens), tilted and with a limited field
of view, become true bearings, and the calibration behind them finds the mount."""

import math
import sys
import unittest

import numpy
import rospy
import rostest
from bearing_calibration.msg import LightBearings
from sensor_msgs.msg import CameraInfo, Image

from calibration_world import Node, PIECE_S, World, assert_finds_the_mount, wait_until, wrap
from camera_images import CameraWorld, camera_info, is_in_image

DRIVE_S = 120.0


class CameraDetectionTest(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        rospy.init_node('camera_detection_test')
        cls.lens = rospy.get_param('~lens')
        cls.node = Node()
        cls.bearings = []
        rospy.Subscriber('bearings', LightBearings, cls.bearings.append)
        cls.images = rospy.Publisher('camera/image_raw', Image, queue_size=1000)
        infos = rospy.Publisher('camera/camera_info', CameraInfo, queue_size=1000, latch=True)
        wait_until(lambda: cls.images.get_num_connections() and infos.get_num_connections(),
                   'the detection subscribes')
        cls.world = CameraWorld(cls.lens, rospy.Time.now().to_sec() - 1000.0)
        infos.publish(camera_info(cls.lens, cls.world.stamp()))
        cls.drive_until_it_is_answered()
        for _ in range(round(DRIVE_S / PIECE_S)):
            cls.drive(PIECE_S)
            # in pieces that fit into the nodes' queues
            cls.node.wait_for(lambda e: e.header.stamp >= cls.last_seen(), 'a piece is taken in')
        cls.estimate = cls.node.estimate()

    @classmethod
    def drive(cls, seconds):
        count = len(cls.bearings)
        images = round(seconds * World.BEARING_RATE)
        for _ in range(images):
            for _ in range(World.TICKS_PER_BEARING):
                cls.world.advance()
                cls.node.wheels.publish(cls.world.ticks())
            cls.images.publish(cls.world.image())
        if count:
            wait_until(lambda: len(cls.bearings) >= count + images, 'an answer to each image')

    @classmethod
    def drive_until_it_is_answered(cls):
        """camera_info and the static transforms have come by then."""
        def is_answered():
            cls.drive(0.1)
            return len(cls.bearings) > 0
        wait_until(is_answered, 'bearings')

    @classmethod
    def last_seen(cls):
        """Stamp of the last image with a light: an estimate has the stamp of one."""
        return [message.header.stamp for message in cls.bearings if message.candidates][-1]

    def test_finds_the_mount(self):
        assert_finds_the_mount(self, self.estimate, self.world, self.lens)

    def test_bearings_are_the_true_ones_of_a_level_frame(self):
        seen = [message for message in self.bearings if message.candidates]
        print('%s: light in %d of %d images' % (self.lens, len(seen), len(self.bearings)))
        self.assertGreater(len(seen), 0.1 * len(self.bearings))
        self.assertLess(len(seen), 0.9 * len(self.bearings), 'it is out of view at times')
        for message in seen:
            self.assertEqual(message.header.frame_id, 'mast')
            self.assertEqual(message.harmonic_stddev, 0.0)
            self.assertEqual(len(message.candidates), 1)
            azimuth, elevation = self.world.seen[message.header.stamp]
            candidate = message.candidates[0]
            # half a pixel: a light's middle is not the middle of its image where lenses bend much
            self.assertLess(abs(wrap(candidate.azimuth - azimuth)) * math.cos(elevation), 0.003)
            self.assertLess(abs(candidate.elevation - elevation), 0.003)
            self.assertGreater(candidate.azimuth_variance, 0.0)
            self.assertGreaterEqual(candidate.elevation_variance, 0.01**2)  # alignment/elevation_stddev
            self.assertTrue(math.isnan(candidate.image_radius))
            self.assertLess(abs(candidate.azimuth - message.view_centre), 0.5 * message.view_width + 0.1,
                            'it is seen where the sensor says that it sees, above the horizon a little beside')


    def test_says_its_field_of_view(self):
        """The azimuths at the horizon whose rays the lens shows in the image."""
        shown = [azimuth for azimuth in numpy.radians(numpy.arange(-180.0, 180.0, 0.25))
                 if is_in_image(self.lens, azimuth, 0.0)]
        for message in self.bearings:
            for border, sense in ((max(shown), 0.5), (min(shown), -0.5)):
                self.assertAlmostEqual(message.view_centre + sense * message.view_width, border,
                                       delta=math.radians(1.0))


if __name__ == '__main__':
    rostest.rosrun('bearing_calibration', 'camera_detection', CameraDetectionTest, sys.argv)
