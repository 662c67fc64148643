"""Programs that print measured tables for the documents: they run, and a miss is a miss."""

import os
import re
import subprocess
import tempfile
import unittest

import roslib.packages


REPOSITORY = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
REMEASURE = os.path.join(REPOSITORY, 'tools', 'study', 'remeasure.py')


def run(name, *arguments):
    program = roslib.packages.find_node('bearing_calibration', name)[0]
    return subprocess.run([program, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          universal_newlines=True, timeout=600)


class Tables(unittest.TestCase):

    def testMonteCarlo(self):
        done = run('monte_carlo', '--what', 'batch', '--runs', '2', '--times', '50')
        self.assertEqual(done.returncode, 0, done.stderr)
        rows = [line.split('|') for line in done.stdout.splitlines() if line.startswith('|')]
        self.assertEqual([row[1].strip() for row in rows], 2 * ['time [s]', '---', '50', '100'])
        states, errors = rows[:4], rows[4:]
        for table in (states, errors):
            self.assertEqual({len(row) for row in table}, {len(table[0])})
        self.assertEqual(errors[3][2].strip(), '2', 'both have an estimate')
        self.assertRegex(done.stdout, r'(?m)^declared at any time: 2 of 2, first after \d+ s')

    def testFaultTableNamesAFaultAndNoneOfASoundRobot(self):
        for fault, named, remark in (('left and right swapped', '1', ''),
                                     ('none', '', 'none, seed 1: CONVERGING\n')):
            done = run('fault_table', '--runs', '1', '--duration', '60', '--only', fault)
            self.assertEqual(done.returncode, 0, done.stderr)
            row, remarks = done.stdout.split('\n', 3)[2:]
            cells = [cell.strip() for cell in row.strip('|').split('|')]
            self.assertEqual(cells[:4] + cells[6:], [fault, '1', named, '0', '0'])
            self.assertEqual(remarks, remark)
        for wrong in (('--runs', '0'), ('--duration', '-1'), ('--only', 'nothing of the kind')):
            self.assertEqual(run('fault_table', *wrong).returncode, 2, wrong)

    def testMonteCarloOfATiltedRobot(self):
        done = run('monte_carlo', '--what', 'batch', '--world', 'corner', '--runs', '4', '--errors',
                   '--known-separation', '--offset', '0.05', '--ratio', '0.01', '--scale', '0.01',
                   '--tilt', '2', '--harmonic', '2.5', '--elevations', '1', '--light-height', '0.4',
                   '--estimate-harmonic', '--estimate-tilt')
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
        self.assertEqual(len(rows), 3)
        self.assertLess(float(rows[2][3]), 1.6)  # mm of rho, better than with one light

    def testMonteCarloWithSlipsAndALightThatMoves(self):
        done = run('monte_carlo', '--what', 'calibrator', '--world', 'paper', '--runs', '2',
                   '--lights', '4', '--unidentified', '--slips', '3', '--moving-light', '0.02')
        self.assertEqual(done.returncode, 0, done.stderr)
        row = next(line.split('|') for line in done.stdout.splitlines() if line.startswith('| 100'))
        self.assertEqual(int(row[5]), 0)  # wrong

    def testAPagesTablesAreMeasuredAgain(self):
        command = 'monte_carlo --what batch --world paper --runs 3 --times'
        other = '| time [s] | luck |\n|---|---|\n| 100 | 7 |\n'
        page = ('Words.\n\n    %s 20\n\nMore.\n\n'
                '| time [s] | NEES/3 | declared |\n|---|---|---|\n| 20 | 9 | 8 |\n\n'
                '    %s \\\n        50\n\n%s\nEnd.\n' % (command, command, other))
        with tempfile.NamedTemporaryFile('w+', suffix='.md') as file:
            file.write(page)
            file.flush()
            done = subprocess.run([REMEASURE, file.name], stdout=subprocess.PIPE,
                                  universal_newlines=True, timeout=600)
            with open(file.name) as measured:
                text = measured.read()
        self.assertEqual(done.returncode, 0, done.stdout)
        printed = [[cell.strip() for cell in row.split('|')]
                   for row in run('monte_carlo', *command.split()[1:], '20').stdout.splitlines()]
        row = '| 20 | %s | %s |' % (printed[2][7], printed[2][4])
        self.assertIn('|---|---|---|\n%s\n| 100 | ' % row, text)
        self.assertNotIn('| 20 | 9 | 8 |', text)
        self.assertTrue(text.startswith('Words.\n') and text.endswith(other + '\nEnd.\n'), text)
        self.assertIn('other columns', done.stdout)

    def testMonteCarloNamesAWrongArgument(self):
        for option, value in (('--what', 'guess'), ('--world', 'moon')):
            done = run('monte_carlo', option, value)
            self.assertNotEqual(done.returncode, 0)
            self.assertIn(value, done.stdout + done.stderr)
        for option in ('--runs', '--threads', '--lights', '--duration'):
            done = run('monte_carlo', option, '0')
            self.assertEqual(done.returncode, 2)
            self.assertIn(option, done.stderr)
        done = run('monte_carlo', '--runs', '3', '--outliers', '5')
        self.assertEqual((done.returncode, done.stderr.count('outlier_probability')), (2, 1))

    def testComparison(self):
        done = run('comparison_table', '--runs', '2')
        self.assertEqual(done.returncode, 0, done.stderr)
        rows = [[cell.strip() for cell in line.split('|')[1:-1]]
                for line in done.stdout.splitlines() if re.match(r'\|(?!-)', line)]
        given = [row for row in rows if len(row) == 2][1:]
        compared = [row for row in rows if len(row) > 2 and row[0] != 'estimator']
        self.assertEqual(len(given), 6)
        settings = re.findall(r'(?m)^\*\*(.*)\*\*$', done.stdout)
        self.assertEqual(len(settings), 5)
        self.assertEqual([row[0] for row in compared], len(settings) * [row[0] for row in given])
        for row in compared:
            with self.subTest(row=row):
                self.assertRegex(row[1], '^[012] of 2$')
                self.assertLessEqual(int(row[6]), int(row[5]))  # wrong of those that are sure
                self.assertEqual(len(row), 8)
                self.assertGreater(float(row[7]), 0.0)
        for row in compared[1::len(given)]:
            self.assertEqual(float(row[7]), 1.0, 'the plain EKF is what times are compared with')

    def testComparisonNamesAWrongArgument(self):
        for option in ('--runs', '--threads'):
            done = run('comparison_table', option, '0')
            self.assertNotEqual(done.returncode, 0)
            self.assertIn(option, done.stderr)

    def testRenderRate(self):
        done = run('render_rate')
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stdout, r'\d+ images/s')


if __name__ == '__main__':
    unittest.main()
