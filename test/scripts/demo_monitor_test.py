"""What the demo calls right: converged, within three sigmas of the truth, sigmas small enough."""

import contextlib
import io
import math
import os
import signal
import socket
import sys
import unittest
from unittest import mock

from geometry_msgs.msg import Pose

from bearing_calibration.msg import CalibrationEstimate

REPOSITORY = os.path.abspath(os.path.join(os.path.dirname(__file__), '..', '..'))
sys.path.insert(0, os.path.join(REPOSITORY, 'tools', 'owner'))
import demo_monitor  # noqa: E402  (lies in tools)


def truthAt(x_m, y_m, yaw_rad):
    pose = Pose()
    pose.position.x, pose.position.y = x_m, y_m
    pose.orientation.z, pose.orientation.w = math.sin(yaw_rad / 2), math.cos(yaw_rad / 2)
    return pose


def convergedEstimate(**changes):
    """An estimate of (0.1 m, 0.05 m, 60 deg), right to half a centimetre and half a degree."""
    estimate = CalibrationEstimate()
    estimate.state = CalibrationEstimate.CONVERGED
    estimate.state_text = 'CONVERGED'
    estimate.x_m, estimate.y_m, estimate.yaw_rad = 0.1, 0.05, math.radians(60)
    estimate.x_stddev_m = estimate.y_stddev_m = 0.005
    estimate.yaw_stddev_rad = math.radians(0.5)
    for name, value in changes.items():
        setattr(estimate, name, value)
    return estimate


TRUTH = truthAt(0.1, 0.05, math.radians(60))


class Faults(unittest.TestCase):

    def assertOneFault(self, estimate, truth, *words):
        faults = demo_monitor.faultsOf(estimate, truth)
        self.assertEqual(len(faults), 1, faults)
        for word in words:
            self.assertIn(word, faults[0])

    def testTheTruthIsRight(self):
        self.assertEqual(demo_monitor.faultsOf(convergedEstimate(), TRUTH), [])

    def testErrorsOfUpToThreeSigmasAreRight(self):
        self.assertEqual(demo_monitor.faultsOf(convergedEstimate(x_m=0.1149), TRUTH), [])
        self.assertOneFault(convergedEstimate(x_m=0.1151), TRUTH, 'x is off by 1.51 cm')
        self.assertOneFault(convergedEstimate(y_m=0.0349), TRUTH, 'y is off by 1.51 cm')
        self.assertOneFault(convergedEstimate(yaw_rad=math.radians(61.51)), TRUTH,
                            'yaw is off by 1.51 deg')

    def testYawErrorsAreWrapped(self):
        estimate = convergedEstimate(yaw_rad=math.radians(180.5))
        self.assertEqual(
            demo_monitor.faultsOf(estimate, truthAt(0.1, 0.05, math.radians(-179))), [])

    def testLargeSigmasAreAFault(self):
        self.assertOneFault(convergedEstimate(x_stddev_m=0.0101), TRUTH, 'deviation of x', '1.01 cm')
        self.assertOneFault(convergedEstimate(y_stddev_m=0.02), TRUTH, 'deviation of y')
        self.assertOneFault(convergedEstimate(yaw_stddev_rad=math.radians(1.1)), TRUTH, '1.10 deg')

    def testNumbersThatAreNoneAreFaults(self):
        nan = float('nan')
        self.assertOneFault(convergedEstimate(x_m=nan), TRUTH, 'no estimate')
        self.assertTrue(demo_monitor.faultsOf(convergedEstimate(yaw_rad=nan), TRUTH))
        self.assertTrue(demo_monitor.faultsOf(convergedEstimate(x_stddev_m=nan), TRUTH))
        self.assertTrue(demo_monitor.faultsOf(convergedEstimate(x_stddev_m=0.0), TRUTH))

    def testOnlyConvergedIsRight(self):
        estimate = convergedEstimate(state=CalibrationEstimate.CONVERGING,
                                     state_text='CONVERGING', advice='drive on')
        self.assertOneFault(estimate, TRUTH, 'has not converged: CONVERGING: drive on')

    def testMissingMessagesAreNamed(self):
        self.assertOneFault(None, TRUTH, '/calibration/estimate')
        self.assertOneFault(convergedEstimate(), None, '/simulation/truth/base_from_camera')


class Table(unittest.TestCase):

    def testRowTellsValueSigmaAndErrorInSigmas(self):
        row = demo_monitor.estimateLine(12.3, convergedEstimate(x_m=0.11), TRUTH)
        self.assertRegex(row, r'^  12 s  CONVERGED +11\.00 \+- 0\.50 +\(\+2\.0\) +5\.00 \+- 0\.50 ')

    def testRowWithoutEstimateTellsTheState(self):
        estimate = CalibrationEstimate(state_text='WAITING_FOR_LIGHT', advice='none yet', x_m=float('nan'))
        self.assertEqual(demo_monitor.estimateLine(1, estimate, TRUTH), '   1 s  WAITING_FOR_LIGHT')
        self.assertIn('no message yet', demo_monitor.estimateLine(1, None, TRUTH))

    def testColumnsStandBelowEachOther(self):
        header = demo_monitor.headerLine()
        truth = demo_monitor.truthLine(TRUTH)
        row = demo_monitor.estimateLine(1, convergedEstimate(), TRUTH)
        self.assertEqual(truth.index('60.00'), row.index('60.00'))
        self.assertLess(header.index('y [cm]'), row.index('5.00'))
        self.assertLess(row.index('5.00'), header.index('yaw [deg]'))

    def testResultBlockNamesFaults(self):
        self.assertIn('right: converged', demo_monitor.resultBlock(convergedEstimate(), TRUTH))
        self.assertIn('FAULT: x is off', demo_monitor.resultBlock(convergedEstimate(x_m=1), TRUTH))
        self.assertIn('FAULT: the calibration said nothing', demo_monitor.resultBlock(None, TRUTH))


class Beginning(unittest.TestCase):

    def setUp(self):
        self.addCleanup(signal.signal, signal.SIGTERM, signal.getsignal(signal.SIGTERM))

    @mock.patch.dict(os.environ, ROS_MASTER_URI='http://localhost:1')
    @mock.patch.object(demo_monitor.subprocess, 'run', side_effect=KeyboardInterrupt)
    @mock.patch.object(demo_monitor, 'Demo')
    def testCtrlCWhileItIsExplainedStopsTheNodes(self, demo, _):
        with contextlib.redirect_stdout(io.StringIO()):
            self.assertEqual(demo_monitor.main(['drive:=manual']), 128 + signal.SIGINT)
        demo.return_value.stop.assert_called_once_with()

    def testAPortThatIsTakenIsNamed(self):
        said = io.StringIO()
        with socket.socket() as other, contextlib.redirect_stderr(said):
            other.bind(('', 0))
            other.listen()
            port = other.getsockname()[1]
            self.assertEqual(demo_monitor.main(['--port', str(port)]), 1)
        self.assertEqual(said.getvalue(), 'demo: port %d is in use already\n' % port)


if __name__ == '__main__':
    unittest.main()
