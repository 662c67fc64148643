#!/usr/bin/env python3
"""Takes pictures of RViz while the robot of demo.launch drives its own calibration.

A real RViz, on a screen of its own that nobody sees (Xvfb, drawn by software): each picture is of one
of the views saved in rviz/calibration.rviz, once the calibration has come to a state.
"""

import argparse
import collections
import math
import os
import signal
import subprocess
import sys
import tempfile
import time

import matplotlib.image
import numpy
import yaml

from bearing_calibration.msg import CalibrationEstimate

HERE = os.path.dirname(os.path.realpath(__file__))
sys.path.insert(0, os.path.join(HERE, '..', 'owner'))
import demo_monitor  # noqa: E402  (not on the path)

CONFIGURATION = os.path.join(HERE, '..', '..', 'rviz', 'calibration.rviz')
# What a picture shows: a saved view, about a fixed frame, with so many pixels a metre and this centre; when
# it is taken. Without panels, so that what is written can be read.
Picture = collections.namedtuple('Picture', 'view fixed_frame size scale centre state least_distance_m')
PAGE = (830, 560)  # as wide as a page
FRONT = (600, 620)  # twice as large as the front page's picture shows it
# While the ellipses are large enough to be seen, or at the end.
UNDER_WAY = CalibrationEstimate.CONVERGING, 0.9
AT_THE_END = CalibrationEstimate.CONVERGED, 0.0
# Those of one set are of the same drive.
SETS = {
    'room': {'rviz_room': Picture('Room', 'calibration_start', PAGE, 290, (0.6, -0.45), *UNDER_WAY)},
    'mount': {'rviz_mount': Picture('Mount', 'base_link', PAGE, 1794, (0.04, 0.01), *UNDER_WAY)},
    'front': {'front_room': Picture('Room', 'calibration_start', FRONT, 430, (0.55, -0.5), *AT_THE_END),
              'front_mount': Picture('Mount', 'base_link', FRONT, 1500, (0.04, 0.01), *AT_THE_END)}}
PAGE_SETS = ('room', 'mount')
VALUES = 'front.yaml'  # the estimate and the truth when those of the front page are taken
STATE_DEADLINE_S = 240
START_S = 8  # RViz takes so long until it has drawn everything, on a busy machine
SETTLE_S = 2  # between the state and its picture
DRAWN_DEADLINE_S = 60  # until the picture shows what it must, on a machine where START_S is too short
MOST_STARTS = 3  # of RViz
# What every picture must show: colours of markers (src/ros/visualisation_markers.cpp), in this many pixels.
MARKS = {'path': (0.34, 0.71, 0.91), 'ray': (0.94, 0.89, 0.26)}
MIN_PIXELS = 40
LIKE = 0.06  # largest difference of a channel


def configurationWith(picture, folder):
    """A copy of the configuration that begins with a picture's view, in a window without panels."""
    with open(CONFIGURATION) as file:
        configuration = yaml.safe_load(file)
    manager = configuration['Visualization Manager']
    manager['Global Options']['Fixed Frame'] = picture.fixed_frame
    views = manager['Views']
    views['Current'] = next(saved for saved in views['Saved'] if saved['Name'] == picture.view)
    views['Current']['Scale'] = picture.scale
    views['Current']['X'], views['Current']['Y'] = picture.centre
    configuration['Panels'] = []
    manager['Displays'] = [display for display in manager['Displays'] if display['Class'] != 'rviz/Image']
    configuration['Window Geometry'] = dict(zip(('Width', 'Height'), picture.size))
    path = os.path.join(folder, picture.view + '.rviz')
    with open(path, 'w') as file:
        yaml.safe_dump(configuration, file)
    return path


def waitForState(demo, picture):
    deadline = time.monotonic() + STATE_DEADLINE_S
    while time.monotonic() < deadline:
        estimate = demo.estimate
        if (estimate is not None and estimate.state == picture.state
                and estimate.distance_travelled_m >= picture.least_distance_m):
            return
        time.sleep(0.1)
    raise RuntimeError('the calibration did not come to the state of the picture within %d s' % STATE_DEADLINE_S)


