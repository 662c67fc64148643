"""The documents' commands have the options that they are shown with, are run by tests, and their
code does what they say; their tables, blocks and equations are shown as they are meant; the
reference pages are those of the files that they describe; links lead to sections that exist."""

import glob
import io
import itertools
import os
import re
import shlex
import subprocess
import sys
import tempfile
import unittest
from unittest import mock

import roslib.packages
import yaml

REPOSITORY = os.path.abspath(os.path.join(os.path.dirname(__file__), '..', '..'))
sys.path.insert(0, os.path.join(REPOSITORY, 'scripts'))
import reference_pages  # noqa: E402  (lies in scripts)

DOCUMENTS = [os.path.join(REPOSITORY, name) for name in ('README.md', 'CONTRIBUTING.md')] + sorted(
    glob.glob(os.path.join(REPOSITORY, 'doc', '**', '*.md'), recursive=True))
COMMAND = re.compile(r'^ *(?:sudo )?(?:[A-Z_]+=\S+ )*'
                     r'(\./scripts/\w+|rosrun|roslaunch|parallel)\b((?:.*\\\n)*.*)$', re.M)
NUMBERED_EQUATION = re.compile(r'^    .*\s\((\d+)\)$', re.M)
# model.md, eqs. 5 to 8; [start.md](start.md), "Batch". It may go on in the next line's comment.
CITATION = re.compile(r'(\w+\.md)\)?,\s+(?:(?:///?|#) )?'
                      r'(?:eqs?\. ((?:\d+(?:, | and | to )?)+)|(?:section )?"([^"\n]+)")')
CITING = [path for folder in ('bench', 'include', 'src', 'test', 'tools') for name in ('*.h', '*.cpp', '*.py')
          for path in glob.glob(os.path.join(REPOSITORY, folder, '**', name), recursive=True)]
TEMPLATE = os.path.join(REPOSITORY, 'tools', 'paper', 'reproduce_paper.md')


def textOf(*path):
    with open(os.path.join(REPOSITORY, *path)) as file:
        return file.read()


def pathOf(page):
    """Of the one page of that name."""
    paths = [path for path in DOCUMENTS + [TEMPLATE] if os.path.basename(path) == page]
    assert len(paths) == 1, '%d pages are called %s' % (len(paths), page)
    return paths[0]


def commandsIn(path):
    """Commands of a document's code, each on one line."""
    for match in COMMAND.finditer(textOf(path)):
        if match.group(0).startswith(' ') or '```' in textOf(path):
            yield (match.group(1) + match.group(2)).replace('\\\n', ' ')


def allCommands():
    return [(os.path.relpath(path, REPOSITORY), command)
            for path in DOCUMENTS for command in commandsIn(path)]


def textOfTests():
    paths = [path for pattern in ('*.py', '*.test', 'try_package', 'CMakeLists.txt')
             for path in glob.glob(os.path.join(REPOSITORY, 'test', '**', pattern), recursive=True)]
    return '\n'.join(textOf(path) for path in paths if path != os.path.abspath(__file__))


