#!/usr/bin/env python3
"""Without the numbers of the robot no node starts: it names all of them, and its manager lives on."""

import glob
import os
import re
import sys

import rostest
import yaml

from calibration_world import SIMULATED_ROBOT
from refused_parameters import CONFIG_FOLDER, Nodelets

# What is asked for, as robots.md and camera.md say it.
SEPARATION = {'wheels/separation'}
RADII = SEPARATION | {'wheels/left_radius', 'wheels/right_radius'}
COUNTERS = RADII | {'wheels/ticks_per_revolution'}
IMAGE = {'sensor/width', 'sensor/height', 'mirror/centre_u', 'mirror/centre_v',
         'mask/inner_radius', 'mask/outer_radius', 'mask/last_row'}
OPTICS = {'lens/focal_length', 'lens/aperture', 'lens/focus_distance', 'lens/pixel_pitch',
          'mirror/lens_to_apex', 'mirror/half_angle', 'mirror/base_radius'}

CALIBRATION = 'bearing_calibration/CalibrationNodelet', ('calibration.yaml',)
DRIVE = 'bearing_calibration/CalibrationDriveNodelet', ('calibration.yaml', 'drive.yaml')
DETECTION = 'bearing_calibration/LightDetectionNodelet', ('detection.yaml',)

CASES = (  # a node, one value that differs from its files, what it then asks for
    (CALIBRATION, ('wheels', 'source', 'ticks'), COUNTERS),
    (CALIBRATION, ('wheels', 'source', 'separate_ticks'), COUNTERS),
    (CALIBRATION, ('wheels', 'source', 'joint_states'), RADII),
    (CALIBRATION, ('wheels', 'source', 'odometry'), SEPARATION),
    (DRIVE, ('wheels', 'source', 'ticks'), COUNTERS),
    (DRIVE, ('wheels', 'source', 'odometry'), SEPARATION),
    (DETECTION, ('mirror', 'kind', 'cone'), IMAGE | OPTICS),
    (DETECTION, ('mirror', 'kind', 'other'), IMAGE),
    (DETECTION, ('mirror', 'kind', 'none'), {'sensor/width', 'sensor/height', 'mask/last_row'}),
)
REQUIRED = re.compile(r'- parameter /broken/(\S+) is required: a number of your [\w ]+ \((\w+\.md)\)')


def overlay(config, others):
    for group, values in others.items():
        config.setdefault(group, {}).update(values)
    return config


def load(path):
    with open(path) as stream:
        return yaml.safe_load(stream)


class RequiredParametersTest(Nodelets):

    def configuration(self, files, changed):
        config = {}
        for name in files:
            overlay(config, load(os.path.join(CONFIG_FOLDER, name)))
        group, name, value = changed
        config[group][name] = value
        return config

    def test_each_node_names_all_that_it_is_not_given(self):
        pages = {os.path.basename(path) for path in
                 glob.glob(os.path.join(CONFIG_FOLDER, '..', 'doc', '**', '*.md'), recursive=True)}
        for (nodelet, files), changed, names in CASES:
            with self.subTest(nodelet=nodelet, changed=changed):
                said = self.said_standalone(nodelet, self.configuration(files, changed))
                found = REQUIRED.findall(said)
                self.assertEqual({name for name, _ in found}, names, said)
                self.assertLessEqual({page for _, page in found}, pages)
                self.assertIn('%d wrong parameter(s)' % len(names), said)  # and nothing else

    def test_it_does_not_take_its_manager_down_and_starts_with_them(self):
        robot = load(SIMULATED_ROBOT)
        for number, ((nodelet, files), changed, names) in enumerate(CASES):
            with self.subTest(nodelet=nodelet, changed=changed):
                name = '/case_%d' % number
                config = self.configuration(files, changed)
                config['output'] = dict(config.get('output', {}), folder='~/.ros/bearing_calibration_test')
                self.assertFalse(self.load(nodelet, name, config))
                self.assertNotIn(name, self.nodelets())
                given = {}
                for each in names:
                    group, key = each.split('/')
                    given.setdefault(group, {})[key] = robot[group][key]
                self.assertTrue(self.load(nodelet, name, overlay(config, given)))
                self.assertIn(name, self.nodelets())


if __name__ == '__main__':
    rostest.rosrun('bearing_calibration', 'required_parameters', RequiredParametersTest, sys.argv)
