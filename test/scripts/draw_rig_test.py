"""draw_rig as its user meets it: the numbers of a rig in, its sizes and a picture out."""

import math
import os
import re
import subprocess
import tempfile
import unittest

import roslib.packages
import yaml

REPOSITORY = os.path.abspath(os.path.join(os.path.dirname(__file__), '..', '..'))
SIMULATED = os.path.join(REPOSITORY, 'config', 'robots', 'simulated.yaml')
PAGE = os.path.join(REPOSITORY, 'doc', 'tutorials', 'hardware.md')
SHOWN = os.path.join(REPOSITORY, 'doc', 'images', 'rig.png')
LARGEST_BYTES = 300000


def reflectedHeight(config, image_radius_px, distance_m):
    """Height over the apex of a pixel's ray, by the law of reflection with vectors (right, up)."""
    lens, mirror = config['lens'], config['mirror']
    f, d = lens['focal_length'], lens['focus_distance']
    ray = (image_radius_px * lens['pixel_pitch'], f * d / (d - f))
    along = (math.sin(mirror['half_angle']), math.cos(mirror['half_angle']))
    # lens + s ray = apex + t along
    determinant = ray[0] * along[1] - ray[1] * along[0]
    t = -ray[0] * mirror['lens_to_apex'] / determinant
    hit = (t * along[0], t * along[1])
    dot = ray[0] * along[0] + ray[1] * along[1]
    out = (2 * dot * along[0] - ray[0], 2 * dot * along[1] - ray[1])
    return hit[1] + (distance_m - hit[0]) * out[1] / out[0]


