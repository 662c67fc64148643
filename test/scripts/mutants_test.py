"""What scripts/mutants breaks and leaves alone, and what it says of mutants that tests notice or not."""

import contextlib
import io
import itertools
import json
import os
import re
import sys
import tempfile
import unittest
from unittest import mock

REPOSITORY = os.path.abspath(os.path.join(os.path.dirname(__file__), '..', '..'))
sys.path.insert(0, os.path.join(REPOSITORY, 'scripts'))
import try_mutants  # noqa: E402  (lies in scripts)


def changed(line):
    """{(kind, the line instead)} of a line of code."""
    text = line + '\n'
    return {(mutant.kind, try_mutants.linesOf(mutant, text)[2])
            for mutant in try_mutants.mutantsOf('src/filter/a.cpp', text)}


class Mutants(unittest.TestCase):

    def testAFactorIsDoubledAndLeftOut(self):
        self.assertEqual(changed('y = kLever_m * x;'), {('factor', 'y = kLever_m * 2 * x;'), ('factor', 'y = x;')})
        self.assertEqual(changed('y = x / count;'), {('factor', 'y = x;')})

    def testASignIsTurned(self):
        self.assertEqual(changed('y = a + b - c;'), {('sign', 'y = a - b - c;'), ('sign', 'y = a + b + c;')})
        self.assertEqual(changed('y += f(-x);'), {('sign', 'y -= f(-x);'), ('sign', 'y += f(x);')})

    def testABoundIsTurnedAndBesideWholeNumbersOffByOne(self):
        self.assertEqual(changed('if (x <= limit_m) y();'), {('bound', 'if (x >= limit_m) y();')})
        self.assertEqual(changed('if (n < all.size()) y();'),
                         {('bound', 'if (n > all.size()) y();'), ('bound', 'if (n <= all.size()) y();')})

    def testConditionsAndArgumentsChangeTheirOrder(self):
        self.assertEqual(changed('if (a && b) y();'), {('order', 'if (a || b) y();')})
        self.assertEqual(changed('y = angle(from, to);'), {('order', 'y = angle(to, from);')})
        self.assertEqual(changed('y = std::hypot(from, to);'), set())

    def testASquareIsTakenAway(self):
        self.assertIn(('square', 'y = x.u;'), changed('y = x.u * x.u;'))
        self.assertEqual(changed('y = ray.squaredNorm();'), {('square', 'y = ray.norm();')})

    def testTheLeastBecomesTheMost(self):
        self.assertEqual(changed('y = std::min(a, b);'), {('extreme', 'y = std::max(a, b);')})

    def testWhatIsNoCodeIsLeftAlone(self):
        for line in ('// a + b < c * d', '/* a && b */', 'say("a + b < c");', '#include <a + b>',
                     'static_assert(a < b, "why");', 'std::vector<double> all(const double* a, T&& b);'):
            self.assertEqual(changed(line), set(), line)

    def testTheSeedDecidesAndTheKindsTakeTurns(self):
        mutants = [mutant for path in try_mutants.sources()
                   for mutant in try_mutants.mutantsOf(path, try_mutants.read(os.path.join(REPOSITORY, path)))]
        first, again, other = (list(itertools.islice(try_mutants.drawn(mutants, seed), 12)) for seed in (1, 1, 2))
        self.assertEqual(first, again)
        self.assertNotEqual(first, other)
        kinds = list(try_mutants.CHANGES)
        self.assertEqual([mutant.kind for mutant in first], kinds + kinds)

    def testItsTestsAreThere(self):
        programs = try_mutants.read(os.path.join(REPOSITORY, 'test', 'CMakeLists.txt'))
        for tests in (try_mutants.QUICK_TESTS, try_mutants.SLOW_TESTS):
            for name in sum(tests.values(), ()):
                if not name.endswith('_fuzz_test'):  # of a loop there
                    self.assertIn('bearing_calibration_gtest(%s' % name, programs)

    def testEquivalentOnesAreMutantsWithAReason(self):
        text = try_mutants.read(try_mutants.EQUIVALENT)
        mutants = set()
        for path in try_mutants.sources():
            source = try_mutants.read(os.path.join(REPOSITORY, path))
            for mutant in try_mutants.mutantsOf(path, source):
                mutants.add((path, *try_mutants.linesOf(mutant, source)[1:]))
        for entry in try_mutants.equivalentMutants(text):
            self.assertTrue(entry in mutants, '%s: not, or no longer, a mutant' % (entry,))
            reason = text.split('\n'.join((entry[0], '- ' + entry[1], '+ ' + entry[2])) + '\n')[1].split('\n\n')[0]
            self.assertGreater(len(reason.split()), 5, entry)


