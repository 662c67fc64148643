#!/usr/bin/env python3
"""Of scripts/mutants: draws places of the estimation and the detection, breaks one at a time, and
says which tests notice.

A mutant is one change of one operator, factor or pair of arguments. What stands in comments, strings,
assertions and includes is left alone, and what does not compile is drawn again.
"""

import collections
import json
import os
import random
import re
import shlex
import shutil
import subprocess
import sys
import time

REPOSITORY = os.path.abspath(os.path.join(os.path.dirname(__file__), '..'))
EQUIVALENT = os.path.join(REPOSITORY, 'scripts', 'equivalent_mutants')
SMALLEST_SHARE = 0.95
# Of a test; with a mutant it has five times what it takes without, and so much more.
LONGEST_TEST_S = 600
LEAST_LIMIT_S = 10.0

ESTIMATION = 'bearing_calibration_core'
DETECTION = 'bearing_calibration_vision'
# The tests that look at a room first; what lives is then run by the other tests of its library.
FIRST_TESTS = {
    'odometry': ('odometry_test',),
    'filter': ('filter_test', 'bearing_model_test'),
    'input': ('scan_bearings_test',),
    'record': ('batch_estimator_test', 'initializer_test'),
    'solve': ('batch_estimator_test', 'robot_errors_test', 'initializer_test'),
    'noise': ('batch_estimator_test', 'initializer_test'),
    'init': ('initializer_test',),
    'track': ('filter_test',),
    'judge': ('batch_estimator_test',),
    'calibration': ('lights_test',),
    'optics': ('conic_mirror_test',),
    'vision': ('vision_test',),
}
# Those of each library, the quick ones first.
QUICK_TESTS = {
    ESTIMATION: (
        'bearing_model_test', 'odometry_test', 'filter_test', 'scan_bearings_test', 'lights_test', 'planning_test',
        'batch_estimator_test', 'robot_errors_test', 'initializer_test', 'sensor_check_test', 'sensor_tilt_test',
        'offline_report_test', 'mount_quality_test', 'rival_mount_test'),
    DETECTION: (
        'conic_mirror_test', 'camera_test', 'vision_test', 'coloured_lights_test', 'image_conversion_test',
        'optics_learner_test', 'real_images_test', 'detection_fuzz_test', 'image_advice_test',
        'mirror_rim_test', 'bearing_variance_test'),
}
# For what lives then.
SLOW_TESTS = {
    ESTIMATION: (
        'calibrator_test', 'fault_finder_test', 'adapted_bearings_test', 'calibrator_fuzz_test',
        'fits_beside_test', 'calibration_driver_test', 'odometry_source_test', 'calibrator_states_test',
        'several_lights_test', 'monte_carlo_test'),
    DETECTION: ('rendered_light_test',),
}

Mutant = collections.namedtuple('Mutant', 'path kind start end new')

NAME = r'[A-Za-z_][\w.]*'
# kind: (what is found, what it becomes), of clang-format's spaces: a binary operator stands between two
CHANGES = {
    'factor': (
        (r' \* (?=\S)', ' * 2 * '),
        (r'(?<![\w.>:)\]] )(?<![\w.>:)\]])(?:\d+\.\d*F?|[A-Za-z_]\w*) \* ', ''),
        (r' / %s(?![\w(<\[{])' % NAME, ''),
    ),
    'sign': (
        (r' \+ ', ' - '), (r' - ', ' + '), (r' \+= ', ' -= '), (r' -= ', ' += '),
        (r'(?<=[(\[{])-(?=[\w(])|(?<=, )-(?=[\w(])|(?<== )-(?=[\w(])|(?<=return )-(?=[\w(])', ''),
    ),
    'bound': (
        (r' < ', ' > '), (r' > ', ' < '), (r' <= ', ' >= '), (r' >= ', ' <= '),
        # off by one beside whole numbers: two doubles are equal by chance only
        (r' < (?=\d+\b(?!\.)|[\w.]+size\(\)|[\w.]+count\b)', ' <= '),
        (r' <= (?=\d+\b(?!\.)|[\w.]+size\(\)|[\w.]+count\b)', ' < '),
        (r' > (?=\d+\b(?!\.)|[\w.]+size\(\)|[\w.]+count\b)', ' >= '),
        (r' >= (?=\d+\b(?!\.)|[\w.]+size\(\)|[\w.]+count\b)', ' > '),
    ),
    'order': (
        (r' && ', ' || '), (r' \|\| ', ' && '),
        (r'(?<=\w\()(%s), (%s)(?=\))' % (NAME, NAME), r'\2, \1'),
    ),
    'square': (
        (r'(?<![\w.*] )(?<![\w.])([A-Za-z_][\w.]*(?:\(\))?) \* \1(?![\w.(\[])', r'\1'),
        (r'\bsquaredNorm\(\)', 'norm()'), (r'\bsquared?\(', '('), (r'\bstd::sqrt\(', '('),
        (r'\.cwiseAbs2\(\)', '.cwiseAbs()'),
    ),
    'extreme': (
        (r'\bstd::min\(', 'std::max('), (r'\bstd::max\(', 'std::min('),
        (r'\bminCoeff\(', 'maxCoeff('), (r'\bmaxCoeff\(', 'minCoeff('),
        (r'\bstd::min_element\(', 'std::max_element('), (r'\bstd::max_element\(', 'std::min_element('),
        (r'\bstd::lower_bound\(', 'std::upper_bound('), (r'\bstd::upper_bound\(', 'std::lower_bound('),
    ),
}
# Left alone: their order of arguments changes nothing.
SYMMETRIC = re.compile(r'\b(?:min|max|hypot|swap)\($')
NO_CODE = re.compile(r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"|^[ \t]*#[^\n]*|\b(?:static_)?assert\([^;]*;',
                     re.M | re.S)