def missingIn(path):
    """Names of the marks that a picture does not show."""
    picture = numpy.atleast_3d(matplotlib.image.imread(path))[:, :, :3]  # grey before it is drawn
    return [name for name, colour in MARKS.items()
            if (abs(picture - colour).max(axis=2) < LIKE).sum() < MIN_PIXELS]


class RvizEnded(RuntimeError):
    """RViz has ended by itself."""


def takePicture(demo, name, picture, output):
    with tempfile.TemporaryDirectory() as folder:
        rviz = subprocess.Popen(
            ['rosrun', 'rviz', 'rviz', '--fullscreen', '-d', configurationWith(picture, folder)],
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)
        keepPicture(demo, name, picture, rviz, output)


def keepPicture(demo, name, picture, rviz, output):
    try:
        time.sleep(START_S)
        waitForState(demo, picture)
        time.sleep(SETTLE_S)
        path = os.path.join(output, name + '.png')
        deadline = time.monotonic() + DRAWN_DEADLINE_S
        while True:
            subprocess.run(['import', '-window', 'root', '-strip', path], check=True)
            missing = missingIn(path)
            if not missing:
                break
            if rviz.poll() is not None:
                raise RvizEnded('RViz has ended with %d' % rviz.returncode)
            if time.monotonic() > deadline:
                raise RuntimeError('%s does not show: %s' % (path, ', '.join(missing)))
            time.sleep(1)
        print(path, flush=True)
    finally:
        if rviz.poll() is None:
            os.killpg(rviz.pid, signal.SIGTERM)
            rviz.wait(timeout=20)


def driveAndTake(pictures, output, rate):
    """On the screen of the environment. On a busy machine RViz sometimes ends at its start (boost::lock_error,
    a mutex of its own): then the robot drives once more, for a picture's moment passes."""
    for attempt in range(1, MOST_STARTS + 1):
        try:
            return driveAndTakeOnce(pictures, output, rate)
        except RvizEnded as error:
            print('start %d: %s' % (attempt, error), flush=True)
            if attempt == MOST_STARTS:
                raise


def driveAndTakeOnce(pictures, output, rate):
    port = demo_monitor.freePort(demo_monitor.masterPorts())
    demo = demo_monitor.Demo(port, ['drive:=optimal', 'rate:=%g' % rate])
    try:
        demo.connect()
        for name, picture in pictures.items():
            takePicture(demo, name, picture, output)
        if pictures is SETS['front']:
            keepValues(demo, os.path.join(output, VALUES))
    finally:
        demo.stop()


def keepValues(demo, path):
    values = {quantity.name: {'value': quantity.value, 'stddev': quantity.stddev, 'truth': quantity.truth}
              for quantity in demo_monitor.quantitiesOf(demo.estimate, demo.truth)}
    with open(path, 'w') as file:
        yaml.safe_dump(values, file)


def takeOnHiddenScreen(name, output, rate):
    width, height = next(iter(SETS[name].values())).size
    with tempfile.TemporaryDirectory() as runtime:
        os.chmod(runtime, 0o700)
        environment = dict(os.environ, LIBGL_ALWAYS_SOFTWARE='1', QT_X11_NO_MITSHM='1',
                           XDG_RUNTIME_DIR=runtime, HOME=runtime)
        return subprocess.run(
            ['xvfb-run', '-a', '-s', '-screen 0 %dx%dx24 +extension GLX' % (width, height), sys.executable,
             os.path.realpath(__file__), output, '--rate', str(rate), '--here', name],
            env=environment).returncode


def main(arguments):
    parser = argparse.ArgumentParser(prog='rviz_screenshots', description=__doc__)
    parser.add_argument('output', help='folder for the pictures')
    parser.add_argument('--rate', type=float, default=0.4,
                        help='simulated seconds in a second (default %(default)s: RViz is drawn by '
                        'software)')
    parser.add_argument('--here', metavar='SET', choices=sorted(SETS),
                        help='the pictures of one set (%(choices)s), on the screen that is there')
    options = parser.parse_args(arguments)
    if not math.isfinite(options.rate) or options.rate <= 0:
        parser.error('--rate must be greater than 0')
    if options.here:
        driveAndTake(SETS[options.here], options.output, options.rate)
        return 0
    return max(takeOnHiddenScreen(name, options.output, options.rate) for name in PAGE_SETS)


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
