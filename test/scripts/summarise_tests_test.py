"""The summary of scripts/test: each test case counts once, and nothing that failed looks passed."""

import json
import os
import subprocess
import sys
import tempfile
import unittest

REPOSITORY = os.path.abspath(os.path.join(os.path.dirname(__file__), '..', '..'))
PROGRAM = os.path.join(REPOSITORY, 'scripts', 'summarise_tests.py')

PASSING_CASE = '<testcase classname="Wheel" name="Turns"/>'
FAILING_CASE = '<testcase classname="Wheel" name="Slips"><failure message="slipped"/></testcase>'
SKIPPED_CASE = ('<testcase classname="Wheel" name="Flies" status="notrun" result="skipped">'
                '<skipped message="no wings"/></testcase>')


def suite(*cases, failures=0):
    return ('<?xml version="1.0"?><testsuites><testsuite name="s" failures="%d">%s</testsuite>'
            '</testsuites>' % (failures, ''.join(cases)))


class SummariseTests(unittest.TestCase):

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        self.tests = []
        self.failed_names = []

    def write(self, name, text):
        path = os.path.join(self.folder, name)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, 'w') as file:
            file.write(text)

    def addTest(self, name, results=None, ctest_failed=False):
        """One test of ctest whose result file (none for None) is called as catkin would call it."""
        file = os.path.join(self.folder, 'test_results', name + '.xml')
        self.tests.append({'name': '_ctest_' + name,
                           'command': ['env.sh', 'python3', '/catkin/run_tests.py', file, 'x']})
        if results is not None:
            self.write('test_results/%s.xml' % name, results)
        if ctest_failed:
            self.failed_names.append('_ctest_' + name)

    def summarise(self):
        """The program's output lines and return code."""
        self.write('tests.json', json.dumps({'tests': self.tests}))
        if self.failed_names:
            self.write('Testing/Temporary/LastTestsFailed.log',
                       ''.join('%d:%s\n' % item for item in enumerate(self.failed_names)))
        done = subprocess.run([sys.executable, PROGRAM, self.folder], stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, universal_newlines=True, timeout=30)
        return done.stdout.strip().split('\n'), done.returncode

    def expect(self, last_line, code):
        lines, returned = self.summarise()
        self.assertEqual(lines[-1], last_line, '\n'.join(lines))
        self.assertEqual(returned, code, '\n'.join(lines))
        return '\n'.join(lines)

    def testCountsEachCaseOnceAndNamesFailuresAndSkips(self):
        self.addTest('gtest-wheel', suite(PASSING_CASE, FAILING_CASE, SKIPPED_CASE, failures=1),
                     ctest_failed=True)
        output = self.expect('1 passed, 1 failed, 1 skipped', 1)
        self.assertIn('Wheel.Slips', output)
        self.assertIn('Wheel.Flies: no wings', output)

    def testIsGoodWhenAllPassed(self):
        self.addTest('gtest-wheel', suite(PASSING_CASE))
        self.expect('1 passed, 0 failed', 0)

    def testWithoutTestsIsNotGood(self):
        self.expect('0 passed, 0 failed', 1)

    def testSkippedTestsAloneAreNotGood(self):
        self.addTest('gtest-wheel', suite(SKIPPED_CASE))
        self.expect('0 passed, 0 failed, 1 skipped', 1)

    def testACrashLeavesNoResultsAndHasFailed(self):
        self.addTest('gtest-wheel', None, ctest_failed=True)
        self.addTest('gtest-axle', '<testsuites><testsuite', ctest_failed=True)
        self.expect('0 passed, 2 failed', 1)

    def testFailsWithCtestThoughNoCaseDid(self):
        self.addTest('gtest-wheel', suite(PASSING_CASE), ctest_failed=True)
        self.expect('1 passed, 1 failed', 1)

    def testFailuresOutsideTheCasesCount(self):
        self.addTest('python-wheel', suite(PASSING_CASE, failures=2))
        self.expect('1 passed, 1 failed', 1)

    def testAnEmptyResultHasFailed(self):
        self.addTest('gtest-wheel', suite())
        self.expect('0 passed, 1 failed', 1)

    def testResultsOfOtherRunsDoNotCount(self):
        self.addTest('gtest-wheel', suite(PASSING_CASE))
        self.write('test_results/gtest-gone.xml', suite(FAILING_CASE, failures=1))
        self.expect('1 passed, 0 failed', 0)

    def testARostestCountsWhatItsProgramsFound(self):
        self.addTest('rostest-drive', suite(
            '<testcase classname="rostest.runner.RosTest" name="testwheel"/>'))
        self.write('test_results/rosunit-wheel.xml', suite(PASSING_CASE, PASSING_CASE))
        self.expect('2 passed, 0 failed', 0)

    def testARostestWhoseProgramDiedHasFailed(self):
        self.addTest('rostest-drive', suite(
            '<testcase classname="RosTest" name="testwheel"><failure message="x"/></testcase>',
            '<testcase classname="RosTest" name="testaxle"/>', failures=1), ctest_failed=True)
        self.expect('0 passed, 2 failed', 1)  # the axle's results are missing

    def testATestWithoutCatkinCountsAsOne(self):
        self.tests.append({'name': 'plain', 'command': ['true']})
        self.expect('1 passed, 0 failed', 0)


if __name__ == '__main__':
    unittest.main()
