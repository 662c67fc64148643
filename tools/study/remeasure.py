#!/usr/bin/env python3
"""Measures tables of a page again: ./scripts/run tools/study/remeasure.py doc/evidence/accuracy.md

Runs each monte_carlo command of the page that is followed by a table, and writes what it prints
into that table's rows. Tables with columns that monte_carlo does not print are left alone.
"""

import argparse
import shlex
import subprocess
import sys

import roslib.packages


def cellsOf(row):
    return [cell.strip() for cell in row.strip().strip('|').split('|')]


def isTableRow(line):
    return line.startswith('|')


def commandsOf(lines):
    """(arguments of monte_carlo, first line of the table after it) of each command."""
    command = None
    for number, line in enumerate(lines):
        if line.startswith('    ') and 'monte_carlo ' in line:
            command = line.split('monte_carlo ', 1)[1]
        elif line.startswith('    ') and command is not None and command.endswith('\\'):
            command = command[:-1] + line
        elif isTableRow(line) and command is not None:
            yield shlex.split(command), number
            command = None


def filled(lines, first, printed):
    """The rows of the table that begins at line `first`, of what the command has printed.

    None where that lacks a column of the table.
    """
    rows = [cellsOf(line) for line in printed.splitlines() if isTableRow(line)]
    wanted = cellsOf(lines[first])
    if not rows or not set(wanted) <= set(rows[0]):
        return None
    # its first table: two lines, and a line for each moment
    values = []
    for row in rows[2:]:
        if len(row) != len(rows[0]) or row[0] == rows[0][0]:
            break
        values.append(dict(zip(rows[0], row)))
    return ['| %s |' % ' | '.join(row[name] for name in wanted) for row in values]


def endOfTable(lines, first):
    end = first
    while end < len(lines) and isTableRow(lines[end]):
        end += 1
    return end


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('pages', nargs='+', metavar='PAGE')
    parser.add_argument('--only', default='', metavar='WORDS',
                        help='commands that contain these')
    arguments = parser.parse_args()
    program = roslib.packages.find_node('bearing_calibration', 'monte_carlo')[0]
    for page in arguments.pages:
        with open(page) as file:
            lines = file.read().splitlines()
        for options, first in reversed(list(commandsOf(lines))):
            if arguments.only not in ' '.join(options):
                continue
            done = subprocess.run([program, *options], stdout=subprocess.PIPE,
                                  universal_newlines=True)
            rows = filled(lines, first, done.stdout)
            print('monte_carlo %s\n%s' % (' '.join(options), done.stdout), flush=True)
            if rows is None:
                print('%s, line %d: has other columns, left alone' % (page, first + 1))
                continue
            lines[first + 2:endOfTable(lines, first)] = rows
            with open(page, 'w') as file:
                file.write('\n'.join(lines) + '\n')
    return 0


if __name__ == '__main__':
    sys.exit(main())
