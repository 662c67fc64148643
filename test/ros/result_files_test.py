"""The result's files in the programs that they are for: check_urdf, xacro, roslaunch and tf2."""

import math
import os
import shutil
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree as ElementTree

import roslib.packages
import rospy
import tf2_ros
import yaml

REPOSITORY = os.path.abspath(os.path.join(os.path.dirname(__file__), '..', '..'))
sys.path.insert(0, os.path.join(REPOSITORY, 'tools', 'owner'))
import demo_monitor  # noqa: E402  (lies in tools)
from calibration_world import SIMULATED_ROBOT, World, recordBag  # noqa: E402

XACRO = '{http://www.ros.org/wiki/xacro}'
MICRO = 2e-6  # the forms are rounded to 1e-6


class ResultFiles(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = os.path.join(folder.name, 'out')
        bag = recordBag(os.path.join(folder.name, 'drive.bag'), World(1000.0))
        program = roslib.packages.find_node('bearing_calibration', 'calibrate_bag')[0]
        subprocess.run([program, bag, '--output', cls.folder, '--config', SIMULATED_ROBOT,
                        '--set', 'mount/z=0.35', '--set', 'mount/roll=0.02',
                        '--set', 'mount/pitch=-0.03'], check=True,
                       stdout=subprocess.DEVNULL, timeout=600)
        with open(cls.path('result.yaml')) as file:
            cls.mount = yaml.safe_load(file)['base_from_camera']

    @classmethod
    def path(cls, name):
        return os.path.join(cls.folder, name)

    def assertJoint(self, joint):
        self.assertEqual(joint.find('parent').get('link'), 'base_link')
        self.assertEqual(joint.find('child').get('link'), 'camera')
        origin = [float(word) for key in ('xyz', 'rpy')
                  for word in joint.find('origin').get(key).split()]
        for value, expected in zip(origin, (self.mount['x'], self.mount['y'], 0.35, 0.02, -0.03,
                                            self.mount['yaw'])):
            self.assertAlmostEqual(value, expected, delta=MICRO)

    def testCheckUrdfTakesTheJoint(self):
        done = subprocess.run(['check_urdf', self.path('mount.urdf')], stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, universal_newlines=True, timeout=600)
        self.assertEqual(done.returncode, 0, done.stdout)
        self.assertIn('root Link: base_link has 1 child', done.stdout)
        self.assertJoint(ElementTree.parse(self.path('mount.urdf')).find('joint'))

    def testTheXacroIsXmlWithItsArguments(self):
        macro = ElementTree.parse(self.path('mount.urdf.xacro')).find(XACRO + 'macro')
        self.assertEqual(macro.get('name'), 'bearing_calibration_mount')
        names = [word.split(':=')[0] for word in macro.get('params').split()]
        self.assertEqual(names, ['parent', 'child', 'z', 'roll', 'pitch'])
        self.assertEqual(macro.find('joint').find('parent').get('link'), '${parent}')

    @unittest.skipUnless(shutil.which('xacro'), 'xacro is not installed: the macro is not expanded')
    def testXacroExpandsTheMacro(self):
        robot = self.path('robot.xacro')
        with open(robot, 'w') as file:
            file.write('<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">'
                       '<xacro:include filename="mount.urdf.xacro"/>'
                       '<xacro:bearing_calibration_mount/></robot>')
        done = subprocess.run(['xacro', robot], check=True, stdout=subprocess.PIPE, timeout=600)
        self.assertJoint(ElementTree.fromstring(done.stdout).find('joint'))

    def testTheLaunchFilePublishesTheTransform(self):
        port = demo_monitor.freePort(demo_monitor.masterPorts())
        os.environ['ROS_MASTER_URI'] = 'http://localhost:%d' % port
        launch = subprocess.Popen(['roslaunch', '-p', str(port),
                                   self.path('static_transform.launch')],
                                  stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.addCleanup(launch.wait)
        self.addCleanup(launch.terminate)
        rospy.init_node('result_files_test', disable_signals=True)
        buffer = tf2_ros.Buffer()
        tf2_ros.TransformListener(buffer)
        found = buffer.lookup_transform('base_link', 'camera', rospy.Time(0),
                                        rospy.Duration(30.0)).transform
        # Rz(yaw) Ry(pitch) Rx(roll), by half angles
        cr, sr = math.cos(0.01), math.sin(0.01)
        cp, sp = math.cos(-0.015), math.sin(-0.015)
        cy, sy = math.cos(self.mount['yaw'] / 2), math.sin(self.mount['yaw'] / 2)
        expected = (self.mount['x'], self.mount['y'], 0.35, sr * cp * cy - cr * sp * sy,
                    cr * sp * cy + sr * cp * sy, cr * cp * sy - sr * sp * cy,
                    cr * cp * cy + sr * sp * sy)
        values = (found.translation.x, found.translation.y, found.translation.z, found.rotation.x,
                  found.rotation.y, found.rotation.z, found.rotation.w)
        for value, wanted in zip(values, expected):
            self.assertAlmostEqual(value, wanted, delta=MICRO)
        rospy.signal_shutdown('the test ends')


if __name__ == '__main__':
    unittest.main()
