#!/usr/bin/env python3
"""The paper's figures 2, 3 and 5, computed, drawn and compared: reproduce_paper.py FOLDER

Runs paper_numbers, which writes the numbers as CSV files; draws them as PNG and SVG; and writes
README.md, the comparison with what the paper says. Every number in that text is taken from the files:
    {FILE COLUMN FORMAT}               the last line of FILE.csv
    {FILE COLUMN NAME=VALUE FORMAT}    its first line where the column NAME has reached VALUE
stand for them in reproduce_paper.md, the text's template.
"""

import argparse
import csv
import os
import re
import subprocess
import sys

import matplotlib
matplotlib.use('Agg')
import matplotlib.pyplot as plt  # noqa: E402
from matplotlib import ticker  # noqa: E402

TEMPLATE = os.path.join(os.path.dirname(os.path.abspath(__file__)), 'reproduce_paper.md')
FIELD = re.compile(r'\{(\w+) (\w+)(?: (\w+)=([\d.]+))? (\.\d+f)\}')
PARAMETERS = (('phi', 'deg', '$\\phi$'), ('rho', 'mm', '$\\rho$'), ('psi', 'deg', '$\\psi$'))
# name: (title, column of the horizontal axis, its label)
FIGURES = {
    'fig2_literal': ('Fig. 2, simulated: steps of 2 mm, variance 0.01 m times 2 mm, as printed',
                     'time_s', 'time [s]'),
    'fig2_centimetre': ('Fig. 2, simulated: steps of 2 mm, standard deviation 0.01 m',
                        'time_s', 'time [s]'),
    'fig2_tenth': ('Fig. 2, simulated: steps of 2 mm, standard deviation a tenth of a step',
                   'time_s', 'time [s]'),
    'fig2_hundredth': ('Fig. 2, simulated: steps of 2 mm, standard deviation a hundredth of a step',
                       'time_s', 'time [s]'),
    'fig3': ('Fig. 3, simulated: 1 m straight and 450 deg on the spot', 'time_s', 'time [s]'),
    'fig5': ('Fig. 5, simulated: bearings from rendered images (one run) or Gaussian (200 runs)',
             'distance_m', 'distance [m]'),
}
# What the paper says of the errors: (column, its value, {parameter: error in its unit}).
FIG_2_SAYS = ('time_s', 1000.0, {'phi': 2.0, 'rho': 10.0, 'psi': 2.0})
PAPER_SAYS = {'fig2_literal': FIG_2_SAYS, 'fig2_centimetre': FIG_2_SAYS, 'fig2_tenth': FIG_2_SAYS,
              'fig2_hundredth': FIG_2_SAYS,
              'fig3': ('distance_m', 4.0, {'phi': 0.1, 'rho': 1.0, 'psi': 0.1})}
STABLE_FROM = {'fig5': 3.0}  # where the paper calls an estimate stable, on the horizontal axis
SIZE_IN = (8.3, 8.6)
DPI = 150  # one and a half times the 830 px at which a page shows it, where 9 pt are 12 px
LINES = (('rmse', 'RMSE', 'C0', '-'), ('median', 'median |error|', 'C2', '-'),
         ('stddev', 'as the filter says', 'C1', '--'),
         ('bound', 'bound, D and $\\theta$ known', 'black', ':'),
         ('bound_unknown', 'bound, nothing known', '0.5', '-.'))

plt.rcParams.update({'svg.hashsalt': 'bearing_calibration', 'font.size': 9,
                     'axes.titlesize': 10, 'axes.grid': True, 'grid.alpha': 0.3, 'lines.linewidth': 1.3})


class Table:
    """A CSV file with names in its first line: columns of numbers."""

    def __init__(self, path):
        with open(path) as file:
            self.rows = list(csv.DictReader(file))

    def __getitem__(self, column):
        return [float(row[column]) for row in self.rows]

    def value(self, column, name=None, least=None):
        """In the first row where `name` has reached `least`, or in the last one."""
        if name is None:
            return self[column][-1]
        return next(value for value, reached in zip(self[column], self[name]) if reached >= least)


def filledIn(template, folder):
    """The template with each field's number."""
    def number(match):
        file, column, name, least, form = match.groups()
        table = Table(os.path.join(folder, file + '.csv'))
        value = table.value(column, name, None if least is None else float(least))
        return format(value, form)
    return FIELD.sub(number, template)


def drawTrajectory(axes, run):
    axes.plot(run['x_m'], run['y_m'], color='C0', linewidth=0.8)
    axes.plot(run['x_m'][0], run['y_m'][0], 'o', color='C0', markersize=5, label='start')
    axes.plot(0.0, 0.0, '*', color='C3', markersize=11, label='light')
    axes.set_aspect('equal', adjustable='datalim')
    axes.set(xlabel='x [m]', ylabel='y [m]', title='trajectory of one run')
    axes.legend(loc='upper right')


