"""The paper's figures: the same from run to run, and doc/paper is what the command writes."""

import glob
import importlib.util
import os
import re
import subprocess
import sys
import tempfile
import unittest

import roslib.packages

REPOSITORY = os.path.abspath(os.path.join(os.path.dirname(__file__), '..', '..'))
SCRIPT = os.path.join(REPOSITORY, 'tools', 'reproduce_paper.py')
COMMITTED = os.path.join(REPOSITORY, 'doc', 'paper')
# The paper's own numbers and the settings of the runs, as they stand in the text.
SETTINGS = {'0.01', '0.074', '0.1', '0.2', '0.5', '1.58', '3.11'}

spec = importlib.util.spec_from_file_location('reproduce_paper', SCRIPT)
reproduce_paper = importlib.util.module_from_spec(spec)
spec.loader.exec_module(reproduce_paper)


def reproduce(folder, *options):
    program = roslib.packages.find_node('bearing_calibration', 'paper_numbers')[0]
    return subprocess.run([sys.executable, SCRIPT, folder, '--program', program] + list(options),
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          universal_newlines=True, timeout=200)


def contentOf(folder):
    content = {}
    for path in glob.glob(os.path.join(folder, '*')):
        with open(path, 'rb') as file:
            content[os.path.basename(path)] = file.read()
    return content


class Command(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = folder.name
        cls.done = reproduce(cls.folder, '--runs', '3', '--seconds', '10')

    def testItWritesNumbersAndFigures(self):
        self.assertEqual(self.done.returncode, 0, self.done.stdout)
        for figure in reproduce_paper.FIGURES:
            for ending in ('.png', '.svg', '_run.csv', '_runs.csv'):
                self.assertGreater(os.path.getsize(os.path.join(self.folder, figure + ending)), 0)

    def testTheSameSeedGivesTheSameFiles(self):
        with tempfile.TemporaryDirectory() as folder:
            again = reproduce(folder, '--runs', '3', '--seconds', '10', '--draw', 'fig3')
            self.assertEqual(again.returncode, 0, again.stdout)
            second = contentOf(folder)
        first = contentOf(self.folder)
        self.assertLessEqual({'fig3.png', 'fig3.svg', 'fig2_tenth_runs.csv', 'fig5_run.csv'},
                             set(second))
        for name in sorted(second):
            self.assertEqual(first[name], second[name], name + ' differs')

    def testItsRunIsTheCommittedOne(self):
        """Not to the last digit: another processor may round its sines otherwise."""
        new = reproduce_paper.Table(os.path.join(self.folder, 'fig3_run.csv'))
        old = reproduce_paper.Table(os.path.join(COMMITTED, 'fig3_run.csv'))
        new_by_time = {row['time_s']: row for row in new.rows}
        common = [(row, new_by_time[row['time_s']]) for row in old.rows
                  if row['time_s'] in new_by_time]
        self.assertGreater(len(common), 10)
        for before, after in common:
            for column, value in before.items():
                self.assertAlmostEqual(float(value), float(after[column]), msg=column,
                                       delta=1e-3 * max(1.0, abs(float(value))))

    def testAFailureIsPassedOn(self):
        with tempfile.TemporaryDirectory() as folder:
            done = reproduce(folder, '--runs', '0')
        self.assertNotEqual(done.returncode, 0)
        self.assertIn('usage', done.stdout)


class CommittedFigures(unittest.TestCase):

    def testTheTextHasTheNumbersOfItsFiles(self):
        with open(reproduce_paper.TEMPLATE) as file:
            template = file.read()
        self.assertGreater(len(reproduce_paper.FIELD.findall(template)), 30)
        with open(os.path.join(COMMITTED, 'README.md')) as file:
            self.assertEqual(file.read(), reproduce_paper.filledIn(template, COMMITTED))

    def testNothingElseInTheTemplateIsMeasured(self):
        """A decimal fraction in it is the paper's own number or a setting: all are listed here."""
        with open(reproduce_paper.TEMPLATE) as file:
            template = reproduce_paper.FIELD.sub('', file.read())
        self.assertLessEqual(set(re.findall(r'\d+\.\d+', template)), SETTINGS)


if __name__ == '__main__':
    unittest.main()
