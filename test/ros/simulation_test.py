#!/usr/bin/env python3
"""The simulation nodelet in wall time: ticks, images, truth, commands; in a manager and alone."""

import hashlib
import math
import sys
import unittest

import numpy
import rospy
import rostest
from bearing_calibration.msg import LightBearings, WheelTicks
from geometry_msgs.msg import PointStamped, PoseStamped, Twist
from rosgraph_msgs.msg import Log
from sensor_msgs.msg import CameraInfo, Image

from calibration_world import wait_until

NAMESPACES = ('managed', 'standalone', 'late', 'commanded')
TICK_PERIOD_NS = 10 ** 7   # wheels/rate is 100 Hz
IMAGE_PERIOD_NS = 10 ** 8  # camera/rate is 10 Hz
LATENCY_NS = 25 * 10 ** 7  # of the camera in 'late'
SEPARATION_M = 0.25
METERS_PER_TICK = 2.0 * math.pi * 0.05 / 65536.0
BRIGHT = 60                # a pixel of the light; all surroundings are darker
COMMAND_TIMEOUT_S = 0.5    # trajectory/command_timeout


class Picture(object):
    """What is kept of an image: a test that takes long must not fill the memory."""

    def __init__(self, image):
        self.header = image.header
        self.description = (image.encoding, image.width, image.height, image.step, len(image.data))
        self.digest = hashlib.md5(image.data).hexdigest()
        levels = numpy.frombuffer(image.data, numpy.uint8).reshape(image.height, image.step)
        rows, columns = numpy.nonzero(levels > BRIGHT)
        weights = levels[rows, columns].astype(float)
        self.column, self.row = (weights @ columns / sum(weights), weights @ rows / sum(weights))


class Recorder(object):
    """Everything that one simulation publishes, by its stamp's nanoseconds after the start."""

    def __init__(self, namespace):
        self.topics = {}
        self.received = {}
        self.start_ns = None
        self.subscribers = []
        for topic, kind in (('wheel_ticks', WheelTicks), ('camera/image_raw', Image),
                            ('camera/camera_info', CameraInfo),
                            ('simulation/truth/base', PoseStamped),
                            ('simulation/truth/bearings', LightBearings),
                            ('simulation/truth/base_from_camera', PoseStamped),
                            ('simulation/truth/light', PointStamped)):
            self.topics[topic] = []
            self.subscribers.append(rospy.Subscriber('/%s/%s' % (namespace, topic), kind,
                                                     self.store, callback_args=topic))

    def store(self, message, topic):
        if topic == 'camera/image_raw':
            message = Picture(message)
        self.received[topic, message.header.stamp.to_nsec()] = rospy.Time.now().to_nsec()
        self.topics[topic].append(message)

    def last(self, topic):
        wait_until(lambda: self.topics[topic], 'a message on ' + topic)
        return self.topics[topic][-1]

    def wait_for(self, topic, count):
        wait_until(lambda: len(self.topics[topic]) >= count, '%d messages on %s' % (count, topic))
        return self.topics[topic][:]

    def stamps(self, topic):
        return [message.header.stamp.to_nsec() for message in self.topics[topic][:]]

    def by_offset(self, topic):
        """Messages by their nanoseconds after the simulation's start."""
        start = self.last('simulation/truth/light').header.stamp.to_nsec()
        return {message.header.stamp.to_nsec() - start: message
                for message in self.topics[topic][:]}

    def pairs(self, topic, other, count):
        """The messages of two topics that have the same stamp; their connections come one by one."""
        def both():
            ours, theirs = self.by_offset(topic), self.by_offset(other)
            found = [(ours[offset], theirs[offset]) for offset in sorted(set(ours) & set(theirs))]
            return found if len(found) >= count else None
        return wait_until(both, '%d pairs of %s and %s' % (count, topic, other))


def yaw_of(pose):
    return 2.0 * math.atan2(pose.orientation.z, pose.orientation.w)


def wrapped(angle):
    return math.remainder(angle, 2.0 * math.pi)


def light_azimuth(picture, info):
    """Azimuth of the bright spot's centroid about the mirror's axis, handedness -1."""
    return math.atan2(picture.row - info.K[5], picture.column - info.K[2])


