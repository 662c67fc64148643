"""What scripts/fuzz builds and runs, what it says of it, and that it fails when something is found."""

import glob
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
# as llvm-cov says it: REPOSITORY/src/a.cpp has 200 lines, of which 190 were reached
COVERAGE = '''cat << END
{"data": [{"files": [{"filename": "%s", "summary": {"lines": {"count": 200, "covered": 190, "percent": 95.0}}}]}]}
END'''
FINDS = FINE + '''
for argument; do case "$argument" in -artifact_prefix=*) touch "${argument#*=}crash-1" ;; esac; done
echo "ERROR: AddressSanitizer: heap-buffer-overflow" >&2
exit 77'''


class Fuzz(CopyOfTheScripts):

    def setUp(self):
        super().setUp()
        shutil.copytree(SEEDS, self.path('fuzz', 'seeds'))
        shutil.copy(os.path.join(REPOSITORY, 'fuzz', 'doors'), self.path('fuzz'))
        os.mkdir(self.path('fuzz', 'corpora'))
        for name in ('cmake', 'ldd', 'llvm-profdata'):
            self.standIn(self.path('stand_ins', name))
        self.standIn(self.path('stand_ins', 'llvm-cov'), COVERAGE % self.path('src', 'a.cpp'))
        self.standIn(self.path('scripts', 'install_dependencies'))
        self.programs = self.makePrograms('fuzz')

    def makePrograms(self, build):
        programs = os.path.join(self.other_builds, build, 'devel', 'lib', 'bearing_calibration')
        os.makedirs(programs)
        for target in TARGETS:
            self.standIn(os.path.join(programs, target + '_fuzz'), FINE)
        return programs

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
                lines = [line.split() for line in file]
            calls = {line[0]: line[1:] for line in lines}
            self.configured = [word for line in lines if line[0] == 'cmake' for word in line]
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
            # target, seconds, executions, coverage, new, the last new one, findings
            self.assertEqual([[cell for i, cell in enumerate(cells) if i not in (1, 5)] for cells in row],
                             [[target, '4321', '150', '30', '0']])
        self.assertIn('--for-fuzz', calls['install_dependencies'])
        self.assertIn('-DBEARING_CALIBRATION_SANITIZE=fuzzer-no-link,address', self.configured)

    def testOfTwoRunsInACloneOneWaits(self):
        self.assertOneWaits('fuzz', self.programs, TARGETS[0] + '_fuzz')

    def testFastIsWithoutSanitizers(self):
        self.makePrograms('fuzz_fast')
        code, said, calls = self.fuzz('--fast', 'files', '5')
        self.assertEqual(code, 0, said)
        self.assertIn('-DBEARING_CALIBRATION_SANITIZE=fuzzer-no-link', self.configured)
        self.assertIn(self.path('.build', 'fuzz', 'corpus', 'files'), calls['files_fuzz'])

    def testCoverageIsOfTheLinesOfEachDoor(self):
        self.makePrograms('fuzz_coverage')
        code, said, calls = self.fuzz('--coverage', 'files')
        self.assertEqual(code, 0, said)
        self.assertIn('-runs=0', calls['files_fuzz'])
        self.assertIn(self.path('src', 'output', 'result_file.cpp'), calls['llvm-cov'])
        self.assertIn(['200', '190', '95.0', 'src/a.cpp'],
                      [line.split() for line in said.splitlines()])

    def testWhatWasLearntIsKeptAndReadAgain(self):
        programs = self.makePrograms('fuzz_fast')
        self.standIn(os.path.join(programs, 'files_fuzz'), 'for folder; do case "$folder" in\n'
                     '*/least/files) echo abc > "$folder/one" ;; esac; done')
        code, said, calls = self.fuzz('--keep', 'files')
        self.assertEqual(code, 0, said)
        self.assertIn('-merge=1', calls['files_fuzz'])
        self.assertIn('files: 1 inputs kept of 0', said)
        first = self.read('fuzz', 'corpora', 'files.tar.xz')
        self.assertEqual(self.fuzz('files', '5')[0], 0)
        self.assertEqual(self.read('.build', 'fuzz', 'corpus', 'files', 'one'), b'abc\n')
        self.assertEqual(self.fuzz('--keep', 'files')[0], 0)
        self.assertEqual(self.read('fuzz', 'corpora', 'files.tar.xz'), first, 'the same bytes')

    def testWhatCannotBeMergedIsNamedAndWhatWasKeptStays(self):
        programs = self.makePrograms('fuzz_fast')
        self.standIn(os.path.join(programs, 'files_fuzz'), 'echo "ERROR: out-of-memory" >&2\nexit 71')
        code, said, _ = self.fuzz('--keep', 'files')
        self.assertNotEqual(code, 0)
        self.assertIn('ERROR: out-of-memory\nfuzz: files: merging has failed', said)
        self.assertEqual(os.listdir(self.path('fuzz', 'corpora')), [])

    def read(self, *names):
        with open(self.path(*names), 'rb') as file:
            return file.read()

    def testEveryDoorIsASource(self):
        with open(self.path('fuzz', 'doors')) as file:
            for door in file.read().split():
                self.assertTrue(glob.glob(os.path.join(REPOSITORY, door)), door)

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
        self.assertIn(os.path.join(self.other_builds, 'fuzz', 'findings', 'files', 'crash-1'), said)
        self.assertIn('AddressSanitizer: heap-buffer-overflow', said)
        self.assertIn(['messages', '4321', '150', '30', '0'],
                      [line.split()[:1] + line.split()[2:5] + line.split()[6:] for line in said.splitlines()])

    def testWrongArgumentsAreNamed(self):
        for arguments in (['images'], ['--slow'], ['1', '2'], ['files', 'x'], ['files', '1', '2']):
            code, said, calls = self.fuzz(*arguments)
            self.assertNotEqual(code, 0, said)
            self.assertIn('usage: scripts/fuzz [--fast | --coverage | --keep] [TARGET] [SECONDS]', said)
            self.assertEqual(calls, {})


if __name__ == '__main__':
    unittest.main()
