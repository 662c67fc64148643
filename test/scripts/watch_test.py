"""The terminal view: what its rows say, and how it ends where there is nothing to show."""

import math
import os
import subprocess
import sys
import unittest

import rosgraph

from bearing_calibration.msg import CalibrationEstimate, CalibrationLight, RobotError

REPOSITORY = os.path.abspath(os.path.join(os.path.dirname(__file__), '..', '..'))
sys.path.insert(0, os.path.join(REPOSITORY, 'tools', 'owner'))
import demo_monitor  # noqa: E402  (lies in tools)
import watch  # noqa: E402

TARGETS = [0.01, math.radians(0.5)]
WIDTH = 80


def estimateOf(**changes):
    """(0.1 m, 0.05 m, 60 deg), right to 2 mm and 1 deg; the light at (3, 4) m."""
    estimate = CalibrationEstimate()
    estimate.state_text = 'CONVERGING'
    estimate.advice = 'turn on the spot, and come nearer to the light'
    estimate.x_m, estimate.y_m, estimate.yaw_rad = 0.1, 0.05, math.radians(60)
    estimate.x_stddev_m = estimate.y_stddev_m = 0.002
    estimate.yaw_stddev_rad = math.radians(1)
    estimate.light_x_m, estimate.light_y_m = 3.0, 4.0
    variances = estimate.covariance_with_clock_and_wheels
    variances[0] = variances[10] = 0.01**2
    estimate.bearings_used, estimate.nis_mean = 120, 1.02
    for name, value in changes.items():
        setattr(estimate, name, value)
    return estimate


def rowsOf(estimate, history=None, width=WIDTH):
    return watch.viewOf('/calibration/estimate', estimate, history or watch.History(), TARGETS,
                        width)


def textOf(*arguments, **more):
    return '\n'.join(text for text, _ in rowsOf(*arguments, **more))


class View(unittest.TestCase):

    def testSaysStateAdviceAndMountWithUnits(self):
        text = textOf(estimateOf())
        self.assertIn('CONVERGING of /calibration/estimate', text)
        self.assertIn('turn on the spot, and come nearer to the light', text)
        self.assertRegex(text, r'x +100\.00 mm +2\.00 mm +10\.00 mm')
        self.assertRegex(text, r'yaw +60\.00 deg +1\.00 deg +0\.50 deg')
        self.assertIn('light at (3.000, 4.000) +- (0.010, 0.010) m of the base, 5.00 m away', text)
        self.assertIn('120 used', text)
        self.assertNotIn('time offset', text)

    def testTheQualityStandsBelowTheMount(self):
        text = textOf(estimateOf(quality=['a light 3 m ahead is placed ' + 9 * 'somewhere ']))
        self.assertRegex(text, r'yaw.*\n  a light 3 m ahead is placed (somewhere ?)+\n    somewhere')

    def testReachedTargetsAndStatesHaveTheirTone(self):
        tones = {text.split()[0]: tone for text, tone in rowsOf(estimateOf()) if text.strip()}
        self.assertEqual((tones['x'], tones['yaw'], tones['CONVERGING']), ('good', 'plain', 'fair'))

    def testBeforeTheFirstEstimateThereAreNoNumbersOfIt(self):
        nothing = math.nan
        text = textOf(estimateOf(x_m=nothing, y_m=nothing, x_stddev_m=nothing,
                                 state_text='INITIALISING', advice='drive on'))
        self.assertIn('no estimate yet', text)
        self.assertNotIn('nan', text)
        self.assertIn('waiting for /calibration/estimate', textOf(None))

    def testRobotErrorsThatAreLookedForStandWithTheirStates(self):
        text = textOf(estimateOf(robot_errors=[
            RobotError('time_offset', 0.1, 0.002, 's', RobotError.ESTIMATED),
            RobotError('wheel_separation_scale', 0.01, 0.005, '1', RobotError.HELD_AT_PRIOR),
            RobotError('sensor_roll', 0, 0, 'rad', RobotError.ESTIMATED),
            RobotError('bearing_noise_factor', 1.5, 0.1, '1', RobotError.ESTIMATED)]))
        self.assertRegex(text, r'time offset +100\.00 \+- 2\.00 ms +estimated')
        self.assertRegex(text, r'wheel separation +1\.00 \+- 0\.50 % +as configured')
        self.assertRegex(text, r'sensor roll +0\.00 \+- 0\.00 deg +estimated')
        self.assertRegex(text, r'bearing noise, factor +1\.50 \+- 0\.10 +estimated')
        self.assertNotIn('left wheel', text)
        self.assertNotIn('mirror', text)

    def testSeveralLightsHaveARowEach(self):
        self.assertNotIn('light 3:', textOf(estimateOf()))
        lights = [CalibrationLight(light_id=3, x_m=3.0, y_m=4.0, covariance_x_y=[1e-4, 0, 0, 4e-4],
                                   in_estimate=True, bearings_used=80),
                  CalibrationLight(light_id=-1, x_m=math.nan, y_m=math.nan, bearings_used=7,
                                   note='not found yet')]
        text = textOf(estimateOf(lights=lights))
        self.assertIn('light 3: (3.000, 4.000) +- (0.010, 0.020) m, 80 bearings', text)
        self.assertIn('light: not found, 7 bearings; left out: not found yet', text)

    def testNoRowIsWiderThanANarrowTerminal(self):
        rejections = 'bearings stamp in the future: 3; ' * 9
        for text, _ in rowsOf(estimateOf(rejections=rejections), width=60)[1:]:
            self.assertLessEqual(len(text), 80)


