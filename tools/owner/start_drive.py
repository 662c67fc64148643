#!/usr/bin/env python3
"""Asks the drive node to drive a calibration, shows how it goes, and stops it on ctrl-C, or when its
terminal or connection is closed.

Waits until the calibration sees the light. Returns 0 only when the calibration has converged.
"""

import argparse
import os
import signal
import sys
import threading
import time

import actionlib
import rospy
from actionlib_msgs.msg import GoalStatus

from bearing_calibration.msg import (CalibrationDriveAction, CalibrationDriveGoal,
                                     CalibrationEstimate)

NOT_READY = (CalibrationEstimate.WAITING_FOR_TICKS, CalibrationEstimate.WAITING_FOR_LIGHT)
ROW_PERIOD_S = 2.0
WAIT_STEP_S = 0.5
PATIENCE_S = 5.0  # the drive node reports four seconds apart at its slowest rate


def parse(arguments):
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('motion', nargs='?', default='',
                        help='optimal, dance or corner_light (default: as the node is configured)')
    parser.add_argument('--max-time', type=float, default=0.0, help='[s] (default: as configured)')
    parser.add_argument('--max-path', type=float, default=0.0, help='[m] (default: as configured)')
    parser.add_argument('--node', default='calibration_drive', help='name of the drive node')
    parser.add_argument('--estimate', default='calibration/estimate', help='topic')
    return parser.parse_args(arguments)


def say(text):
    """To whoever watches. When nobody can any more, all ends as on ctrl-C."""
    try:
        print(text, flush=True)
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # Python flushes it at the end
        rospy.signal_shutdown('nobody watches')


def waitForLight(topic):
    """Until the calibration has ticks and a light."""
    while not rospy.is_shutdown():
        try:
            estimate = rospy.wait_for_message(topic, CalibrationEstimate, timeout=PATIENCE_S)
        except rospy.ROSException:
            say('waiting for %s' % topic)
            continue
        if estimate.state not in NOT_READY:
            return
        say('waiting: %s: %s' % (estimate.state_text, estimate.advice))
        rospy.rostime.wallsleep(WAIT_STEP_S)


class Printer:
    """A row of the table every few seconds of the drive."""

    def __init__(self):
        self.next_row_s = 0.0
        self.heard_s = time.monotonic()

    def isSilent(self):
        return time.monotonic() > self.heard_s + PATIENCE_S

    def show(self, feedback):
        self.heard_s = time.monotonic()
        if feedback.time_s < self.next_row_s:
            return
        self.next_row_s = feedback.time_s + ROW_PERIOD_S
        say('%5.0f s %6.2f m  x +- %.1f mm  y +- %.1f mm  yaw +- %.2f deg  light at %.2f m  %s' % (
            feedback.time_s, feedback.path_m, 1e3 * feedback.x_stddev_m,
            1e3 * feedback.y_stddev_m, 57.29578 * feedback.yaw_stddev_rad,
            feedback.light_distance_m, feedback.state_text))


def takeBack(client):
    """Its own goal alone: another one may have replaced it."""
    if client.get_state() in (GoalStatus.PENDING, GoalStatus.ACTIVE):
        client.cancel_goal()


def main(arguments):
    options = parse(arguments)
    rospy.init_node('start_drive', anonymous=True)
    if signal.getsignal(signal.SIGHUP) == signal.SIG_DFL:  # not under nohup
        signal.signal(signal.SIGHUP, lambda *_: rospy.signal_shutdown('the terminal was closed'))
    waitForLight(options.estimate)
    client = actionlib.SimpleActionClient(options.node + '/drive', CalibrationDriveAction)
    rospy.on_shutdown(lambda: takeBack(client))
    # In real time, unlike the client's wait_for_server(SECONDS) and wait_for_result().
    is_there, has_ended = threading.Event(), threading.Event()
    threading.Thread(target=lambda: (client.wait_for_server(), is_there.set())).start()
    while not is_there.wait(PATIENCE_S):
        say('waiting for %s: live.launch starts it with drive:=true' % options.node)
    if rospy.is_shutdown():
        return 1
    printer = Printer()
    client.send_goal(CalibrationDriveGoal(motion=options.motion, max_time_s=options.max_time,
                                          max_path_m=options.max_path),
                     done_cb=lambda *_: has_ended.set(), feedback_cb=printer.show)
    while not rospy.is_shutdown() and not has_ended.wait(WAIT_STEP_S):
        if printer.isSilent():
            break
    silent = '%s is silent: it has ended, or cannot be reached' % options.node
    say(client.get_goal_status_text() or ('cancelled' if rospy.is_shutdown() else silent))
    return 0 if client.get_state() == GoalStatus.SUCCEEDED else 1


if __name__ == '__main__':
    sys.exit(main(rospy.myargv(sys.argv)[1:]))
