"""What the documents say is there, and the package is one that catkin's own checks accept."""

import glob
import os
import re
import shutil
import subprocess
import unittest
import xml.etree.ElementTree as ElementTree

import roslib.packages

REPOSITORY = os.path.abspath(os.path.join(os.path.dirname(__file__), '..', '..'))
DOCUMENTS = [os.path.join(REPOSITORY, name) for name in ('README.md', 'CONTRIBUTING.md')] + sorted(
    glob.glob(os.path.join(REPOSITORY, 'doc', '**', '*.md'), recursive=True))

# What catkin_lint asks for and this package has reason not to do.
IGNORED_CHECKS = [
    # include paths belong to targets here; catkin_lint knows only those of folders
    'unused_catkin_include_dirs', 'unused_include_path', 'external_interface_path',
    'uninstalled_script',  # scripts/ works on the clone, not on an installation
    'launch_depend',  # rviz is for rviz:=true alone; dependencies_test knows the others
    'uninstalled_target',  # benches measure this package, nobody else runs them
]

WRITTEN_LAUNCH_FILES = ['static_transform.launch']  # not the package's own: a result's


def textOf(path):
    with open(path) as file:
        return file.read()


class Documents(unittest.TestCase):

    def assertNamed(self, pattern, exists):
        """Whatever `pattern` finds in the documents exists; returns how much was found."""
        count = 0
        for path in DOCUMENTS:
            for name in re.findall(pattern, textOf(path)):
                count += 1
                with self.subTest(document=os.path.relpath(path, REPOSITORY), name=name):
                    self.assertTrue(exists(name), '%s is not there' % name)
        return count

    def testScriptsExistAndAreExecutable(self):
        count = self.assertNamed(
            r'\./(scripts/\w+)', lambda name: os.access(os.path.join(REPOSITORY, name), os.X_OK))
        self.assertGreater(count, 0)

    def testLaunchFilesExist(self):
        count = self.assertNamed(
            r'(\w+\.launch)', lambda name: name in WRITTEN_LAUNCH_FILES or os.path.exists(
                os.path.join(REPOSITORY, 'launch', name)))
        self.assertGreater(count, 0)

    def testLaunchArgumentsExist(self):
        for path in DOCUMENTS:
            # A command goes on while its lines end with a backslash.
            for name, rest in re.findall(
                    r'roslaunch bearing_calibration (\w+\.launch)((?:[^\n]*\\\n)*[^\n`]*)',
                    textOf(path)):
                launch = os.path.join(REPOSITORY, 'launch', name)
                if not os.path.exists(launch):
                    continue  # another test's business
                known = {arg.get('name') for arg in ElementTree.parse(launch).iter('arg')}
                used = set(re.findall(r'(\w+):=', rest))
                with self.subTest(document=os.path.relpath(path, REPOSITORY), launch=name):
                    self.assertLessEqual(used, known)

    def testProgramsExist(self):
        count = self.assertNamed(
            r'rosrun bearing_calibration (\w+)',
            lambda name: bool(roslib.packages.find_node('bearing_calibration', name)))
        self.assertGreater(count, 0)

    def testLinkedFilesExist(self):
        for path in DOCUMENTS:
            for target in re.findall(r'\]\(([^)#:]+)\)', textOf(path)):
                with self.subTest(document=os.path.relpath(path, REPOSITORY), target=target):
                    self.assertTrue(os.path.exists(os.path.join(os.path.dirname(path), target)))


class Package(unittest.TestCase):

    def testRostestProgramsHaveUniqueNames(self):
        """Results of programs of the same name would overwrite each other."""
        names = []
        for path in glob.glob(os.path.join(REPOSITORY, 'test', '**', '*.test'), recursive=True):
            names += [test.get('test-name') for test in ElementTree.parse(path).iter('test')]
        self.assertTrue(names)
        self.assertEqual(sorted(names), sorted(set(names)))

    def testTestsOfSeveralUsersWriteToFoldersOfTheirOwn(self):
        for path in glob.glob(os.path.join(REPOSITORY, 'test', 'ros', '*.*')):
            with self.subTest(file=os.path.basename(path)):
                self.assertNotRegex(textOf(path), r'(?<!\$\(anon )/tmp/')

    def testNoTestReplacesTheOwnersResult(self):
        for path in glob.glob(os.path.join(REPOSITORY, 'test', 'ros', '*.test')):
            if re.search('CalibrationNodelet|/calibrate.launch', textOf(path)):
                with self.subTest(file=os.path.basename(path)):
                    self.assertRegex(textOf(path), 'result_folder|output/folder|calibration_overrides.yaml')

    def testCatkinLint(self):
        self.assertTrue(shutil.which('catkin_lint'), 'catkin-lint is not installed')
        ignored = [word for check in IGNORED_CHECKS for word in ('--ignore', check)]
        done = subprocess.run(['catkin_lint', '--strict'] + ignored + [REPOSITORY],
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                              universal_newlines=True, timeout=600)
        self.assertEqual(done.returncode, 0, done.stdout)


if __name__ == '__main__':
    unittest.main()
