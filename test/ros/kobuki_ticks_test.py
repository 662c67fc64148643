#!/usr/bin/env python3
"""The line of robots.md that makes wheel_ticks of a driver's own message, as it stands there."""

import os
import re
import shlex
import signal
import subprocess
import sys
import tempfile
import unittest

import rospy
import rostest
from bearing_calibration.msg import WheelTicks

from calibration_world import wait_until

REPOSITORY = os.path.abspath(os.path.join(os.path.dirname(__file__), '..', '..'))

# kobuki_msgs is not in Debian: a stand-in with those of its fields that are read.
STAND_IN = '''
import genpy.dynamic
NAME = 'kobuki_msgs/SensorState'
SensorState = genpy.dynamic.generate_dynamic(NAME, """std_msgs/Header header
uint16 left_encoder
uint16 right_encoder
================================================================================
MSG: std_msgs/Header
uint32 seq
time stamp
string frame_id
""")[NAME]
'''


def commandOfTheDocument():
    with open(os.path.join(REPOSITORY, 'doc', 'tutorials', 'robots.md')) as file:
        command = re.search(r'\./scripts/run (rosrun topic_tools transform(?:.*\\\n)*.*)', file.read())
    return shlex.split(command.group(1).replace('\\\n', ' '))


class KobukiTicksTest(unittest.TestCase):

    def test_the_documented_line_makes_wheel_ticks(self):
        rospy.init_node('kobuki_ticks_test')
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        package = os.path.join(folder.name, 'kobuki_msgs')
        os.makedirs(os.path.join(package, 'msg'))
        with open(os.path.join(package, '__init__.py'), 'w'):
            pass
        with open(os.path.join(package, 'msg', '__init__.py'), 'w') as file:
            file.write(STAND_IN)
        sys.path.insert(0, folder.name)
        from kobuki_msgs.msg import SensorState
        received = []
        rospy.Subscriber('/wheel_ticks', WheelTicks, received.append)
        publisher = rospy.Publisher('/mobile_base/sensors/core', SensorState, queue_size=1)
        environment = dict(os.environ, PYTHONPATH=folder.name + ':' + os.environ['PYTHONPATH'])
        process = subprocess.Popen(commandOfTheDocument(), env=environment)
        self.addCleanup(process.wait)
        self.addCleanup(process.send_signal, signal.SIGINT)
        sent = SensorState(left_encoder=65535, right_encoder=3)
        sent.header.stamp = rospy.Time(1000, 7)

        def sendUntilItComes():
            publisher.publish(sent)
            return received
        wait_until(sendUntilItComes, 'wheel_ticks')
        self.assertEqual((received[0].left, received[0].right), (65535, 3))
        self.assertEqual(received[0].header.stamp, sent.header.stamp)


if __name__ == '__main__':
    rostest.rosrun('bearing_calibration', 'kobuki_ticks', KobukiTicksTest, sys.argv)
