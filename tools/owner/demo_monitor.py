#!/usr/bin/env python3
"""Runs demo.launch and prints the estimate beside the truth until the calibration has converged.

Returns 0 only when the calibration called itself converged, its estimate lies within three of its
own standard deviations of the truth, and these are at most 1 cm and 1 deg.
"""

import argparse
import collections
import math
import os
import random
import signal
import socket
import subprocess
import sys
import time

import rosgraph
import roslib.packages
import rospy
from geometry_msgs.msg import PoseStamped

from bearing_calibration.msg import CalibrationEstimate

MAX_STDDEV_M = 0.01
MAX_STDDEV_RAD = math.radians(1)
MAX_ERROR_SIGMAS = 3

ESTIMATE_TOPIC = '/calibration/estimate'
TRUTH_TOPIC = '/simulation/truth/base_from_camera'
DEFAULT_MASTER_PORT = 11311
MASTER_DEADLINE_S = 20
STOP_DEADLINE_S = 15
RECORD_ON_S = 8  # after convergence: the bag misses the first images, and shall say the same

# One number of the mount. `unit` is what it is printed in; `scale` makes that from SI.
Quantity = collections.namedtuple('Quantity', 'name unit scale value stddev truth limit')


def yawOf(orientation):
    """Yaw [rad] of a quaternion, as z-y-x Euler angles have it."""
    q = orientation
    return math.atan2(2 * (q.w * q.z + q.x * q.y), 1 - 2 * (q.y * q.y + q.z * q.z))


def quantitiesOf(estimate, truth):
    """x, y and yaw of an estimate (CalibrationEstimate) beside those of the truth (Pose)."""
    degrees = math.degrees(1)
    return [
        Quantity('x', 'cm', 100, estimate.x_m, estimate.x_stddev_m, truth.position.x,
                 MAX_STDDEV_M),
        Quantity('y', 'cm', 100, estimate.y_m, estimate.y_stddev_m, truth.position.y,
                 MAX_STDDEV_M),
        Quantity('yaw', 'deg', degrees, estimate.yaw_rad, estimate.yaw_stddev_rad,
                 yawOf(truth.orientation), MAX_STDDEV_RAD),
    ]


def errorOf(quantity):
    error = quantity.value - quantity.truth
    return math.remainder(error, 2 * math.pi) if quantity.unit == 'deg' else error


def hasEstimate(estimate):
    return estimate is not None and math.isfinite(estimate.x_m)


def faultsOf(estimate, truth):
    """What is wrong with a result, one sentence each; empty when it is right."""
    if truth is None:
        return ['the simulator published no truth on %s' % TRUTH_TOPIC]
    if estimate is None:
        return ['the calibration said nothing on %s' % ESTIMATE_TOPIC]
    if not hasEstimate(estimate):
        return ['there is no estimate: %s' % estimate.advice]
    faults = []
    if estimate.state != CalibrationEstimate.CONVERGED:
        faults.append('it has not converged: %s: %s' % (estimate.state_text, estimate.advice))
    for quantity in quantitiesOf(estimate, truth):
        if not 0 < quantity.stddev <= quantity.limit:
            faults.append('the standard deviation of %s is %.2f %s, more than %.2f' % (
                quantity.name, quantity.scale * quantity.stddev, quantity.unit,
                quantity.scale * quantity.limit))
        if not abs(errorOf(quantity)) <= MAX_ERROR_SIGMAS * quantity.stddev:
            faults.append('%s is off by %.2f %s, more than %d of its standard deviations' % (
                quantity.name, quantity.scale * abs(errorOf(quantity)), quantity.unit,
                MAX_ERROR_SIGMAS))
    return faults


def headerLine():
    return '%6s  %-18s%-24s%-24s%s' % ('time', 'state', 'x [cm]', 'y [cm]', 'yaw [deg]')


def truthLine(truth):
    nothing = CalibrationEstimate()
    cells = ['%8.2f' % (q.scale * q.truth) for q in quantitiesOf(nothing, truth)]
    return '%6s  %-18s%-24s%-24s%s' % ('', 'truth', *cells)


