#!/usr/bin/env python3
"""What a node has found is saved though nobody asks for it: when it is CONVERGED, and when the node
ends, in whatever way it is told to; and never in the place of something better."""

import os
import shutil
import signal
import subprocess
import tempfile
import unittest
import xmlrpc.client

import rosgraph
import rosnode
import rospkg
import rospy
import rosservice
import rostest
import yaml
from bearing_calibration.msg import CalibrationEstimate
from nodelet.srv import NodeletUnload

from calibration_world import Node, SIMULATED_ROBOT, World, wait_until

OVERRIDES = os.path.join(rospkg.RosPack().get_path('bearing_calibration'), 'test', 'ros',
                         'calibration_overrides.yaml')


class CalibrationEndedTest(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        rospy.init_node('calibration_ended_test')
        cls.runs = 0

    def setUp(self):
        self.top = tempfile.mkdtemp(prefix='calibration_ended_test.')
        self.addCleanup(shutil.rmtree, self.top)
        self.folder = os.path.join(self.top, 'result')

    def started(self, *arguments):
        """A node in a namespace of its own; what its launch file prints is in `self.log`."""
        type(self).runs += 1
        self.name = 'run_%d' % self.runs
        self.log = os.path.join(self.top, self.name + '.log')
        with open(self.log, 'w') as log:
            self.process = subprocess.Popen(
                ['roslaunch', '--disable-title', 'bearing_calibration', 'calibrate.launch',
                 'robot:=' + SIMULATED_ROBOT, 'overrides:=' + OVERRIDES,
                 'result_folder:=' + self.folder] + list(arguments),
                stdout=log, stderr=subprocess.STDOUT,
                env=dict(os.environ, ROS_NAMESPACE=self.name, PYTHONUNBUFFERED='1'))
        self.addCleanup(self.end, self.process)
        names = ['/%s/%s' % (self.name, name)
                 for name in ('calibration', 'wheel_ticks', 'bearings')]
        wait_until(lambda: (names[0] + '/save') in rosservice.get_service_list(), 'it has started',
                   deadline_s=60.0)
        node = Node(*names)
        node.world = World(rospy.Time.now().to_sec() - 1000.0, seed=self.runs)
        return node

    def end(self, process):
        if process.poll() is None:
            process.send_signal(signal.SIGINT)
        process.wait(timeout=60)

    def said(self):
        with open(self.log) as file:
            return file.read().partition('started with pid')[2]

    def driveUntil(self, node, state):
        wait_until(lambda: node.drive(node.world, 2.0) and node.estimates
                   and node.estimate().state == state, 'state %d' % state, deadline_s=60.0)

    def result(self, *folders):
        with open(os.path.join(self.folder, *folders, 'result.yaml')) as file:
            return yaml.safe_load(file)

    def hasResult(self):
        return os.path.exists(os.path.join(self.folder, 'result.yaml'))

    def pid(self):
        node = rosgraph.Master('/test').lookupNode('/%s/calibration' % self.name)
        return xmlrpc.client.ServerProxy(node).getPid('/test')[2]

    def assertSaved(self, state):
        self.assertEqual(self.result()['state'], state)
        self.assertTrue(os.path.exists(os.path.join(self.folder, 'mount.urdf')))
        self.assertIn(os.path.join(self.folder, 'result.yaml'), self.said())

    def test_it_is_saved_when_it_has_converged(self):
        node = self.started('standalone:=true')
        self.driveUntil(node, CalibrationEstimate.CONVERGED)
        wait_until(self.hasResult, 'it is saved')
        wait_until(lambda: 'CONVERGED: written to' in self.said(), 'it is said')
        self.assertSaved('CONVERGED')

    # Promise kept: Ctrl-C of roslaunch
    def test_it_is_saved_when_roslaunch_is_interrupted(self):
        node = self.started()
        self.driveUntil(node, CalibrationEstimate.CONVERGING)
        self.assertFalse(self.hasResult())
        self.end(self.process)
        self.assertSaved('CONVERGING')
        self.assertEqual(self.said().count('at the end: '), 1)

    # Promise kept: SIGTERM
    def test_it_is_saved_when_the_process_is_terminated(self):
        node = self.started('standalone:=true')
        self.driveUntil(node, CalibrationEstimate.CONVERGING)
        os.kill(self.pid(), signal.SIGTERM)
        self.process.wait(timeout=60)
        self.assertSaved('CONVERGING')

    # Promise kept: rosnode kill
    def test_it_is_saved_when_the_node_is_asked_to_end(self):
        node = self.started('standalone:=true')
        self.driveUntil(node, CalibrationEstimate.CONVERGING)
        rosnode.kill_nodes(['/%s/calibration' % self.name])
        self.process.wait(timeout=60)
        self.assertSaved('CONVERGING')

    # Promise kept: a nodelet that is unloaded
    def test_it_is_saved_when_the_nodelet_is_unloaded(self):
        node = self.started()
        self.driveUntil(node, CalibrationEstimate.CONVERGING)
        unload = rospy.ServiceProxy('/%s/calibration_manager/unload_nodelet' % self.name,
                                    NodeletUnload)
        self.assertTrue(unload('/%s/calibration' % self.name).success)
        wait_until(lambda: 'at the end: ' in self.said(), 'it is said')
        self.assertSaved('CONVERGING')

    # Promise kept: an end during a pause
    def test_a_pause_does_not_hide_it(self):
        node = self.started('standalone:=true')
        self.driveUntil(node, CalibrationEstimate.CONVERGING)
        self.assertTrue(node.pause_service(True).success)
        node.wait_for(lambda e: e.state == CalibrationEstimate.PAUSED, 'paused')
        self.end(self.process)
        self.assertSaved('CONVERGING')

    # Promise kept: an end before anything was found; no file is written
    def test_nothing_found_is_said(self):
        self.started('standalone:=true')
        self.end(self.process)
        self.assertIn('nothing is saved', self.said())
        self.assertEqual(os.listdir(self.folder), [])

    # Promise kept: a new run that knows less than the saved result
    def test_a_new_run_does_not_overwrite_a_better_result(self):
        self.driveUntil(self.started('standalone:=true'), CalibrationEstimate.CONVERGED)
        self.end(self.process)
        before = self.result()
        self.assertEqual(before['state'], 'CONVERGED')
        node = self.started('standalone:=true', 'save_period:=1.0')
        self.driveUntil(node, CalibrationEstimate.CONVERGING)
        answer = node.save_service()
        self.assertTrue(answer.success, answer.message)
        self.assertIn('stays: it is CONVERGED, this one CONVERGING; this one is written to '
                      + os.path.join(self.folder, '1', 'result.yaml'), answer.message)
        self.assertEqual(self.result('1')['state'], 'CONVERGING')
        self.end(self.process)
        self.assertIn('result.yaml stays: it is CONVERGED', self.said())
        self.assertEqual(self.result(), before)

    # Promise kept: a reset between two results
    def test_after_a_reset_both_are_kept(self):
        node = self.started('standalone:=true')
        self.driveUntil(node, CalibrationEstimate.CONVERGING)
        self.assertFalse(self.hasResult())
        self.assertIn('what it had found: written to ' + os.path.join(self.folder, 'result.yaml'),
                      node.reset_service().message)
        self.assertEqual(self.result()['state'], 'CONVERGING')
        node.forget()
        self.driveUntil(node, CalibrationEstimate.CONVERGING)
        self.end(self.process)
        stamps = [self.result(*folders)['provenance']['written_at'] for folders in (['1'], [])]
        self.assertLess(*stamps)
        self.assertIn('kept in %s: the calibration was reset since'
                      % os.path.join(self.folder, '1'), self.said())


if __name__ == '__main__':
    rostest.rosrun('bearing_calibration', 'calibration_ended', CalibrationEndedTest)
