#!/usr/bin/env python3
"""Runs the bench programs and prints one table of ratios (scripts/bench); compares two runs.

Each benchmark is repeated, in turn with the others of its program, so that a load from outside falls
on all of them alike; what counts is the median of its CPU time. The results are a JSON file:
{"machine": {...}, "benchmarks": {"PROGRAM/NAME": {"median_ns", "least_ns", "most_ns"}}}.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile

PROGRAMS = ('filter_bench', 'ceres_bench', 'estimation_bench', 'detection_bench',
            'driving_bench', 'bag_bench')
REPETITIONS = 15
QUICK_REPETITIONS = 3
MIN_TIME_S = 0.05        # of one repetition: thousands of filter steps, some of the slowest batch
QUICK_MIN_TIME_S = 0.01
SLOWER = 1.10            # what a comparison calls slower
MEDIANS = '; medians of CPU time, one thread (/real_time: of real time).'
NANOSECONDS = {'ns': 1.0, 'us': 1e3, 'ms': 1e6, 's': 1e9}

# Title, then rows of: what is divided, by what it is divided, least ratio that is aimed at.
# performance.md has a section for each title.
SECTIONS = (
    ('Filter step', (
        ('filter_bench/dynamicStep/15', 'filter_bench/cartesianStep', 10.0),
        ('filter_bench/dynamicStep/5', 'filter_bench/cartesianStep', 2.0),
        ('filter_bench/dynamicStep/15', 'filter_bench/paperStep', None),
        ('filter_bench/dynamicStep/5', 'filter_bench/paperStep', None),
    )),
    ('Batch, fit and search beside Ceres', (
        ('ceres_bench/ceresPlain/1000', 'ceres_bench/batchPlain/1000', 3.0),
        ('ceres_bench/ceresPlainTight/1000', 'ceres_bench/batchPlain/1000', 3.0),
        ('ceres_bench/ceresPlain/300', 'ceres_bench/batchPlain/300', 3.0),
        ('ceres_bench/ceresPlain/100', 'ceres_bench/batchPlain/100', 3.0),
        ('ceres_bench/ceresHuber/1000', 'ceres_bench/batchHuber/1000', 3.0),
        ('ceres_bench/ceresHuber/1000', 'ceres_bench/batchFull/1000', None),
        ('ceres_bench/ceresFit', 'ceres_bench/fit', None),
        ('ceres_bench/ceresSearch/8', 'ceres_bench/search', None),
    )),
    ('Light detector', (
        ('detection_bench/simpleBlob/0', 'detection_bench/fullScan/0', None),
        ('detection_bench/thresholdAndContours/0', 'detection_bench/fullScan/0', 1.25),
        ('detection_bench/plainRead/0', 'detection_bench/fullScan/0', None),
        ('detection_bench/simpleBlob/1', 'detection_bench/fullScan/1', None),
        ('detection_bench/thresholdAndContours/1', 'detection_bench/fullScan/1', 1.25),
        ('detection_bench/clutteredContours/0', 'detection_bench/clutteredScan/0', 1.25),
        ('detection_bench/clutteredContours/1', 'detection_bench/clutteredScan/1', 1.25),
        ('detection_bench/plainRead/1', 'detection_bench/fullScan/1', None),
        ('detection_bench/fullScan/0', 'detection_bench/countNonZero/0', None),
        ('detection_bench/fullScan/0', 'detection_bench/regionOfInterest/0', None),
    )),
    ('From a bag', (
        ('bag_bench/readAndDetect/real_time', 'bag_bench/readOnly/real_time', None),
        ('bag_bench/calibrateBag/real_time', 'bag_bench/readAndDetect/real_time', None),
        # calibrate_bag in at most 1.5 times the time of reading
        ('bag_bench/readOnly/real_time', 'bag_bench/calibrateBag/real_time', 1.0 / 1.5),
    )),
    ('Scaling', (
        ('filter_bench/dynamicStep/10', 'filter_bench/dynamicStep/5', None),
        ('filter_bench/dynamicStep/20', 'filter_bench/dynamicStep/5', None),
        ('filter_bench/dynamicStep/30', 'filter_bench/dynamicStep/5', None),
        ('filter_bench/robotStep/9', 'filter_bench/cartesianStep', None),
        ('filter_bench/robotStep/12', 'filter_bench/cartesianStep', None),
        ('filter_bench/robotStep/15', 'filter_bench/cartesianStep', None),
        ('filter_bench/elevationStep', 'filter_bench/robotStep/12', None),
        ('ceres_bench/batchPlain/300', 'ceres_bench/batchPlain/100', None),
        ('ceres_bench/batchPlain/1000', 'ceres_bench/batchPlain/100', None),
        ('ceres_bench/ceresPlain/1000', 'ceres_bench/ceresPlain/100', None),
        ('estimation_bench/batchStates/9', 'estimation_bench/batchStates/5', None),
        ('estimation_bench/batchStates/12', 'estimation_bench/batchStates/5', None),
        ('estimation_bench/batchStates/15', 'estimation_bench/batchStates/5', None),
        ('estimation_bench/attempt/1000', 'estimation_bench/attempt/150', None),
        ('detection_bench/fullScan/1', 'detection_bench/fullScan/0', None),
        ('detection_bench/regionOfInterest/1', 'detection_bench/regionOfInterest/0', None),
        ('detection_bench/manyLights/2', 'detection_bench/manyLights/1', None),
        ('detection_bench/manyLights/4', 'detection_bench/manyLights/1', None),
        ('detection_bench/manyLights/8', 'detection_bench/manyLights/1', None),
        ('detection_bench/manyLights/16', 'detection_bench/manyLights/1', None),
    )),
)
# Title, then rows of: what is measured, the longest time [ns] that is aimed at.
TIMES = (
    ('Decision of a drive', (
        ('driving_bench/decision/60', 5e6),
        ('driving_bench/decision/100', 5e6),
        ('driving_bench/decision/300', 5e6),
    )),
)


def timesOf(report):
    """{name: [ns of each repetition]} of a Google Benchmark report: CPU time, but real time of what
    was measured in it, because it works on several threads."""
    times = {}
    for entry in report['benchmarks']:
        if entry.get('error_occurred'):
            raise SystemExit('%s: %s' % (entry['name'], entry.get('error_message', 'failed')))
        if entry.get('run_type') == 'iteration':
            clock = 'real_time' if entry['run_name'].endswith('/real_time') else 'cpu_time'
            time_ns = entry[clock] * NANOSECONDS[entry['time_unit']]
            times.setdefault(entry['run_name'], []).append(time_ns)
    return times


def runProgram(path, repetitions, min_time_s):
    """Google Benchmark's own report of one program."""
    with tempfile.NamedTemporaryFile(suffix='.json') as out:
        subprocess.run([path, '--benchmark_out=' + out.name, '--benchmark_out_format=json',
                        '--benchmark_repetitions=%d' % repetitions,
                        '--benchmark_min_time=%g' % min_time_s,
                        '--benchmark_enable_random_interleaving=true'],
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=True)
        return json.load(out)