def mutantsOf(path, text):
    """All mutants of a source, by their place in it."""
    code = NO_CODE.sub(lambda match: ' ' * len(match.group()), text)
    mutants = []
    for kind, changes in CHANGES.items():
        for pattern, new in changes:
            for match in re.finditer(pattern, code):
                change = match.expand(new)
                if change == match.group() or (kind == 'order' and SYMMETRIC.search(code[:match.start()])):
                    continue
                mutants.append(Mutant(path, kind, match.start(), match.end(), change))
    return sorted(mutants, key=lambda mutant: mutant[2:])


def drawn(mutants, seed):
    """All of them in an order by chance, in which the kinds take turns."""
    generator = random.Random(seed)
    kinds = {kind: [mutant for mutant in mutants if mutant.kind == kind] for kind in CHANGES}
    for of_kind in kinds.values():
        generator.shuffle(of_kind)
    while any(kinds.values()):
        for of_kind in kinds.values():
            if of_kind:
                yield of_kind.pop()


def linesOf(mutant, text):
    """The number of its line; what stands there and what comes there instead, without the margin."""
    first = text.rfind('\n', 0, mutant.start) + 1
    last = text.index('\n', mutant.end)
    after = text[first:mutant.start] + mutant.new + text[mutant.end:last]
    return text.count('\n', 0, mutant.start) + 1, text[first:last].strip(), after.strip()


def equivalentMutants(text):
    """{(path, line, line instead)} of scripts/equivalent_mutants."""
    found = set()
    for entry in re.split(r'\n\s*\n', re.sub(r'^#.*\n', '', text, flags=re.M).strip()):
        lines = entry.splitlines()
        if lines:
            found.add((lines[0], lines[1][2:], lines[2][2:]))
    return found


def read(path):
    with open(path, encoding='utf-8') as file:
        return file.read()


def write(path, text):
    with open(path, 'w', encoding='utf-8') as file:
        file.write(text)


def sources():
    folders = [os.path.join('src', room) for room in FIRST_TESTS]
    return sorted(os.path.join(folder, name) for folder in folders
                  for name in os.listdir(os.path.join(REPOSITORY, folder)) if name.endswith('.cpp'))


def libraryOf(mutant):
    return DETECTION if mutant.path.split(os.sep)[1] in ('optics', 'vision') else ESTIMATION


def copyTo(folder):
    """The repository's files into a folder."""
    names = subprocess.check_output(['git', 'ls-files', '-z', '--cached', '--others', '--exclude-standard'],
                                    cwd=REPOSITORY).decode().split('\0')
    for name in filter(None, names):
        source, target = os.path.join(REPOSITORY, name), os.path.join(folder, name)
        if not os.path.isfile(source):
            continue
        os.makedirs(os.path.dirname(target), exist_ok=True)
        shutil.copy(source, target)


