"""find_mirror as its user meets it: pictures in, lines for the robot's file or a message out."""

import math
import os
import random
import re
import subprocess
import tempfile
import unittest

import roslib.packages
import yaml

SIMULATED = os.path.abspath(os.path.join(os.path.dirname(__file__), '..', '..', 'config', 'robots',
                                         'simulated.yaml'))
WIDTH, HEIGHT = 320, 240
CENTRE_U, CENTRE_V, RADIUS = 163.25, 118.5, 105.0


def mirrorPicture(seed, width=WIDTH, height=HEIGHT):
    """A bright disc with an edge of two pixels on a dark ground, a portable grey map."""
    noise = random.Random(seed)
    pixels = bytearray()
    for v in range(height):
        for u in range(width):
            inside = (RADIUS - math.hypot(u - CENTRE_U, v - CENTRE_V)) / 2.0 + 0.5
            level = 20.0 + 100.0 * min(1.0, max(0.0, inside)) + noise.gauss(0.0, 2.0)
            pixels.append(min(255, max(0, round(level))))
    return b'P5 %d %d 255\n' % (width, height) + bytes(pixels)


class FindMirror(unittest.TestCase):

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        self.program = roslib.packages.find_node('bearing_calibration', 'find_mirror')[0]

    def write(self, name, content):
        path = os.path.join(self.folder, name)
        with open(path, 'wb') as file:
            file.write(content)
        return path

    def findMirror(self, *arguments):
        return subprocess.run([self.program] + list(arguments), stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, universal_newlines=True, timeout=600)

    def assertRefused(self, done, code, *words):
        self.assertEqual(done.returncode, code, done.stderr)
        self.assertEqual(done.stdout, '')
        for word in words:
            self.assertIn(word, done.stderr)

    def testPrintsLinesForTheConfiguration(self):
        pictures = [self.write('%d.pgm' % seed, mirrorPicture(seed)) for seed in range(3)]
        drawing = os.path.join(self.folder, 'found.png')
        done = self.findMirror(*pictures, '--output', drawing)
        self.assertEqual(done.returncode, 0, done.stderr)
        printed = yaml.safe_load(done.stdout)
        self.assertAlmostEqual(printed['mirror']['centre_u'], CENTRE_U, delta=0.1)
        self.assertAlmostEqual(printed['mirror']['centre_v'], CENTRE_V, delta=0.1)
        self.assertAlmostEqual(printed['mask']['outer_radius'], RADIUS, delta=1.1)
        self.assertIn('# rim: radius', done.stdout)
        with open(drawing, 'rb') as file:
            self.assertEqual(file.read(4), b'\x89PNG')

    def testAMisalignmentWantsLensAndMirrorAlone(self):
        """Not the centre, which it finds, nor the wheels; and the optics even where nothing else is
        compared with them."""
        picture = self.write('a.pgm', mirrorPicture(1))
        point = ['--principal-point', '160', '120', '--light-height=-0.03']
        optics = {'lens/focal_length', 'lens/aperture', 'lens/focus_distance', 'lens/pixel_pitch',
                  'mirror/lens_to_apex', 'mirror/half_angle', 'mirror/base_radius'}
        plain = self.write('plain.yaml', b'gates: {mirror: false}')
        for arguments in ([], ['--config', plain]):
            done = self.findMirror(picture, *point, *arguments)
            self.assertEqual(done.returncode, 1, done.stdout)
            self.assertEqual(set(re.findall(r'parameter (\S+) is required', done.stderr)), optics)
        with open(SIMULATED) as file:
            rig = yaml.safe_load(file)
        own = {'wheels': rig['wheels'], 'lens': rig['lens'], 'region': {'radius': 1.2},
               'mirror': {name: rig['mirror'][name]
                          for name in ('lens_to_apex', 'half_angle', 'base_radius')}}
        done = self.findMirror(picture, *point, '--config',
                               self.write('own.yaml', yaml.safe_dump(own).encode()))
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn('near_per_far', yaml.safe_load(done.stdout)['alignment'])

    def testARadiusNarrowsTheSearch(self):
        picture = self.write('a.pgm', mirrorPicture(1))
        self.assertEqual(self.findMirror(picture, '--radius', '100').returncode, 0)
        self.assertRefused(self.findMirror(picture, '--radius', '60'), 1, 'no rim found')

    def testNamesWhatIsWrong(self):
        picture = self.write('a.pgm', mirrorPicture(1))
        self.assertRefused(self.findMirror(), 2, 'IMAGE is missing', '--help')
        self.assertRefused(self.findMirror(picture, '--radius', '-1'), 2, '--radius')
        self.assertRefused(self.findMirror('missing.png'), 1, 'missing.png', 'no image')
        text = self.write('text.png', b'not a picture')
        self.assertRefused(self.findMirror(text), 1, 'text.png')
        other = self.write('b.pgm', mirrorPicture(1, width=100, height=80))
        self.assertRefused(self.findMirror(picture, other), 1, 'b.pgm', 'another size')
        for drawing in (os.path.join('no', 'folder.png'), 'picture.of_no_kind'):
            done = self.findMirror(picture, '--output', os.path.join(self.folder, drawing))
            self.assertEqual(done.returncode, 1)
            self.assertIn('%s: cannot be written' % drawing, done.stderr)
            self.assertNotIn('OpenCV', done.stderr)


if __name__ == '__main__':
    unittest.main()
