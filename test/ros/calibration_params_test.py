#!/usr/bin/env python3
"""Wrong parameters: all of them said at once, the node does not start, the manager lives on."""

import subprocess
import sys
import unittest

import rosnode
import rospy
import rostest
from rosgraph_msgs.msg import Log

from calibration_world import DEADLINE_S, Node, wait_until

CLASS = 'bearing_calibration/CalibrationNodelet'
# parts of one sentence for each fault in calibration_params.test
EXPECTED = [
    ('frames/base', 'without slash'),
    ('wheels/separation', 'must lie in [0.0001, 100]', '-0.25'),
    ('wheels/counter_bits', '17'),
    ('wheels/seperation', 'not known'),
    ('wheels/source', 'ticks, joint_states, separate_ticks', "'encoder'"),
    ('bearings/latency', 'finite number', "'late'"),
    ('bearings/reorder_window', 'is missing'),
    ('filter/gate_probability', '1.5'),
    ('session/restart_on_mount_change', 'true or false'),
    ('mount/z_stddev', 'must lie in'),
    ('mount/roll_stddev', 'must lie in'),
    ('output/publish_tf', 'true or false'),
    ('output/save_period', '0 (never) or at least 1 s', '0.5'),
    ('output/max_rate', 'must lie in'),
    ('clock/max_step_back', '0.1', '60', '0.05'),
    ('output/folder', '/proc/nope cannot be made: No such file or directory'),
]


def nodelet(*arguments):
    return subprocess.run(['rosrun', 'nodelet', 'nodelet'] + list(arguments),
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=DEADLINE_S)


class CalibrationParamsTest(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        rospy.init_node('calibration_params_test')
        rospy.delete_param('/wrong/bearings/reorder_window')  # roslaunch deletes before it loads
        cls.logs = []
        rospy.Subscriber('/rosout', Log, cls.logs.append)

    def assert_all_errors_at_once(self, text):
        self.assertIn('%d wrong parameter(s)' % len(EXPECTED), text)
        lines = text[text.index('wrong parameter(s)'):].splitlines()[1:]
        for parts in EXPECTED:
            self.assertTrue(any(all(part in line for part in parts) for line in lines),
                            '%s is not said in\n%s' % (parts, text))

    # Promise named: sixteen wrong parameters at once
    def test_standalone_ends_with_an_error(self):
        process = nodelet('standalone', CLASS, '__name:=wrong')
        self.assertNotEqual(process.returncode, 0)
        self.assert_all_errors_at_once(process.stdout.decode())

    # Promise alive: a nodelet with wrong parameters in a manager of others
    def test_manager_lives_on(self):
        wait_until(lambda: '/manager' in rosnode.get_node_names(), 'the manager runs')
        process = nodelet('load', CLASS, 'manager', '--no-bond', '__name:=wrong')
        self.assertNotEqual(process.returncode, 0)
        fatal = wait_until(lambda: [log.msg for log in self.logs
                                    if log.level == Log.FATAL and 'wrong parameter' in log.msg],
                           'a fatal message of the manager')
        self.assertEqual(len(fatal), 1, fatal)
        self.assert_all_errors_at_once(fatal[0])
        self.assertTrue(rosnode.rosnode_ping('/manager', max_count=1, verbose=False))
        self.assertFalse([topic for topic, _ in rospy.get_published_topics()
                          if topic.startswith('/wrong')], 'it is not half alive')

        loader = subprocess.Popen(['rosrun', 'nodelet', 'nodelet', 'load', CLASS, 'manager',
                                   '--no-bond', '__name:=good'])
        try:
            Node('good')  # waits for topics and a first estimate
        finally:
            loader.terminate()
            loader.wait(timeout=DEADLINE_S)


if __name__ == '__main__':
    rostest.rosrun('bearing_calibration', 'calibration_params', CalibrationParamsTest, sys.argv)
