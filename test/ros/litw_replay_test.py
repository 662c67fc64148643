#!/usr/bin/env python3
"""The real recording `litw`, replayed from bags through the calibration nodelet.

Each of its nine landmarks alone is one calibration of the same mount: it gets a nodelet, a bag made
by csv_to_bag. The bags are played at once, with the bags' own clock.
"""

import bisect
import csv
import json
import math
import os
import shutil
import subprocess
import sys
import tempfile
import time
import unittest

import roslib.packages
import rosgraph
import rosparam
import rospkg
import rospy
import yaml

from bearing_calibration.msg import CalibrationEstimate
from rosgraph_msgs.msg import Clock
from std_srvs.srv import SetBool

REPOSITORY = rospkg.RosPack().get_path('bearing_calibration')
sys.path.insert(0, os.path.join(REPOSITORY, 'test', 'support'))
import junit_unittest  # noqa: E402  (lies beside the tests, not on the path)

DATA = os.environ.get('BEARING_CALIBRATION_DATA')
NO_DATA = 'BEARING_CALIBRATION_DATA is not set: it names the folder of the real recordings'
LANDMARKS = (1, 3, 4, 6, 7, 8, 10, 12, 15)

# Where the estimate must end.
MAX_POSITION_ERROR_M = 0.06
MAX_YAW_ERROR_RAD = math.radians(2.5)
# Between the live node, whose fits run beside, and calibrate_bag, in standard deviations.
MAX_DIFFERENCE = 0.1

# The recording's README: bearings scatter by 0.019 rad with a lag-1 correlation a of 0.3 to 0.6.
# Such a series says as much as white noise whose variance is larger by (1 + a) / (1 - a); a = 0.5.
BEARING_STDDEV_RAD = 0.019 * math.sqrt((1 + 0.5) / (1 - 0.5))

# Any will do: a radius and a resolution that make one tick of this length.
METERS_PER_TICK = 1e-5
WHEEL_RADIUS_M = 0.1

WHEEL_SEPARATION_M = 0.40
# The README: the odometry errs by 7 mm along the way and 0.013 rad in heading per second. At the
# recording's mean wheel speed v, eq. 22 gives a heading variance of 2 K v / b^2 and a variance along
# the way of K v / 2 per second; what is missing of the latter is common to both wheels.
MEAN_WHEEL_SPEED_MPS = 0.274
NOISE_INDEPENDENT_M = 0.013**2 * WHEEL_SEPARATION_M**2 / (2 * MEAN_WHEEL_SPEED_MPS)
NOISE_COMMON_M = 0.007**2 / MEAN_WHEEL_SPEED_MPS - NOISE_INDEPENDENT_M / 2

LATENCY_S = 0.11  # by which bearings lag the odometry, from the README

PARAMETERS = {
    'wheels': {
        'source': 'ticks',
        'separation': WHEEL_SEPARATION_M,
        'left_radius': WHEEL_RADIUS_M,
        'right_radius': WHEEL_RADIUS_M,
        'ticks_per_revolution': 2 * math.pi * WHEEL_RADIUS_M / METERS_PER_TICK,
        'counter_bits': 64,
        'max_speed': 3.0,
        # At 20 times real time a bearing that waits for a second, on a busy machine, is 20 s late.
        'history': 60.0,
        'noise_independent': NOISE_INDEPENDENT_M,
        'noise_common': NOISE_COMMON_M,
    },
    'bearings': {
        'latency': LATENCY_S,
        'extra_stddev': 0.0,
        # At 20 times real time a clock message that is late by two seconds, on a busy machine,
        # makes all others look 40 s early.
        'max_future': 40.0,
    },
    'errors': {
        'bearing_noise_stddev': 0.0,
        'wheel_noise_stddev': 0.0,
    },
}

START_TIME_S = 1000000  # of the recording, on the bags' clock
# A message every 0.6 ms for all landmarks together, unless the nine calibrations do not keep up: then
# the player pauses before their queues are full.
PLAYBACK_RATE = 20
MOST_WAITING = 100  # bearings on their way to one calibration, half of what its queue holds
CLOCK_RATE_HZ = 250  # in wall time: steps of 80 ms in the recording's
START_DEADLINE_S = 180
PLAYBACK_DEADLINE_S = 900


def rowsOf(name):
    with open(os.path.join(DATA, 'litw', name)) as file:
        return list(csv.DictReader(file))


def waitFor(condition, deadline_s, what):
    """Polls until `condition` holds; raises an error that says what did not happen."""
    deadline = time.monotonic() + deadline_s
    while not condition():
        if time.monotonic() > deadline:
            raise RuntimeError('after %d s still not so: %s' % (deadline_s, what))
        time.sleep(0.05)