def drawRun(axes, run, parameter, unit, symbol, across, label, stable_from):
    def column(what):
        return run['%s_%s_%s' % (parameter, what, unit)]
    x, estimate, truth = run[across], column('estimate'), column('truth')

    def around(centre, widths, factor):
        return [c + factor * w for c, w in zip(centre, widths)]
    stddev, bound = column('stddev'), column('bound')
    axes.fill_between(x, around(estimate, stddev, -3), around(estimate, stddev, 3), color='C1',
                      alpha=0.25, linewidth=0, label='3 sigma of the filter')
    axes.plot(x, around(truth, bound, 3), ':', color='black', label='3 sigma of the bound')
    axes.plot(x, around(truth, bound, -3), ':', color='black')
    axes.plot(x, truth, color='C3', label='truth')
    axes.plot(x, estimate, color='C0', label='estimate')
    if stable_from is not None:
        axes.axvline(stable_from, color='C4', linestyle='--', label='the paper: stable')
    late = stddev[len(stddev) // 20]   # leaves out the wide beginning, not the estimate
    low = min(estimate + [truth[0] - 3 * late])
    high = max(estimate + [truth[0] + 3 * late])
    margin = 0.05 * (high - low)
    axes.set(ylim=(low - margin, high + margin), xlabel=label, ylabel='%s [%s]' % (symbol, unit),
             title='%s, one run' % symbol)


def drawRuns(axes, runs, parameter, unit, symbol, across, label, says):
    x = runs[across]
    for what, words, colour, style in LINES:
        axes.semilogy(x[1:], runs['%s_%s_%s' % (parameter, what, unit)][1:], style, color=colour,
                      label=words)
    if says is not None:
        column, least, errors = says
        if runs[column][-1] >= least:  # short runs end before
            axes.plot(runs.value(across, column, least), errors[parameter], 'D', color='C4',
                      label='the paper says', clip_on=False, zorder=5)
    highest = max(max(runs['%s_%s_%s' % (parameter, what, unit)]) for what in ('rmse', 'stddev'))
    axes.set(xlabel=label, ylabel='error of %s [%s]' % (symbol, unit),
             title='%s, %d runs' % (symbol, runs['runs'][0]))
    axes.set_ylim(top=2.0 * highest)
    axes.yaxis.set_major_locator(ticker.LogLocator(subs=(1.0, 2.0, 5.0)))
    axes.yaxis.set_major_formatter('{x:g}')
    axes.yaxis.set_minor_formatter(ticker.NullFormatter())


def drawFigure(name, folder):
    title, across, label = FIGURES[name]
    run = Table(os.path.join(folder, name + '_run.csv'))
    runs = Table(os.path.join(folder, name + '_runs.csv'))
    figure, axes = plt.subplots(3, 3, figsize=SIZE_IN, constrained_layout=True)
    figure.suptitle(title, fontsize=11)
    drawTrajectory(axes[0][0], run)
    for column, (parameter, unit, symbol) in enumerate(PARAMETERS):
        drawRun(axes[1][column], run, parameter, unit, symbol, across, label, STABLE_FROM.get(name))
        drawRuns(axes[2][column], runs, parameter, unit, symbol, across, label, PAPER_SAYS.get(name))
    for row, words in ((1, 'one run'), (2, 'many runs')):
        axes[0][row].axis('off')
        axes[0][row].legend(*axes[row][0].get_legend_handles_labels(), loc='center', title=words)
    path = os.path.join(folder, name)
    figure.savefig(path + '.svg', metadata={'Date': None})
    figure.savefig(path + '.png', dpi=DPI, metadata={'Software': None})
    plt.close(figure)


def parseArguments(words):
    parser = argparse.ArgumentParser(description=__doc__.split('\n')[0])
    parser.add_argument('folder', metavar='FOLDER', help='for the files; made when it is missing')
    parser.add_argument('--program', default='paper_numbers', help='what computes the numbers')
    parser.add_argument('--draw', nargs='*', default=list(FIGURES), metavar='NAME',
                        help='only these of ' + ', '.join(FIGURES))
    parser.add_argument('--runs', type=int, default=200, help='of each figure')
    parser.add_argument('--seconds', type=float, default=0.0,
                        help='at most of each run, for a quick look: the text is not written')
    return parser.parse_args(words)


def main(words):
    arguments = parseArguments(words)
    folder = arguments.folder
    os.makedirs(folder, exist_ok=True)
    done = subprocess.run([arguments.program, folder, str(arguments.runs),
                           str(arguments.seconds)])
    if done.returncode != 0:
        return done.returncode
    for number, name in enumerate(arguments.draw, 1):
        print('\rdrawing %18d of %d ' % (number, len(arguments.draw)), end='', file=sys.stderr)
        drawFigure(name, folder)
    print(file=sys.stderr)
    if arguments.seconds == 0.0:
        with open(TEMPLATE) as file:
            text = filledIn(file.read(), folder)
        with open(os.path.join(folder, 'README.md'), 'w') as file:
            file.write(text)
    return 0


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
