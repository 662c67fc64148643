#!/usr/bin/env python3
"""Whatever a robot has already (the parameter ~source), the adapter makes true bearings of it, and
the calibration behind it finds the mount."""

import math
import sys
import time
import unittest

import numpy
import rospy
import rostest
from bearing_calibration.msg import CalibrationEstimate, LightBearings
from geometry_msgs.msg import (Point, PointStamped, Pose, PoseArray, PoseStamped, TransformStamped)
from sensor_msgs.msg import LaserScan
from tf2_msgs.msg import TFMessage

from calibration_world import Node, PIECE_S, World, assert_finds_the_mount, wait_until, wrap

STDDEV_RAD = 0.01  # bearing_adapter_overrides.yaml
DRIVE_S = 120.0
FITS_MAY_TAKE_S = 5.0  # after a piece: it is driven faster than it happens, so that they can be behind
LIGHT_HEIGHT_M = 0.4
OTHER_LIGHT = (2.5, 2.0)
RAYS, TURN_S, POST_RADIUS_M, ROOM_M, RANGE_STDDEV_M = 720, 0.1, 0.05, 8.0, 0.01


class AdapterWorld(World):
    """Remembers where the robot was, and what its sensors see."""

    def __init__(self, start_stamp_s):
        super().__init__(start_stamp_s)
        self.poses = [(self.x, self.y, self.heading)]

    def advance(self):
        super().advance()
        self.poses.append((self.x, self.y, self.heading))

    def directions(self, light, steps):
        """Azimuth and distance of a light in the sensor's frame after so many steps, fractions
        too: between two of them the robot drives straight or turns on the spot."""
        x, y, heading = (numpy.interp(steps, numpy.arange(len(self.poses)), numbers)
                         for numbers in zip(*self.poses))
        sensor_x = x + numpy.cos(heading) * self.sensor[0] - numpy.sin(heading) * self.sensor[1]
        sensor_y = y + numpy.sin(heading) * self.sensor[0] + numpy.cos(heading) * self.sensor[1]
        distance = numpy.hypot(light[0] - sensor_x, light[1] - sensor_y)
        azimuth = numpy.arctan2(light[1] - sensor_y, light[0] - sensor_x) - heading - self.sensor[2]
        return azimuth, distance

    def place(self, light):
        """Of a light in the sensor's frame (x ahead, y left, z up), as it is measured now."""
        azimuth, distance = self.directions(light, self.step)
        azimuth += self.random.gauss(0.0, STDDEV_RAD)
        distance *= 1.0 + self.random.gauss(0.0, 0.02)
        return distance * math.cos(azimuth), distance * math.sin(azimuth), LIGHT_HEIGHT_M

    def optical(self, light):
        """In the optical frame of a camera: x to the right, y down, z ahead."""
        x, y, z = self.place(light)
        return Point(-y, -z, x)

    def stamped(self, message, frame):
        message.header.stamp = self.stamp()
        message.header.frame_id = frame
        return message

    def point(self):
        return self.stamped(PointStamped(point=Point(*self.place(self.light))), '/mast')

    def pose(self):
        message = self.stamped(PoseStamped(), 'camera_optical_frame')
        message.pose.position = self.optical(self.light)
        return message

    def posesOfAll(self):
        """The light among what is taken for it, anywhere and anew in each image."""
        around = self.random.uniform(-math.pi, math.pi)
        points = [self.optical(self.light), Point(math.sin(around), 0.2, math.cos(around))]
        self.random.shuffle(points)
        return self.stamped(PoseArray(poses=[Pose(position=point) for point in points]),
                            'camera_optical_frame')

    def transforms(self):
        """Two lights and something else, each sent alone."""
        messages = []
        for child, light in (('tag_1', self.light), ('other', (1.0, 1.0)), ('tag_2', OTHER_LIGHT)):
            message = self.stamped(TransformStamped(child_frame_id=child), 'camera_optical_frame')
            point = self.optical(light)
            message.transform.translation.x = point.x
            message.transform.translation.y = point.y
            message.transform.translation.z = point.z
            message.transform.rotation.w = 1.0
            messages.append(TFMessage([message]))
        return messages

    def scan(self):
        """Of the turn that ends now, by a scanner upside down, 0.5 rad to the left of the mast: its
        ray at `a` goes to -a + 0.5 in the mast's frame. A ray meets a round post where it passes its
        axis by less than the radius."""
        message = LaserScan(angle_min=-math.pi, angle_max=math.pi, angle_increment=2 * math.pi / RAYS,
                            time_increment=TURN_S / RAYS, range_min=0.1, range_max=30.0)
        began = self.step - TURN_S * self.TICK_RATE
        message.header.stamp = self.stamp() - rospy.Duration.from_sec(TURN_S)
        message.header.frame_id = 'laser'
        steps = began + numpy.arange(RAYS) * message.time_increment * self.TICK_RATE
        ray = 0.5 - (message.angle_min + numpy.arange(RAYS) * message.angle_increment)
        azimuth, distance = self.directions(self.light, steps)
        off = ray - azimuth - self.random.gauss(0.0, STDDEV_RAD)
        aside, along = distance * numpy.sin(off), distance * numpy.cos(off)
        hits = (numpy.abs(aside) < POST_RADIUS_M) & (along > 0)
        depth = numpy.sqrt(numpy.maximum(POST_RADIUS_M**2 - aside**2, 0.0))
        noise = numpy.random.RandomState(self.step).normal(0.0, RANGE_STDDEV_M, RAYS)
        message.ranges = numpy.where(hits, along - depth, ROOM_M) + noise
        return message


