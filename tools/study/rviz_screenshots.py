#!/usr/bin/env python3
"""Takes pictures of RViz while the robot of demo.launch drives its own calibration.

A real RViz, on a screen of its own that nobody sees (Xvfb, drawn by software): each picture is of one
of the views saved in rviz/calibration.rviz, once the calibration has come to a state.
"""

import argparse
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
# As wide as a page shows it, so that what is written can be read: without RViz' panels.
WIDTH, HEIGHT = 830, 620
SHRUNK = 0.78  # the scene, which has a larger window with the panels
# Name of the picture: saved view and fixed frame.
PICTURES = {'rviz_room': ('Room', 'calibration_start'), 'rviz_mount': ('Mount', 'base_link')}
# Taken while the ellipses are large enough to be seen.
STATE, LEAST_DISTANCE_M = CalibrationEstimate.CONVERGING, 0.9
STATE_DEADLINE_S = 120
START_S = 8  # RViz takes so long until it has drawn everything, on a busy machine
SETTLE_S = 2  # between the state and its picture
DRAWN_DEADLINE_S = 60  # until the picture shows what it must, on a machine where START_S is too short
MOST_STARTS = 3  # of RViz
# What every picture must show: colours of markers (src/ros/visualisation_markers.cpp), in this many pixels.
MARKS = {'path': (0.34, 0.71, 0.91), 'ray': (0.94, 0.89, 0.26)}
MIN_PIXELS = 40
LIKE = 0.06  # largest difference of a channel


def configurationWith(view, fixed_frame, folder):
    """A copy of the configuration that begins with one of its saved views, in a window without panels."""
    with open(CONFIGURATION) as file:
        configuration = yaml.safe_load(file)
    manager = configuration['Visualization Manager']
    manager['Global Options']['Fixed Frame'] = fixed_frame
    views = manager['Views']
    views['Current'] = next(saved for saved in views['Saved'] if saved['Name'] == view)
    views['Current']['Scale'] *= SHRUNK
    configuration['Panels'] = []
    manager['Displays'] = [display for display in manager['Displays'] if display['Class'] != 'rviz/Image']
    configuration['Window Geometry'] = {'Width': WIDTH, 'Height': HEIGHT}
    path = os.path.join(folder, view + '.rviz')
    with open(path, 'w') as file:
        yaml.safe_dump(configuration, file)
    return path


def waitForState(demo):
    deadline = time.monotonic() + STATE_DEADLINE_S
    while time.monotonic() < deadline:
        estimate = demo.estimate
        if (estimate is not None and estimate.state == STATE
                and estimate.distance_travelled_m >= LEAST_DISTANCE_M):
            return
        time.sleep(0.1)
    raise RuntimeError('the calibration did not converge within %d s' % STATE_DEADLINE_S)


def missingIn(path):
    """Names of the marks that a picture does not show."""
    picture = numpy.atleast_3d(matplotlib.image.imread(path))[:, :, :3]  # grey before it is drawn
    return [name for name, colour in MARKS.items()
            if (abs(picture - colour).max(axis=2) < LIKE).sum() < MIN_PIXELS]


class RvizEnded(RuntimeError):
    """RViz has ended by itself."""


def takePicture(demo, name, folder, output):
    """On a busy machine RViz sometimes ends at its start (boost::lock_error, a mutex of its own): then
    it is started again."""
    for attempt in range(1, MOST_STARTS + 1):
        try:
            return takePictureOnce(demo, name, folder, output)
        except RvizEnded as error:
            print('start %d: %s' % (attempt, error), flush=True)
            if attempt == MOST_STARTS:
                raise


def takePictureOnce(demo, name, folder, output):
    rviz = subprocess.Popen(['rosrun', 'rviz', 'rviz', '-d', configurationWith(*PICTURES[name], folder)],
                            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                            start_new_session=True)
    try:
        time.sleep(START_S)
        waitForState(demo)
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


def driveAndTake(name, output, rate):
    """On the screen of the environment."""
    port = demo_monitor.freePort(demo_monitor.masterPorts())
    demo = demo_monitor.Demo(port, ['drive:=optimal', 'rate:=%g' % rate])
    try:
        demo.connect()
        with tempfile.TemporaryDirectory() as folder:
            takePicture(demo, name, folder, output)
    finally:
        demo.stop()


def takeOnHiddenScreen(name, options):
    with tempfile.TemporaryDirectory() as runtime:
        os.chmod(runtime, 0o700)
        environment = dict(os.environ, LIBGL_ALWAYS_SOFTWARE='1', QT_X11_NO_MITSHM='1',
                           XDG_RUNTIME_DIR=runtime, HOME=runtime)
        return subprocess.run(
            ['xvfb-run', '-a', '-s', '-screen 0 %dx%dx24 +extension GLX' % (WIDTH, HEIGHT), sys.executable,
             os.path.realpath(__file__), options.output, '--rate', str(options.rate),
             '--here', name], env=environment).returncode


def main(arguments):
    parser = argparse.ArgumentParser(prog='rviz_screenshots', description=__doc__)
    parser.add_argument('output', help='folder for the pictures')
    parser.add_argument('--rate', type=float, default=0.4,
                        help='simulated seconds in a second (default %(default)s: RViz is drawn by '
                        'software)')
    parser.add_argument('--here', metavar='PICTURE', choices=sorted(PICTURES),
                        help='one picture, on the screen that is there')
    options = parser.parse_args(arguments)
    if not math.isfinite(options.rate) or options.rate <= 0:
        parser.error('--rate must be greater than 0')
    if options.here:
        driveAndTake(options.here, options.output, options.rate)
        return 0
    return max(takeOnHiddenScreen(name, options) for name in PICTURES)


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
