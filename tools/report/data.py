"""What calibrate_bag has written into a folder, as the report wants it."""

import collections
import csv
import os

import numpy as np
import yaml

# One calibration. `result` is None where there is no estimate; `estimates` and `looks` hold columns
# by name: arrays of numbers (NaN for an empty cell), lists of words.
Record = collections.namedtuple('Record', 'name folder details result estimates looks plans')

WORDS = ('state', 'live', 'verdict')


def readYaml(path):
    """None where there is no such file."""
    if not os.path.exists(path):
        return None
    with open(path) as file:
        return yaml.safe_load(file)


def columnsOf(path):
    with open(path) as file:
        reader = csv.DictReader(file)
        rows = list(reader)
        names = reader.fieldnames
    columns = {}
    for name in names:
        cells = [row[name] for row in rows]
        if name in WORDS:
            columns[name] = np.array(cells, dtype=object)
        else:
            columns[name] = np.array([float(cell) if cell else np.nan for cell in cells])
    return columns


def readRecord(folder):
    details = readYaml(os.path.join(folder, 'details.yaml'))
    return Record(details['name'], folder, details, readYaml(os.path.join(folder, 'result.yaml')),
                  columnsOf(os.path.join(folder, 'estimates.csv')),
                  columnsOf(os.path.join(folder, 'looks.csv')),
                  columnsOf(os.path.join(folder, 'plans.csv')))


def readFolder(folder):
    """The records of a folder, in the order of their names, and their comparison (None without).

    @throws ValueError when nothing of calibrate_bag lies there.
    """
    folders = [folder] + sorted(os.path.join(folder, name) for name in os.listdir(folder))
    records = [readRecord(each) for each in folders
               if os.path.exists(os.path.join(each, 'details.yaml'))]
    if not records:
        raise ValueError('%s holds nothing that calibrate_bag has written' % folder)
    return records, readYaml(os.path.join(folder, 'comparison.yaml'))
