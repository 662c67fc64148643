"""The paper's figures: the same from run to run, and doc/evidence/paper is what the command writes."""

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
SCRIPT = os.path.join(REPOSITORY, 'tools', 'paper', 'reproduce_paper.py')
COMMITTED = os.path.join(REPOSITORY, 'doc', 'evidence', 'paper')
# The paper's own numbers, those of its figures, equations and parameters, and the settings of the
# runs with the moments that are looked at, as they stand in the text.
SETTINGS = {'0', '0.01', '0.074', '0.1', '0.2', '0.5', '1', '1.58', '1.8', '2', '3', '3.11', '4', '5',
            '6', '8', '10', '12', '14', '20', '45', '100', '200', '450', '480', '640', '800', '1000',
            '2006'}

spec = importlib.util.spec_from_file_location('reproduce_paper', SCRIPT)
reproduce_paper = importlib.util.module_from_spec(spec)
spec.loader.exec_module(reproduce_paper)


def reproduce(folder, *options):
    program = roslib.packages.find_node('bearing_calibration', 'paper_numbers')[0]
    return subprocess.run([sys.executable, SCRIPT, folder, '--program', program] + list(options),
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          universal_newlines=True, timeout=600)


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

    def testTheLightIsFoundInEveryImage(self):
        camera = reproduce_paper.Table(os.path.join(self.folder, 'fig5_camera.csv'))
        self.assertGreater(camera.value('images'), 50)
        self.assertEqual(camera.value('found'), camera.value('images'))

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
        """Any other number in it is the paper's own or a setting: all are listed here."""
        with open(reproduce_paper.TEMPLATE) as file:
            template = reproduce_paper.FIELD.sub('', file.read())
        template = re.sub(r'\]\([^)]*\)', ']', template)  # names of files
        self.assertLessEqual(set(re.findall(r'\d+(?:\.\d+)?', template)), SETTINGS)

    def testItsVerdictsHold(self):
        """What the text concludes in words, by the files' numbers."""
        def value(name, column, *where):
            path = os.path.join(COMMITTED, name + '.csv')
            return reproduce_paper.Table(path).value(column, *where)
        at_4_m = ('distance_m', 4.0)
        # Fig. 2: reachable with large steps only
        self.assertLess(value('fig2_centimetre_runs', 'phi_bound_deg'), 4.0)
        self.assertLess(value('fig2_centimetre_runs', 'rho_bound_mm'), 10.0)
        self.assertGreater(value('fig2_literal_runs', 'phi_bound_deg'), 4.0)
        for name in ('fig2_tenth_runs', 'fig2_hundredth_runs'):
            self.assertGreater(value(name, 'phi_bound_deg'), 10.0)
        # Fig. 3: ten times beyond what is printed; even an exact camera does not reach it
        self.assertGreater(value('fig3_runs', 'phi_bound_deg', *at_4_m), 1.0)
        self.assertGreater(value('fig3_exact_camera_runs', 'phi_bound_deg', *at_4_m), 0.3)
        self.assertLess(value('fig3_runs', 'as_printed_percent', *at_4_m), 1.0)
        self.assertLess(value('fig3_runs', 'phi_rmse_deg'),
                        1.15 * value('fig3_runs', 'phi_bound_deg'))
        # the second trajectory is faster than any reading of the first
        for reading in ('literal', 'centimetre', 'tenth', 'hundredth'):
            self.assertLess(value('fig3_runs', 'phi_rmse_deg', 'time_s', 99.9),
                            value('fig2_%s_runs' % reading, 'phi_bound_deg', 'time_s', 99.9))
        # Fig. 5: found everywhere, stable from 3 m on, and on the bound when told the noise
        self.assertEqual(value('fig5_camera', 'found'), value('fig5_camera', 'images'))
        for distance_m in (3.0, 5.0, 10.0):
            for column, unit in (('phi', 'deg'), ('rho', 'mm'), ('psi', 'deg')):
                there = ('distance_m', distance_m)
                error = (value('fig5_run', '%s_estimate_%s' % (column, unit), *there)
                         - value('fig5_run', '%s_truth_%s' % (column, unit), *there))
                stddev = value('fig5_run', '%s_stddev_%s' % (column, unit), *there)
                self.assertLess(abs(error), 3.0 * stddev)
        self.assertAlmostEqual(value('fig5_told_runs', 'phi_rmse_deg')
                               / value('fig5_told_runs', 'phi_bound_deg'), 1.0, delta=0.15)


if __name__ == '__main__':
    unittest.main()