# What a sensor sends at a moment.
SOURCES = {'point': (PointStamped, lambda world: [world.point()]),
           'pose': (PoseStamped, lambda world: [world.pose()]),
           'poses': (PoseArray, lambda world: [world.posesOfAll()]),
           'tf': (TFMessage, AdapterWorld.transforms),
           'scan': (LaserScan, lambda world: [world.scan()])}


class BearingAdapterTest(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        rospy.init_node('bearing_adapter_test')
        cls.source = rospy.get_param('~source')
        kind, sense = SOURCES[cls.source]
        cls.node = Node()
        cls.bearings = []
        rospy.Subscriber('bearings', LightBearings, cls.bearings.append)
        publisher = rospy.Publisher('/tf' if cls.source == 'tf' else 'what_the_robot_has', kind,
                                    queue_size=1000)
        cls.publisher = publisher
        wait_until(publisher.get_num_connections, 'the adapter subscribes')
        cls.world = AdapterWorld(rospy.Time.now().to_sec() - 1000.0)
        cls.waitForStaticTransforms(publisher, sense)
        is_ready = cls.world.stamp()
        pieces = round(DRIVE_S / PIECE_S)
        for piece in range(1, pieces + 1):
            cls.drive(publisher, sense)
            end = time.monotonic() + FITS_MAY_TAKE_S
            while 2 * piece > pieces and not cls.isConverged() and time.monotonic() < end:
                time.sleep(0.02)
        cls.estimate = cls.node.estimate()
        # Of the last image before, one light may have come without its transform, the other one with it.
        cls.bearings = [message for message in cls.bearings if message.header.stamp > is_ready]

    @classmethod
    def isConverged(cls):
        return cls.node.estimate().state == CalibrationEstimate.CONVERGED

    @classmethod
    def drive(cls, publisher, sense):
        """In pieces that fit into the nodes' queues; a scan may be stamped with its beginning."""
        for _ in range(round(PIECE_S * World.BEARING_RATE)):
            for _ in range(World.TICKS_PER_BEARING):
                cls.world.advance()
                cls.node.wheels.publish(cls.world.ticks())
            for message in sense(cls.world):
                publisher.publish(message)
        last = cls.world.stamp() - rospy.Duration.from_sec(2 * TURN_S)
        cls.node.wait_for(lambda e: e.header.stamp >= last, 'all of %g s is taken in' % PIECE_S)

    @classmethod
    def waitForStaticTransforms(cls, publisher, sense):
        """Drives until the adapter knows them: no faster than it happens, for the calibration has no use
        for a bearing that comes later than wheels/history remembers."""
        def isAnswered():
            time.sleep(2 * TURN_S)
            for _ in range(round(2 * TURN_S * World.TICK_RATE)):
                cls.world.advance()
                cls.node.wheels.publish(cls.world.ticks())
            for message in sense(cls.world):
                publisher.publish(message)
            return len(cls.bearings) > 0
        wait_until(isAnswered, 'bearings')

    def test_finds_the_mount(self):
        assert_finds_the_mount(self, self.estimate, self.world, self.source)
        if self.source == 'tf':
            self.assertEqual([light.light_id for light in self.estimate.lights], [1, 2])

    def test_bearings_are_the_true_ones_of_their_stamps(self):
        offs = []
        for message in self.bearings:
            self.assertEqual(message.header.frame_id, 'mast')
            steps = (message.header.stamp.to_sec() - self.world.start_stamp_s) * World.TICK_RATE
            azimuth, distance = self.world.directions(self.world.light, steps)
            of_lights = [wrap(each.azimuth - azimuth) / math.sqrt(each.azimuth_variance)
                         for each in message.candidates if each.light_id in (-1, 1, 7)]
            if self.source == 'poses':  # the other one is not the light, and nearer in 1 of 400 only
                of_lights = [min(of_lights, key=abs)]
            offs += of_lights
        self.assertGreater(len(offs), 0.9 * DRIVE_S * World.BEARING_RATE)
        spread = math.sqrt(sum(off * off for off in offs) / len(offs))
        self.assertAlmostEqual(spread, 1.0, delta=5.0 / math.sqrt(2.0 * len(offs)))

    def test_numbers_and_elevations_are_those_of_the_source(self):
        numbers = {tuple(each.light_id for each in message.candidates)
                   for message in self.bearings if message.candidates}
        expected = {'point': {(7,)}, 'pose': {(7,)}, 'poses': {(-1, -1)}, 'tf': {(1, 2)}, 'scan': {(-1,)}}
        self.assertEqual(numbers, expected[self.source])
        for message in self.bearings:
            steps = (message.header.stamp.to_sec() - self.world.start_stamp_s) * World.TICK_RATE
            for each in message.candidates:
                if self.source == 'scan':
                    self.assertTrue(math.isnan(each.elevation))
                elif each.light_id in (1, 7):
                    _, distance = self.world.directions(self.world.light, steps)
                    self.assertAlmostEqual(math.tan(each.elevation) * distance / LIGHT_HEIGHT_M, 1.0,
                                           delta=0.15)  # of a distance that scatters by 2 %
                    self.assertAlmostEqual(each.elevation_variance, STDDEV_RAD**2)


    def test_says_its_field_of_view(self):
        """A scanner that turns once sees all around; the last third of its rays goes, clockwise in the mast's
        frame, from 0.5 - 60 deg to 0.5 - 180 deg."""
        self.assertEqual({message.view_width for message in self.bearings}, {0.0})
        if self.source != 'scan':
            return
        scan = self.world.scan()
        first = RAYS - RAYS // 3
        scan.angle_min += first * scan.angle_increment
        scan.ranges = scan.ranges[first:]
        scan.header.stamp += rospy.Duration.from_sec(TURN_S)
        answers = []
        subscriber = rospy.Subscriber('bearings', LightBearings, answers.append)
        wait_until(subscriber.get_num_connections, 'the adapter is heard')
        self.publisher.publish(scan)
        wait_until(lambda: answers, 'the part of a scan is answered')
        subscriber.unregister()
        part = answers[0]
        self.assertAlmostEqual(wrap(part.view_centre - (0.5 - math.radians(120.0))), 0.0,
                               delta=math.radians(0.5))
        self.assertAlmostEqual(part.view_width, math.radians(120.0), delta=math.radians(0.6))


if __name__ == '__main__':
    rostest.rosrun('bearing_calibration', 'bearing_adapter', BearingAdapterTest, sys.argv)
