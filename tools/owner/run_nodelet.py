#!/usr/bin/env python3
"""Runs `nodelet` with its own arguments, and says so while the manager to load into is not there.

    rosrun bearing_calibration run_nodelet load TYPE MANAGER --no-bond
    rosrun bearing_calibration run_nodelet standalone TYPE

The nodelet loader itself waits for its manager without a word, for ever.
"""

import os
import signal
import socket
import sys
import time
import urllib.parse

import rosgraph
import roslib.packages

POLL_S = 0.2
PATIENCE_S = 5.0  # a manager that is started at the same time is there by then, mostly
CONNECT_S = 1.0


def isAnswered(service):
    """Whether somebody listens there: one that was killed is still registered."""
    try:
        address = urllib.parse.urlparse(rosgraph.Master('/run_nodelet').lookupService(service))
        socket.create_connection((address.hostname, address.port), CONNECT_S).close()
        return True
    except (OSError, rosgraph.MasterException):
        return False


def waitForManager(manager):
    due = time.monotonic() + PATIENCE_S
    while not isAnswered(manager + '/load_nodelet'):
        if time.monotonic() > due:
            print('waiting for the nodelet manager %s, which is not running. Start what runs it, or '
                  'give start_manager:=true or standalone:=true' % manager, file=sys.stderr, flush=True)
            due += PATIENCE_S
        time.sleep(POLL_S)


def main():
    words = sys.argv[1:]
    if not words or words[0] in ('-h', '--help'):
        print(__doc__)
        return 0
    if words[0] == 'load' and len(words) > 2:
        signal.signal(signal.SIGINT, signal.SIG_DFL)  # the end while it waits is no error
        namespace = rosgraph.names.get_ros_namespace()
        waitForManager(rosgraph.names.ns_join(namespace, words[2]))
    program = roslib.packages.find_node('nodelet', 'nodelet')[0]
    os.execv(program, [program] + words)


if __name__ == '__main__':
    sys.exit(main())