def estimateLine(seconds, estimate, truth):
    """A row of the table: value +- standard deviation (error in standard deviations)."""
    cells = ['', '', '']
    if hasEstimate(estimate):
        cells = ['%8.2f +- %-5.2f(%+.1f)' % (q.scale * q.value, q.scale * q.stddev,
                                             errorOf(q) / q.stddev if q.stddev > 0 else math.nan)
                 for q in quantitiesOf(estimate, truth)]
    state = estimate.state_text if estimate is not None else 'no message yet'
    return ('%4.0f s  %-18s%-24s%-24s%-24s' % (seconds, state, *cells)).rstrip()


def resultBlock(estimate, truth):
    faults = faultsOf(estimate, truth)
    lines = ['', 'Result']
    if truth is not None and hasEstimate(estimate):
        for q in quantitiesOf(estimate, truth):
            lines.append('  %-4s%8.2f %-3s +- %.2f   truth %7.2f   error %+.2f' % (
                q.name, q.scale * q.value, q.unit, q.scale * q.stddev, q.scale * q.truth,
                q.scale * errorOf(q)))
    lines += ['  FAULT: ' + fault for fault in faults]
    if not faults:
        lines.append('  right: converged, within %d standard deviations of the truth, these at '
                     'most %.0f cm and %.0f deg' % (MAX_ERROR_SIGMAS, 100 * MAX_STDDEV_M,
                                                    math.degrees(MAX_STDDEV_RAD)))
    return '\n'.join(lines)


def bagPath():
    """Where the drive is recorded: the same file at each demo."""
    folder = os.environ.get('ROS_HOME', os.path.expanduser('~/.ros'))
    os.makedirs(folder, exist_ok=True)
    return os.path.join(folder, 'bearing_calibration_demo.bag')


def nextSteps(bag):
    """The way of an owner from a recording to a URDF."""
    run = '  ./scripts/run rosrun bearing_calibration '
    robot = os.path.join(roslib.packages.get_pkg_dir('bearing_calibration'), 'config', 'robots',
                         'simulated.yaml')
    return '\n'.join([
        '', 'The joint for a URDF, and a report, of what was just recorded:',
        run + 'calibrate_bag %s --config %s --output demo_result' % (bag, robot),
        run + 'calibration_report demo_result'])


class Demo:
    """demo.launch as a child process, and the last messages of the two topics."""

    def __init__(self, port, launch_arguments):
        self.estimate = None
        self.truth = None
        os.environ['ROS_MASTER_URI'] = 'http://localhost:%d' % port
        log_folder = os.environ.get('ROS_LOG_DIR', os.path.expanduser('~/.ros/log'))
        os.makedirs(log_folder, exist_ok=True)
        self.log_path = os.path.join(log_folder, 'demo.log')
        with open(self.log_path, 'w') as log:
            # A session of its own: it is stopped by stop() alone, once, whoever presses ctrl-C.
            self.process = subprocess.Popen(
                ['roslaunch', '-p', str(port), 'bearing_calibration', 'demo.launch']
                + launch_arguments,
                stdin=subprocess.DEVNULL, stdout=log, stderr=subprocess.STDOUT,
                start_new_session=True)

    def connect(self):
        deadline = time.monotonic() + MASTER_DEADLINE_S
        while not rosgraph.is_master_online():
            if not self.isAlive() or time.monotonic() > deadline:
                raise RuntimeError('roslaunch did not start')
            time.sleep(0.1)
        rospy.init_node('demo_monitor', anonymous=True, disable_signals=True)
        rospy.Subscriber(ESTIMATE_TOPIC, CalibrationEstimate, self.keepEstimate)
        rospy.Subscriber(TRUTH_TOPIC, PoseStamped, self.keepTruth)

    def keepEstimate(self, message):
        self.estimate = message

    def keepTruth(self, message):
        self.truth = message.pose

    def isAlive(self):
        return self.process.poll() is None

    def hasConverged(self):
        return self.estimate is not None and self.estimate.state == CalibrationEstimate.CONVERGED

    def stop(self):
        rospy.signal_shutdown('the demo ends')
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGKILL):
            if not self.isAlive():
                return
            # To roslaunch alone first: it stops its nodes in order.
            if number == signal.SIGINT:
                self.process.send_signal(number)
            else:
                os.killpg(self.process.pid, number)
            try:
                self.process.wait(timeout=STOP_DEADLINE_S)
            except subprocess.TimeoutExpired:
                pass


