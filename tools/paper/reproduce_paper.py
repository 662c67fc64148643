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
    'fig2_literal': ('Fig. 2, steps of 2 mm with a variance of 0.01 m times 2 mm, as printed',
                     'time_s', 'time [s]'),
    'fig2_centimetre': ('Fig. 2, steps of 2 mm with a standard deviation of 0.01 m',
                        'time_s', 'time [s]'),
    'fig2_tenth': ('Fig. 2, steps of 2 mm with a standard deviation of a tenth of it',
                   'time_s', 'time [s]'),
    'fig2_hundredth': ('Fig. 2, steps of 2 mm with a standard deviation of a hundredth of it',
                       'time_s', 'time [s]'),
    'fig3': ('Fig. 3, 1 m straight and 450 deg on the spot', 'time_s', 'time [s]'),
    'fig5': ('Fig. 5, bearings found in rendered images', 'distance_m', 'distance [m]'),
}
LINES = (('rmse', 'RMSE', 'C0', '-'), ('median', 'median |error|', 'C2', '-'),
         ('stddev', 'as the filter says', 'C1', '--'),
         ('bound', 'bound, D and $\\theta$ known', 'black', ':'),
         ('bound_unknown', 'bound, nothing known', '0.5', ':'))

plt.rcParams.update({'svg.hashsalt': 'bearing_calibration', 'font.size': 10,
                     'axes.grid': True, 'grid.alpha': 0.3, 'lines.linewidth': 1.3})


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
    axes.legend(loc='upper right', fontsize=9)


def drawRun(axes, run, parameter, unit, symbol, across, label):
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
    late = stddev[len(stddev) // 20]   # leaves out the wide beginning, not the estimate
    low = min(estimate + [truth[0] - 3 * late])
    high = max(estimate + [truth[0] + 3 * late])
    margin = 0.05 * (high - low)
    axes.set(ylim=(low - margin, high + margin), xlabel=label, ylabel='%s [%s]' % (symbol, unit),
             title='%s, one run' % symbol)


def drawRuns(axes, runs, parameter, unit, symbol, across, label):
    x = runs[across]
    for what, words, colour, style in LINES:
        axes.semilogy(x[1:], runs['%s_%s_%s' % (parameter, what, unit)][1:], style, color=colour,
                      label=words)
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
    figure, axes = plt.subplots(2, 4, figsize=(16, 8), constrained_layout=True)
    figure.suptitle(title, fontsize=13)
    drawTrajectory(axes[0][0], run)
    for column, (parameter, unit, symbol) in enumerate(PARAMETERS, 1):
        drawRun(axes[0][column], run, parameter, unit, symbol, across, label)
        drawRuns(axes[1][column], runs, parameter, unit, symbol, across, label)
    axes[1][0].axis('off')
    for row, place in ((0, 'upper center'), (1, 'lower center')):
        handles, words = axes[row][1].get_legend_handles_labels()
        legend = axes[1][0].legend(handles, words, loc=place, fontsize=10,
                                   title='above, one run' if row == 0 else 'right, many runs')
        axes[1][0].add_artist(legend)
    path = os.path.join(folder, name)
    figure.savefig(path + '.svg', metadata={'Date': None})
    figure.savefig(path + '.png', dpi=90, metadata={'Software': None})
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
