#!/usr/bin/env python3
"""~reset, ~pause and ~save, and TF beside them."""

import math
import os
import shutil
import sys
import unittest

import rosgraph
import rospy
import rostest
import yaml
from bearing_calibration.msg import CalibrationEstimate
from tf2_msgs.msg import TFMessage

from calibration_world import Node, World, wait_until


class CalibrationServicesTest(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        rospy.init_node('calibration_services_test')
        cls.node = Node()
        cls.transforms = []
        rospy.Subscriber('/tf', TFMessage, lambda m: cls.transforms.extend(m.transforms))
        cls.folder = rospy.get_param('calibration/output/folder')

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(os.path.dirname(os.path.dirname(os.path.dirname(cls.folder))),
                      ignore_errors=True)

    def setUp(self):
        self.node.reset()
        self.world = World(rospy.Time.now().to_sec() - 1000.0)

    def drive(self, seconds):
        return self.node.feed(self.world, seconds)

    def test_reset_forgets_everything(self):
        self.drive(2.0)
        estimate = self.node.reset()
        self.assertEqual(estimate.state, CalibrationEstimate.WAITING_FOR_TICKS)
        self.assertNotEqual(estimate.x_m, estimate.x_m, 'NaN is expected')
        self.assertEqual(estimate.distance_travelled_m, 0.0)
        self.drive(1.0)  # with the stamps of before

    # Promise unharmed: a drive during a pause
    def test_pause_ignores_bearings_and_follows_the_wheels(self):
        self.drive(World.FOUND_S)
        self.assertTrue(self.node.pause_service(True).success)
        before = self.node.wait_for(lambda e: e.state == CalibrationEstimate.PAUSED, 'paused')
        self.node.drive(self.world, 2.0)
        paused = self.node.wait_for(lambda e: e.ticks_used == self.world.step, 'the wheels are followed')
        self.assertEqual(paused.bearings_used, before.bearings_used)
        self.assertEqual(paused.bearings_rejected, 0, 'a pause is no fault of the input')
        self.assertEqual((paused.x_m, paused.x_stddev_m), (before.x_m, before.x_stddev_m))
        self.assertTrue(self.node.pause_service(False).success)
        after = self.drive(2.0)
        self.assertNotEqual(after.state, CalibrationEstimate.PAUSED)
        self.assertEqual(after.bearings_gated, before.bearings_gated, 'the way driven meanwhile is known')

    # Promise refused: bearings after a reset during a pause
    def test_reset_does_not_end_a_pause(self):
        self.drive(2.0)
        self.assertTrue(self.node.pause_service(True).success)
        response = self.node.reset_service()
        self.assertIn('starts anew; it is paused as before', response.message)
        self.node.wait_for(lambda e: e.ticks_used == 0, 'reset')
        self.node.drive(self.world, 2.0)
        paused = self.node.wait_for(lambda e: e.ticks_used > 0, 'the wheels are followed')
        self.assertEqual(paused.state, CalibrationEstimate.PAUSED)
        self.assertEqual(paused.bearings_used, 0)
        self.assertTrue(self.node.pause_service(False).success)
        self.assertGreater(self.drive(2.0).bearings_used, 0)

    # Promise kept: a request to save before there is an estimate, which the answer says
    def test_save_before_an_estimate_says_why_not(self):
        response = self.node.save_service()
        self.assertFalse(response.success)
        self.assertIn('no estimate to save yet: WAITING_FOR_TICKS', response.message)

    def test_save_writes_what_the_estimate_says(self):
        self.drive(20.0)
        response = self.node.save_service()
        self.assertTrue(response.success, response.message)
        path = os.path.join(self.folder, 'result.yaml')
        self.assertIn(path, response.message)
        with open(path) as file:
            result = yaml.safe_load(file)
        mount, paper = result['base_from_camera'], result['paper_state']
        estimate = self.node.wait_for(lambda e: (e.x_m, e.y_m) == (mount['x'], mount['y']),
                                      'the estimate that was saved')
        self.assertEqual(result['base_frame'], 'base_link')
        self.assertEqual(result['camera_frame'], 'camera')
        self.assertEqual(mount['yaw'], estimate.yaw_rad)
        self.assertEqual(sum(result['covariance_x_y_yaw'], []), list(estimate.covariance_x_y_yaw))
        self.assertEqual([paper[key] for key in ('D_m', 'theta_rad', 'phi_rad', 'rho_m', 'psi_rad')],
                         [estimate.D_m, estimate.theta_rad, estimate.phi_rad, estimate.rho_m,
                          estimate.psi_rad])
        self.assertEqual(sum(paper['covariance_D_theta_phi_rho_psi'], []),
                         list(estimate.covariance_D_theta_phi_rho_psi))
        self.assertEqual(result['state'], estimate.state_text)
        self.assertEqual(result['stamp_ns'], estimate.header.stamp.to_nsec())
        self.assertEqual(result['not_estimated']['z_m'], 0.3)
        self.assertEqual(result['provenance']['wheel_separation_m'], 0.25)
        self.assertEqual(result['parameters']['wheels/separation'], 0.25)
        forms = {'mount.urdf', 'mount.urdf.xacro', 'static_transform.launch',
                 'kalibr_camchain.yaml', 'vins_extrinsics.yaml', 'diff_drive_controller.yaml'}
        trusted = result['state'] in ('CONVERGED', 'CONVERGING')
        files = {name for name in os.listdir(self.folder)
                 if os.path.isfile(os.path.join(self.folder, name))}
        self.assertEqual(files, {'result.yaml', '.bearing_calibration'}
                         | (forms if trusted else set()), 'nothing else is left')

    # Promise kept: a folder that cannot be written, which the answer names
    def test_save_says_why_it_cannot_write(self):
        other = Node('/bad/calibration', wheels='/bad/wheel_ticks', bearings='/bad/bearings')
        other.feed(self.world, World.FOUND_S)
        other.wait_for(lambda e: not math.isnan(e.x_m), 'an estimate')
        folder = rospy.get_param('/bad/calibration/output/folder')
        parent = os.path.dirname(folder)
        shutil.rmtree(parent)
        with open(parent, 'w'):
            self.addCleanup(os.remove, parent)
        response = other.save_service()
        self.assertFalse(response.success)
        self.assertIn('Not a directory', response.message)
        self.assertIn(folder, response.message)

    def test_tf_goes_on_without_the_light_and_ends_with_the_estimate(self):
        self.assertEqual(self.transforms_after(rospy.Time.now()), [], 'no estimate yet')
        began = rospy.Time.now()
        self.drive(World.FOUND_S)
        alone = rospy.Time.now()  # no input any more
        wait_until(lambda: len(self.transforms_after(alone)) > 20, 'TF goes on')
        self.assert_current(self.transforms_after(began), began)

        self.node.reset()
        self.assertEqual(self.transforms_after(rospy.Time.now()), [], 'no estimate any more')
        again = rospy.Time.now()
        self.world = World(self.world.start_stamp_s)  # the stamps of the first drive
        self.drive(World.FOUND_S)
        wait_until(lambda: len(self.transforms_after(again)) > 10, 'TF of the new estimate')
        self.assert_current(self.transforms_after(began), began)

        published, _, _ = rosgraph.Master(rospy.get_name()).getSystemState()
        self.assertNotIn('/tf_static', [topic for topic, _ in published])

    def transforms_after(self, moment):
        """Of the last while, which is at least a second: ~estimate comes once a second."""
        if not rospy.Time.now() - moment > rospy.Duration(1.0):
            count = len(self.node.estimates)
            wait_until(lambda: len(self.node.estimates) >= count + 2, 'a second')
        return [t for t in self.transforms if t.header.stamp > moment]

    def assert_current(self, transforms, began):
        stamps = [t.header.stamp for t in transforms]
        self.assertTrue(all(a < b for a, b in zip(stamps, stamps[1:])), stamps)
        self.assertTrue(began < stamps[0] and stamps[-1] <= rospy.Time.now(), stamps)
        # the median does not mind a busy machine
        period_s = sorted((b - a).to_sec() for a, b in zip(stamps, stamps[1:]))[len(stamps) // 2]
        self.assertAlmostEqual(period_s, 0.1, delta=0.05)
        self.assertEqual({(t.header.frame_id, t.child_frame_id) for t in transforms},
                         {('base_link', 'camera_calibrated')})


if __name__ == '__main__':
    rostest.rosrun('bearing_calibration', 'calibration_services', CalibrationServicesTest, sys.argv)