def summaryOf(times_ns):
    return {'median_ns': statistics.median(times_ns), 'least_ns': min(times_ns),
            'most_ns': max(times_ns)}


def cpuModel():
    with open('/proc/cpuinfo') as file:
        for line in file:
            if line.startswith('model name'):
                return line.split(':', 1)[1].strip()
    return 'unknown'


def runAll(folder, programs, repetitions, min_time_s):
    results = {'machine': {'cpu': cpuModel(), 'cores': os.cpu_count(),
                           'load': os.getloadavg()[0]}, 'benchmarks': {}}
    for number, program in enumerate(programs, 1):
        print('[%d/%d] %s' % (number, len(programs), program), file=sys.stderr)
        report = runProgram(os.path.join(folder, program), repetitions, min_time_s)
        for name, times_ns in timesOf(report).items():
            results['benchmarks']['%s/%s' % (program, name)] = summaryOf(times_ns)
    return results


def timeText(time_ns):
    for unit, scale in (('s', 1e9), ('ms', 1e6), ('us', 1e3)):
        if time_ns >= scale:
            return '%.3g %s' % (time_ns / scale, unit)
    return '%.3g ns' % time_ns


def shortName(name):
    return name.split('/', 1)[1]


def verdict(words, is_reached):
    return words if is_reached else words + ': **missed**'


def ratioRows(rows, medians):
    lines = ['| A | time | B | time | A / B | aim |', '|---|---|---|---|---|---|']
    for slow, fast, aim in rows:
        ratio = medians[slow] / medians[fast]
        lines.append('| %s | %s | %s | %s | %.3g | %s |' % (
            shortName(slow), timeText(medians[slow]), shortName(fast), timeText(medians[fast]),
            ratio, '' if aim is None else verdict('at least %.3g' % aim, ratio >= aim)))
    return lines


