"""Programs that print measured tables for the documents: they run, and a miss is a miss."""

import subprocess
import unittest

import roslib.packages


def run(name, *arguments):
    program = roslib.packages.find_node('bearing_calibration', name)[0]
    return subprocess.run([program, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          universal_newlines=True, timeout=120)


class Tables(unittest.TestCase):

    def testMonteCarlo(self):
        done = run('monte_carlo', '--what', 'batch', '--runs', '2', '--times', '50')
        self.assertEqual(done.returncode, 0, done.stderr)
        rows = [line.split('|') for line in done.stdout.splitlines() if line.startswith('|')]
        self.assertEqual([row[1].strip() for row in rows], ['time [s]', '---', '50', '100'])
        self.assertEqual({len(row) for row in rows}, {len(rows[0])})

    def testMonteCarloNamesAWrongArgument(self):
        done = run('monte_carlo', '--what', 'guess')
        self.assertNotEqual(done.returncode, 0)
        self.assertIn('guess', done.stdout + done.stderr)

    def testRenderRate(self):
        done = run('render_rate')
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stdout, r'\d+ images/s')


if __name__ == '__main__':
    unittest.main()
