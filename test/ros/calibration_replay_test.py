#!/usr/bin/env python3
"""replay.launch: a bag with its own clock, once, faster than it was recorded, and in a loop."""

import os
import shutil
import signal
import subprocess
import sys
import tempfile
import unittest

import rosbag
import rospy
import rostest
from geometry_msgs.msg import TransformStamped
from rosgraph_msgs.msg import Clock
from tf2_msgs.msg import TFMessage

from calibration_world import (DEADLINE_S, Node, SIMULATED_ROBOT, World, errors_in_stddevs,
                               wait_until)

SECONDS = 40.0
START_STAMP_S = 1.0e6
DELAY_S = 10.0  # until the bag begins, so that the nodes are there on a slow machine too
CAMERA = TransformStamped(child_frame_id='camera_optical_frame')
CAMERA.header.frame_id = 'camera'
CAMERA.transform.rotation.w = 1.0
OVERRIDES = os.path.join(os.path.dirname(os.path.abspath(__file__)), 'calibration_overrides.yaml')


def record(path):
    """A bag of the robot's drive; with a clock of another time in it, which must not be played, and
    a static transform, which is played where the owner wants it."""
    world = World(START_STAMP_S)
    with rosbag.Bag(path, 'w') as bag:
        bag.write('/tf_static', TFMessage([CAMERA]), world.stamp())
        for _ in range(round(SECONDS * World.TICK_RATE)):
            world.advance()
            stamp = world.stamp()
            bag.write('/wheel_ticks', world.ticks(), stamp)
            bag.write('/clock', Clock(rospy.Time(1, 0)), stamp)
            if world.step % World.TICKS_PER_BEARING == 0:
                bag.write('bearings', world.bearings(), stamp)  # without the slash, as some do
    return world


class CalibrationReplayTest(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        rospy.init_node('calibration_replay_test')
        cls.folder = tempfile.mkdtemp(prefix='calibration_replay_test.')
        cls.bag = os.path.join(cls.folder, 'drive.bag')
        cls.world = record(cls.bag)

    def setUp(self):
        self.static_frames = []
        subscriber = rospy.Subscriber(
            '/tf_static', TFMessage,
            lambda message: self.static_frames.extend(t.child_frame_id for t in message.transforms))
        self.addCleanup(subscriber.unregister)

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.folder)

    def replay(self, *arguments):
        process = subprocess.Popen(
            ['roslaunch', 'bearing_calibration', 'replay.launch', 'bag:=' + self.bag, 'rate:=10',
             'robot:=' + SIMULATED_ROBOT, 'overrides:=' + OVERRIDES, 'delay:=%g' % DELAY_S,
             'result_folder:=' + os.path.join(self.folder, 'result')] + list(arguments))
        self.addCleanup(self.stop, process)
        return process

    @staticmethod
    def stop(process):
        if process.poll() is None:
            process.send_signal(signal.SIGINT)
        process.wait(timeout=DEADLINE_S)

    def test_once(self):
        self.replay('detect:=false')
        node = Node()
        all_ticks = round(SECONDS * World.TICK_RATE)
        estimate = node.wait_for(lambda e: e.ticks_used == all_ticks and
                                 e.bearings_used + e.bearings_gated == 10 * SECONDS,
                                 'everything is played')
        self.assertEqual(estimate.rejections, '')
        self.assertEqual(self.static_frames, [])
        self.assertEqual(estimate.header.stamp, self.world.stamp(), 'the time of the bag')
        for quantity, error in zip(('x', 'y', 'yaw'), errors_in_stddevs(estimate, self.world)):
            self.assertLess(error, 3.0, '%s\n%s' % (quantity, estimate))
        clock = []
        rospy.Subscriber('/clock', Clock, clock.append)
        wait_until(lambda: clock and clock[-1].clock > self.world.stamp() + rospy.Duration(1),
                   'the player stays: one that ends drops what it has not sent')
        response = node.save_service()  # the nodes have stayed
        self.assertTrue(response.success, response.message)
        self.assertTrue(os.path.exists(os.path.join(self.folder, 'result', 'result.yaml')))

    # Promise refused: bearings in a bag whose images become bearings, too
    def test_the_bags_bearings_are_not_played_beside_the_detections(self):
        self.replay()  # with the detection, which has nothing to do
        node = Node()
        node.wait_for(lambda e: e.ticks_used == round(SECONDS * World.TICK_RATE),
                      'everything is played')
        count = len(node.estimates)
        wait_until(lambda: len(node.estimates) >= count + 2, 'a second: what was played has come')
        estimate = node.estimate()
        self.assertEqual(estimate.rejections, '')
        self.assertEqual(estimate.bearings_used + estimate.bearings_gated, 0)

    def test_loop_starts_anew_with_a_warning(self):
        self.replay('detect:=false', 'loop:=true')
        node = Node()
        node.wait_for(lambda e: e.bearings_used > 300, 'the first time')
        wait_until(lambda: node.warnings('jumped back', 'starts anew'), 'the loop is noticed')
        node.wait_for(lambda e: e.bearings_used < 100, 'from the beginning')
        node.wait_for(lambda e: e.bearings_used > 300, 'the second time')

    def test_quit_ends_with_the_bag(self):
        process = self.replay('detect:=false', 'quit:=true', 'tf_static:=true')
        process.wait(timeout=2.0 * DEADLINE_S)
        self.assertEqual(self.static_frames, [CAMERA.child_frame_id])


if __name__ == '__main__':
    rostest.rosrun('bearing_calibration', 'calibration_replay', CalibrationReplayTest, sys.argv)