def timeRows(rows, medians):
    lines = ['| | time | aim |', '|---|---|---|']
    for name, limit_ns in rows:
        lines.append('| %s | %s | %s |' % (
            shortName(name), timeText(medians[name]),
            verdict('at most ' + timeText(limit_ns), medians[name] <= limit_ns)))
    return lines


def machineLine(results):
    machine = results['machine']
    return '%s, %d cores, load %.1f at the start%s' % (machine['cpu'], machine['cores'],
                                                      machine['load'], MEDIANS)


def tables(results):
    """{title: lines of Markdown}."""
    medians = {name: one['median_ns'] for name, one in results['benchmarks'].items()}
    made = {title: ratioRows(rows, medians) for title, rows in SECTIONS}
    made.update({title: timeRows(rows, medians) for title, rows in TIMES})
    return made


def report(results):
    """Markdown."""
    lines = [machineLine(results)]
    for title, table in tables(results).items():
        lines += ['', '### ' + title, ''] + table
    return '\n'.join(lines)


def filledIn(document, results):
    """A Markdown text with the tables of its sections, and its line of the machine, made anew."""
    made = tables(results)
    lines, title, is_table_written = [], None, False
    for line in document.split('\n'):
        if line.startswith('## '):
            title, is_table_written = line[3:], False
        if line.endswith(MEDIANS):
            line = machineLine(results)
        if line.startswith('|') and title in made:
            if not is_table_written:
                lines += made[title]
            is_table_written = True
            continue
        lines.append(line)
    return '\n'.join(lines)


def compare(before, after):
    """(text, whether something became slower) of two results."""
    old, new = before['benchmarks'], after['benchmarks']
    slower, lines = False, []
    for name in sorted(set(old) | set(new)):
        if name not in old or name not in new:
            lines.append('%-45s only %s' % (name, 'after' if name in new else 'before'))
            continue
        ratio = new[name]['median_ns'] / old[name]['median_ns']
        word = ''
        if ratio > SLOWER:
            slower = True
            overlap = new[name]['least_ns'] <= old[name]['most_ns']
            word = '  SLOWER' + (' (though the repetitions overlap)' if overlap else '')
        elif ratio < 1.0 / SLOWER:
            word = '  faster'
        lines.append('%-45s %8s -> %8s  %+6.1f %%%s' % (
            name, timeText(old[name]['median_ns']), timeText(new[name]['median_ns']),
            100.0 * (ratio - 1.0), word))
    return '\n'.join(lines), slower


def withNew(results, new):
    """The results of one run, those of the programs in `new` replaced by these. Ratios are of one
    program each, so that they stay ratios of one run."""
    programs = {name.split('/', 1)[0] for name in new['benchmarks']}
    kept = {name: one for name, one in results['benchmarks'].items()
            if name.split('/', 1)[0] not in programs}
    return {'machine': results['machine'], 'benchmarks': dict(kept, **new['benchmarks'])}


def load(path):
    with open(path) as file:
        return json.load(file)


def parseArguments(words):
    parser = argparse.ArgumentParser(description='Speed beside what one would use instead.')
    parser.add_argument('--programs', default='.', help='folder of the bench programs')
    parser.add_argument('--output', help='JSON file for the results')
    parser.add_argument('--document', help='Markdown file whose tables are made anew')
    parser.add_argument('--only', choices=PROGRAMS, help='run this one, and take the others from '
                        'the file of --output')
    parser.add_argument('--quick', action='store_true', help='few repetitions: only a first look')
    parser.add_argument('--compare', nargs=2, metavar=('BEFORE', 'AFTER'),
                        help='two result files; 1 when something became 10 %% slower')
    return parser.parse_args(words)


def main(words):
    arguments = parseArguments(words)
    if arguments.compare:
        text, slower = compare(*map(load, arguments.compare))
        print(text)
        return 1 if slower else 0
    before = load(arguments.output) if arguments.only else None
    results = runAll(arguments.programs, [arguments.only] if arguments.only else PROGRAMS, QUICK_REPETITIONS if arguments.quick else REPETITIONS,
                     QUICK_MIN_TIME_S if arguments.quick else MIN_TIME_S)
    if before:
        results = withNew(before, results)
    if arguments.output:
        with open(arguments.output, 'w') as file:
            json.dump(results, file, indent=1, sort_keys=True)
            file.write('\n')
    if arguments.document:
        with open(arguments.document) as file:
            text = filledIn(file.read(), results)
        with open(arguments.document, 'w') as file:
            file.write(text)
    print(report(results))
    return 0


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
