#!/usr/bin/env python3
"""result.yaml is written without being asked, and taken up after a restart; a corrupt one is not."""

import math
import os
import shutil
import subprocess
import unittest

import rosnode
import rospkg
import rospy
import rostest
import yaml

from calibration_world import Node, SIMULATED_ROBOT, World, wait_until

OVERRIDES = os.path.join(rospkg.RosPack().get_path('bearing_calibration'), 'test', 'ros',
                         'calibration_overrides.yaml')


class CalibrationSavedTest(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        rospy.init_node('calibration_saved_test')
        cls.folder = rospy.get_param('/folder')
        cls.path = os.path.join(cls.folder, 'result.yaml')

    @classmethod
    def tearDownClass(cls):
        rosnode.kill_nodes(['/calibration'])  # it saves once more as it ends
        wait_until(lambda: not rosnode.rosnode_ping('/calibration', max_count=1),
                   'nobody writes any more')
        shutil.rmtree(cls.folder)

    def restarted(self, name, folder):
        """A node in a namespace of its own that takes up what lies in the folder."""
        process = subprocess.Popen(
            ['roslaunch', '--disable-title', 'bearing_calibration', 'calibrate.launch',
             'robot:=' + SIMULATED_ROBOT, 'overrides:=' + OVERRIDES,
             'result_folder:=' + folder, 'resume:=true', 'standalone:=true'],
            env=dict(os.environ, ROS_NAMESPACE=name))
        self.addCleanup(process.wait)
        self.addCleanup(process.terminate)
        return Node('/%s/calibration' % name, '/%s/wheel_ticks' % name, '/%s/bearings' % name)

    # Promise kept: a saved result that is damaged; it is not resumed
    def test_it_is_written_and_taken_up_and_a_corrupt_one_is_refused(self):
        node = Node()
        world = World(rospy.Time.now().to_sec() - 1000.0)
        node.feed(world, 60.0)
        wait_until(lambda: os.path.exists(self.path), 'result.yaml is there, unasked')
        last = node.estimate()

        def saved():
            with open(self.path) as file:
                return yaml.safe_load(file)

        def worst(x_stddev, y_stddev, yaw_stddev):
            targets = rospy.get_param('/calibration/converged')
            return max(max(x_stddev, y_stddev) / targets['position_stddev'],
                       yaw_stddev / targets['yaw_stddev'])

        def is_newest_or_better():  # a converged result is never replaced by a worse one
            stddev = saved()['stddev']
            return (abs(saved()['base_from_camera']['x'] - last.x_m) < 1e-6 or
                    worst(stddev['x'], stddev['y'], stddev['yaw'])
                    < worst(last.x_stddev_m, last.y_stddev_m, last.yaw_stddev_rad))
        wait_until(is_newest_or_better, 'the newest estimate is in it, or a better one')

        again = self.restarted('again', self.folder)
        fresh = World(rospy.Time.now().to_sec() - 1000.0, seed=2)
        again.drive(fresh, 1.0)
        estimate = again.wait_for(lambda e: e.bearings_used >= 5, 'bearings are used')
        self.assertLess(estimate.x_stddev_m, 2.0 * last.x_stddev_m, 'as good as before')
        self.assertLess(math.hypot(estimate.x_m - last.x_m, estimate.y_m - last.y_m), 0.01)

        broken = os.path.join(self.folder, 'broken')  # the first node goes on writing its own
        os.mkdir(broken)
        with open(os.path.join(broken, 'result.yaml'), 'w') as file:
            file.write('state: [cut sho')
        corrupt = self.restarted('corrupt', broken)
        corrupt.drive(World(rospy.Time.now().to_sec() - 1000.0, seed=3), 1.0)
        estimate = corrupt.wait_for(lambda e: e.bearings_used >= 5, 'bearings are used')
        self.assertTrue(math.isnan(estimate.x_m), 'nothing is known yet')


if __name__ == '__main__':
    rostest.rosrun('bearing_calibration', 'calibration_saved', CalibrationSavedTest)
