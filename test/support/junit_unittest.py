#!/usr/bin/env python3
"""Runs a Python test file and writes a JUnit file that knows skipped tests and their reasons.

    junit_unittest.py TEST_FILE --gtest_output=xml:RESULTS

rosunit's runner, which rostest is used with, counts skipped tests as passed.
"""

import importlib.util
import os
import sys
import time
import unittest
import xml.etree.ElementTree as ElementTree

OUTPUT_FLAG = '--gtest_output=xml:'


class JunitResult(unittest.TextTestResult):
    """Keeps one JUnit element for each test case beside what it prints."""

    def __init__(self, *args, **kwargs):
        super().__init__(*args, **kwargs)
        self.suite = ElementTree.Element('testsuite')
        self.cases = {}
        self.started = time.monotonic()

    def caseOf(self, test):
        """The element of a test; class fixtures that fail have none before this call."""
        if test.id() not in self.cases:
            class_name, _, name = test.id().rpartition('.')
            self.cases[test.id()] = ElementTree.SubElement(
                self.suite, 'testcase', classname=class_name, name=name)
        return self.cases[test.id()]

    def note(self, test, kind, text):
        element = ElementTree.SubElement(self.caseOf(test), kind, message=text.split('\n')[0])
        element.text = text

    def startTest(self, test):
        super().startTest(test)
        self.started = time.monotonic()
        self.caseOf(test)

    def stopTest(self, test):
        super().stopTest(test)
        self.caseOf(test).set('time', '%.3f' % (time.monotonic() - self.started))

    def addSkip(self, test, reason):
        super().addSkip(test, reason)
        self.note(test, 'skipped', reason)

    def addFailure(self, test, err):
        super().addFailure(test, err)
        self.note(test, 'failure', self.failures[-1][1])

    def addError(self, test, err):
        super().addError(test, err)
        self.note(test, 'error', self.errors[-1][1])

    def addSubTest(self, test, subtest, err):
        super().addSubTest(test, subtest, err)
        if err is not None:
            self.note(test, 'failure', '%s: %s' % (subtest, err[1]))

    def addUnexpectedSuccess(self, test):
        super().addUnexpectedSuccess(test)
        self.note(test, 'failure', 'succeeded against expectation')

    def write(self, path):
        counts = (('tests', self.testsRun), ('failures', len(self.failures)),
                  ('errors', len(self.errors)), ('skipped', len(self.skipped)))
        for name, count in counts:
            self.suite.set(name, str(count))
        os.makedirs(os.path.dirname(os.path.abspath(path)), exist_ok=True)
        ElementTree.ElementTree(self.suite).write(path, encoding='utf-8', xml_declaration=True)


def loadTests(path):
    name = os.path.splitext(os.path.basename(path))[0]
    sys.path.insert(0, os.path.dirname(os.path.abspath(path)))
    spec = importlib.util.spec_from_file_location(name, path)
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return unittest.defaultTestLoader.loadTestsFromModule(module)


def main(arguments):
    files = [argument for argument in arguments if argument.endswith('.py')]
    outputs = [argument[len(OUTPUT_FLAG):] for argument in arguments
               if argument.startswith(OUTPUT_FLAG)]
    if len(files) != 1 or len(outputs) > 1:
        sys.exit(__doc__)
    runner = unittest.TextTestRunner(verbosity=2, resultclass=JunitResult)
    result = runner.run(loadTests(files[0]))
    if outputs:
        result.write(outputs[0])
    return 0 if result.wasSuccessful() and result.testsRun > 0 else 1


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
