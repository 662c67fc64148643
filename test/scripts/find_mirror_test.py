"""find_mirror as its user meets it: pictures in, lines for config/detection.yaml or a message out."""

import math
import os
import random
import subprocess
import tempfile
import unittest

import roslib.packages
import yaml

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

    def testARadiusNarrowsTheSearch(self):
        picture = self.write('a.pgm', mirrorPicture(1))
        self.assertEqual(self.findMirror(picture, '--radius', '100').returncode, 0)
        self.assertRefused(self.findMirror(picture, '--radius', '60'), 1, 'no rim found')

    def testNamesWhatIsWrong(self):
        picture = self.write('a.pgm', mirrorPicture(1))
        self.assertRefused(self.findMirror(), 2, 'image', '--help')
        self.assertRefused(self.findMirror(picture, '--radius', '-1'), 2, '--radius')
        self.assertRefused(self.findMirror('missing.png'), 1, 'missing.png', 'no image')
        text = self.write('text.png', b'not a picture')
        self.assertRefused(self.findMirror(text), 1, 'text.png')
        other = self.write('b.pgm', mirrorPicture(1, width=100, height=80))
        self.assertRefused(self.findMirror(picture, other), 1, 'b.pgm', 'another size')
        done = self.findMirror(picture, '--output', os.path.join(self.folder, 'no', 'folder.png'))
        self.assertEqual(done.returncode, 1)
        self.assertIn('cannot be written', done.stderr)


if __name__ == '__main__':
    unittest.main()
