"""What calibrate_bag has written into a folder, as the report wants it."""

import collections
import csv
import os
import re

import numpy as np
import yaml

# One calibration. `result` is None where there is no estimate; `estimates` and `images` hold columns
# by name: arrays of numbers (NaN for an empty cell), lists of words.
Record = collections.namedtuple('Record', 'name folder details result estimates images plans')

WORDS = ('state', 'live', 'fit')


def readYaml(path):
    """None where there is no such file."""
    if not os.path.exists(path):
        return None
    with open(path, encoding='utf-8') as file:
        content = yaml.safe_load(file)
    if not isinstance(content, dict):
        raise ValueError('%s is empty or damaged' % path)
    return content


def columnsOf(path):
    with open(path, encoding='utf-8') as file:
        reader = csv.DictReader(file)
        rows = list(reader)
        names = reader.fieldnames
    if names is None:
        raise ValueError('%s is empty' % path)
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
                  columnsOf(os.path.join(folder, 'images.csv')),
                  columnsOf(os.path.join(folder, 'plans.csv')))


OWN_FILES = '.bearing_calibration'  # the list of them


def ownFolder(folder):
    """Where calibrate_bag has written when this folder was given, and others' files lay in it."""
    own = os.path.join(folder, 'bearing_calibration')
    is_ours = os.path.exists(os.path.join(folder, OWN_FILES))
    return own if not is_ours and os.path.isdir(own) else folder


def addToOwnFiles(path):
    """Lets a file go with the result that it shows, when that is replaced or kept."""
    folder, name = os.path.split(path)
    if not os.path.exists(os.path.join(folder, OWN_FILES)):
        return
    with open(os.path.join(folder, OWN_FILES), 'r+', encoding='utf-8') as file:
        if name not in file.read().splitlines():
            file.write(name + '\n')


def readFolder(folder):
    """The records of a folder, as calibrate_bag lists them, and their comparison (None without).

    Without its list, all below a folder that is none itself, light_2 before light_10.
    @throws ValueError when nothing of calibrate_bag lies there.
    """
    def isRecord(name):
        return os.path.exists(os.path.join(folder, name, 'details.yaml'))

    def order(name):
        return [int(part) if i % 2 else part for i, part in enumerate(re.split(r'(\d+)', name))]

    listed = readYaml(os.path.join(folder, 'calibrations.yaml'))
    if listed:
        names = listed['calibrations']
    else:
        names = [''] if isRecord('') else sorted(os.listdir(folder), key=order)
    records = [readRecord(os.path.join(folder, name)) for name in names if isRecord(name)]
    if not records:
        raise ValueError('%s holds nothing that calibrate_bag has written' % folder)
    return records, readYaml(os.path.join(folder, 'comparison.yaml'))
