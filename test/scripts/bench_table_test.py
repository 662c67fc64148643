"""The table of scripts/bench: its names are those of the programs, and a slowdown is seen."""

import copy
import importlib.util
import json
import os
import subprocess
import tempfile
import unittest

import roslib.packages

REPOSITORY = os.path.abspath(os.path.join(os.path.dirname(__file__), '..', '..'))
PATH = os.path.join(REPOSITORY, 'bench', 'bench_table.py')

spec = importlib.util.spec_from_file_location('bench_table', PATH)
bench_table = importlib.util.module_from_spec(spec)
spec.loader.exec_module(bench_table)


DOCUMENT = os.path.join(REPOSITORY, 'doc', 'evidence', 'performance.md')
MEASURED = os.path.join(REPOSITORY, 'doc', 'evidence', 'performance.json')


def namesInTable():
    names = {name for _, rows in bench_table.SECTIONS for row in rows for name in row[:2]}
    return names | {name for _, rows in bench_table.TIMES for name, _ in rows}


def results(time_ns=100.0):
    """Every benchmark of the table at one time."""
    benchmarks = {name: bench_table.summaryOf([time_ns]) for name in namesInTable()}
    return {'machine': {'cpu': 'a', 'cores': 1, 'load': 0.0}, 'benchmarks': benchmarks}


class BenchTable(unittest.TestCase):

    def testItsNamesAreThoseOfThePrograms(self):
        known = set()
        for program in bench_table.PROGRAMS:
            paths = roslib.packages.find_node('bearing_calibration', program)
            self.assertTrue(paths, '%s is not built' % program)
            listed = subprocess.run([paths[0], '--benchmark_list_tests'], stdout=subprocess.PIPE,
                                    universal_newlines=True, check=True, timeout=600).stdout
            known |= {'%s/%s' % (program, name) for name in listed.split()}
        self.assertLessEqual(namesInTable(), known)

    def testEachIsMeasured(self):
        folder = os.path.dirname(roslib.packages.find_node('bearing_calibration',
                                                           bench_table.PROGRAMS[0])[0])
        measured = bench_table.runAll(folder, bench_table.PROGRAMS, repetitions=1, min_time_s=1e-9)
        self.assertLessEqual(namesInTable(), set(measured['benchmarks']))

    def testTimesAreNanosecondsOfEachRepetition(self):
        def entry(time, unit, run_type='iteration'):
            return {'name': 'n', 'run_name': 'step', 'run_type': run_type, 'cpu_time': time,
                    'time_unit': unit}
        report = {'benchmarks': [entry(2.0, 'us'), entry(0.003, 'ms'), entry(9, 's', 'aggregate')]}
        self.assertEqual(bench_table.timesOf(report), {'step': [2000.0, 3000.0]})

    def testAFailedBenchmarkIsNoResult(self):
        report = {'benchmarks': [{'name': 'fullScan', 'error_occurred': True,
                                  'error_message': 'the light was not found'}]}
        with self.assertRaisesRegex(SystemExit, 'the light was not found'):
            bench_table.timesOf(report)

    def testAMissedAimIsSaid(self):
        table = bench_table.report(results(6e6))  # every ratio is 1, and every time 6 ms
        self.assertIn('at least 10: **missed**', table)
        self.assertIn('| decision/100 | 6 ms | at most 5 ms: **missed** |', table)
        quick = results()
        for name in ('filter_bench/cartesianStep', 'ceres_bench/batchPlain/1000',
                     'ceres_bench/batchPlain/300', 'ceres_bench/batchPlain/100',
                     'ceres_bench/batchHuber/1000',
                     'detection_bench/fullScan/0', 'detection_bench/fullScan/1',
                     'detection_bench/clutteredScan/0', 'detection_bench/clutteredScan/1'):
            quick['benchmarks'][name]['median_ns'] = 10.0
        table = bench_table.report(quick)
        self.assertNotIn('missed', table)
        self.assertIn('| decision/100 | 100 ns | at most 5 ms |', table)
        self.assertIn('| dynamicStep/15 | 100 ns | cartesianStep | 10 ns | 10 | at least 10 |',
                      table)

    def testTheDocumentHasTheNumbersOfItsFile(self):
        with open(MEASURED) as file:
            measured = json.load(file)
        self.assertEqual(set(measured['benchmarks']) & namesInTable(), namesInTable())
        with open(DOCUMENT) as file:
            document = file.read()
        self.assertEqual(document, bench_table.filledIn(document, measured))
        for title, table in bench_table.tables(measured).items():
            self.assertIn('## %s\n' % title, document)
            self.assertIn('\n'.join(table), document)
        self.assertIn(bench_table.machineLine(measured), document)

    def testTheTablesOfADocumentAreMadeAnew(self):
        document = 'old' + bench_table.MEDIANS + '\n## Filter step\ntext\n| old |\n|---|\nmore'
        new = bench_table.filledIn(document, results())
        self.assertTrue(new.startswith('a, 1 cores, load 0.0 at the start'))
        self.assertIn('text\n| A | time | B |', new)
        self.assertTrue(new.endswith('|\nmore'))
        self.assertNotIn('old', new)

    def testOneProgramsResultsReplaceThoseOfTheSameProgram(self):
        old, new = results(100.0), {'machine': {'load': 9.0}, 'benchmarks': {
            'driving_bench/decision/60': bench_table.summaryOf([7.0])}}
        both = bench_table.withNew(old, new)
        self.assertEqual(both['machine'], old['machine'])
        self.assertEqual({name for name in both['benchmarks'] if name.startswith('driving_bench')},
                         {'driving_bench/decision/60'})
        self.assertEqual(both['benchmarks']['driving_bench/decision/60']['median_ns'], 7.0)
        self.assertEqual(both['benchmarks']['ceres_bench/fit']['median_ns'], 100.0)

    def compareFiles(self, before, after):
        with tempfile.TemporaryDirectory() as folder:
            paths = []
            for name, content in (('before', before), ('after', after)):
                paths.append(os.path.join(folder, name))
                with open(paths[-1], 'w') as file:
                    json.dump(content, file)
            done = subprocess.run(['python3', PATH, '--compare'] + paths, stdout=subprocess.PIPE,
                                  universal_newlines=True, timeout=600)
        return done.returncode, done.stdout

    def testASlowdownOfMoreThanATenthIsSeen(self):
        before, after = results(), results()
        self.assertEqual(self.compareFiles(before, after)[0], 0)
        after['benchmarks']['ceres_bench/fit'] = bench_table.summaryOf([109.0])
        self.assertEqual(self.compareFiles(before, after)[0], 0)
        after['benchmarks']['ceres_bench/fit'] = bench_table.summaryOf([111.0])
        status, text = self.compareFiles(before, after)
        self.assertEqual(status, 1)
        slower = [line for line in text.split('\n') if 'SLOWER' in line]
        self.assertEqual(len(slower), 1)
        self.assertRegex(slower[0], r'ceres_bench/fit .*\+11\.0 %')

    def testWhatOneRunAloneHasIsNamed(self):
        before = results()
        after = copy.deepcopy(before)
        del after['benchmarks']['ceres_bench/fit']
        self.assertRegex(self.compareFiles(before, after)[1], 'ceres_bench/fit +only before')


if __name__ == '__main__':
    unittest.main()
