"""simulate_bag and calibrate_bag on raw images: from the bag of a camera to the mount."""

import math
import os
import re
import resource
import signal
import subprocess
import sys
import tempfile
import unittest

import rosbag
import roslib.packages
import yaml

REPOSITORY = os.path.abspath(os.path.join(os.path.dirname(__file__), '..', '..'))
sys.path.insert(0, os.path.join(REPOSITORY, 'test', 'ros'))
from calibration_world import SIMULATED_ROBOT  # noqa: E402  (lies beside the tests of the node)
from mirror_images import png_of  # noqa: E402

TRUTH = (0.1 * math.cos(math.radians(30)), 0.1 * math.sin(math.radians(30)), math.radians(60))
CHI_SQUARE_3_AT_999 = 16.27
IMAGE_SECONDS = 40
IMAGE_BYTES = 640 * 480 * 10 * IMAGE_SECONDS


def program(name):
    return roslib.packages.find_node('bearing_calibration', name)[0]


class SimulateBag(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = folder.name

    def path(self, name):
        return os.path.join(self.folder, name)

    def simulate(self, name, *arguments):
        done = subprocess.run([program('simulate_bag'), '--output', self.path(name), *arguments],
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                              universal_newlines=True, timeout=600)
        self.assertEqual(done.returncode, 0, done.stderr)
        return self.path(name)

    @staticmethod
    def calibrateBag(*arguments, config=('--config', SIMULATED_ROBOT)):
        return subprocess.run([program('calibrate_bag'), *config, *arguments],
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                              universal_newlines=True, timeout=600)

    def calibrate(self, bag):
        """Exit status, text and result, in a folder of the bag's own: a better result stays."""
        output = bag + '_out'
        done = self.calibrateBag(bag, '--output', output)
        with open(os.path.join(output, 'result.yaml')) as file:
            return done, yaml.safe_load(file)

    def assertRight(self, result):
        squared = sum(((result['base_from_camera'][key] - true) / result['stddev'][key])**2
                      for key, true in zip(('x', 'y', 'yaw'), TRUTH))
        # by the axes alone, at least a third of the true chi-square
        self.assertLess(squared, 3 * CHI_SQUARE_3_AT_999, result)

    def compressed(self, path, name):
        """The bag with its images as png."""
        with rosbag.Bag(path) as bag, rosbag.Bag(self.path(name), 'w') as output:
            for topic, message, received in bag:
                if topic.endswith('camera/image_raw'):
                    topic, message = topic + '/compressed', png_of(message)
                output.write(topic, message, received)
        return self.path(name)

    def testCompressedImagesLeadToTheSameBits(self):
        raw = self.simulate('raw.bag', '--seconds', '5')
        compressed = self.compressed(raw, 'compressed.bag')
        looks = []  # there are some whatever comes of so short a drive
        for arguments in ((raw,), (compressed,), (compressed, '--image-topic', 'camera/image_raw')):
            output = self.path('out_%d' % len(looks))
            done = self.calibrateBag(*arguments, '--output', output)
            images_file = os.path.join(output, 'images.csv')
            self.assertTrue(os.path.exists(images_file), done.stdout)
            with open(images_file) as file:
                looks.append(file.read())
        self.assertGreater(looks[0].count('\n'), 40)
        self.assertEqual(looks[1], looks[0])
        self.assertEqual(looks[2], looks[0])

    def testBearingsLeadToTheMount(self):
        bag = self.simulate('bearings.bag', '--only-bearings')
        done, result = self.calibrate(bag)
        self.assertEqual(done.returncode, 0, done.stdout)
        self.assertRight(result)
        self.assertEqual(result['record']['rejections'], '', 'the simulated sensor is an honest one')

    def testImagesLeadToTheMountInBoundedMemory(self):
        bag = self.simulate('images.bag', '--seconds', str(IMAGE_SECONDS))
        self.assertGreater(os.path.getsize(bag), IMAGE_BYTES)
        done, result = self.calibrate(bag)
        self.assertIn(done.returncode, (0, 4), done.stdout)
        self.assertIn('(%d images)' % (10 * IMAGE_SECONDS), done.stdout)
        self.assertRight(result)
        with open(os.path.join(bag + '_out', 'optics.yaml')) as file:
            mirror = yaml.safe_load(file)['mirror']
        self.assertLess(mirror['half_angle_stddev'], 0.013, 'half of what is configured')
        self.assertLess(abs(mirror['half_angle'] - math.radians(52.5)),
                        3.0 * mirror['half_angle_stddev'])
        if os.environ.get('ASAN_OPTIONS'):
            self.skipTest('with the address sanitizer the memory is not that of the program alone')
        # the largest of this test's children so far, the renderer among them
        used_bytes = 1024 * resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
        self.assertLess(used_bytes, 1.2 * IMAGE_BYTES)

    def testImagesOfAnotherSizeAreNamed(self):
        bag = self.simulate('few.bag', '--seconds', '2')
        done = self.calibrateBag(bag, '--output', self.path('wrong'), '--set', 'sensor/width=320',
                                 '--set', 'mirror/centre_u=159.5', '--set', 'mask/outer_radius=150.0')
        self.assertEqual(done.returncode, 1, done.stdout)
        self.assertIn('WAITING_FOR_LIGHT', done.stdout)
        self.assertRegex(done.stdout, r'images were left out \(.*640')

    def testWhatIsNotKnownOfRobotAndCameraIsNamed(self):
        """A bag of bearings needs no camera; a bag of images names all that is not given of it."""
        wheels = {'wheels/' + name for name in
                  ('separation', 'left_radius', 'right_radius', 'ticks_per_revolution')}
        camera = {'sensor/width', 'sensor/height', 'lens/focal_length', 'lens/aperture',
                  'lens/focus_distance', 'lens/pixel_pitch', 'mirror/lens_to_apex',
                  'mirror/half_angle', 'mirror/base_radius', 'mirror/centre_u', 'mirror/centre_v',
                  'mask/inner_radius', 'mask/outer_radius', 'mask/last_row'}
        with open(SIMULATED_ROBOT) as file:
            known = [word for name, value in yaml.safe_load(file)['wheels'].items()
                     for word in ('--set', 'wheels/%s=%s' % (name, value))]
        images = self.simulate('unknown.bag', '--seconds', '2')
        for arguments, status, names in (
                ((images,), 2, wheels), ((images, *known), 1, camera),
                ((images, *known, '--set', 'mirror/kind=other'), 1,
                 {name for name in camera if not re.match('lens/|mirror/[^c]', name)})):
            with self.subTest(arguments=arguments[1:]):
                done = self.calibrateBag(*arguments, '--output', self.path('unknown'), config=())
                self.assertEqual(done.returncode, status, done.stdout)
                self.assertEqual(set(re.findall(r'parameter (\S+) is required', done.stdout)), names)
                self.assertIn('%d wrong parameter(s)' % len(names), done.stdout)
        bearings = self.simulate('known.bag', '--seconds', '2', '--only-bearings')
        done = self.calibrateBag(bearings, *known, '--output', self.path('known'), config=())
        self.assertNotIn('required', done.stdout)

    def testImagesHaveTheFaultsOfTheirScene(self):
        with open(self.path('faults.yaml'), 'w') as file:
            yaml.safe_dump({'faults': {'stamp_latency': 0.05, 'occlusions': [[0.45, 0.5]]}}, file)
        images = []
        for arguments in ((), ('--scene', self.path('faults.yaml'))):
            with rosbag.Bag(self.simulate('faults.bag', '--seconds', '1', *arguments)) as bag:
                images.append([message for _, message, _ in bag.read_messages('/camera/image_raw')])
        for i, (plain, faulty) in enumerate(zip(*images)):
            self.assertAlmostEqual((faulty.header.stamp - plain.header.stamp).to_sec(), 0.05)
            self.assertEqual(max(faulty.data) < max(plain.data), i >= 5, i)

    def testTheSameSeedGivesTheSameBag(self):
        def messages(seed):
            with rosbag.Bag(self.simulate('seed.bag', '--only-bearings', '--seconds', '2', '--seed',
                                          seed)) as bag:
                return [(topic, str(message)) for topic, message, _ in bag.read_messages()]
        self.assertEqual(messages('5'), messages('5'))
        self.assertNotEqual(messages('5'), messages('6'))

    def testAFullDiskIsNamedAndNoHalfABagIsLeftBehind(self):
        def limit():
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)  # writing fails, as on a full disk
            resource.setrlimit(resource.RLIMIT_FSIZE, (5000, 5000))
        bag = self.path('full.bag')
        done = subprocess.run([program('simulate_bag'), '--output', bag, '--only-bearings', '--seconds', '2'],
                              stderr=subprocess.PIPE, universal_newlines=True, timeout=600, preexec_fn=limit)
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertIn(bag + ' cannot be written', done.stderr)
        self.assertEqual([name for name in os.listdir(self.folder) if 'full' in name], [])

    def testWrongArgumentsAreSaid(self):
        for arguments in ([], ['--output', 'x', '--seconds', '0'], ['--output', 'x', '--seed=-1']):
            done = subprocess.run([program('simulate_bag')] + arguments, stderr=subprocess.PIPE,
                                  universal_newlines=True, timeout=600)
            self.assertEqual(done.returncode, 2)
            self.assertIn('see --help', done.stderr)


if __name__ == '__main__':
    unittest.main()
