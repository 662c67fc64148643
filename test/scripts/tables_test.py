"""Programs that print measured tables for the documents: they run, and a miss is a miss."""

import re
import subprocess
import unittest

import roslib.packages


def run(name, *arguments):
    program = roslib.packages.find_node('bearing_calibration', name)[0]
    return subprocess.run([program, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          universal_newlines=True, timeout=600)


class Tables(unittest.TestCase):

    def testMonteCarlo(self):
        done = run('monte_carlo', '--what', 'batch', '--runs', '2', '--times', '50')
        self.assertEqual(done.returncode, 0, done.stderr)
        rows = [line.split('|') for line in done.stdout.splitlines() if line.startswith('|')]
        self.assertEqual([row[1].strip() for row in rows], ['time [s]', '---', '50', '100'])
        self.assertEqual({len(row) for row in rows}, {len(rows[0])})

    def testMonteCarloOfATiltedRobot(self):
        done = run('monte_carlo', '--what', 'batch', '--world', 'corner', '--runs', '4', '--errors',
                   '--known-separation', '--offset', '0.05', '--ratio', '0.01', '--scale', '0.01',
                   '--tilt', '2', '--harmonic', '2.5', '--elevations', '1', '--light-height', '0.4',
                   '--look-for-harmonic', '--look-for-tilt')
        self.assertEqual(done.returncode, 0, done.stderr)
        found = re.search(r'RMSE of phi (\S+) deg, rho (\S+) mm', done.stdout)
        # four runs: twice what a hundred have
        self.assertLess(float(found.group(1)), 1.6)
        self.assertLess(float(found.group(2)), 4.0)
        self.assertRegex(done.stdout, r'(?m)^sensor_roll \[rad\] +4 ')
        self.assertNotIn('wheel_separation', done.stdout)

    def testMonteCarloWithSeveralLightsSaysTheBoundToo(self):
        done = run('monte_carlo', '--what', 'batch', '--world', 'paper', '--runs', '2', '--lights',
                   '2', '--unidentified')
        self.assertEqual(done.returncode, 0, done.stderr)
        rows = [line.split('|') for line in done.stdout.splitlines() if line.startswith('| 100')]
        self.assertEqual(len(rows), 2)
        self.assertLess(float(rows[1][3]), 1.6)  # mm of rho, better than with one light

    def testMonteCarloWithSlipsAndALightThatMoves(self):
        done = run('monte_carlo', '--what', 'calibrator', '--world', 'paper', '--runs', '2',
                   '--lights', '4', '--unidentified', '--slips', '3', '--moving-light', '0.02')
        self.assertEqual(done.returncode, 0, done.stderr)
        row = next(line.split('|') for line in done.stdout.splitlines() if line.startswith('| 100'))
        self.assertEqual(int(row[5]), 0)  # wrong

    def testMonteCarloNamesAWrongArgument(self):
        for option, value in (('--what', 'guess'), ('--world', 'moon')):
            done = run('monte_carlo', option, value)
            self.assertNotEqual(done.returncode, 0)
            self.assertIn(value, done.stdout + done.stderr)

    def testRenderRate(self):
        done = run('render_rate')
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stdout, r'\d+ images/s')


if __name__ == '__main__':
    unittest.main()
