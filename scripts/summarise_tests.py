#!/usr/bin/env python3
"""Adds up the results of a ctest run: summarise_tests.py BUILD_FOLDER

Reads BUILD_FOLDER/tests.json (ctest --show-only=json-v1), the list of what ctest saw fail, and the
JUnit file of each test. Prints what failed and what was skipped, by name, and `N passed, N failed`
as its last line. A test without results has failed: a program that crashed leaves none. A test that
ctest saw fail counts as failed, whatever its file says. Returns non-zero unless something passed
and nothing failed.
"""

import json
import os
import sys
import xml.etree.ElementTree


class Tally:
    """Names of test cases by what became of them."""

    def __init__(self):
        self.passed = []
        self.failed = []
        self.skipped = []  # "name: reason"

    def addAll(self, other):
        self.passed += other.passed
        self.failed += other.failed
        self.skipped += other.skipped

    def lastLine(self):
        line = '%d passed, %d failed' % (len(self.passed), len(self.failed))
        return line + (', %d skipped' % len(self.skipped) if self.skipped else '')

    def isGood(self):
        return bool(self.passed) and not self.failed


def skipReason(case):
    """Why a test case was skipped; None when it was not."""
    element = case.find('skipped')
    if element is not None:
        reason = element.get('message') or element.text or ''
        # gtest puts the place of GTEST_SKIP() before the reason.
        return ' '.join(line for line in reason.split('\n') if line.strip()) or 'no reason given'
    if case.get('result') == 'skipped' or case.get('status') == 'notrun':
        return 'not run'
    return None


def tallyOfFile(path, test):
    """The cases of one JUnit file. `test` names it in messages."""
    tally = Tally()
    try:
        root = xml.etree.ElementTree.parse(path).getroot()
    except (OSError, xml.etree.ElementTree.ParseError) as error:
        tally.failed.append('%s: no results (%s)' % (test, error))
        return tally
    for case in root.iter('testcase'):
        name = '%s: %s.%s' % (test, case.get('classname', ''), case.get('name', ''))
        reason = skipReason(case)
        if case.find('failure') is not None or case.find('error') is not None:
            tally.failed.append(name)
        elif reason is not None:
            tally.skipped.append('%s: %s' % (name, reason))
        else:
            tally.passed.append(name)
    # Python's subtests and class fixtures fail without a test case of their own.
    suites = [root] if root.tag == 'testsuite' else root.findall('testsuite')
    counted = sum(int(suite.get(kind) or 0) for suite in suites for kind in ('failures', 'errors'))
    if counted > 0 and not tally.failed:
        tally.failed.append('%s: %d failures outside the test cases' % (test, counted))
    return tally


def tallyOfRostest(path, test):
    """A rostest's own file says which test programs ran; what they found is in files beside it."""
    ran = tallyOfFile(path, test)
    tally = Tally()
    tally.failed += ran.failed
    for name in ran.passed:
        program = name.rsplit('.', 1)[1][len('test'):]  # rostest calls its cases test<name>
        inner = os.path.join(os.path.dirname(path), 'rosunit-%s.xml' % program)
        tally.addAll(tallyOfFile(inner, '%s: %s' % (test, program)))
    return tally


def resultFile(test):
    """The JUnit file that catkin's test wrapper was told to write; None for other tests."""
    command = test.get('command', [])
    for wrapper, results in zip(command, command[1:]):
        if wrapper.endswith('run_tests.py'):
            return results
    return None


def shortName(test):
    name = test['name']
    return name[len('_ctest_'):] if name.startswith('_ctest_') else name


def tallyOfTest(test, has_failed):
    path = resultFile(test)
    name = shortName(test)
    tally = Tally()
    if path is None:
        (tally.failed if has_failed else tally.passed).append(name)
        return tally
    is_rostest = os.path.basename(path).startswith('rostest-')
    tally = tallyOfRostest(path, name) if is_rostest else tallyOfFile(path, name)
    if has_failed and not tally.failed:
        tally.failed.append('%s: failed, though no test case did' % name)
    if not (tally.passed or tally.failed or tally.skipped):
        tally.failed.append('%s: has no test cases' % name)
    return tally


def failedTests(build_folder):
    """Names of the tests that ctest saw fail, crash or run out of time."""
    path = os.path.join(build_folder, 'Testing', 'Temporary', 'LastTestsFailed.log')
    if not os.path.exists(path):
        return set()
    with open(path) as log:
        return {line.strip().split(':', 1)[1] for line in log if ':' in line}


def main(build_folder):
    with open(os.path.join(build_folder, 'tests.json')) as listing:
        tests = json.load(listing)['tests']
    failed = failedTests(build_folder)
    tally = Tally()
    for test in tests:
        tally.addAll(tallyOfTest(test, test['name'] in failed))
    for title, names in (('Skipped', tally.skipped), ('Failed', tally.failed)):
        if names:
            print('\n%s:' % title)
            print('\n'.join('  ' + name for name in names))
    if not tally.passed and not tally.failed:
        print('\nNo test was run.')
    print('\n' + tally.lastLine())
    return 0 if tally.isGood() else 1


if __name__ == '__main__':
    if len(sys.argv) != 2:
        sys.exit('usage: summarise_tests.py BUILD_FOLDER')
    sys.exit(main(sys.argv[1]))