class StandardDeviationsSoFar(unittest.TestCase):

    def historyOf(self, values):
        history = watch.History()
        for i, value in enumerate(values):
            history.add(float(i), (value, 0.01, value))
        return history

    def testTheCurveFallsWithThem(self):
        # On a logarithmic scale an exponential decay is a straight line, from full to the least.
        curve = self.historyOf([math.exp(-0.1 * i) for i in range(100)]).curve(0)
        heights = [watch.BLOCKS.index(block) for block in curve]
        self.assertEqual((len(heights), heights[0], heights[-1]), (watch.CURVE_WIDTH, 8, 1))
        self.assertEqual(heights, sorted(heights, reverse=True))
        self.assertEqual(sorted(set(heights)), list(range(1, 9)))

    def testWhatDoesNotChangeHasNoCurve(self):
        self.assertEqual(self.historyOf([0.5, 0.4]).curve(1), '')

    def testMemoryIsBoundedAndTheBeginningStays(self):
        history = self.historyOf([1.0 / (1 + i) for i in range(20 * watch.MOST_SAMPLES)])
        self.assertLess(len(history.samples), watch.MOST_SAMPLES)
        self.assertEqual(history.samples[0][0], 1.0)
        self.assertLess(history.samples[-1][0], 2e-4)

    def testAResetForgetsThem(self):
        history = self.historyOf([0.5, 0.4])
        history.add(9.0, (math.nan, math.nan, math.nan))
        self.assertEqual(history.samples, [])


class Program(unittest.TestCase):

    def run_(self, *arguments):
        port = demo_monitor.freePort(demo_monitor.masterPorts())
        environment = dict(os.environ, ROS_MASTER_URI='http://localhost:%d' % port)
        return subprocess.run(['rosrun', 'bearing_calibration', 'watch'] + list(arguments),
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=environment,
                              universal_newlines=True, timeout=600)

    def testWithoutAMasterItSaysSoAndEnds(self):
        self.assertFalse(rosgraph.is_master_online('http://localhost:1'))
        done = self.run_('--once')
        self.assertEqual((done.returncode, done.stdout), (1, ''))
        self.assertRegex(done.stderr, r'^watch: no ROS master at http://localhost:\d+: start')
        self.assertNotIn('Traceback', done.stderr)

    def testInAPipeItAsksForOnce(self):
        done = self.run_()
        self.assertEqual(done.returncode, 2)
        self.assertIn('--once', done.stderr)


if __name__ == '__main__':
    unittest.main()
