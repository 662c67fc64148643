"""A mirror that leans and is decentred, from images to the mount, as tilted_mirror.py measures it."""

import os
import re
import subprocess
import unittest

TOOL = os.path.join(os.path.dirname(__file__), '..', '..', 'tools', 'study', 'tilted_mirror.py')


class TiltedMirror(unittest.TestCase):

    def testTheMountIsFoundAllTheSame(self):
        done = subprocess.run(['python3', TOOL, '--runs', '1', '--tilt', '1', '--offset', '0.5'],
                              stdout=subprocess.PIPE, universal_newlines=True, check=True,
                              timeout=600)
        row = done.stdout.splitlines()[-1]
        state, _, _, rho_mm, sigmas, _ = (cell.strip() for cell in row.split('|')[2:-1])
        self.assertRegex(state, re.compile('^(CONVERGED|CONVERGING)$'), done.stdout)
        self.assertLess(abs(float(rho_mm)), 3.0, done.stdout)
        self.assertLess(float(sigmas), 3.0, done.stdout)


if __name__ == '__main__':
    unittest.main()
