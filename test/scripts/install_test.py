"""The installed package works by itself: programs, configuration, launch files, nodelets, Python."""

import glob
import math
import os
import re
import subprocess
import sys
import tempfile
import unittest

import yaml

from cpp_test import REPOSITORY, buildFolder

sys.path.insert(0, os.path.join(REPOSITORY, 'tools', 'owner'))
import demo_monitor  # noqa: E402  (lies in tools)

TRUTH = {'x': 0.1 * math.cos(math.radians(30)), 'y': 0.1 * math.sin(math.radians(30)),
         'yaw': math.radians(60)}  # of the simulated camera, config/simulation.yaml
ROS_SETUPS = ['/opt/ros/noetic/setup.bash', '/opt/ros/one/setup.bash']


class Install(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = folder.name
        subprocess.run(['cmake', '--install', buildFolder()], check=True, stdout=subprocess.DEVNULL,
                       env=dict(os.environ, DESTDIR=os.path.join(folder.name, 'root')), timeout=600)
        cls.prefix = os.path.dirname(
            glob.glob(os.path.join(folder.name, 'root', '**', 'local_setup.bash'),
                      recursive=True)[0])
        cls.bag = os.path.join(folder.name, 'drive.bag')
        cls.run_('rosrun', 'bearing_calibration', 'simulate_bag', '--output', cls.bag,
                 '--only-bearings')

    @classmethod
    def run_(cls, *command, status=0):
        """In an environment that knows of the installation only, not of this build."""
        setups = [setup for setup in ROS_SETUPS if os.path.isfile(setup)]
        setups.append(os.path.join(cls.prefix, 'local_setup.bash'))
        shell = ' '.join('source %s;' % setup for setup in setups) + ' exec "$@"'
        done = subprocess.run(
            ['bash', '-c', shell, 'bash', *command], stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, universal_newlines=True, timeout=600,
            env={'PATH': '/usr/bin:/bin', 'HOME': cls.folder, 'ROS_HOSTNAME': 'localhost'})
        if done.returncode != status:
            raise AssertionError('%s ended with %d:\n%s' % (command, done.returncode, done.stdout))
        return done.stdout

    def path(self, name):
        return os.path.join(self.folder, name)

    def assertRight(self, folder):
        with open(os.path.join(folder, 'result.yaml')) as file:
            result = yaml.safe_load(file)
        for name, true in TRUTH.items():
            error = result['base_from_camera'][name] - true
            self.assertLess(abs(error), 4.0 * result['stddev'][name], name)

    def installed(self):
        """The paths of all libraries and programs."""
        libraries = glob.glob(os.path.join(self.prefix, 'lib', '*.so'))
        programs = glob.glob(os.path.join(self.prefix, 'lib', 'bearing_calibration', '*'))
        self.assertGreaterEqual(len(libraries), 4)
        self.assertGreaterEqual(len(programs), 10)
        return libraries + [path for path in programs if os.path.isfile(path)]

    def testTheInstallationIsTheOneThatIsRun(self):
        self.assertEqual(self.run_('rospack', 'find', 'bearing_calibration').strip(),
                         os.path.join(self.prefix, 'share', 'bearing_calibration'))
        for path in self.installed():
            with self.subTest(file=os.path.basename(path)):
                listed = self.run_('bash', '-c', 'ldd %s || true' % path)
                self.assertNotIn('not found', listed)
                self.assertNotIn(buildFolder(), listed)

    def testNoFunctionOfEigenIsSharedWithOtherLibraries(self):
        """Theirs are perhaps compiled for other instructions, and then allocate memory in another way."""
        for path in self.installed():
            with open(path, 'rb') as file:
                if file.read(4) != b'\x7fELF':
                    continue  # a script
            with self.subTest(file=os.path.basename(path)):
                functions = self.run_('nm', '-D', '--defined-only', path).split()
                if path.endswith('.so'):
                    self.assertTrue([name for name in functions if 'bearing_calibration' in name])
                shared = [name for name in functions if re.match('_ZNK?5Eigen', name)]
                self.assertEqual(len(shared), 0, shared[:3])

    def testCalibrateBagAndItsReport(self):
        output = self.path('out')
        robot = os.path.join(self.prefix, 'share', 'bearing_calibration', 'config', 'robots')
        self.assertGreaterEqual(len(os.listdir(robot)), 4)
        self.run_('rosrun', 'bearing_calibration', 'calibrate_bag', self.bag, '--output', output,
                  '--config', os.path.join(robot, 'simulated.yaml'))
        self.assertRight(output)
        self.run_('rosrun', 'bearing_calibration', 'calibration_report', output)
        self.assertTrue(os.path.exists(os.path.join(output, 'report.html')))

    def testFindMirror(self):
        images = self.path('images')
        scene = os.path.join(self.prefix, 'share', 'bearing_calibration', 'config', 'scene.yaml')
        self.run_('rosrun', 'bearing_calibration', 'render_scene', '--scene', scene, '--seed', '1',
                  '--output', images)
        said = self.run_('rosrun', 'bearing_calibration', 'find_mirror',
                         *glob.glob(os.path.join(images, '*.png')))
        self.assertIn('centre_u', said)

    def testALaunchFileCalibrates(self):
        output = self.path('live')
        overrides = self.path('overrides.yaml')
        with open(overrides, 'w') as file:
            yaml.safe_dump({'output': {'folder': output, 'save_period': 1.0}}, file)
        port = demo_monitor.freePort(demo_monitor.masterPorts())
        said = self.run_('roslaunch', '-p', str(port), 'bearing_calibration', 'replay.launch',
                         'bag:=' + self.bag, 'detect:=false', 'quit:=true', 'rate:=20.0',
                         'overrides:=' + overrides, 'robot:=' + os.path.join(
                             self.prefix, 'share', 'bearing_calibration', 'config', 'robots',
                             'simulated.yaml'))
        self.assertNotRegex(said, r'terminate called|Aborted|Segmentation|Traceback')
        self.assertRight(output)

    def testACatkinPackageFindsTheSameTarget(self):
        build = self.path('cpp_of_catkin')
        said = self.run_('cmake', '-S', os.path.join(REPOSITORY, 'examples', 'core_only'), '-B', build,
                         '-DPACKAGE=bearing_calibration', '-DCMAKE_PREFIX_PATH=' + self.prefix)
        self.assertIn('Configuring done', said)
        with open(os.path.join(build, 'CMakeCache.txt')) as file:
            self.assertIn('bearing_calibration_core_DIR:PATH=' + self.prefix, file.read())

    def testThePythonProgramsFindTheirMessages(self):
        self.assertIn('usage', self.run_('rosrun', 'bearing_calibration', 'start_drive', '--help'))
        self.run_('python3', '-c', 'from bearing_calibration.msg import LightBearings; '
                  'from bearing_calibration.srv import StartDrive')


if __name__ == '__main__':
    unittest.main()
