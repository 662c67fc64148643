"""The worked configurations of config/robots: a robot of each kind, with the values of its data
sheet, is driven in a simulation of its own, recorded, and calibrated with nothing but its file."""

import glob
import math
import os
import subprocess
import sys
import tempfile
import unittest

import rosbag
import roslib.packages
import std_msgs.msg
import yaml
from sensor_msgs.msg import JointState

from bearing_calibration.msg import WheelTicks

REPOSITORY = os.path.abspath(os.path.join(os.path.dirname(__file__), '..', '..'))
sys.path.insert(0, os.path.join(REPOSITORY, 'test', 'ros'))
from calibration_world import World, duckietownCount, wrap  # noqa: E402  (lies beside the tests of the node)

CHI_SQUARE_3_AT_999 = 16.27  # what the squared error stays below in 999 of 1000 honest runs
SECONDS = 120


class Robot(World):
    """A world whose robot writes its own kind of messages into a bag."""

    def record(self, bag):
        self.SPIN_S = 2.5 * math.pi * self.WHEEL_SEPARATION / 2.0 / self.WHEEL_SPEED
        for step in range(SECONDS * self.TICK_RATE):
            self.recordWheels(bag)
            if step % self.TICKS_PER_BEARING == 0:
                bag.write('/bearings', self.bearings(), self.stamp())
            self.advance()

    def counts(self):
        """Of both wheels, as an encoder counts them."""
        per_metre = self.TICKS_PER_REVOLUTION / (2.0 * math.pi * self.WHEEL_RADIUS)
        return math.floor(self.left_m * per_metre), math.floor(self.right_m * per_metre)


class TurtleBot3(Robot):
    WHEEL_SEPARATION, WHEEL_RADIUS, TICKS_PER_REVOLUTION = 0.160, 0.033, 4096
    TICK_RATE, TICKS_PER_BEARING = 30, 3

    def recordWheels(self, bag):
        step = 2.0 * math.pi / self.TICKS_PER_REVOLUTION
        message = JointState(name=['wheel_right_joint', 'wheel_left_joint'])
        left, right = self.counts()
        message.position = [step * right, step * left]
        message.header.stamp = self.stamp()
        bag.write('/joint_states', message, self.stamp())


class Kobuki(Robot):
    WHEEL_SEPARATION, WHEEL_RADIUS, TICKS_PER_REVOLUTION = 0.230, 0.035, 52.0 * 6545.0 / 132.0
    START = 65000  # so that it wraps soon, too

    def recordWheels(self, bag):
        left, right = ((self.START + count) % 2**16 for count in self.counts())
        message = WheelTicks(left=left, right=right)
        message.header.stamp = self.stamp()
        bag.write('/wheel_ticks', message, self.stamp())


class Duckiebot(Robot):
    """Its wheels are read at moments of their own: each second of them, in turns."""

    WHEEL_SEPARATION, WHEEL_RADIUS, TICKS_PER_REVOLUTION = 0.100, 0.0318, 135
    TOPICS = ('/duckie/left_wheel_encoder_node/tick', '/duckie/right_wheel_encoder_node/tick')

    def __init__(self, *arguments):
        super().__init__(*arguments)
        self.kind = duckietownCount()

    def message(self, count):
        message = self.kind(data=count, resolution=135, type=1)
        message.header.stamp = self.stamp()
        return message

    def recordWheels(self, bag):
        side = self.step % 2
        bag.write(self.TOPICS[side], self.message(self.counts()[side]), self.stamp())


class OwnRobot(Duckiebot):
    """Bare counters of 16 bits without a stamp, that wrap: std_msgs/Int16."""

    WHEEL_SEPARATION, WHEEL_RADIUS, TICKS_PER_REVOLUTION = 0.25, 0.05, 4096
    TOPICS = ('/left_ticks', '/right_ticks')

    def message(self, count):
        return std_msgs.msg.Int16((count + 2**15) % 2**16 - 2**15)


