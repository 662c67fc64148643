"""The front page is short, the words of pages, parameters, messages and texts are those of the field,
a number that two pages, or a page and a configuration, state is the same on both, and parameters that
are named exist."""

import ast
import decimal
import glob
import math
import os
import re
import sys
import unittest

import yaml

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from documents_test import DOCUMENTS, REPOSITORY, commandsIn, reference_pages, textOf  # noqa: E402

READ_AS_THEY_ARE = ('config/**/*.yaml', 'config/*.xml', 'msg/*.msg', 'srv/*.srv', 'action/*.action', 'launch/*.launch',
                    'rviz/*.rviz', 'tools/owner/report/page.html')
CODE = [path for folder, pattern in (('src', '*.cpp'), ('include', '*.h'), ('tools', '*.cpp'), ('tools', '*.h'),
                                     ('tools', '*.py'))
        for path in glob.glob(os.path.join(REPOSITORY, folder, '**', pattern), recursive=True)]


def below(path):
    return os.path.relpath(path, REPOSITORY)


def prose(text):
    """What a reader reads of a page: no code, no comments, no targets of links."""
    text = re.sub(r'(?ms)^ *```.*?^ *```$', '', text)
    text = re.sub(r'(?s)<!--.*?-->', '', text)
    text = re.sub(r'(?m)^(?: {4,}|\t)(?:\./|[A-Z_]+=\S+ |sudo |source |rosrun |roslaunch ).*(?:\\\n.*)*', '',
                  text)
    return re.sub(r'\]\([^)]*\)', ']', text)


def wordsOf(text):
    """Runs of characters between spaces that hold a letter or a digit: '0.31°' is one word, '|' and
    '-' are none. Inline code, headings, cells of tables and the texts of links and pictures count."""
    return [word for word in prose(text).split() if re.search(r'\w', word)]


class FrontPage(unittest.TestCase):

    def testItIsShort(self):
        words = wordsOf(textOf('README.md'))
        self.assertLessEqual(len(words), 500)
        self.assertGreater(len(words), 300, 'is everything counted?')

    def testItsFirstCommandIsTheWholePath(self):
        self.assertEqual(next(commandsIn(os.path.join(REPOSITORY, 'README.md'))), './scripts/demo')

    def testItsResultIsThatOfTheQuickStart(self):
        result = re.search(r'```\n(Result\n.*?)```', textOf('README.md'), re.S).group(1)
        self.assertIn(result, textOf('doc', 'tutorials', 'quick_start.md'))

    def testWhatCounts(self):
        self.assertEqual(wordsOf('# One *two*\n\n    ./scripts/demo a b\n\n- three <!-- no -->`four`\n'
                                 '| five | [six](no.html) |\n```\nno\n```\n'),
                         ['One', '*two*', 'three', '`four`', 'five', '[six]'])


def textsOfPython(source):
    """[(line, text)] of its constants, which are what is printed, without documentation."""
    tree = ast.parse(source)
    documentation = {id(node.body[0].value) for node in ast.walk(tree)
                     if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef)) and node.body
                     and isinstance(node.body[0], ast.Expr)}
    return [(node.lineno, node.value) for node in ast.walk(tree)
            if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in documentation]


def textsOfCpp(source):
    """[(line, text)] of its literals, those of several lines as one."""
    source = re.sub(r'(?m)^#include.*$', '', source)
    literal = r'"(?:[^"\\\n]|\\.)*"'
    found = []
    for match in re.finditer(r'//[^\n]*|\'(?:[^\'\\]|\\.)\'|(%s(?:\s*%s)*)' % (literal, literal), source):
        if match.group(1):
            text = ''.join(part[1:-1] for part in re.findall(literal, match.group(1)))
            found.append((source[:match.start()].count('\n') + 1, text.replace('\\n', '\n')))
    return found


def allTexts():
    """(file, first line, text) of pages, parameters, messages and what is printed."""
    for path in DOCUMENTS:
        yield below(path), 1, textOf(path)
    for pattern in READ_AS_THEY_ARE:
        paths = glob.glob(os.path.join(REPOSITORY, pattern), recursive=True)
        assert paths, pattern
        for path in paths:
            yield below(path), 1, textOf(path)
    for path in CODE:
        for line, text in (textsOfPython if path.endswith('.py') else textsOfCpp)(textOf(path)):
            yield below(path), line, text