class Workshop:
    """The copy, where one source at a time is compiled, and the tests, which then find it before the
    one of the package's libraries."""

    def __init__(self, copy):
        self.copy = copy
        self.mutant = os.path.join(copy, 'mutant.so')
        self.seconds = {}  # that each test takes as the code stands
        self.commands = {os.path.relpath(entry['file'], os.path.join(copy, 'source')): entry
                         for entry in json.loads(read(os.path.join(copy, 'build', 'compile_commands.json')))}

    def compile(self, path):
        """Whether a source of the copy compiles, into a library of its own."""
        entry = self.commands[path]
        command = shlex.split(entry['command'])
        place = command.index('-o') + 1
        command[place] = self.mutant + '.o'
        link = ['c++', '-shared', '-o', self.mutant, command[place]]
        return all(subprocess.run(each, cwd=entry['directory'], stdout=subprocess.DEVNULL,
                                  stderr=subprocess.DEVNULL).returncode == 0 for each in (command, link))

    def run(self, test, limit_s, mutant):
        """What has failed first; None when nothing has."""
        path = ':'.join(filter(None, (os.path.join(self.copy, 'lib'), os.environ.get('LD_LIBRARY_PATH'))))
        try:
            done = subprocess.run([os.path.join(self.copy, 'tests', test), '--gtest_fail_fast', '--gtest_brief=1'],
                                  env=dict(os.environ, LD_LIBRARY_PATH=path, LD_PRELOAD=mutant), cwd=self.copy,
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=limit_s,
                                  universal_newlines=True, errors='replace')
        except subprocess.TimeoutExpired:
            return 'no end within %.0f s' % limit_s
        if done.returncode == 0:
            return None
        if 'symbol lookup error' in done.stdout:
            sys.exit('%s does not run with the mutant: %s' % (test, done.stdout))
        failed = re.search(r'\[  FAILED  \] ([\w./]+)', done.stdout)
        return failed.group(1) if failed else 'ended with %d' % done.returncode

    def limitOf(self, test):
        if test not in self.seconds:
            start = time.monotonic()
            failed = self.run(test, LONGEST_TEST_S, '')
            if failed:
                sys.exit('%s fails without a mutant: %s' % (test, failed))
            self.seconds[test] = time.monotonic() - start
        return LEAST_LIMIT_S + 5.0 * self.seconds[test]

    def judge(self, mutant, tests):
        """killed, survived or does not compile; by which test."""
        path = os.path.join(self.copy, 'source', mutant.path)
        text = read(path)
        write(path, text[:mutant.start] + mutant.new + text[mutant.end:])
        try:
            if not self.compile(mutant.path):
                return 'does not compile', ''
            for test in tests:
                failed = self.run(test, self.limitOf(test), self.mutant)
                if failed:
                    return 'killed', '%s: %s' % (test, failed)
            return 'survived', ''
        finally:
            write(path, text)


def tryMutants(copy, count, seed, only):
    texts = {path: read(os.path.join(REPOSITORY, path)) for path in sources()}
    mutants = [mutant for path, text in texts.items() for mutant in mutantsOf(path, text)]
    equivalent = equivalentMutants(read(EQUIVALENT))
    workshop = Workshop(copy)
    print('%d mutants of %d sources' % (len(mutants), len(texts)), flush=True)
    if not workshop.compile(next(iter(texts))):
        sys.exit('the copy does not compile without a mutant')

    counts = collections.Counter()
    living = {}

    def tell(number, fate, by, mutant):
        line, old, new = linesOf(mutant, texts[mutant.path])
        print('%3d %-8s %s:%d (%s) %s\n      - %s\n      + %s'
              % (number, fate, mutant.path, line, mutant.kind, by, old, new), flush=True)

    for number, mutant in enumerate(drawn(mutants, seed), 1):
        if len(living) + counts['killed'] == (len(only) or count):
            break
        if only and number not in only:
            continue
        if (mutant.path, *linesOf(mutant, texts[mutant.path])[1:]) in equivalent:
            counts['equivalent'] += 1
            continue
        first = FIRST_TESTS[mutant.path.split(os.sep)[1]]
        fate, by = workshop.judge(mutant, dict.fromkeys(first + QUICK_TESTS[libraryOf(mutant)]))
        if fate == 'survived':
            living[number] = mutant
            tell(number, 'lives', 'after the quick tests', mutant)
            continue
        counts[fate] += 1
        if fate == 'killed':
            tell(number, fate, by, mutant)
    for number, mutant in living.items():
        fate, by = workshop.judge(mutant, SLOW_TESTS[libraryOf(mutant)])
        counts[fate] += 1
        tell(number, fate, by, mutant)

    tried = counts['killed'] + counts['survived']
    print('%d mutants: %d killed, %d survived, %.0f %%; beside them %d equivalent, %d that did not compile'
          % (tried, counts['killed'], counts['survived'], 100.0 * counts['killed'] / max(tried, 1),
             counts['equivalent'], counts['does not compile']))
    return 0 if counts['killed'] >= SMALLEST_SHARE * tried else 1


def main(arguments):
    if arguments == ['--tests']:
        print('\n'.join(test for tests in (QUICK_TESTS, SLOW_TESTS) for of_library in tests.values()
                        for test in of_library))
        return 0
    if arguments[0] == '--copy':
        copyTo(arguments[1])
        return 0
    numbers = [int(number) for number in arguments[1:]]
    count, seed = (numbers + [100, 1][len(numbers):])[:2]
    return tryMutants(arguments[0], count, seed, numbers[2:])


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
