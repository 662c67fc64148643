#!/usr/bin/env python3
"""The right mount, whatever the parametrisation, the source of the wheels' readings and
the way the nodelet was started; and what is published on the way."""

import math
import subprocess
import sys
import time
import unittest

import numpy
import rosgraph
import rospy
import rostest
from bearing_calibration.msg import CalibrationEstimate, PredictedBearing

from calibration_world import DEADLINE_S, Node, World, errors_in_stddevs, wait_until, wrap

CHI_SQUARE_3 = 25.0  # more comes about in 1.5 of 100 000 honest estimates
LINES_ON_A_SCREEN = 42  # of a terminal on half of a screen


class CalibrationEstimateTest(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        rospy.init_node('calibration_estimate_test')
        wheels = rospy.get_param('~wheels')
        cls.reading = getattr(World, rospy.get_param('~reading'))
        cls.node = Node(wheels=wheels)
        cls.first_estimate = cls.node.estimate()
        cls.predictions = []
        rospy.Subscriber('calibration/predicted_bearing', PredictedBearing, cls.predictions.append)
        cls.world = World(rospy.Time.now().to_sec() - 1000.0)
        start, before = time.monotonic(), len(cls.node.estimates)
        cls.node.feed(cls.world, 60.0, wheels=cls.reading)
        cls.estimate = cls.node.wait_for(
            lambda e: e.ticks_used == 3000 and e.bearings_used + e.bearings_gated == 600,
            'all 3000 wheel readings and 600 bearings are in')
        cls.elapsed_s = time.monotonic() - start
        cls.estimate_count = len(cls.node.estimates) - before

    def test_says_nothing_before_it_knows_anything(self):
        estimate = self.first_estimate
        self.assertEqual(estimate.state, CalibrationEstimate.WAITING_FOR_TICKS)
        self.assertEqual('WAITING_FOR_TICKS', estimate.state_text)
        for value in (estimate.x_m, estimate.yaw_stddev_rad, estimate.rho_m,
                      estimate.covariance_x_y_yaw[8]):
            self.assertTrue(math.isnan(value), estimate)

    def test_finds_the_mount(self):
        self.assertIn(self.estimate.state,
                      (CalibrationEstimate.CONVERGED, CalibrationEstimate.CONVERGING))
        for quantity, error in zip(('x', 'y', 'yaw'),
                                   errors_in_stddevs(self.estimate, self.world)):
            self.assertLess(error, 3.0, '%s is off by %.2f standard deviations\n%s'
                            % (quantity, error, self.estimate))
        error = numpy.array([self.estimate.x_m, self.estimate.y_m, self.estimate.yaw_rad]) - self.world.sensor
        covariance = numpy.reshape(self.estimate.covariance_x_y_yaw, (3, 3))
        self.assertLess(error @ numpy.linalg.solve(covariance, error), CHI_SQUARE_3, self.estimate)
        self.assertIn('a light 3 m ahead is placed within', self.estimate.quality[0])
        self.assertLess(self.estimate.x_stddev_m, 0.02)
        self.assertLess(self.estimate.y_stddev_m, 0.02)
        self.assertLess(self.estimate.yaw_stddev_rad, math.radians(2.0))

    def test_paper_state_is_the_same_knowledge(self):
        e = self.estimate
        self.assertAlmostEqual(e.rho_m * math.cos(e.phi_rad), e.x_m, delta=1e-9)
        self.assertAlmostEqual(e.rho_m * math.sin(e.phi_rad), e.y_m, delta=1e-9)
        self.assertAlmostEqual(wrap(e.phi_rad + e.psi_rad - e.yaw_rad), 0.0, delta=1e-9)
        distance = math.hypot(self.world.x - self.world.light[0], self.world.y - self.world.light[1])
        self.assertAlmostEqual(e.D_m, distance, delta=3.0 * math.sqrt(
            e.covariance_D_theta_phi_rho_psi[0]))

    def test_counts_the_way(self):
        cycle = World.STRAIGHT_S + World.SPIN_S
        straight_s = 6 * World.STRAIGHT_S + max(0.0, 60.0 - 6 * cycle)
        self.assertAlmostEqual(self.estimate.distance_travelled_m, 0.2 * straight_s, delta=0.02)
        self.assertAlmostEqual(self.estimate.rotation_travelled_rad,
                               (60.0 - straight_s) * 0.2 / 0.125, delta=0.2)
        self.assertEqual(self.estimate.ticks_rejected, 0)
        self.assertEqual(self.estimate.bearings_rejected, 0)
        self.assertEqual(self.estimate.rejections, '')

    def test_pose_and_transform_say_what_the_estimate_says(self):
        stamp = self.estimate.header.stamp
        pose = wait_until(lambda: [p for p in self.node.poses if p.header.stamp == stamp],
                          'a pose with the stamp of the estimate')[0]
        transform = wait_until(lambda: [t for t in self.node.transforms
                                        if t.header.stamp == stamp], 'a transform')[0]
        self.assertEqual(pose.header.frame_id, 'base_link')
        self.assertEqual(transform.header.frame_id, 'base_link')
        self.assertEqual(transform.child_frame_id, 'camera')
        self.assertEqual(pose.pose.pose.orientation, transform.transform.rotation)
        position = pose.pose.pose.position
        self.assertEqual((position.x, position.y, position.z),
                         (self.estimate.x_m, self.estimate.y_m, 0.3))
        translation = transform.transform.translation
        self.assertEqual((translation.x, translation.y, translation.z),
                         (position.x, position.y, position.z))
        # roll 0.02, pitch -0.01 (calibration.yaml of this test), then yaw: q_yaw q_pitch q_roll
        half = [0.02 / 2, -0.01 / 2, self.estimate.yaw_rad / 2]
        (cr, cp, cy), (sr, sp, sy) = map(math.cos, half), map(math.sin, half)
        expected = (sr * cp * cy - cr * sp * sy, cr * sp * cy + sr * cp * sy,
                    cr * cp * sy - sr * sp * cy, cr * cp * cy + sr * sp * sy)
        rotation = transform.transform.rotation
        for value, reference in zip((rotation.x, rotation.y, rotation.z, rotation.w), expected):
            self.assertAlmostEqual(value, reference, delta=1e-12)

    def test_covariance_has_the_configured_part_too(self):
        stamp = self.estimate.header.stamp
        pose = wait_until(lambda: [p for p in self.node.poses if p.header.stamp == stamp],
                          'a pose with the stamp of the estimate')[0]
        expected = [0.0] * 36
        axes = (0, 1, 5)
        for i, row in enumerate(axes):
            for j, column in enumerate(axes):
                expected[6 * row + column] = self.estimate.covariance_x_y_yaw[3 * i + j]
        expected[14], expected[21], expected[28] = 0.05**2, 0.03**2, 0.04**2
        for index, (value, reference) in enumerate(zip(pose.pose.covariance, expected)):
            self.assertAlmostEqual(value, reference, delta=1e-12, msg='entry %d' % index)

    def test_each_pose_has_a_later_stamp(self):
        stamps = [pose.header.stamp for pose in self.node.poses]
        self.assertGreater(len(stamps), 20)
        self.assertTrue(all(a < b for a, b in zip(stamps, stamps[1:])), stamps)

    def test_keeps_to_the_rate(self):
        max_rate = rospy.get_param('calibration/output/max_rate')
        # with the 1 Hz of the timer, the first one, and what lies in queues
        most = (max_rate + 1.0) * self.elapsed_s + 5
        self.assertLess(self.estimate_count, most)
        self.assertGreater(self.estimate_count, 2.0 * self.elapsed_s, 'the timer alone makes 1 Hz')

    def test_predicts_the_next_bearing(self):
        last = wait_until(lambda: self.predictions and
                          self.predictions[-1].header.stamp == self.world.stamp() and
                          self.predictions[-1], 'a prediction for the last wheel reading')
        self.assertGreater(len(self.predictions), 100)
        self.assertEqual(last.header.frame_id, 'camera')
        # 5 standard deviations, and a thousandth where the prediction is very sure of itself
        bound = 5.0 * math.sqrt(last.azimuth_variance) + 1e-3
        self.assertAlmostEqual(wrap(last.azimuth - self.world.azimuth()), 0.0, delta=bound)

    def test_a_late_echo_fits_the_screen(self):
        echo = subprocess.run(['rostopic', 'echo', '-n1', '--noarr', self.node.name + '/estimate'],
                              stdout=subprocess.PIPE, timeout=DEADLINE_S, check=True)
        lines = echo.stdout.decode().splitlines()
        self.assertLessEqual(len(lines), LINES_ON_A_SCREEN, echo.stdout.decode())
        self.assertTrue(any('x_m:' in line for line in lines), lines)

    def test_tf_is_off_unless_asked_for(self):
        wanted = rospy.get_param('calibration/output/publish_tf')
        published, _, _ = rosgraph.Master(rospy.get_name()).getSystemState()
        topics = [topic for topic, _ in published]
        self.assertEqual('/tf' in topics, wanted, topics)


if __name__ == '__main__':
    rostest.rosrun('bearing_calibration', 'calibration_estimate', CalibrationEstimateTest, sys.argv)
