"""The worked example of replay.md: nine landmarks of a real recording in one command; and the
same recording as odometry."""

import json
import math
import os
import re
import subprocess
import tempfile
import unittest

import numpy
import rosbag
import roslib.packages
import yaml
from nav_msgs.msg import Odometry

DATA = os.environ.get('BEARING_CALIBRATION_DATA')
NO_DATA = 'BEARING_CALIBRATION_DATA is not set: it names the folder of the real recordings'
LANDMARKS = (1, 3, 4, 6, 7, 8, 10, 12, 15)
DOCUMENT = os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..', 'doc', 'how-to', 'replay.md')
UNCERTAIN, DISAGREE = 4, 5
MAX_POSITION_ERROR_M = 0.06  # as litw_replay asks of the live node
MAX_YAW_ERROR_RAD = math.radians(2.5)
ODOMETRY_POSITION_ERROR_M = 0.04
ODOMETRY_YAW_ERROR_RAD = math.radians(1.5)
METERS_PER_TICK = 1e-5
WHEEL_SEPARATION_M = 0.40


def run(name, *arguments):
    program = roslib.packages.find_node('bearing_calibration', name)[0]
    return subprocess.run([program] + list(arguments), stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, universal_newlines=True, timeout=600)


def writeAsOdometry(ticks_bag, odometry_bag):
    """The bag with nav_msgs/Odometry of a driver in place of the ticks: it goes by the heading at the
    middle of each step."""
    x = y = heading = 0.0
    last = None
    with rosbag.Bag(ticks_bag) as source, rosbag.Bag(odometry_bag, 'w') as target:
        for topic, message, received in source.read_messages():
            if topic != 'wheel_ticks':
                target.write(topic, message, received)
                continue
            left, right = (0, 0) if last is None else (
                METERS_PER_TICK * (message.left - last.left), METERS_PER_TICK * (message.right - last.right))
            last = message
            turn = (right - left) / WHEEL_SEPARATION_M
            x += 0.5 * (left + right) * math.cos(heading + 0.5 * turn)
            y += 0.5 * (left + right) * math.sin(heading + 0.5 * turn)
            heading += turn
            odometry = Odometry(header=message.header, child_frame_id='base_link')
            odometry.header.frame_id = 'odom'
            odometry.pose.pose.position.x, odometry.pose.pose.position.y = x, y
            odometry.pose.pose.orientation.z = math.sin(0.5 * heading)
            odometry.pose.pose.orientation.w = math.cos(0.5 * heading)
            target.write('odom', odometry, received)


def table(name):
    return numpy.genfromtxt(os.path.join(DATA, 'litw', name), delimiter=',', names=True)


def scannerSweep():
    """Seconds by which the scanner sees what is a radian further to the left later, and their standard
    deviation: least squares over the true motion, with mount and latency."""
    latency_s, half_s, largest_rad = 0.11, 0.15, 0.08
    path, landmarks, bearings = map(table, ('groundtruth_vicon.csv', 'landmarks_vicon.csv', 'bearings.csv'))

    def at(moments, values):
        return numpy.interp(moments, path['t_s'], values)

    moments = bearings['t_s'] - latency_s
    seen = (moments > half_s) & (moments < path['t_s'][-1] - half_s) & (at(moments, path['valid']) == 1.0)
    moments, azimuths, ids = moments[seen], bearings['bearing_rad'][seen], bearings['landmark_id'][seen]
    place = {landmark['landmark_id']: complex(landmark['x_m'], landmark['y_m']) for landmark in landmarks}
    yaws = numpy.unwrap(path['theta_rad'])
    turn_rate = (at(moments + half_s, yaws) - at(moments - half_s, yaws)) / (2.0 * half_s)
    base = at(moments, path['x_m']) + 1j * at(moments, path['y_m'])
    landmark_in_base = (numpy.array([place[i] for i in ids]) - base) * numpy.exp(-1j * at(moments, yaws))
    unknowns = numpy.zeros(5)  # x, y, yaw, latency beyond the above, sweep
    for _ in range(8):
        x, y, yaw, further_s, sweep = unknowns
        landmark = landmark_in_base - complex(x, y)
        expected = numpy.angle(landmark) - yaw + turn_rate * (further_s - sweep * azimuths)
        residuals = numpy.angle(numpy.exp(1j * (azimuths - expected)))
        used = abs(residuals) < largest_rad
        J = numpy.column_stack([(landmark / abs(landmark) ** 2).imag, -(landmark / abs(landmark) ** 2).real,
                                -numpy.ones_like(azimuths), turn_rate, -turn_rate * azimuths])[used]
        unknowns += numpy.linalg.lstsq(J, residuals[used], rcond=None)[0]
    covariance = numpy.var(residuals[used]) * numpy.linalg.inv(J.T @ J)
    return unknowns[4], math.sqrt(covariance[4, 4])