def freePort(candidates):
    """The first of `candidates` that nobody listens on. @throws RuntimeError when there is none."""
    for port in candidates:
        with socket.socket() as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            try:
                probe.bind(('', port))
                return port
            except OSError:
                continue
    raise RuntimeError('port %s is in use already' % ', '.join(map(str, candidates[:1])))


def masterPorts():
    """Ports for a master of one's own, in random order, below those that the kernel hands out: one
    of these might be taken between this and the master's start."""
    return random.sample(range(DEFAULT_MASTER_PORT + 1, 32768), 100)


def watch(demo, limit_s, period_s):
    """Prints a row each period until the calibration has converged or the time is up."""
    start = time.monotonic()
    next_row_s = 0.0
    truth_is_told = False
    print(headerLine())
    while demo.isAlive() and time.monotonic() - start < limit_s and not demo.hasConverged():
        elapsed_s = time.monotonic() - start
        if demo.truth is not None and elapsed_s >= next_row_s:
            if not truth_is_told:
                print(truthLine(demo.truth))
                truth_is_told = True
            print(estimateLine(elapsed_s, demo.estimate, demo.truth), flush=True)
            next_row_s = elapsed_s + period_s
        time.sleep(0.1)
    if demo.hasConverged():
        time.sleep(RECORD_ON_S)
    if demo.truth is not None:
        print(estimateLine(time.monotonic() - start, demo.estimate, demo.truth), flush=True)


def raiseExit(number, _):
    sys.exit(128 + number)


def parse(arguments):
    parser = argparse.ArgumentParser(prog='demo', description=__doc__)
    parser.add_argument('--no-detector', action='store_true',
                        help='leave the light detector out: the calibration cannot converge')
    parser.add_argument('--seconds', type=float, default=150,
                        help='give up after so long (default %(default)s)')
    parser.add_argument('--period', type=float, default=3, help='seconds between two rows')
    parser.add_argument('--port', type=int,
                        help="of the demo's own ROS master (default %d, so that other terminals see "
                        'it, or another when that one is taken)' % DEFAULT_MASTER_PORT)
    parser.add_argument('launch_arguments', nargs='*', metavar='NAME:=VALUE',
                        help='for demo.launch, as rviz:=true or seed:=2')
    return parser.parse_args(arguments)


def main(arguments):
    options = parse(arguments)
    signal.signal(signal.SIGTERM, raiseExit)
    without_detector = ['detect:=false'] if options.no_detector else []
    ports = [options.port] if options.port else [DEFAULT_MASTER_PORT] + masterPorts()
    try:
        port = freePort(ports)
    except RuntimeError as error:
        print('demo: %s' % error, file=sys.stderr)
        return 1
    bag = bagPath()
    demo = Demo(port, without_detector + ['bag:=' + bag] + options.launch_arguments)
    try:
        print('Demo at %s, output of its nodes in %s' % (os.environ['ROS_MASTER_URI'], demo.log_path))
        if 'drive:=manual' in options.launch_arguments:  # what the launch file prints is in the log
            subprocess.run(['rosrun', 'bearing_calibration', 'drive_instructions', 'corner_light'])
            print()
        print('In the table: value +- standard deviation (error in standard deviations)\n', flush=True)
        demo.connect()
        watch(demo, options.seconds, options.period)
        if not demo.isAlive():
            raise RuntimeError('roslaunch ended before the demo did')
        print(resultBlock(demo.estimate, demo.truth), flush=True)
        if faultsOf(demo.estimate, demo.truth):
            return 1
        print(nextSteps(bag), flush=True)
        return 0
    except KeyboardInterrupt:
        print('\nstopped')
        return 128 + signal.SIGINT
    except RuntimeError as error:
        print('demo: %s; see %s' % (error, demo.log_path), file=sys.stderr)
        return 1
    finally:
        demo.stop()


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
