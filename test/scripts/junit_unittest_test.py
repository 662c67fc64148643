"""The runner of the Python tests tells passed, failed, broken and skipped tests apart."""

import os
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree as ElementTree

REPOSITORY = os.path.abspath(os.path.join(os.path.dirname(__file__), '..', '..'))
PROGRAM = os.path.join(REPOSITORY, 'test', 'support', 'junit_unittest.py')


class JunitUnittest(unittest.TestCase):

    def outcomesOf(self, body):
        """Outcome of each case of a test class with the given body, and the return code."""
        with tempfile.TemporaryDirectory() as folder:
            test_file = os.path.join(folder, 'some_test.py')
            results = os.path.join(folder, 'results', 'some.xml')
            with open(test_file, 'w') as file:
                file.write('import unittest\nclass Some(unittest.TestCase):\n' + body)
            done = subprocess.run(
                [sys.executable, PROGRAM, test_file, '--gtest_output=xml:' + results],
                stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=30)
            cases = ElementTree.parse(results).getroot().findall('testcase')
        outcomes = {case.get('name'): [(child.tag, child.get('message')) for child in case]
                    for case in cases}
        return outcomes, done.returncode

    def testPassedTest(self):
        self.assertEqual(self.outcomesOf('  def testA(self): pass\n'), ({'testA': []}, 0))

    def testSkippedTestCarriesItsReason(self):
        outcomes, code = self.outcomesOf('  def testA(self): self.skipTest("no data")\n')
        self.assertEqual(outcomes, {'testA': [('skipped', 'no data')]})
        self.assertEqual(code, 0)

    def testFailedAndBrokenTests(self):
        outcomes, code = self.outcomesOf(
            '  def testA(self): self.assertEqual(1, 2)\n  def testB(self): raise ValueError()\n')
        self.assertEqual([tag for tag, _ in outcomes['testA']], ['failure'])
        self.assertEqual([tag for tag, _ in outcomes['testB']], ['error'])
        self.assertEqual(code, 1)

    def testFailedSubtest(self):
        outcomes, code = self.outcomesOf(
            '  def testA(self):\n    with self.subTest(x=1): self.assertEqual(1, 2)\n')
        self.assertEqual([tag for tag, _ in outcomes['testA']], ['failure'])
        self.assertEqual(code, 1)

    def testBrokenClassFixture(self):
        outcomes, code = self.outcomesOf(
            '  @classmethod\n  def setUpClass(cls): raise ValueError()\n  def testA(self): pass\n')
        self.assertEqual([tag for case in outcomes.values() for tag, _ in case], ['error'])
        self.assertEqual(code, 1)

    def testNoTestsIsNotGood(self):
        self.assertEqual(self.outcomesOf('  pass\n'), ({}, 1))


if __name__ == '__main__':
    unittest.main()