class Robots(unittest.TestCase):

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        self.output = os.path.join(self.folder, 'out')

    def calibrate(self, world, *arguments, record=None):
        path = os.path.join(self.folder, 'drive.bag')
        with rosbag.Bag(path, 'w') as bag:
            (record or world.record)(bag)
        return subprocess.run(
            [roslib.packages.find_node('bearing_calibration', 'calibrate_bag')[0], path,
             '--output', self.output, '--quiet', *arguments],
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, universal_newlines=True, timeout=600)

    def assertFindsTheMount(self, world, *arguments):
        done = self.calibrate(world, *arguments)
        self.assertIn(done.returncode, (0, 4), done.stdout)  # converged, or less sure than 1 cm
        # no wrap is taken for a reset, for instance, and no reading is without its partner
        self.assertNotRegex(done.stdout, 'counter reset|faster than possible|other wheel|exceeds')
        with open(os.path.join(self.output, 'result.yaml')) as file:
            result = yaml.safe_load(file)
        error = [result['base_from_camera'][key] - true
                 for key, true in zip(('x', 'y', 'yaw'), world.sensor)]
        error[2] = wrap(error[2])
        squared = sum(e * e / s**2 for e, s in zip(error, result['stddev'].values()))
        # the axes taken apart: at least a third of the true chi-square, so the bar is that high
        self.assertLess(squared, 3.0 * CHI_SQUARE_3_AT_999, (error, result['stddev']))
        for e, bar in zip(error, (0.02, 0.02, 0.02)):
            self.assertLess(abs(e), bar, error)
        return done

    @staticmethod
    def config(name):
        return ['--config', os.path.join(REPOSITORY, 'config', 'robots', name + '.yaml')]

    def testEveryConfigurationIsTestedHere(self):
        names = {os.path.basename(path) for path in
                 glob.glob(os.path.join(REPOSITORY, 'config', 'robots', '*'))}
        self.assertEqual(names, {'turtlebot3_burger.yaml', 'kobuki.yaml', 'duckiebot.yaml', 'simulated.yaml'})

    def testTurtleBot3(self):
        self.assertFindsTheMount(TurtleBot3(1000.0), *self.config('turtlebot3_burger'))

    def testKobuki(self):
        world = Kobuki(1000.0)
        self.assertFindsTheMount(world, *self.config('kobuki'))
        self.assertGreater(abs(world.counts()[1]), 2**16, 'the counter has not wrapped')

    def testDuckiebot(self):
        self.assertFindsTheMount(
            Duckiebot(1000.0), *self.config('duckiebot'), '--wheels-topic', Duckiebot.TOPICS[0],
            '--right-wheel-topic', Duckiebot.TOPICS[1])

    def testBareCountersWithoutStamps(self):
        world = OwnRobot(1000.0)
        self.assertFindsTheMount(world, *self.config('simulated'), '--set', 'wheels/source=separate_ticks', '--set',
                                 'wheels/counter_bits=16', '--set',
                                 'wheels/ticks_per_revolution=4096.0')
        self.assertGreater(abs(world.counts()[1]), 2**16, 'the counter has not wrapped')

    def testAMissingWheelIsNamed(self):
        world = OwnRobot(1000.0)
        world.TOPICS = ('/left_ticks', '/right')
        done = self.calibrate(world, *self.config('simulated'), '--set', 'wheels/source=separate_ticks')
        self.assertEqual(done.returncode, 1, done.stdout)
        self.assertIn('no topic right_ticks with the count of one wheel', done.stdout)
        self.assertIn('/right (std_msgs/Int16)', done.stdout)

    def testAWheelThatFallsSilentIsSaid(self):
        world = OwnRobot(1000.0)

        def recordWheels(bag):
            if world.step % 2 == 0 or world.step < 20 * world.TICK_RATE:
                Duckiebot.recordWheels(world, bag)
        world.recordWheels = recordWheels
        done = self.calibrate(world, *self.config('simulated'), '--set', 'wheels/source=separate_ticks', '--set',
                              'wheels/counter_bits=16', '--set',
                              'wheels/ticks_per_revolution=4096.0')
        self.assertIn('no reading of the other wheel', done.stdout)


if __name__ == '__main__':
    unittest.main()
