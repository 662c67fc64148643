#!/usr/bin/env python3
"""Shows a calibration in the terminal: its state, what to do next, the mount with its standard
deviations as they shrink. Ends on q or ctrl-C; it may come and go at any time."""

import argparse
import curses
import locale
import math
import shutil
import signal
import sys
import textwrap
import threading
import time

import rosgraph
import rospy

from bearing_calibration.msg import CalibrationEstimate, RobotError

BLOCKS = ' \u2581\u2582\u2583\u2584\u2585\u2586\u2587\u2588'
CURVE_WIDTH = 24
MOST_SAMPLES = 512
SAMPLE_PERIOD_S = 0.2
SILENCE_S = 4.0  # the node says something each second
REFRESH_S = 0.2
ONCE_DEADLINE_S = 5.0
DEGREES = math.degrees(1.0)

# Of a state's line, by its name; the curses colours stand in COLOURS.
TONES = {'CONVERGED': 'good', 'CONVERGING': 'fair', 'INITIALISING': 'fair',
         'DEGENERATE_MOTION': 'bad', 'INCONSISTENT': 'bad'}
COLOURS = {'good': curses.COLOR_GREEN, 'fair': curses.COLOR_YELLOW, 'bad': curses.COLOR_RED}

# A robot error in the unit that people use: name, unit, factor from SI.
ERRORS = {'time_offset': ('time offset', 'ms', 1e3),
          'left_wheel_scale': ('left wheel', '%', 100),
          'right_wheel_scale': ('right wheel', '%', 100),
          'wheel_separation_scale': ('wheel separation', '%', 100),
          'mirror_harmonic_cos': ('mirror, cos', 'deg', DEGREES),
          'mirror_harmonic_sin': ('mirror, sin', 'deg', DEGREES),
          'mirror_near_per_far': ('mirror, near per far', 'mm', 1e3),
          'sensor_roll': ('sensor roll', 'deg', DEGREES),
          'sensor_pitch': ('sensor pitch', 'deg', DEGREES),
          'light_height': ('light above sensor', 'mm', 1e3),
          **{f'light_height_{light}': (f'light {light} above sensor', 'mm', 1e3)
             for light in range(2, 9)},
          'bearing_noise_factor': ('bearing noise, factor', '', 1),
          'wheel_noise_factor': ('wheel noise, factor', '', 1),
          'light_size': ('light size', 'mm', 1e3),
          'bearing_correlation_time': ('correlation time', 's', 1)}
ERROR_STATES = {RobotError.HELD_AT_PRIOR: 'as configured: the data say little',
                RobotError.ESTIMATED: 'estimated'}