@unittest.skipUnless(DATA, NO_DATA)
class Recording(unittest.TestCase):

    def testItsScannerSeesOneDirectionAfterTheOther(self):
        sweep_s, stddev_s = scannerSweep()
        self.assertGreater(sweep_s, 5.0 * stddev_s)
        with open(DOCUMENT) as file:
            said = re.search(r'sees what is a radian further to the left (\d+) ms later',
                             ' '.join(file.read().split()))
        self.assertEqual(int(said.group(1)), round(1e3 * sweep_s))


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
        os.mkdir(os.path.join(folder.name, 'odometry'))
        odometry_bags = [os.path.join(folder.name, 'odometry', os.path.basename(bag)) for bag in bags]
        for bags_of_one in zip(bags, odometry_bags):
            writeAsOdometry(*bags_of_one)
        cls.by_odometry = run('calibrate_bag', *odometry_bags, '--config', config, '--set',
                              'wheels/source=odometry', '--output', cls.folder + '_odometry', '--compare')
        print(cls.by_odometry.stdout)
        with open(os.path.join(source, 'truth.json')) as file:
            cls.truth = json.load(file)
        cls.comparison = cls.comparisonIn(cls.folder)

    @staticmethod
    def comparisonIn(folder):
        with open(os.path.join(folder, 'comparison.yaml')) as file:
            return yaml.safe_load(file)

    def assertEveryLandmarkEndsNearTheTruth(self, comparison, position_m, yaw_rad):
        self.assertEqual([each['name'] for each in comparison['mounts']],
                         ['landmark_%d' % landmark for landmark in LANDMARKS])
        for each in comparison['mounts']:
            mount = each['base_from_camera']
            with self.subTest(landmark=each['name']):
                self.assertLessEqual(math.hypot(mount['x'] - self.truth['x_m'],
                                                mount['y'] - self.truth['y_m']), position_m)
                self.assertLessEqual(abs(math.remainder(mount['yaw'] - self.truth['yaw_rad'],
                                                        2 * math.pi)), yaw_rad)

    def testEveryLandmarkEndsNearTheTruth(self):
        self.assertEveryLandmarkEndsNearTheTruth(self.comparison, MAX_POSITION_ERROR_M, MAX_YAW_ERROR_RAD)

    def testByOdometryEveryLandmarkEndsNearTheTruth(self):
        comparison = self.comparisonIn(self.folder + '_odometry')
        self.assertEveryLandmarkEndsNearTheTruth(comparison, ODOMETRY_POSITION_ERROR_M,
                                                 ODOMETRY_YAW_ERROR_RAD)
        self.assertNotRegex(self.by_odometry.stdout, 'changed: ticks', 'no odometry is refused')
        for by_odometry, by_ticks in zip(comparison['mounts'], self.comparison['mounts']):
            for key in ('x', 'y', 'yaw'):  # robots.md: the same to a millimetre and 1 mrad
                self.assertAlmostEqual(by_odometry['base_from_camera'][key],
                                       by_ticks['base_from_camera'][key], delta=1e-3)

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
