"""The worked example of doc/replay.md: nine landmarks of a real recording in one command."""

import json
import math
import os
import re
import subprocess
import tempfile
import unittest

import roslib.packages
import yaml

DATA = os.environ.get('BEARING_CALIBRATION_DATA')
NO_DATA = 'BEARING_CALIBRATION_DATA is not set: it names the folder of the real recordings'
LANDMARKS = (1, 3, 4, 6, 7, 8, 10, 12, 15)
DOCUMENT = os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..', 'doc', 'replay.md')
UNCERTAIN, DISAGREE = 4, 5
MAX_POSITION_ERROR_M = 0.06  # as litw_replay asks of the live node
MAX_YAW_ERROR_RAD = math.radians(2.5)


def run(name, *arguments):
    program = roslib.packages.find_node('bearing_calibration', name)[0]
    return subprocess.run([program] + list(arguments), stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, universal_newlines=True, timeout=600)


@unittest.skipUnless(DATA, NO_DATA)
class LitwCalibrate(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = os.path.join(folder.name, 'litw')
        source = os.path.join(DATA, 'litw')
        config = os.path.join(folder.name, 'litw.yaml')
        with open(DOCUMENT) as document, open(config, 'w') as file:
            file.write(re.search(r'```yaml\n(.*?)```', document.read(), re.DOTALL).group(1))
        bags = []
        for landmark in LANDMARKS:
            bags.append(os.path.join(folder.name, 'landmark_%d.bag' % landmark))
            run('csv_to_bag', os.path.join(source, 'odometry_calibrated.csv'),
                os.path.join(source, 'bearings.csv'), '--landmark', str(landmark),
                '--bearing-stddev', '0.033', '--output', bags[-1]).check_returncode()
        cls.done = run('calibrate_bag', *bags, '--config', config, '--output', cls.folder,
                       '--compare')
        print(cls.done.stdout)
        with open(os.path.join(source, 'truth.json')) as file:
            cls.truth = json.load(file)
        with open(os.path.join(cls.folder, 'comparison.yaml')) as file:
            cls.comparison = yaml.safe_load(file)

    def testEveryLandmarkEndsNearTheTruth(self):
        self.assertEqual([each['name'] for each in self.comparison['mounts']],
                         ['landmark_%d' % landmark for landmark in LANDMARKS])
        for each in self.comparison['mounts']:
            mount = each['base_from_camera']
            with self.subTest(landmark=each['name']):
                self.assertLessEqual(math.hypot(mount['x'] - self.truth['x_m'],
                                                mount['y'] - self.truth['y_m']),
                                     MAX_POSITION_ERROR_M)
                self.assertLessEqual(abs(math.remainder(mount['yaw'] - self.truth['yaw_rad'],
                                                        2 * math.pi)), MAX_YAW_ERROR_RAD)

    def testTogetherTheyAreTheTruth(self):
        """Within three standard deviations, those of the truth included."""
        together = self.comparison['together']
        for key, true in (('x', 'x_m'), ('y', 'y_m'), ('yaw', 'yaw_rad')):
            stddev = math.hypot(together['stddev'][key], self.truth['sigma'][true])
            self.assertLessEqual(abs(together['base_from_camera'][key] - self.truth[true]),
                                 3 * stddev, key)

    def testSaysHowSureItIs(self):
        self.assertIn(self.done.returncode, (UNCERTAIN, DISAGREE), self.done.stdout)
        self.assertRegex(self.done.stdout, r'with 24 degrees of freedom, p = ')
        self.assertIn('landmark_1: CONVERGED', self.done.stdout)


if __name__ == '__main__':
    unittest.main()