class History:
    """Samples of the standard deviations from the first one on, however long it takes: when it is
    full, every second one is dropped."""

    def __init__(self):
        self.samples = []  # (x, y, yaw)
        self.period_s = SAMPLE_PERIOD_S
        self.next_s = -math.inf

    def add(self, now_s, stddevs):
        if not all(math.isfinite(each) and each > 0 for each in stddevs):
            self.samples = []  # begun anew
            return
        if now_s < self.next_s:
            return
        self.next_s = now_s + self.period_s
        self.samples.append(stddevs)
        if len(self.samples) == MOST_SAMPLES:
            self.samples = self.samples[::2]
            self.period_s *= 2

    def curve(self, quantity, width=CURVE_WIDTH):
        """The samples as a line of blocks, on a logarithmic scale from the least to the most."""
        logs = [math.log(sample[quantity]) for sample in self.samples]
        if len(logs) < 2 or max(logs) - min(logs) < 1e-9:
            return ''
        columns = [logs[i * (len(logs) - 1) // (width - 1)] for i in range(width)]
        steps = len(BLOCKS) - 2
        return ''.join(BLOCKS[1 + round(steps * (each - min(logs)) / (max(logs) - min(logs)))]
                       for each in columns)


def mountRows(estimate, history, targets):
    rows = [('  %-6s%12s%14s%14s   %s' % ('', 'value', 'std dev', 'wanted', 'std dev so far'),
             'plain')]
    for i, (name, unit, scale, value, stddev, target) in enumerate((
            ('x', 'mm', 1e3, estimate.x_m, estimate.x_stddev_m, targets[0]),
            ('y', 'mm', 1e3, estimate.y_m, estimate.y_stddev_m, targets[0]),
            ('yaw', 'deg', DEGREES, estimate.yaw_rad, estimate.yaw_stddev_rad, targets[1]))):
        wanted = '' if target is None else '%.2f %s' % (scale * target, unit)
        tone = 'good' if target is not None and stddev <= target else 'plain'
        rows.append(('  %-6s%8.2f %-3s%10.2f %-3s%14s   %s' % (
            name, scale * value, unit, scale * stddev, unit, wanted, history.curve(i)), tone))
    return rows


def qualityRows(estimate, width):
    return [('  ' + line, 'plain') for sentence in estimate.quality
            for line in textwrap.wrap(sentence, max(20, width - 4), subsequent_indent='  ')]


def paperRow(estimate):
    if not estimate.phi_psi_determined:
        return '  rho %.1f mm: phi and psi mean nothing by themselves' % (1e3 * estimate.rho_m)
    return '  phi %.2f deg   rho %.1f mm   psi %.2f deg' % (
        DEGREES * estimate.phi_rad, 1e3 * estimate.rho_m, DEGREES * estimate.psi_rad)


def lightRow(estimate):
    variance = estimate.covariance_with_clock_and_wheels
    return '  light at (%.3f, %.3f) +- (%.3f, %.3f) m of the base, %.2f m away' % (
        estimate.light_x_m, estimate.light_y_m, math.sqrt(variance[0]), math.sqrt(variance[10]),
        math.hypot(estimate.light_x_m, estimate.light_y_m))


def furtherLightRows(estimate):
    """Every light, where there are several."""
    if len(estimate.lights) < 2:
        return []
    rows = []
    for light in estimate.lights:
        name = 'light' if light.light_id < 0 else 'light %d' % light.light_id
        place = 'not found' if math.isnan(light.x_m) else '(%.3f, %.3f) +- (%.3f, %.3f) m' % (
            light.x_m, light.y_m, math.sqrt(light.covariance_x_y[0]),
            math.sqrt(light.covariance_x_y[3]))
        rows.append('  %s: %s, %d bearings%s' % (
            name, place, light.bearings_used,
            '' if light.in_estimate else '; left out: ' + (light.note or 'another one leads')))
    return rows


def errorRows(estimate):
    """Those of the robot's own errors that are estimated."""
    rows = []
    for error in estimate.robot_errors:
        said = ERROR_STATES.get(error.state)
        if said is not None:
            name, unit, scale = ERRORS.get(error.name, (error.name, error.unit, 1))
            rows.append('  %-21s%7.2f +- %.2f %-3s  %s' % (
                name, scale * error.value, scale * error.stddev, unit, said))
    return rows


def countRows(estimate):
    rows = ['  driven %.2f m, turned %.0f deg' % (
                estimate.distance_travelled_m, DEGREES * estimate.rotation_travelled_rad),
            '  bearings: %d used, %d gated, %d refused, %d waiting; mean NIS %.2f' % (
                estimate.bearings_used, estimate.bearings_gated, estimate.bearings_rejected,
                estimate.bearings_waiting, estimate.nis_mean),
            '  wheel readings: %d used, %d refused' % (estimate.ticks_used,
                                                       estimate.ticks_rejected)]
    if estimate.rejections:
        rows.append('  refused or changed: ' + estimate.rejections)
    return rows


def viewOf(topic, estimate, history, targets, width):
    """The rows of the picture: (text, tone). `estimate` is None before the first one."""
    if estimate is None:
        return [('waiting for %s: does the calibration run?' % topic, 'bad')]
    state, advice = estimate.state_text, estimate.advice
    rows = [('%s of %s' % (state, topic), TONES.get(state, 'plain'))]
    rows += [('  ' + line, 'plain') for line in textwrap.wrap(advice, max(20, width - 4))]
    rows.append(('', 'plain'))
    if math.isfinite(estimate.x_m):
        rows += mountRows(estimate, history, targets) + qualityRows(estimate, width)
        plain = ['', paperRow(estimate), lightRow(estimate)]
    else:
        plain = ['  no estimate yet']
    plain += furtherLightRows(estimate)
    errors = errorRows(estimate)
    plain += ([''] + errors if errors else []) + [''] + countRows(estimate)
    rows += [(line[:width], 'plain') for line in plain]
    return rows


class Watch:
    """The last estimate of a topic and the history of its standard deviations."""

    def __init__(self, topic):
        self.lock = threading.Lock()
        self.estimate, self.history = None, History()
        self.heard_s = time.monotonic()
        self.topic = rospy.resolve_name(topic)
        rospy.Subscriber(self.topic, CalibrationEstimate, self.keep)

    def keep(self, estimate):
        with self.lock:
            self.estimate, self.heard_s = estimate, time.monotonic()
            self.history.add(self.heard_s, (estimate.x_stddev_m, estimate.y_stddev_m,
                                            estimate.yaw_stddev_rad))

    def targets(self):
        """What the node wants to know the position and the yaw to; None where it does not say."""
        group = self.topic.rsplit('/', 1)[0] + '/converged/'
        try:
            return [rospy.get_param(group + name, None)
                    for name in ('position_stddev', 'yaw_stddev')]
        except (OSError, rospy.ROSException):
            return [None, None]  # the master is gone

    def view(self, targets, width):
        with self.lock:
            rows = viewOf(self.topic, self.estimate, self.history, targets, width)
            silent_s = time.monotonic() - self.heard_s
        if self.estimate is not None and silent_s > SILENCE_S:
            rows.append(('  nothing new for %.0f s: does the calibration still run?' % silent_s,
                         'bad'))
        return rows


def printOnce(watch):
    deadline = time.monotonic() + ONCE_DEADLINE_S
    while watch.estimate is None and time.monotonic() < deadline:
        time.sleep(0.05)
    width = shutil.get_terminal_size().columns
    view = '\n'.join(text for text, _ in watch.view(watch.targets(), width))
    signal.signal(signal.SIGPIPE, signal.SIG_DFL)  # it ends as any program before `| head`
    print(view)
    return 0 if watch.estimate is not None else 1


def attributeOf(tone):
    if tone not in COLOURS:
        return curses.A_NORMAL
    number = 1 + sorted(COLOURS).index(tone)
    return curses.color_pair(number) | curses.A_BOLD


def showOn(screen, watch):
    if curses.has_colors():  # a serial console has none
        curses.use_default_colors()
        for tone in COLOURS:
            curses.init_pair(1 + sorted(COLOURS).index(tone), COLOURS[tone], -1)
    try:
        curses.curs_set(0)
    except curses.error:
        pass  # not every terminal can hide its cursor
    screen.timeout(round(1e3 * REFRESH_S))
    targets = watch.targets()
    while screen.getch() != ord('q'):
        height, width = screen.getmaxyx()
        if targets == [None, None]:
            targets = watch.targets()  # the node may have come meanwhile
        screen.erase()
        for row, (text, tone) in enumerate(watch.view(targets, width - 1)[:height - 1]):
            screen.addstr(row, 0, text[:width - 1], attributeOf(tone))
        screen.addstr(height - 1, 0, 'q: quit'[:width - 1], curses.A_DIM)
        screen.refresh()


def main(arguments):
    parser = argparse.ArgumentParser(prog='watch', description=__doc__)
    parser.add_argument('--once', action='store_true', help='print what there is now, and end')
    parser.add_argument('--estimate', default='calibration/estimate', metavar='TOPIC',
                        help='default: %(default)s')
    options = parser.parse_args(arguments)
    if not options.once and not sys.stdout.isatty():
        parser.error('this is no terminal: --once prints the view')
    if not rosgraph.is_master_online():
        print('watch: no ROS master at %s: start the calibration first, or set ROS_MASTER_URI'
              % rosgraph.get_master_uri(), file=sys.stderr)
        return 1
    try:
        locale.setlocale(locale.LC_ALL, '')
    except locale.Error:
        pass  # ssh brings the desktop's, which the robot need not have
    rospy.init_node('watch', anonymous=True, disable_signals=True)
    watch = Watch(options.estimate)
    if options.once:
        return printOnce(watch)
    try:
        curses.wrapper(showOn, watch)
    except KeyboardInterrupt:
        pass  # the usual way to end it
    return 0


if __name__ == '__main__':
    sys.exit(main(rospy.myargv(sys.argv)[1:]))
