"""What the offline programs about driving print: instructions for people, and the table."""

import subprocess
import unittest

import roslib.packages


def run(name, *arguments):
    program = roslib.packages.find_node('bearing_calibration', name)[0]
    return subprocess.run([program] + list(arguments), stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, universal_newlines=True, timeout=600)


class DriveInstructions(unittest.TestCase):

    def testBothWaysToDriveByHandHaveSteps(self):
        for motion in ('corner_light', 'dance'):
            done = run('drive_instructions', motion)
            self.assertEqual(done.returncode, 0, done.stdout)
            for step in ('1. ', '2. Drive 1 m', '3. Turn on the spot', '(450 degrees)'):
                self.assertIn(step, done.stdout)
        self.assertIn('inside', run('drive_instructions', 'corner_light').stdout)
        by_roslaunch = run('drive_instructions', 'corner_light', '__name:=instructions', '__log:=/tmp/log')
        self.assertIn('inside', by_roslaunch.stdout)

    def testAnUnknownMotionIsRefused(self):
        for words in (('waltz',), ('dance', 'corner_light')):
            done = run('drive_instructions', *words)
            self.assertEqual(done.returncode, 2)
            self.assertIn('usage', done.stdout)

    def testHelpIsNoError(self):
        done = run('drive_instructions', '--help')
        self.assertEqual(done.returncode, 0)
        self.assertIn('corner_light|dance', done.stdout)


class DriveTable(unittest.TestCase):

    def testTheBestKnownDriveIsBetterThanThePapersDance(self):
        done = run('drive_table', '--what', 'best', '--changes', '10')
        self.assertEqual(done.returncode, 0, done.stdout)
        figure = float(done.stdout.split('figure ')[1].split(',')[0])
        self.assertLess(figure, 0.25)  # a regular polygon about the light has 0.20
        self.assertIn('nearest 0.50 m', done.stdout)

    def testAWrongArgumentIsNamed(self):
        done = run('drive_table', '--what', 'waltz')
        self.assertEqual(done.returncode, 2)
        self.assertIn('waltz', done.stdout)
        for option in ('--runs', '--threads', '--duration'):
            done = run('drive_table', option, '0')
            self.assertEqual(done.returncode, 2)
            self.assertIn(option + ' must be greater than 0', done.stdout)


if __name__ == '__main__':
    unittest.main()