class DrawRig(unittest.TestCase):

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        self.picture = os.path.join(self.folder, 'rig.png')
        self.program = roslib.packages.find_node('bearing_calibration', 'draw_rig')[0]
        with open(SIMULATED) as file:
            self.config = yaml.safe_load(file)

    def draw(self, *files):
        arguments = [argument for file in files for argument in ('--config', file)]
        return subprocess.run([self.program] + arguments + ['--output', self.picture], stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, universal_newlines=True, timeout=600)

    def write(self, config):
        path = os.path.join(self.folder, 'robot.yaml')
        with open(path, 'w') as file:
            file.write(config if isinstance(config, str) else yaml.safe_dump(config))
        return path

    def assertRefused(self, done, *lines):
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertEqual(done.stdout, '')
        self.assertFalse(os.path.exists(self.picture))
        for line in lines:
            self.assertIn(line, done.stderr)
        self.assertNotIn('Traceback', done.stderr)

    def testWhatThePageShows(self):
        done = self.draw(SIMULATED)
        self.assertEqual(done.returncode, 0, done.stderr)
        with open(PAGE) as file:
            self.assertIn('```\n' + done.stdout + '```\n', file.read())
        for path in (self.picture, SHOWN):
            with open(path, 'rb') as file:
                picture = file.read()
            self.assertTrue(picture.startswith(b'\x89PNG'), path)
            self.assertLess(len(picture), LARGEST_BYTES, path)

    def testSeesALightWhereTheLawOfReflectionSays(self):
        # upper limit: the last row, nearer than the rim; lower limit: where the camera sees itself
        done = self.draw(SIMULATED)
        self.assertEqual(done.returncode, 0, done.stderr)
        lights = re.findall(r'a light ([\d.]+) m away: (\S+) to (\S+) m', done.stdout)
        self.assertEqual(len(lights), 4)
        for distance, low, high in lights:
            for shown, radius in ((low, 40.0), (high, 239.5)):
                expected = reflectedHeight(self.config, radius, float(distance))
                self.assertAlmostEqual(float(shown), expected, delta=0.0051)

    def testTheRimLimitsASmallMirror(self):
        self.config['mirror']['base_radius'] = 0.02
        done = self.draw(self.write(self.config))
        self.assertEqual(done.returncode, 0, done.stderr)
        lens, mirror = self.config['lens'], self.config['mirror']
        base_m = mirror['lens_to_apex'] + 0.02 / math.tan(mirror['half_angle'])
        f, d = lens['focal_length'], lens['focus_distance']
        rim = f * d / (d - f) / lens['pixel_pitch'] * 0.02 / base_m
        self.assertIn('a circle of %.0f px' % rim, done.stdout)
        high = float(re.search(r'a light 3.0 m away: \S+ to (\S+) m', done.stdout).group(1))
        self.assertAlmostEqual(high, reflectedHeight(self.config, rim, 3.0), delta=0.0051)

    def testDegreesAndFurtherFilesAreReadAsRoslaunchReadsThem(self):
        with open(SIMULATED) as file:
            text = re.sub(r'half_angle: \S+', 'half_angle: 0.8', file.read())
        first = self.write(text)
        second = os.path.join(self.folder, 'mirror.yaml')
        with open(second, 'w') as file:
            file.write('mirror: {half_angle: deg(52.5)}\n')
        self.assertEqual(self.draw(first, second).stdout, self.draw(SIMULATED).stdout)

    def testTakesWhatTheDetectionTakes(self):
        self.config['lens']['focus_distance'] = math.inf
        self.config['mask']['inner_radius'] = 0
        done = self.draw(self.write(self.config))
        self.assertEqual(done.returncode, 0, done.stderr)
        lens, mirror = self.config['lens'], self.config['mirror']
        base_m = mirror['lens_to_apex'] + mirror['base_radius'] / math.tan(mirror['half_angle'])
        rim = lens['focal_length'] / lens['pixel_pitch'] * mirror['base_radius'] / base_m
        self.assertIn('a circle of %.0f px' % rim, done.stdout)
        self.assertIn('elevations of -14.9 to', done.stdout)  # a pixel beside the apex: 90 deg - 2 x 52.5 deg

    def testNamesAllThatIsMissingOrWrong(self):
        del self.config['lens']['focal_length']
        del self.config['mask']
        self.config['mirror']['half_angle'] = -0.9
        self.config['mirror']['base_radius'] = 'wide'
        self.config['sensor']['width'] = True
        self.config['lens']['pixel_pitch'] = '5e-6'
        self.config['mirror']['kind'] = 'cone'
        path = self.write(self.config)
        self.assertRefused(self.draw(path), path + ': lens/focal_length is missing',
                           path + ': mask/inner_radius is missing', 'mirror/half_angle is -0.9',
                           'mirror/base_radius is wide', 'sensor/width is True',
                           'lens/pixel_pitch is 5e-6, which is not a number above 0 but text to YAML')

    def testRefusesWhatIsNoConeOrNoFile(self):
        self.config['mirror']['half_angle'] = 1.6
        self.assertRefused(self.draw(self.write(self.config)), 'mirror/half_angle is 1.6 rad, which is no cone')
        self.assertRefused(self.draw(self.write('mirror: {kind: none}\n')), 'only a conic mirror')
        self.assertRefused(self.draw(self.write('lens: [1\n')), 'robot.yaml')
        self.config['mask']['first_row'] = 'top'
        self.assertRefused(self.draw(self.write(self.config)), 'mask/first_row is top')
        self.assertRefused(self.draw(self.write('- 1\n')), 'lens/focal_length is missing')
        self.assertRefused(self.draw('/nowhere.yaml'), '/nowhere.yaml')

    def testRefusesMillimetresAsTheDetectionDoes(self):
        for room, name in (('lens', 'focal_length'), ('lens', 'pixel_pitch'), ('mirror', 'lens_to_apex'),
                           ('mirror', 'base_radius')):
            with open(SIMULATED) as file:
                config = yaml.safe_load(file)
            config[room][name] = 11
            self.assertRefused(self.draw(self.write(config)), '%s/%s is 11 m, more than ' % (room, name),
                               'in millimetres?')

    def testRefusesARigThatSeesNothing(self):
        self.config['mask']['inner_radius'] = 245.0
        self.assertRefused(self.draw(self.write(self.config)), 'mask/inner_radius is 245 px')


if __name__ == '__main__':
    unittest.main()