class SimulationTest(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        rospy.init_node('simulation_test')
        cls.recorders = {namespace: Recorder(namespace) for namespace in NAMESPACES}

    def check_stamps(self, stamps, period_ns, topic):
        steps = {after - before for before, after in zip(stamps, stamps[1:])}
        self.assertEqual(steps, {period_ns}, 'steps between the stamps of ' + topic)

    def test_ticks_and_images_come_at_their_rates(self):
        for namespace in ('managed', 'standalone'):
            recorder = self.recorders[namespace]
            recorder.wait_for('wheel_ticks', 300)
            recorder.wait_for('camera/image_raw', 20)
            self.check_stamps(recorder.stamps('wheel_ticks'), TICK_PERIOD_NS, 'wheel_ticks')
            image_steps = {after - before
                           for before, after in zip(recorder.stamps('camera/image_raw'),
                                                    recorder.stamps('camera/image_raw')[1:])}
            self.assertTrue(all(step > 0 and step % IMAGE_PERIOD_NS == 0 for step in image_steps),
                            'a busy machine may drop an image, no more: %s' % image_steps)

    def test_image_and_camera_info_go_together(self):
        image, info = self.recorders['managed'].pairs('camera/image_raw', 'camera/camera_info', 3)[2]
        self.assertEqual(image.description, ('mono8', 640, 480, 640, 640 * 480))
        self.assertEqual((info.width, info.height), (640, 480))
        self.assertEqual((image.header.frame_id, info.header.frame_id), ('camera', 'camera'))
        # Thin lens: f = 4 mm focused at 60 mm, pixels of 5.6 um.
        self.assertAlmostEqual(info.K[0], 1.0 / (1.0 / 4e-3 - 1.0 / 0.06) / 5.6e-6, places=6)

    def test_light_is_seen_where_it_truly_is(self):
        recorder = self.recorders['managed']
        info = recorder.last('camera/camera_info')
        for image, truth in recorder.pairs('camera/image_raw', 'simulation/truth/bearings', 5)[:5]:
            error = wrapped(light_azimuth(image, info) - truth.candidates[0].azimuth)
            # A thresholded centroid of a spot at 1 m has an error of 0.014 degrees (1 sigma).
            self.assertLess(abs(math.degrees(error)), 0.06)

    def test_truth_is_that_of_the_configuration(self):
        for recorder in self.recorders.values():
            mount = recorder.last('simulation/truth/base_from_camera')
            self.assertEqual(mount.header.frame_id, 'base_link')
            self.assertAlmostEqual(mount.pose.position.x, 0.1 * math.cos(math.radians(30.0)))
            self.assertAlmostEqual(mount.pose.position.y, 0.1 * math.sin(math.radians(30.0)))
            self.assertAlmostEqual(mount.pose.position.z, 0.3)
            self.assertAlmostEqual(math.degrees(yaw_of(mount.pose)), 60.0)
            light = recorder.last('simulation/truth/light')
            self.assertEqual(light.header.frame_id, 'world')
            self.assertEqual((light.point.x, light.point.y), (0.0, 0.0))
            self.assertAlmostEqual(light.point.z, 0.27)

    def test_bearing_follows_from_pose_mount_and_light(self):
        base, bearings = self.recorders['standalone'].pairs(
            'simulation/truth/base', 'simulation/truth/bearings', 5)[-1]
        pose = base.pose
        yaw = yaw_of(pose)
        sensor_x = pose.position.x + 0.1 * math.cos(yaw + math.radians(30.0))
        sensor_y = pose.position.y + 0.1 * math.sin(yaw + math.radians(30.0))
        expected = math.atan2(-sensor_y, -sensor_x) - yaw - math.radians(60.0)
        self.assertAlmostEqual(wrapped(bearings.candidates[0].azimuth - expected), 0.0, places=9)
        self.assertGreater(bearings.candidates[0].azimuth_variance, 0.0)

    def test_ticks_tell_the_turn(self):
        """A spin at 0.2 m/s of the wheels; K = 1e-6 m makes 1.4 mm in the difference after 1 m."""
        recorder = self.recorders['standalone']
        ticks = recorder.wait_for('wheel_ticks', 300)
        turn = ((ticks[299].right - ticks[0].right) - (ticks[299].left - ticks[0].left)) \
            * METERS_PER_TICK / SEPARATION_M
        seconds = (ticks[299].header.stamp - ticks[0].header.stamp).to_sec()
        expected = 2.0 * 0.2 * seconds / SEPARATION_M
        stddev = math.sqrt(2.0 * 1e-6 * 0.2 * seconds) / SEPARATION_M
        self.assertLess(abs(turn - expected), 4.0 * stddev)

    def test_the_seed_decides_ticks_and_pixels(self):
        first, second = self.recorders['managed'], self.recorders['standalone']
        for topic, digest in (('wheel_ticks', lambda m: (m.left, m.right)),
                              ('camera/image_raw', lambda m: m.digest)):
            def common():
                ours, theirs = first.by_offset(topic), second.by_offset(topic)
                found = [(offset, ours[offset], theirs[offset]) for offset in set(ours) & set(theirs)]
                return found if len(found) >= 5 else None
            for offset, ours, theirs in wait_until(common, 'both simulations publish ' + topic):
                self.assertEqual(digest(ours), digest(theirs), '%s at %g s' % (topic, offset * 1e-9))

    def test_late_camera_is_late(self):
        recorder = self.recorders['late']
        recorder.wait_for('camera/image_raw', 10)
        for offset in recorder.by_offset('camera/image_raw'):
            self.assertEqual((offset - LATENCY_NS) % IMAGE_PERIOD_NS, 0)
        for stamp in recorder.stamps('camera/image_raw'):
            self.assertGreaterEqual(recorder.received['camera/image_raw', stamp], stamp,
                                    'an image came before its stamp')

    def test_small_counters_wrap(self):
        ticks = self.recorders['late'].wait_for('wheel_ticks', 500)
        for side in ('left', 'right'):
            counts = [getattr(message, side) for message in ticks]
            self.assertTrue(all(-128 <= count < 128 for count in counts))
            steps = [(after - before + 128) % 256 - 128
                     for before, after in zip(counts, counts[1:])]
            # 0.2 m/s are 6.4 ticks in 10 ms; the noise adds less than two.
            self.assertTrue(all(abs(step) <= 9 for step in steps), sorted(set(steps)))
            self.assertGreater(max(abs(a - b) for a, b in zip(counts, counts[1:])), 128, 'no wrap')

    def test_commands_move_the_robot_until_they_stop(self):
        recorder = self.recorders['commanded']
        publisher = rospy.Publisher('/commanded/cmd_vel', Twist, queue_size=1)
        wait_until(lambda: publisher.get_num_connections() > 0, 'the simulation listens')
        start = recorder.last('simulation/truth/base').pose

        def moved():
            pose = recorder.last('simulation/truth/base').pose
            return math.hypot(pose.position.x - start.position.x,
                              pose.position.y - start.position.y)

        def robots_time():
            return recorder.last('simulation/truth/base').header.stamp.to_sec()
        warnings = []
        rospy.Subscriber('/rosout', Log, lambda log: warnings.append(log.msg))
        bad = Twist()
        bad.linear.x = float('nan')

        def is_refused():
            publisher.publish(bad)  # again: the log's listener may have come late
            return any('/commanded/cmd_vel' in text and 'not finite' in text for text in warnings)
        wait_until(is_refused, 'a warning of the NaN')
        self.assertEqual(moved(), 0.0)
        command = Twist()
        command.linear.x = 0.2
        publisher.publish(command)
        wait_until(lambda: moved() > 0.0, 'the robot moves')
        moved_s = robots_time()
        wait_until(lambda: robots_time() > moved_s + 2.0 * COMMAND_TIMEOUT_S, 'its time goes on')
        self.assertAlmostEqual(moved(), command.linear.x * COMMAND_TIMEOUT_S, places=9)


if __name__ == '__main__':
    rostest.rosrun('bearing_calibration', 'simulation', SimulationTest, sys.argv)