def namespaceOf(landmark):
    return 'landmark_%d' % landmark


class Replay:
    """Nodelets, bags and player of all landmarks; `estimates` are the last ones by landmark."""

    def __init__(self):
        self.folder = tempfile.mkdtemp()
        self.processes = []
        self.estimates = {}
        self.observations = {}
        self.times_s = {}
        self.is_paused = False
        self.truth = None

    def prepare(self):
        with open(os.path.join(DATA, 'litw', 'truth.json')) as file:
            self.truth = json.load(file)
        # Nodelets wait for the clock and drop what comes before it.
        clock = rospy.Publisher('/clock', Clock, queue_size=1, latch=True)
        clock.publish(rospy.Time.from_sec(START_TIME_S))
        bearings = rowsOf('bearings.csv')
        for landmark in LANDMARKS:
            self.observations[landmark] = [row for row in bearings if int(row['landmark_id']) == landmark]
            self.times_s[landmark] = [float(row['t_s']) for row in self.observations[landmark]]
            self.makeBag(landmark)
            self.startNodelet(landmark)
        waitFor(self.nodeletsListen, START_DEADLINE_S, 'the nodelets have subscribed')

    def bagOf(self, landmark):
        return os.path.join(self.folder, '%s.bag' % namespaceOf(landmark))

    def makeBag(self, landmark):
        program = roslib.packages.find_node('bearing_calibration', 'csv_to_bag')[0]
        namespace = namespaceOf(landmark)
        subprocess.run(
            [program, os.path.join(DATA, 'litw', 'odometry_calibrated.csv'),
             os.path.join(DATA, 'litw', 'bearings.csv'), '--landmark', str(landmark),
             '--output', self.bagOf(landmark), '--meters-per-tick', str(METERS_PER_TICK),
             '--bearing-stddev', str(BEARING_STDDEV_RAD), '--start-time', str(START_TIME_S),
             '--ticks-topic', namespace + '/wheel_ticks',
             '--bearings-topic', namespace + '/bearings'], check=True, timeout=300)

    def startNodelet(self, landmark):
        namespace = '/' + namespaceOf(landmark)
        file = os.path.join(REPOSITORY, 'config', 'calibration.yaml')
        for parameters, _ in rosparam.load_file(file):
            rosparam.upload_params(namespace + '/calibration', parameters)
        for group, values in PARAMETERS.items():
            rosparam.upload_params('%s/calibration/%s' % (namespace, group), values)
        rosparam.set_param(namespace + '/calibration/output/folder', self.folder)
        rospy.Subscriber(namespace + '/calibration/estimate', CalibrationEstimate,
                         lambda message: self.estimates.update({landmark: message}))
        self.start(['rosrun', 'nodelet', 'nodelet', 'standalone',
                    'bearing_calibration/CalibrationNodelet',
                    '__ns:=' + namespace, '__name:=calibration'])

    def start(self, command):
        process = subprocess.Popen(command, stdin=subprocess.DEVNULL)
        self.processes.append(process)
        return process

    def nodeletsListen(self):
        """All of them are subscribed: what is played before is lost."""
        subscriptions = dict(rosgraph.Master('/litw_replay').getSystemState()[1])
        topics = ['/%s/%s' % (namespaceOf(landmark), topic)
                  for landmark in LANDMARKS for topic in ('wheel_ticks', 'bearings')]
        return all(topic in subscriptions for topic in topics)

    def play(self):
        player = self.start(  # it stays at the end: one that ends may drop the bags' last messages
            ['rosbag', 'play', '--clock', '--hz', str(CLOCK_RATE_HZ), '-r', str(PLAYBACK_RATE),
             '--quiet', '--keep-alive', '--wait-for-subscribers', '--queue', '1000']
            + [self.bagOf(landmark) for landmark in LANDMARKS] + ['__name:=player'])
        try:
            waitFor(lambda: self.isPlayed(player), PLAYBACK_DEADLINE_S,
                    'every bearing is accounted for')
        except RuntimeError as error:
            raise RuntimeError('%s: seen and sent: %s' % (error, {
                landmark: (self.seenBy(landmark), len(self.observations[landmark]))
                for landmark in LANDMARKS})) from error

    def isPlayed(self, player):
        """Every bearing is accounted for. Lets the player wait for a calibration that falls behind."""
        if player.poll() is not None:
            raise RuntimeError('rosbag play ended with %d' % player.returncode)
        pauses = any(self.sentTo(landmark) - self.seenBy(landmark) > MOST_WAITING
                     for landmark in LANDMARKS)
        if pauses != self.is_paused:
            try:
                rospy.ServiceProxy('/player/pause_playback', SetBool)(pauses)
                self.is_paused = pauses
            except rospy.ServiceException:
                pass  # not yet there
        return all(map(self.isComplete, LANDMARKS))

    def sentTo(self, landmark):
        """How many of the bag's bearings have been played."""
        return bisect.bisect(self.times_s[landmark], rospy.get_time() - START_TIME_S)

    def seenBy(self, landmark):
        """How many of the bag's bearings the nodelet's last estimate speaks of."""
        estimate = self.estimates.get(landmark)
        if estimate is None:
            return 0
        return (estimate.bearings_used + estimate.bearings_gated + estimate.bearings_rejected
                + estimate.bearings_waiting)

    def observationsBeforeTheFirstTicks(self, landmark):
        """How many were seen, their latency taken off, before the odometry starts."""
        first_s = float(rowsOf('odometry_calibrated.csv')[0]['t_s'])
        return sum(float(row['t_s']) - LATENCY_S < first_s for row in self.observations[landmark])

    def isComplete(self, landmark):
        return self.seenBy(landmark) == len(self.observations[landmark])

    def calibrateBags(self):
        """The same bags through calibrate_bag; the results by landmark."""
        config = os.path.join(self.folder, 'parameters.yaml')
        with open(config, 'w') as file:
            yaml.safe_dump(PARAMETERS, file)
        output = os.path.join(self.folder, 'offline')
        program = roslib.packages.find_node('bearing_calibration', 'calibrate_bag')[0]
        subprocess.run([program] + [self.bagOf(landmark) for landmark in LANDMARKS] +
                       ['--config', config, '--output', output], timeout=600)
        results = {}
        for landmark in LANDMARKS:
            with open(os.path.join(output, namespaceOf(landmark), 'result.yaml')) as file:
                results[landmark] = yaml.safe_load(file)
        return results

    def stop(self):
        for process in self.processes:
            process.terminate()
        for process in self.processes:
            try:
                process.wait(timeout=10)
            except subprocess.TimeoutExpired:
                process.kill()
        shutil.rmtree(self.folder)


