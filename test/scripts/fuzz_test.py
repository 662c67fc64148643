"""What scripts/fuzz builds and runs, what it says of it, and that it fails when something is found."""

import os
import shutil
import subprocess
import unittest

from run_test import CopyOfTheScripts, REPOSITORY

SEEDS = os.path.join(REPOSITORY, 'fuzz', 'seeds')
TARGETS = sorted(os.listdir(SEEDS))
# as libFuzzer says it
FINE = '''echo "INFO: Seed: 1" >&2
echo "#3 INITED cov: 120 ft: 9 corp: 1/1b" >&2
echo "#90 NEW    cov: 150 ft: 12 corp: 2/3b" >&2
echo "stat::number_of_executed_units: 4321" >&2'''
FINDS = FINE + '''
for argument; do case "$argument" in -artifact_prefix=*) touch "${argument#*=}crash-1" ;; esac; done
echo "ERROR: AddressSanitizer: heap-buffer-overflow" >&2
exit 77'''


class Fuzz(CopyOfTheScripts):

    def setUp(self):
        super().setUp()
        shutil.copytree(SEEDS, self.path('fuzz', 'seeds'))
        self.programs = self.path('.build', 'fuzz', 'devel', 'lib', 'bearing_calibration')
        os.makedirs(self.programs)
        for name in ('cmake', 'clang++'):
            self.standIn(self.path('stand_ins', name))
        for target in TARGETS:
            self.standIn(os.path.join(self.programs, target + '_fuzz'), FINE)

    def fuzz(self, *arguments):
        """Return code and output; the calls of programs by name."""
        if os.path.exists(self.log):
            os.remove(self.log)
        done = subprocess.run([self.path('scripts', 'fuzz'), *arguments], timeout=300,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                              universal_newlines=True)
        calls = {}
        if os.path.exists(self.log):
            with open(self.log) as file:
                calls = {line.split()[0]: line.split()[1:] for line in file}
        return done.returncode, done.stdout, calls

    def testEveryTargetForAMinute(self):
        code, said, calls = self.fuzz()
        self.assertEqual(code, 0, said)
        for target in TARGETS:
            self.assertIn(target + '_fuzz', calls['cmake'])
            arguments = calls[target + '_fuzz']
            self.assertIn('-max_total_time=60', arguments)
            self.assertEqual(arguments[-1], self.path('fuzz', 'seeds', target))
            row = [line.split() for line in said.splitlines() if line.startswith(target + ' ')]
            self.assertEqual(row, [[target, '4321', '150', '30', '0']])

    def testANumberAloneIsSeconds(self):
        code, said, calls = self.fuzz('7')
        self.assertEqual(code, 0, said)
        self.assertEqual([name for name in calls if '-max_total_time=7' in calls[name]],
                         [name for name in calls if name.endswith('_fuzz')])

    def testOneTarget(self):
        code, said, calls = self.fuzz('files', '5')
        self.assertEqual(code, 0, said)
        self.assertEqual([name for name in calls if name.endswith('_fuzz')], ['files_fuzz'])

    def testAFindingFailsWithItsPath(self):
        self.standIn(os.path.join(self.programs, 'files_fuzz'), FINDS)
        code, said, _ = self.fuzz('1')
        self.assertNotEqual(code, 0)
        self.assertIn(self.path('.build', 'fuzz', 'findings', 'files', 'crash-1'), said)
        self.assertIn('AddressSanitizer: heap-buffer-overflow', said)
        self.assertIn(['messages', '4321', '150', '30', '0'], [line.split() for line in said.splitlines()])

    def testWrongArgumentsAreNamed(self):
        for arguments in (['images'], ['1', '2'], ['files', 'x'], ['files', '1', '2']):
            code, said, calls = self.fuzz(*arguments)
            self.assertNotEqual(code, 0, said)
            self.assertIn('usage: scripts/fuzz [TARGET] [SECONDS]', said)
            self.assertEqual(calls, {})


if __name__ == '__main__':
    unittest.main()
