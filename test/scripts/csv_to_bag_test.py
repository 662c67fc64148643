"""csv_to_bag as its user meets it: files in, a bag or a message that names file and line out."""

import math
import os
import resource
import signal
import subprocess
import tempfile
import unittest

import rosbag
import roslib.packages

WHEELS = 't_s,left_m,right_m\n0.0,0.01,0.02\n0.1,0.01,0.02\n0.2,0.01,0.02\n'
OBSERVATIONS = 't_s,landmark_id,bearing_rad\n0.0,3,0.5\n0.0,4,0.1\n0.15,3,0.25\n0.2,4,0.1\n'


def onADiskOf(size):
    """For a child process: no file that it writes may become larger."""
    def limit():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)  # writing fails, as on a full disk
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))
    return limit


class CsvToBag(unittest.TestCase):

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        self.output = os.path.join(self.folder, 'out.bag')
        self.program = roslib.packages.find_node('bearing_calibration', 'csv_to_bag')[0]

    def write(self, name, text):
        path = os.path.join(self.folder, name)
        with open(path, 'wb') as file:
            file.write(text if isinstance(text, bytes) else text.encode())
        return path

    def convert(self, *arguments, wheels=WHEELS, observations=OBSERVATIONS, before=None):
        return subprocess.run(
            [self.program, self.write('wheels.csv', wheels), self.write('observations.csv', observations)]
            + list(arguments), stdout=subprocess.PIPE, stderr=subprocess.PIPE,
            universal_newlines=True, timeout=600, preexec_fn=before)

    def messagesOf(self, *arguments, **files):
        done = self.convert('--output', self.output, *arguments, **files)
        self.assertEqual(done.returncode, 0, done.stderr)
        with rosbag.Bag(self.output) as bag:
            return list(bag.read_messages())

    def assertRefused(self, done, code, *words):
        self.assertEqual(done.returncode, code, done.stderr)
        for word in words:
            self.assertIn(word, done.stderr)
        self.assertEqual([name for name in os.listdir(self.folder) if 'bag' in name], [])

    def testWritesBothStreamsInOrderOfTheirStamps(self):
        messages = self.messagesOf('--landmark', '3', '--start-time', '100')
        self.assertEqual([(topic, time.to_nsec()) for topic, _, time in messages], [
            ('wheel_ticks', 100000000000), ('bearings', 100000000000),
            ('wheel_ticks', 100100000000), ('bearings', 100150000000),
            ('wheel_ticks', 100200000000)])
        for _, message, time in messages:
            self.assertEqual(message.header.stamp.to_nsec(), time.to_nsec())

    def testTicksAreTheQuantisedSum(self):
        messages = self.messagesOf('--landmark', '3', '--meters-per-tick', '0.001')
        counts = [(m.left, m.right) for topic, m, _ in messages if topic == 'wheel_ticks']
        self.assertEqual(counts, [(10, 20), (20, 40), (30, 60)])

    def testBearingsCarryVarianceLandmarkAndFrame(self):
        messages = self.messagesOf('--landmark', '3', '--bearing-stddev', '0.03',
                                   '--sensor-frame', 'laser')
        bearings = [message for topic, message, _ in messages if topic == 'bearings']
        self.assertEqual([len(message.candidates) for message in bearings], [1, 1])
        first = bearings[0].candidates[0]
        self.assertEqual(bearings[0].header.frame_id, 'laser')
        self.assertEqual((first.azimuth, first.light_id, first.probability), (0.5, 3, 1.0))
        self.assertAlmostEqual(first.azimuth_variance, 9e-4, delta=1e-15)
        for value in (first.image_radius, first.image_radius_variance,
                      first.elevation, first.elevation_variance, first.track_probability):
            self.assertTrue(math.isnan(value), value)

    def testTopicsCanBeNamed(self):
        messages = self.messagesOf('--landmark', '4', '--ticks-topic', 'a', '--bearings-topic', 'b')
        self.assertEqual({topic for topic, _, _ in messages}, {'a', 'b'})

    # Promise named: bad rows of a CSV file; no bag is left
    def testBadRowsNameFileAndLineAndLeaveNoBag(self):
        for observations, words in (
                (OBSERVATIONS + '0.1,3,0.5\n', ('observations.csv:6:', "'0.1'")),
                (OBSERVATIONS + '0.3,3\n', ('observations.csv:6:', '2 cells')),
                (OBSERVATIONS.replace('0.25', 'left'), ('observations.csv:4:', "'left'", 'not a number')),
                (OBSERVATIONS.replace('t_s', 'time'), ('observations.csv:1:', "'t_s' is missing"))):
            with self.subTest(observations=observations):
                done = self.convert('--landmark', '3', '--output', self.output, observations=observations)
                self.assertRefused(done, 1, *words)

    def testAFileFromASpreadsheetIsReadOrNamed(self):
        messages = self.messagesOf('--landmark', '3', wheels=WHEELS.encode('utf-8-sig'),
                                   observations=OBSERVATIONS.encode('utf-8-sig'))
        self.assertEqual(len(messages), 5)
        os.remove(self.output)
        for wheels, words in (
                (WHEELS.encode('utf-16'), ('wheels.csv:1:', 'UTF-16', 'UTF-8')),
                (WHEELS.replace(',', ';'), ('wheels.csv:1:', 'semicolons')),
                (WHEELS.replace('0.02', '"0,02"'), ('wheels.csv:2:', 'quotes')),
                (WHEELS.replace('0.02', '0,02'), ('wheels.csv:2:', 'decimal comma'))):
            with self.subTest(wheels=wheels):
                done = self.convert('--landmark', '3', '--output', self.output, wheels=wheels)
                self.assertRefused(done, 1, *words)

    # Promise named: a CSV file in degrees
    def testBearingsInDegreesAreRefused(self):
        done = self.convert('--landmark', '3', '--output', self.output,
                            observations=OBSERVATIONS.replace('0.25', '25.0'))
        self.assertRefused(done, 1, 'observations.csv:4:', "bearing_rad '25.0'", 'in degrees?', 'radians')

    def testFilesWithoutACommonTimeAreRefused(self):
        done = self.convert('--landmark', '3', '--output', self.output,
                            observations=OBSERVATIONS.replace('\n0.', '\n1700000000.'))
        self.assertRefused(done, 1, 'no time in common', 'wheels.csv: t_s from 0.000 to 0.200',
                           'observations.csv: t_s from 1700000000.000 to 1700000000.150')

    # Milliseconds in one of them, or in both, show.
    def testSaysFromWhenToWhenTheFilesAre(self):
        done = self.convert('--landmark', '3', '--output', self.output,
                            observations=OBSERVATIONS.replace('0.2,4', '200,3'))
        self.assertIn('3 messages on wheel_ticks (t_s from 0.000 to 0.200), 3 on bearings '
                      '(t_s from 0.000 to 200.000)', done.stdout)

    def testUnknownLandmarkNamesThoseThereAre(self):
        done = self.convert('--landmark', '5', '--output', self.output)
        self.assertRefused(done, 1, 'landmark 5 is never seen', '3, 4')

    def testMissingFilesAreNamed(self):
        done = subprocess.run([self.program, '/no/wheels.csv', '/no/observations.csv', '--landmark', '1',
                               '--output', self.output], stderr=subprocess.PIPE,
                              universal_newlines=True, timeout=600)
        self.assertRefused(done, 1, '/no/wheels.csv')

    def testAnOutputThatCannotBeWrittenIsNamed(self):
        done = self.convert('--landmark', '3', '--output', '/no/such/out.bag')
        self.assertRefused(done, 1, '/no/such/out.bag')
        place = os.path.join(self.folder, 'place')
        os.mkdir(place)
        done = self.convert('--landmark', '3', '--output', place)
        self.assertRefused(done, 1, place)
        self.assertEqual(sorted(os.listdir(self.folder)), ['observations.csv', 'place', 'wheels.csv'])

    def testAFullDiskIsNamedAndNothingIsLeftBehind(self):
        for size in (2000, 5000):  # bytes: within the head of a bag, behind it
            with self.subTest(size=size):
                done = self.convert('--landmark', '3', '--output', self.output,
                                    before=onADiskOf(size))
                self.assertRefused(done, 1, self.output + ' cannot be written')

    def testMissingArgumentsAreNamedAsInTheHelp(self):
        done = subprocess.run([self.program, 'wheels.csv', '--landmark', '1', '--output', self.output],
                              stderr=subprocess.PIPE, universal_newlines=True, timeout=600)
        self.assertRefused(done, 2, 'BEARINGS.csv is missing')

    def testWrongOptionsAreUsageErrors(self):
        for arguments, word in (
                (('--output', self.output), 'landmark'), (('--landmark', '3'), 'output'),
                (('--landmark', 'x', '--output', self.output), 'landmark'),
                (('--landmark', '3', '--output', self.output, '--meters-per-tick', '0'),
                 'meters-per-tick'),
                (('--landmark', '3', '--output', self.output, '--bearing-stddev', 'nan'),
                 'bearing-stddev')):
            with self.subTest(arguments=arguments):
                self.assertRefused(self.convert(*arguments), 2, word, '--help')


if __name__ == '__main__':
    unittest.main()
