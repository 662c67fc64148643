#!/usr/bin/env python3
"""Wrong parameters: the nodelet does not start, names all of them, and its manager lives on."""

import os
import subprocess
import sys
import unittest

import rosgraph
import rospy
import rostest
import yaml
from nodelet.srv import NodeletLoad, NodeletLoadRequest, NodeletList

CONFIG = os.path.join(os.path.dirname(__file__), '..', '..', 'config', 'simulation.yaml')
DEADLINE_S = 30.0

# What is done to the configuration, and a piece of the sentence that names it.
FAULTS = (
    (lambda c: c['wheels'].pop('separation'), 'wheels/separation is missing'),
    (lambda c: c['wheels'].update(counter_bits=12), 'wheels/counter_bits must be 8, 16, 32 or 64'),
    (lambda c: c['camera'].update(handedness=0), 'camera/handedness must be 1 or -1'),
    (lambda c: c['camera'].update(rate=7.0), 'camera/rate must be trajectory/step_rate divided by'),
    (lambda c: c['camera'].update(focal_length='4e-3'), 'camera/focal_length must be a finite number'),
    (lambda c: c['trajectory'].update(kind='waltz'), 'trajectory/kind must be one of'),
    (lambda c: c['trajectory'].update(wheel_speeed=0.1), 'wheel_speeed is not known'),
    (lambda c: c['world'].update(lights=[[0.0, 0.0]]), 'world/lights must be a list of lists of 5'),
    (lambda c: c['clock'].update(publish=True), 'clock/publish is true, but /use_sim_time is not'),
    (lambda c: c['exposure'].update(reference_value=400.0), 'exposure/reference_value must lie in'),
)


def configuration(faults):
    with open(CONFIG) as stream:
        config = yaml.safe_load(stream)
    for spoil, _ in faults:
        spoil(config)
    return config


class SimulationParametersTest(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        rospy.init_node('simulation_parameters_test')
        rospy.wait_for_service('/manager/load_nodelet', DEADLINE_S)

    def load(self, name, config):
        rospy.set_param(name, config)
        request = NodeletLoadRequest(name=name, type='bearing_calibration/SimulationNodelet')
        try:
            return rospy.ServiceProxy('/manager/load_nodelet', NodeletLoad)(request).success
        except rospy.ServiceException:
            return False  # how the manager answers when a nodelet does not load

    def nodelets(self):
        return rospy.ServiceProxy('/manager/list', NodeletList)().nodelets

    def test_standalone_ends_with_every_error(self):
        rospy.set_param('/broken', configuration(FAULTS))
        process = subprocess.run(
            ['rosrun', 'nodelet', 'nodelet', 'standalone', 'bearing_calibration/SimulationNodelet',
             '__name:=broken'],
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, universal_newlines=True,
            timeout=DEADLINE_S)
        self.assertNotEqual(process.returncode, 0, process.stdout)
        self.assertGreater(process.returncode, 0, 'ended by a signal:\n' + process.stdout)
        for _, sentence in FAULTS:
            self.assertIn(sentence, process.stdout)
        self.assertEqual(process.stdout.count('not started: '), 1, process.stdout)

    def test_manager_lives_on(self):
        self.assertFalse(self.load('/wrong', configuration(FAULTS)))
        self.assertNotIn('/wrong', self.nodelets())
        published = rosgraph.Master('simulation_parameters_test').getSystemState()[0]
        self.assertEqual([topic for topic, _ in published if topic.startswith('/wrong')], [])
        self.assertTrue(self.load('/right', configuration(())))
        self.assertIn('/right', self.nodelets())


if __name__ == '__main__':
    rostest.rosrun('bearing_calibration', 'simulation_parameters', SimulationParametersTest,
                   sys.argv)
