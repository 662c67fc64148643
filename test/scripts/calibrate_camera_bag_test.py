"""calibrate_bag with the images of a camera without a mirror: the bag's camera_info and /tf_static give its
rays; what is missing of them is said."""

import math
import os
import subprocess
import sys
import tempfile
import unittest

import roslib.packages
import rosbag
import yaml
from geometry_msgs.msg import TransformStamped
from tf2_msgs.msg import TFMessage

REPOSITORY = os.path.abspath(os.path.join(os.path.dirname(__file__), '..', '..'))
sys.path.insert(0, os.path.join(REPOSITORY, 'test', 'ros'))
from camera_images import FRAME, LIGHT_HEIGHT_M, PITCH, ROLL, CameraWorld, camera_info  # noqa: E402

START_S, DRIVE_S = 1000.0, 60.0
CONVERGED = 0


def transform(parent, child, quaternion):
    message = TransformStamped(child_frame_id=child)
    message.header.frame_id = parent
    rotation = message.transform.rotation
    rotation.x, rotation.y, rotation.z, rotation.w = quaternion
    return TFMessage([message])


def transforms(pitch):
    """Of the camera on its mast: pitch after roll, then z ahead."""
    sine_p, cosine_p, sine_r, cosine_r = (function(0.5 * angle) for angle in (pitch, ROLL)
                                          for function in (math.sin, math.cos))
    tilted = cosine_p * sine_r, sine_p * cosine_r, -sine_p * sine_r, cosine_p * cosine_r
    return (transform('mast', 'camera_link', tilted),
            transform('camera_link', FRAME, (-0.5, 0.5, -0.5, 0.5)))


def record(path, world, with_info=True, with_transforms=True, stated_pitch=PITCH):
    with rosbag.Bag(path, 'w') as bag:
        now = world.stamp()
        if with_transforms:
            for message in transforms(stated_pitch):
                bag.write('/tf_static', message, now)
        if with_info:
            bag.write('/camera/camera_info', camera_info(world.lens, now), now)
        while world.step < DRIVE_S * world.TICK_RATE:
            world.advance()
            bag.write('/wheel_ticks', world.ticks(), world.stamp())
            if world.step % world.TICKS_PER_BEARING == 0:
                bag.write('/camera/image_raw', world.image(), world.stamp())
    return world


class CalibrateCameraBag(unittest.TestCase):

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.bag = os.path.join(folder.name, 'drive.bag')
        self.output = os.path.join(folder.name, 'out')

    def calibrate(self, *assignments):
        program = roslib.packages.find_node('bearing_calibration', 'calibrate_bag')[0]
        robot = os.path.join(REPOSITORY, 'config', 'robots', 'simulated.yaml')
        camera = os.path.join(REPOSITORY, 'test', 'ros', 'camera_overrides.yaml')
        return subprocess.run([program, self.bag, '--config', robot, '--config', camera, '--set', 'frames/sensor=mast',
                               '--set', 'wheels/noise_independent=1.0e-6', '--output', self.output,
                               *(part for each in assignments for part in ('--set', each))],
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                              universal_newlines=True, timeout=300)

    def assertRight(self, done, world):
        self.assertEqual(done.returncode, CONVERGED, done.stdout)
        with open(os.path.join(self.output, 'result.yaml')) as file:
            result = yaml.safe_load(file)
        for key, true, stddev in zip(('x', 'y', 'yaw'), world.sensor, result['stddev'].values()):
            self.assertLess(abs(result['base_from_camera'][key] - true), 5.0 * stddev, key)

        return result

    def testFindsTheMount(self):
        world = record(self.bag, CameraWorld('fisheye', START_S))
        self.assertRight(self.calibrate(), world)

    def testEstimatesATiltThatTheTransformDoesNotState(self):
        tilt = 0.03
        world = record(self.bag, CameraWorld('fisheye', START_S), stated_pitch=PITCH - tilt)
        result = self.assertRight(self.calibrate('errors/sensor_tilt_stddev=0.035'), world)
        (block,) = [each for each in result['blocks'] if each['name'] == 'sensor_tilt']
        self.assertEqual(block['status'], 'estimated')
        for name, true in (('sensor_roll [rad]', 0.0), ('sensor_pitch [rad]', tilt),
                           ('light_height [m]', LIGHT_HEIGHT_M)):
            self.assertLess(abs(block['value'][name] - true), 5.0 * block['stddev'][name], name)
        self.assertGreater(block['value']['sensor_pitch [rad]'],
                           5.0 * block['stddev']['sensor_pitch [rad]'], 'it is told from a level one')

    def testTakesWhatWasRecordedBehindTheImages(self):
        world = record(self.bag, CameraWorld('fisheye', START_S), with_info=False, with_transforms=False)
        with rosbag.Bag(self.bag, 'a') as bag:
            for message in transforms(PITCH):
                bag.write('/tf_static', message, world.stamp())
            bag.write('/camera/camera_info', camera_info(world.lens, world.stamp()), world.stamp())
        done = self.calibrate()
        self.assertRight(done, world)
        self.assertNotIn('left out', done.stdout)

    def testSaysWhatIsMissing(self):
        for missing, kind in (('with_info', 'no camera_info'), ('with_transforms', 'no static transform')):
            with self.subTest(missing=missing):
                record(self.bag, CameraWorld('fisheye', START_S), **{missing: False})
                done = self.calibrate()
                self.assertNotEqual(done.returncode, CONVERGED)
                self.assertIn('images were left out (%s)' % kind, done.stdout)

    def testSaysWhyTheImagesShowNoLight(self):
        record(self.bag, CameraWorld('fisheye', START_S))
        done = self.calibrate('threshold/min_contrast=240.0')
        self.assertNotEqual(done.returncode, CONVERGED)
        self.assertIn('on the images: nothing stands out of the background', done.stdout)

    def testSaysHowTheLightIsThoughItIsOftenOutOfView(self):
        record(self.bag, CameraWorld('perspective', START_S))
        done = self.calibrate('sensor/saturation_level=100.0')
        self.assertIn('on the images: the light is saturated', done.stdout)


if __name__ == '__main__':
    unittest.main()
