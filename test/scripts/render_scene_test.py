"""render_scene as its user meets it: a scene's file in, images with their truth out."""

import csv
import glob
import math
import os
import subprocess
import tempfile
import unittest

import roslib.packages
import yaml

REPOSITORY = os.path.abspath(os.path.join(os.path.dirname(__file__), '..', '..'))
SCENE = os.path.join(REPOSITORY, 'config', 'scene.yaml')


class RenderScene(unittest.TestCase):

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        self.program = roslib.packages.find_node('bearing_calibration', 'render_scene')[0]

    def runProgram(self, *arguments):
        return subprocess.run([self.program] + list(arguments), stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, universal_newlines=True, timeout=600)

    def render(self, name, *arguments):
        """The files' bytes by name, and the truth's rows."""
        output = os.path.join(self.folder, name)
        done = self.runProgram('--output', output, *arguments)
        self.assertEqual(done.returncode, 0, done.stderr)
        files = {}
        for path in glob.glob(os.path.join(output, '*')):
            with open(path, 'rb') as file:
                files[os.path.basename(path)] = file.read()
        with open(os.path.join(output, 'truth.csv')) as file:
            return files, list(csv.DictReader(file))

    def scene(self, name, parameters):
        path = os.path.join(self.folder, name)
        with open(path, 'w') as file:
            yaml.safe_dump(parameters, file)
        return path

    def testWritesImagesAndTruth(self):
        files, truth = self.render('clutter', '--scene', SCENE, '--seed', '3', '--images', '2')
        self.assertEqual(sorted(files), ['000000.png', '000001.png', 'detection.yaml', 'truth.csv'])
        self.assertEqual([row['image'] for row in truth], ['000000.png', '000001.png'])
        for row in truth:
            self.assertGreater(float(row['stamp_s']), -1e-9)
            # The pixel is where the azimuth says, seen from the image's centre (handedness -1).
            azimuth = -math.atan2(-(float(row['row_px']) - 239.5), float(row['column_px']) - 319.5)
            self.assertAlmostEqual(math.remainder(azimuth - float(row['azimuth_rad']), 2 * math.pi),
                                   0, delta=1e-4)

    def testTheSameSeedTheSameFiles(self):
        arguments = ('--scene', SCENE, '--images', '1', '--seed')
        first, _ = self.render('first', *arguments, '5')
        again, _ = self.render('again', *arguments, '5')
        other, _ = self.render('other', *arguments, '6')
        self.assertEqual(first, again)
        self.assertNotEqual(first['000000.png'], other['000000.png'])

    def testADetectorIsToldOfHoldersAndRowTime(self):
        scene = self.scene('held.yaml', {
            'clutter': {'holders': 3}, 'camera': {'row_time': 3e-05, 'encoding': 'bgr8',
                                                  'jpeg_quality': 80}})
        files, truth = self.render('held', '--scene', SCENE, '--scene', scene, '--images', '1')
        self.assertIn('000000.jpg', files)
        told = yaml.safe_load(files['detection.yaml'])
        self.assertEqual(told['time']['row_time'], 3e-05)
        self.assertEqual([len(post) for post in told['mask']['posts']], [2, 2, 2])
        late = float(truth[0]['row_stamp_s']) - float(truth[0]['stamp_s'])
        self.assertAlmostEqual(late, 3e-05 * float(truth[0]['row_px']), delta=2e-9)

    def testScenesHoldTheClutterOfTheDocumentsTable(self):
        with open(SCENE) as file:
            clutter = yaml.safe_load(file)['clutter']
        self.assertEqual(clutter, {'windows': [1, 4], 'lamps': [2, 8], 'reflections': [0, 4],
                                   'papers': [0, 3], 'texture_contrast': [0.2, 0.6], 'holders': 0})

    def testAFullDiskIsNamed(self):
        for name in ('detection.yaml', 'truth.csv'):
            output = os.path.join(self.folder, 'full_' + name)
            os.mkdir(output)
            os.symlink('/dev/full', os.path.join(output, name))
            done = self.runProgram('--output', output, '--scene', SCENE, '--images', '1')
            self.assertEqual(done.returncode, 1, done.stdout)
            self.assertIn(os.path.join(output, name) + ': cannot be written', done.stderr)

    def testFaultsAreNamed(self):
        output = ('--output', os.path.join(self.folder, 'never'))
        wrong = self.scene('wrong.yaml', {'clutter': {'windows': [2, 1], 'lamp': [0, 1]},
                                          'camera': {'encoding': 'bayer_rggb8', 'jpeg_quality': 9}})
        for arguments, code, words in (
                (('--scene', wrong), 1, ('clutter/windows must be', 'clutter/lamp is not known',
                                         'camera/jpeg_quality must be 0')),
                (('--scene', '/no/such.yaml'), 1, ('/no/such.yaml: cannot be read',)),
                (('--seed', '-1'), 2, ('--seed', '--help')),
                (('--images', '0'), 2, ('--images', '--help')),
                (('left-over',), 2, ('--help',))):
            with self.subTest(arguments=arguments):
                done = self.runProgram(*output, *arguments)
                self.assertEqual(done.returncode, code, done.stderr)
                for word in words:
                    self.assertIn(word, done.stderr)
        self.assertEqual(self.runProgram().returncode, 2)
        self.assertFalse(os.path.exists(os.path.join(self.folder, 'never')))


if __name__ == '__main__':
    unittest.main()
