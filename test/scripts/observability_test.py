"""The observability section of model.md is what its two programs print."""

import os
import subprocess
import unittest

import roslib.packages

REPOSITORY = os.path.abspath(os.path.join(os.path.dirname(__file__), '..', '..'))


def output(command):
    """What the command prints; it must succeed."""
    return subprocess.run(command, stdout=subprocess.PIPE, universal_newlines=True, check=True,
                          timeout=600).stdout


def cellsOf(text):
    """The cells of each line of the tables."""
    return [[cell.strip() for cell in line.strip('|').split('|')]
            for line in text.split('\n') if line.startswith('|')]


class Observability(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        with open(os.path.join(REPOSITORY, 'doc', 'background', 'model.md')) as file:
            cls.document = cellsOf(file.read())

    def testRanksByMotionStandInTheDocument(self):
        """Motion, rank and number of unknowns; the singular values are the machine's rounding."""
        program = roslib.packages.find_node('bearing_calibration', 'observability_table')[0]
        ranks = [cells[:3] for cells in cellsOf(output([program]))]
        self.assertGreater(len(ranks), 20)
        written = [cells[:3] for cells in self.document]
        for cells in ranks:
            self.assertIn(cells, written)

    def testTheAppendixIsCorrectedAsTheDocumentHasIt(self):
        program = os.path.join(REPOSITORY, 'tools', 'paper', 'appendix_observability.py')
        text = output(['python3', program])  # fails when a formula or a rank is another one
        self.assertIn('Determinant of the five gradients: +-D^2 rho (D^2 - rho^2) '
                      '(D + rho cos(theta + phi)) / gamma^5: right', text)
        rows = cellsOf(text)
        self.assertIn(['(A.5)', 'wrong', 'right'], rows)
        ranks = rows[rows.index(['where', 'rank of the five', 'with brackets of the third order']):]
        self.assertGreater(len(ranks), 4)
        for cells in ranks:
            self.assertIn(cells, self.document)


if __name__ == '__main__':
    unittest.main()