class Words(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        listed = yaml.safe_load(textOf('test', 'repository', 'words.yaml'))
        cls.instead = {re.compile(r'(?i)(?<![\w-])(?:%s)(?![\w-])' % word.replace(' ', r'\s+')): says
                       for word, says in listed['words'].items()}
        cls.exceptions = listed['exceptions'] or []
        cls.unused = list(cls.exceptions)

    def isOrdinary(self, place, text, match):
        around = ' '.join(text[max(0, match.start() - 40):match.end() + 40].split())
        for exception in self.exceptions:
            if exception['file'] in place and exception['text'] in around:
                if exception in self.unused:
                    self.unused.remove(exception)
                return True
        return False

    def check(self, place, text, line=1):
        for word, says in self.instead.items():
            for match in word.finditer(text):
                if not self.isOrdinary(place, text, match):
                    at = text[:match.start()].count('\n')
                    with self.subTest(file=place, line=line + at, word=match.group(0),
                                      text=text.splitlines()[at].strip()[:100]):
                        self.fail('say instead: ' + says)

    def testTheyAreThoseOfTheField(self):
        texts = 0
        for place, line, text in allTexts():
            texts += 1
            if place.endswith('.md'):
                # Names of topics, options and parameters in code are not read as words.
                text = re.sub(r'`[^`]*`', '', prose(text))
            self.check(place, text, line)
        self.assertGreater(texts, 1000)
        self.assertEqual(self.unused, [], 'exceptions that nothing needs any more')

    def testParametersHaveNoneOfThem(self):
        names = [key for name, _, _ in reference_pages.CONFIGURATIONS
                 for group, _, rows in reference_pages.parametersOf(textOf('config', name))
                 for key in [group] + [row[0] for row in rows]]
        self.assertGreater(len(names), 150)
        for name in names:
            self.check('the parameter ' + name, name.replace('_', ' '))

    def testWhatIsReadOfCode(self):
        self.assertEqual(textsOfCpp('#include "no"\nint a = \'"\';  // "no"\nf("one \\"x\\""\n  " two");\n'),
                         [(3, 'one \\"x\\" two')])
        self.assertEqual(textsOfPython('"""No."""\nf(\'one \'\n  \'two\')\n'), [(2, 'one two')])


class ParameterNames(unittest.TestCase):
    """Those that pages, comments and texts name are there."""

    NOT_PARAMETERS = {'camera/image_raw', 'images/s'}
    EXAMPLES = {'errors/azimuth_scale_stddev'}  # one that architecture.md adds

    def testTheyExist(self):
        parameters = {'%s/%s' % (group, row[0]) for name, _, _ in reference_pages.CONFIGURATIONS
                      for group, _, rows in reference_pages.parametersOf(textOf('config', name)) for row in rows}
        sources = {re.sub(r'^(?:include/bearing_calibration|src)/|\.\w+$', '', below(path)) for path in CODE}
        known = parameters | sources | self.NOT_PARAMETERS | self.EXAMPLES
        groups = '|'.join({name.split('/')[0] for name in parameters})
        # camera/rate, errors/*_stddev and wheels/noise_*, but no file and no longer path
        pattern = re.compile(r'(?<![\w/.~$-])((?:%s)/(?:\\?\*)?\w+(?:\\?\*)?)(?![\w/.-]*[/.]\w)' % groups)
        found = 0
        for place, _, text in allTexts():
            if place.startswith('src/simulation/'):
                continue  # the parameters of studies
            for name in pattern.findall(text):
                found += 1
                with self.subTest(file=place, name=name):
                    wanted = re.escape(name.replace('\\', '')).replace(r'\*', r'\w*')
                    self.assertTrue(any(re.fullmatch(wanted, one) for one in known))
        self.assertGreater(found, 200)


class Numbers(unittest.TestCase):

    # <!--same: NAME-->1.4 marks a number that other pages state too, with the same mark, and
    # <!--default: GROUP/PARAMETER-->1 cm one that a file of config states.
    MARK = re.compile(r'<!--(same|default): ([\w/]+)-->[^\w<]*(\d[\d.]*(?:e-?\d+)?)(?: (%|[a-z]+))?')
    UNITS = {'': 1.0, '%': 0.01, 'cm': 0.01, 'mm': 0.001, 'm': 1.0, 's': 1.0, 'rad': 1.0,
             'deg': math.radians(1.0), 'degrees': math.radians(1.0)}

    def marks(self):
        """(page, kind, name, number, unit) of each."""
        for path in DOCUMENTS:
            text = re.sub(r'`[^`]*`', '', textOf(path))
            found = self.MARK.findall(text)
            self.assertEqual(len(found), len(re.findall('<!--(?:same|default)', text)),
                             'a mark without a number in ' + path)
            yield from ((below(path), kind, name, number.rstrip('.'), unit) for kind, name, number, unit in found)

    def testNumbersOfTheSameNameAreTheSame(self):
        stated = {}
        for page, kind, name, number, _ in self.marks():
            if kind == 'same':
                stated.setdefault(name, []).append((page, number))
        self.assertGreater(len(stated), 5)
        for name, places in stated.items():
            with self.subTest(name=name):
                self.assertEqual(len({number for _, number in places}), 1, places)
                self.assertGreater(len(places), 1, 'marked only once, on ' + places[0][0])

    def testDefaultsAreThoseOfTheConfigurations(self):
        """To the digits that the page states."""
        defaults = {'%s/%s' % (group, row[0]): row[1] for name in ('calibration.yaml', 'detection.yaml', 'drive.yaml')
                    for group, _, rows in reference_pages.parametersOf(textOf('config', name)) for row in rows}
        marked = [mark for mark in self.marks() if mark[1] == 'default']
        self.assertGreater(len(marked), 10)
        for page, _, name, number, unit in marked:
            with self.subTest(page=page, name=name):
                scale = self.UNITS.get(unit, 1.0)
                last_digit = 10.0 ** decimal.Decimal(number).as_tuple().exponent
                self.assertAlmostEqual(scale * float(number), float(defaults[name]), delta=0.5 * scale * last_digit)


if __name__ == '__main__':
    unittest.main()