class Commands(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        cls.helps = {}

    def helpOf(self, program):
        if program not in self.helps:
            path = roslib.packages.find_node('bearing_calibration', program)[0]
            done = subprocess.run([path, '--help'], stdin=subprocess.DEVNULL,
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                  universal_newlines=True, timeout=600)
            self.helps[program] = done.stdout
        return self.helps[program]

    def testThereAreManyOfThem(self):
        self.assertGreater(len(allCommands()), 40)

    def testTheirOptionsExist(self):
        checked = 0
        for document, command in allCommands():
            for program, rest in re.findall(r'rosrun bearing_calibration (\w+)([^|;]*)', command):
                for option in re.findall(r'(?<!\S)--?[a-z][\w-]*', rest):
                    checked += 1
                    with self.subTest(document=document, program=program, option=option):
                        self.assertIn(option, self.helpOf(program))
        self.assertGreater(checked, 10)

    def testEveryProgramAndLaunchFileIsRunByATest(self):
        tests = textOfTests()
        for document, command in allCommands():
            names = re.findall(r'rosrun bearing_calibration (\w+)', command)
            names += re.findall(r'roslaunch bearing_calibration (\w+)\.launch', command)
            for name in names:
                with self.subTest(document=document, name=name):
                    self.assertTrue(re.search(r'\b%s\b' % name, tests), 'no test names it')


def blocksOf(text, is_inside):
    """(line number, lines) of each run of lines that is_inside(line) holds for, without fences."""
    block, fenced = [], False
    for number, line in enumerate(text.splitlines() + [''], 1):
        fenced ^= line.lstrip().startswith('```')
        if is_inside(line) and not fenced:
            block.append(line)
        elif block:
            yield number - len(block), block
            block = []


def commandsAlone(lines):
    """Whether indented lines that begin with a command have nothing else after an empty line. What is
    indented less than the command belongs to the list that the block stands in."""
    lines = '\n'.join(lines).strip('\n').split('\n')
    indentation = re.match(' *', lines[0]).group(0)
    block = itertools.takewhile(lambda line: line.startswith(indentation) or not line, lines)
    starts = re.split(r'\n\s*\n', '\n'.join(block).strip('\n'))
    return not COMMAND.match(starts[0]) or all(COMMAND.match(start) for start in starts)


class Rendering(unittest.TestCase):
    """What a page looks like, by the rules of CommonMark with GitHub's tables."""

    def testTablesAreWhole(self):
        tables = 0
        for path in DOCUMENTS:
            for number, rows in blocksOf(textOf(path), lambda line: line.startswith('|')):
                tables += 1
                with self.subTest(document=os.path.relpath(path, REPOSITORY), line=number):
                    self.assertRegex(''.join(rows[1:2]), r'^[|:-]+$',
                                     'rows without a head: does an empty line cut them off?')
                    cells = {len(re.findall(r'(?<!\\)\|', row)) for row in rows}
                    self.assertEqual(len(cells), 1, 'rows of different lengths')
                    after = textOf(path).splitlines()[number - 1 + len(rows):][:1]
                    self.assertEqual(''.join(after), '', 'the text below becomes a row')
        self.assertGreater(tables, 40)

    def testEveryTableOfFiguresNamesItsConfiguration(self):
        named_in_header = re.compile(r'\| (configuration|default|aim|parameters?) \|')
        for page in ('accuracy.md', 'imperfect.md'):
            lines = textOf(pathOf(page)).splitlines()
            tables = [number for number, line in enumerate(lines)
                      if line.startswith('|') and not lines[number - 1].startswith('|')]
            for number in tables:
                with self.subTest(page=page, line=number + 1):
                    self.assertTrue(named_in_header.search(lines[number]) or
                                    lines[number - 2].startswith('Configuration: '))

    def testABlockOfCommandsHoldsNothingElse(self):
        """An empty line does not end an indented block: what follows must not be indented too."""
        for path in DOCUMENTS:
            for number, lines in blocksOf(textOf(path), lambda line: re.match(r'    |$', line)):
                with self.subTest(document=os.path.relpath(path, REPOSITORY), line=number):
                    self.assertTrue(commandsAlone(lines), '\n'.join(lines))

    def testNoCommentBeginsALine(self):
        """There it would end the paragraph."""
        for path in DOCUMENTS:
            with self.subTest(document=os.path.relpath(path, REPOSITORY)):
                self.assertNotRegex(textOf(path), r'(?m)^ *<!--')

    def testEquationsAreNumberedInTheirOrder(self):
        numbered = set()
        for path in DOCUMENTS:
            numbers = [int(number) for number in NUMBERED_EQUATION.findall(textOf(path))]
            self.assertEqual(numbers, list(range(1, len(numbers) + 1)), path)
            if numbers:
                numbered.add(path)
        self.assertLessEqual({pathOf('model.md'), pathOf('start.md')}, numbered)

    def testCitedEquationsAndSectionsAreThere(self):
        found = 0
        for path in DOCUMENTS + CITING:
            for page, equations, section in CITATION.findall(textOf(path)):
                found += 1
                text = textOf(pathOf(page))
                with self.subTest(file=os.path.relpath(path, REPOSITORY), page=page):
                    self.assertLessEqual(set(re.findall(r'\d+', equations)),
                                         set(NUMBERED_EQUATION.findall(text)))
                    self.assertTrue(re.search(r'(?m)^(#+ |\*\*)' + re.escape(section), text),
                                    'no section "%s"' % section)
        self.assertGreater(found, 40)


class Links(unittest.TestCase):

    @staticmethod
    def anchorsOf(path):
        """As GitHub makes them of headings."""
        return {re.sub(r'[^\w\- ]', '', heading.lower()).replace(' ', '-')
                for heading in re.findall(r'(?m)^#+ (.*)$', textOf(path))}

    def testLinkedSectionsExist(self):
        found = 0
        for path in DOCUMENTS:
            for target, anchor in re.findall(r'\]\(([^)#:]*)#([^)]+)\)', textOf(path)):
                found += 1
                other = os.path.join(os.path.dirname(path), target) if target else path
                with self.subTest(document=os.path.relpath(path, REPOSITORY), target=target):
                    self.assertIn(anchor, self.anchorsOf(other))
        self.assertGreater(found, 5)

    def testPagesThatAreNamedAreThere(self):
        """In documents, code, messages and configurations by their path (doc/images), in code also
        by a page's name alone."""
        others = [path for pattern in ('CHANGELOG.rst', 'config/**/*.yaml', 'msg/*', 'scripts/*')
                  for path in glob.glob(os.path.join(REPOSITORY, pattern), recursive=True)]
        found = 0
        for path in DOCUMENTS + CITING + others:
            if path == os.path.abspath(__file__) or not os.path.isfile(path):
                continue
            names = re.findall(r'(?<![\w/.-])doc/[\w./-]*\w', textOf(path))
            if path in CITING:
                names += [os.path.relpath(pathOf(name), REPOSITORY)
                          for name in re.findall(r'(?<![\w/.-])(?!README|index)\w+\.md\b', textOf(path))]
            found += len(names)
            for name in names:
                with self.subTest(file=os.path.relpath(path, REPOSITORY), name=name):
                    self.assertTrue(os.path.exists(os.path.join(REPOSITORY, name)))
        self.assertGreater(found, 100)


class QuickStart(unittest.TestCase):

    def testItsCommandsLeadToTheFilesThatItNames(self):
        """Those without a master, as they stand there; the live ones have tests of their own."""
        with tempfile.TemporaryDirectory() as folder:
            os.symlink(os.path.join(REPOSITORY, 'config'), os.path.join(folder, 'config'))
            ran = []
            for command in commandsIn(pathOf('quick_start.md')):
                words = shlex.split(command)
                if words[:3] != ['./scripts/run', 'rosrun', 'bearing_calibration']:
                    continue
                program = roslib.packages.find_node('bearing_calibration', words[3])[0]
                done = subprocess.run([program] + words[4:], cwd=folder, stdin=subprocess.DEVNULL,
                                      stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                      universal_newlines=True, timeout=600)
                self.assertEqual(done.returncode, 0, done.stdout)
                ran.append(words[3])
            self.assertEqual(ran, ['simulate_bag', 'calibrate_bag', 'calibration_report'])
            for name in re.findall(r'`(result/[\w.]+)`', textOf(pathOf('quick_start.md'))):
                self.assertTrue(os.path.exists(os.path.join(folder, name)), name)


class RobotFile(unittest.TestCase):

    def testWhatIsShownOfItHasEveryRequiredNumberOfARobot(self):
        def numbersIn(text):
            return {'%s/%s' % (group, name): value
                    for block in re.findall(r'(?ms)^ *```yaml\n(.*?)^ *```$', text)[:1]
                    for group, values in yaml.safe_load(block).items() for name, value in values.items()}
        for page, config in (('quick_start.md', 'calibration.yaml'), ('camera.md', 'detection.yaml')):
            with self.subTest(page=page):
                required = {'%s/%s' % (group, key) for group, _, rows in
                            reference_pages.parametersOf(textOf('config', config))
                            for key, value, _ in rows if value == 'required'}
                shown = numbersIn(textOf(pathOf(page)))
                self.assertEqual(set(shown), required)
                for name, value in shown.items():
                    self.assertIsInstance(value, (int, float), name)  # 4e-3 is text in YAML


class BearingSensor(unittest.TestCase):

    def testTheExamplesMessageIsOne(self):
        import rospy
        code = re.search(r'```python\n(.*?)```', textOf(pathOf('bearing_sensor.md')), re.S).group(1)
        names = {}
        with mock.patch('rospy.init_node'), mock.patch('rospy.Publisher') as publisher:
            exec(code, names)  # the document's own code
            names['publish'](rospy.Time(10, 5), 0.3, 0.01)
        message = publisher.return_value.publish.call_args[0][0]
        with io.BytesIO() as buffer:
            message.serialize(buffer)
            self.assertGreater(buffer.tell(), 50)
        self.assertEqual(message.header.stamp, rospy.Time(10, 5))
        self.assertAlmostEqual(message.candidates[0].azimuth_variance, 1e-4)
        self.assertEqual(publisher.call_args[0][0], 'bearings')


class References(unittest.TestCase):

    def testThePagesAreThoseOfTheFiles(self):
        for name, page in reference_pages.PAGES.items():
            self.assertEqual(textOf('doc', name), page(),
                             'doc/%s is stale: run scripts/reference_pages.py' % name)

    def testEveryInterfaceAndConfigurationIsOnThem(self):
        for folder, name in ((folder, os.path.splitext(name)[0]) for folder in
                             ('msg', 'srv', 'action')
                             for name in os.listdir(os.path.join(REPOSITORY, folder))):
            self.assertIn((folder, name), [entry[:2] for entry in reference_pages.INTERFACES])
        described = {name for name, _, _ in reference_pages.CONFIGURATIONS}
        # values for the parameters of simulation.yaml and of calibration.yaml
        overlays = {'scene.yaml', 'paper.yaml'}
        names = {os.path.basename(path)
                 for path in glob.glob(os.path.join(REPOSITORY, 'config', '*.yaml'))}
        self.assertEqual(names - overlays, described)

    def testCommentsOverSeveralLinesAndGroupsAreKept(self):
        groups = reference_pages.parametersOf(
            'group:  # what it is\n  first: 1.0   # [m] begins\n               # and ends\n'
            '  # stands above\n  second: [1, 2]  # and beside\n')
        self.assertEqual(groups, [('group', 'what it is', [
            ['first', '1.0', '[m] begins and ends'],
            ['second', '[1, 2]', 'stands above and beside']])])

    def testPromisesAreThoseOfTheTestsBelowTheirMarks(self):
        self.assertEqual(
            reference_pages.promisesIn(
                '# Promise kept: a\n    # Promise still: b\n    def test_it(self):\n    def test_other(self):\n'
                '// Promise kept: c\nTEST_F(Fixture, Does) {\n', 'x'),
            [('kept', 'a', 'test_it'), ('still', 'b', 'test_it'), ('kept', 'c', 'Fixture.Does')])
        with self.assertRaisesRegex(ValueError, 'x: .*: a'):
            reference_pages.promisesIn('# Promise kept: a\nnumber = 1\ndef test_it(self):\n', 'x')
        sections = textOf('doc', 'background', 'promises.md').split('\n## ')[1:]
        self.assertEqual(len(sections), len(reference_pages.PROMISES))
        for section in sections:
            self.assertGreater(section.count('\n| '), 2, section)

    def testTheIndexLeadsToEveryPage(self):
        index = textOf('doc', 'README.md')
        for path in DOCUMENTS:
            name = os.path.relpath(path, os.path.join(REPOSITORY, 'doc'))
            if name != 'README.md' and name != os.path.join('..', 'README.md'):
                self.assertIn('(%s)' % name, index)


if __name__ == '__main__':
    unittest.main()