class Fates(unittest.TestCase):
    """A source with two mutants, a compiler that refuses what a text names, and a test that wants one."""

    SOURCE = 'double twice(double x, double y) {\n  return x + y < 0.0 ? x : y;\n}\n'

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.copy = os.path.join(folder.name, 'copy')
        self.source = os.path.join(self.copy, 'source', 'src', 'filter', 'a.cpp')
        for path in (os.path.dirname(self.source), os.path.join(folder.name, 'bin'),
                     os.path.join(self.copy, 'tests'),
                     os.path.join(folder.name, 'src', 'filter')):
            os.makedirs(path)
        for path in (self.source, os.path.join(folder.name, 'src', 'filter', 'a.cpp')):
            try_mutants.write(path, self.SOURCE)
        self.equivalent = os.path.join(folder.name, 'equivalent')
        try_mutants.write(self.equivalent, '')
        for patch in (mock.patch.object(try_mutants, 'REPOSITORY', folder.name),
                      mock.patch.object(try_mutants, 'EQUIVALENT', self.equivalent),
                      mock.patch.object(try_mutants, 'FIRST_TESTS', {'filter': ('a_test',)}),
                      mock.patch.object(try_mutants, 'QUICK_TESTS', {try_mutants.ESTIMATION: ('a_test',)}),
                      mock.patch.object(try_mutants, 'SLOW_TESTS', {try_mutants.ESTIMATION: ('slow_test',)}),
                      mock.patch.dict(os.environ, PATH=os.path.join(folder.name, 'bin') + ':' + os.environ['PATH'])):
            patch.start()
            self.addCleanup(patch.stop)
        os.makedirs(os.path.join(self.copy, 'build'))
        try_mutants.write(os.path.join(self.copy, 'build', 'compile_commands.json'), json.dumps(
            [{'directory': folder.name, 'file': self.source, 'command': 'compiler -o a.o -c a.cpp'}]))
        for name in ('compiler', 'c++'):
            self.program(os.path.join(folder.name, 'bin', name), 'exit 0')

    @staticmethod
    def program(path, then):
        try_mutants.write(path, '#!/bin/sh\n%s\n' % then)
        os.chmod(path, 0o755)

    def tryThem(self, test, slow='exit 0', only=()):
        """Exit code and output, with a test that does as it says where the mutant is loaded."""
        for name, then in (('a_test', test), ('slow_test', slow)):
            self.program(os.path.join(self.copy, 'tests', name),
                         'case "$LD_PRELOAD" in *copy/mutant.so) %s ;; esac' % then)
        said = io.StringIO()
        with contextlib.redirect_stdout(said):
            code = try_mutants.tryMutants(self.copy, 9, 1, only)
        self.assertEqual(try_mutants.read(self.source), self.SOURCE, 'the source is as it was')
        return code, said.getvalue()

    def testWhatATestNoticesIsKilledByItsName(self):
        code, said = self.tryThem('grep -q "x + y < 0.0" "%s" || { echo "[  FAILED  ] Sum.Is (0 ms)"; exit 1; }'
                                  % self.source)
        self.assertEqual(code, 0)
        self.assertIn('2 mutants: 2 killed, 0 survived, 100 %', said)
        self.assertIn('killed   src/filter/a.cpp:2 (sign) a_test: Sum.Is\n'
                      '      - return x + y < 0.0 ? x : y;\n'
                      '      + return x - y < 0.0 ? x : y;', said)

    def testWhatNoTestNoticesSurvivesAndFails(self):
        code, said = self.tryThem('grep -q "x + y" "%s"' % self.source)
        self.assertEqual(code, 1)
        self.assertIn('2 mutants: 1 killed, 1 survived, 50 %', said)
        self.assertRegex(said, r'survived src/filter/a.cpp:2 \(bound\)')

    def testWhatLivesIsTriedByTheSlowTests(self):
        code, said = self.tryThem('exit 0', 'grep -q "x + y <" "%s"' % self.source)
        self.assertEqual(code, 0)
        self.assertRegex(said, r'lives +src/filter/a.cpp:2 \(sign\)')
        self.assertRegex(said, r'killed +src/filter/a.cpp:2 \(sign\) slow_test: ended with 1')

    def testWhatDoesNotEndIsKilled(self):
        with mock.patch.object(try_mutants, 'LEAST_LIMIT_S', 0.5):
            _, said = self.tryThem('grep -q "x + y" "%s" || exec sleep 60' % self.source)
        self.assertIn('(sign) a_test: no end within', said)

    def testOneAloneByItsNumber(self):
        _, all_said = self.tryThem('exit 0')
        number = int(re.search(r'(\d+) survived \S+ \(bound\)', all_said).group(1))
        _, said = self.tryThem('exit 0', only=[number])
        self.assertIn('1 mutants: 0 killed, 1 survived', said)
        self.assertRegex(said, r'%d survived \S+ \(bound\)' % number)

    def testWhatDoesNotCompileDoesNotCount(self):
        path = os.path.join(os.environ['PATH'].split(':')[0], 'compiler')
        self.program(path, '! grep -q "x - y" "%s"' % self.source)
        _, said = self.tryThem('exit 0')
        self.assertIn('1 mutants: 0 killed, 1 survived, 0 %; beside them 0 equivalent, 1 that did not compile', said)

    def testNothingIsSaidWhereTheSourceItselfDoesNotCompile(self):
        self.program(os.path.join(os.environ['PATH'].split(':')[0], 'compiler'), 'exit 1')
        with self.assertRaisesRegex(SystemExit, 'does not compile without a mutant'):
            self.tryThem('exit 0')

    def testEquivalentOnesAreNotTried(self):
        try_mutants.write(self.equivalent, '# why\n\nsrc/filter/a.cpp\n- return x + y < 0.0 ? x : y;\n'
                          '+ return x + y > 0.0 ? x : y;\nit is the same\n')
        _, said = self.tryThem('exit 0')
        self.assertIn('1 mutants: 0 killed, 1 survived, 0 %; beside them 1 equivalent', said)

    def testATestThatFailsAnywayIsNamed(self):
        with self.assertRaisesRegex(SystemExit, 'a_test fails without a mutant: ended with 1'):
            self.tryThem(';; *) exit 1')


if __name__ == '__main__':
    unittest.main()
