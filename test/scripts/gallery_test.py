"""The pictures of the documents are made by tools/study/gallery.py and overview.py."""

import os
import re
import subprocess
import sys
import tempfile
import unittest

REPOSITORY = os.path.abspath(os.path.join(os.path.dirname(__file__), '..', '..'))
PROGRAM = os.path.join(REPOSITORY, 'tools', 'study', 'gallery.py')
OVERVIEW = os.path.join(REPOSITORY, 'tools', 'study', 'overview.py')
IMAGES = os.path.join(REPOSITORY, 'doc', 'images')
LARGEST_BYTES = 300000


class Gallery(unittest.TestCase):

    def assertPicture(self, path):
        with open(path, 'rb') as file:
            picture = file.read()
        self.assertTrue(picture.startswith(b'\x89PNG'), path)
        self.assertLess(len(picture), LARGEST_BYTES, path)

    def testDrawsTheFrontPagesPicture(self):
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run([sys.executable, OVERVIEW, folder], stdout=subprocess.PIPE,
                                  stderr=subprocess.STDOUT, universal_newlines=True, timeout=600)
            self.assertEqual(done.returncode, 0, done.stdout)
            self.assertEqual(os.listdir(folder), ['overview.png'])
            for path in (os.path.join(folder, 'overview.png'), os.path.join(IMAGES, 'overview.png')):
                self.assertPicture(path)

    def testDrawsEveryPictureOfTheDetectionsDocument(self):
        with open(os.path.join(REPOSITORY, 'doc', 'background', 'detection.md')) as file:
            shown = re.findall(r'\]\(\.\./images/(\w+\.png)\)', file.read())
        self.assertTrue(shown)
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run([sys.executable, PROGRAM, folder, '--images', '2'],
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                  universal_newlines=True, timeout=600)
            self.assertEqual(done.returncode, 0, done.stdout)
            self.assertEqual(sorted(os.listdir(folder)), sorted(shown))
            for name in shown:
                for path in (os.path.join(folder, name), os.path.join(IMAGES, name)):
                    self.assertPicture(path)


if __name__ == '__main__':
    unittest.main()