@unittest.skipUnless(DATA, NO_DATA)
class LitwReplay(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        rospy.init_node('litw_replay', disable_signals=True)
        cls.replay = Replay()
        cls.addClassCleanup(cls.replay.stop)
        cls.replay.prepare()
        cls.replay.play()
        cls.offline = cls.replay.calibrateBags()

    def assertEndsNearTheTruth(self, landmark):
        estimate = self.replay.estimates[landmark]
        truth = self.replay.truth
        position_error_m = math.hypot(estimate.x_m - truth['x_m'], estimate.y_m - truth['y_m'])
        yaw_error_rad = abs(math.remainder(estimate.yaw_rad - truth['yaw_rad'], 2 * math.pi))
        found = ('landmark %d: x %.3f +- %.3f m, y %.3f +- %.3f m, yaw %.3f +- %.3f rad; off by '
                 '%.1f cm and %.2f deg; %d bearings used, %d gated' % (
                     landmark, estimate.x_m, estimate.x_stddev_m, estimate.y_m,
                     estimate.y_stddev_m, estimate.yaw_rad, estimate.yaw_stddev_rad,
                     100 * position_error_m, math.degrees(yaw_error_rad),
                     estimate.bearings_used, estimate.bearings_gated))
        print(found)
        self.assertEqual(estimate.ticks_rejected, 0, estimate.rejections)
        self.assertEqual(estimate.bearings_rejected,
                         self.replay.observationsBeforeTheFirstTicks(landmark), estimate.rejections)
        self.assertLessEqual(position_error_m, MAX_POSITION_ERROR_M, found)
        self.assertLessEqual(yaw_error_rad, MAX_YAW_ERROR_RAD, found)
        self.assertIsWhatTheBagSays(landmark, estimate)

    def assertIsWhatTheBagSays(self, landmark, estimate):
        offline = self.offline[landmark]
        self.assertEqual(offline['state'], estimate.state_text)
        mount, stddev = offline['base_from_camera'], offline['stddev']
        for axis, live in (('x', estimate.x_m), ('y', estimate.y_m), ('yaw', estimate.yaw_rad)):
            difference = abs(live - mount[axis]) / stddev[axis]
            print('landmark %d: %s is %.3f standard deviations from that of calibrate_bag'
                  % (landmark, axis, difference))
            self.assertLessEqual(difference, MAX_DIFFERENCE, axis)


def addTestOf(landmark):
    def test(self):
        self.assertEndsNearTheTruth(landmark)
    setattr(LitwReplay, 'testLandmark%02d' % landmark, test)


for each in LANDMARKS:
    addTestOf(each)

if __name__ == '__main__':
    sys.exit(junit_unittest.main([__file__] + sys.argv[1:]))
