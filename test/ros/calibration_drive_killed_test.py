#!/usr/bin/env python3
"""The end of the drive node: told to end, it stops the robot first. Killed, it can say nothing: the
robot's own watchdog stops the wheels, which is assumed of every robot, and the simulated one has it.
And the end of time: the robot stops when /clock does."""

import os
import signal
import subprocess
import sys
import time
import unittest

import rospy
import rostest
from bearing_calibration.msg import CalibrationDriveResult

from calibration_world import wait_until
from drivable_robot import DrivableRobot, is_running, is_zero, pid_of

WATCHDOG_S = 0.5  # trajectory/command_timeout of the simulation


class CalibrationDriveKilledTest(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        rospy.init_node('calibration_drive_killed_test')
        cls.robot = DrivableRobot()

    def setUp(self):
        self.robot.reconnect()
        self.robot.forget()

    def wait_for_watchdog(self):
        began = rospy.get_time()
        wait_until(lambda: rospy.get_time() > began + 2.0 * WATCHDOG_S, 'its own time goes on')

    def assertStands(self):
        before = self.robot.place()
        time.sleep(0.5)
        for now, then in zip(self.robot.place(), before):
            self.assertAlmostEqual(now, then, delta=1e-6)

    def assertEndedBySignalItStops(self, number):
        self.robot.drive()
        pid = pid_of('calibration_drive')
        os.kill(pid, number)
        wait_until(lambda: not is_running(pid), 'the process ends')
        wait_until(self.robot.is_standing, 'its last word is to stand')
        result = wait_until(self.robot.client.get_result, 'its result')
        self.assertEqual(result.end, CalibrationDriveResult.SHUT_DOWN, result)

    # Promise stands: Ctrl-C while it drives
    def test_interrupted_it_stops_the_robot(self):
        self.assertEndedBySignalItStops(signal.SIGINT)

    # Promise stands: SIGTERM while it drives, and a restart
    def test_terminated_it_stops_the_robot_and_started_again_it_does_not_move(self):
        self.assertEndedBySignalItStops(signal.SIGTERM)
        count = len(self.robot.said())
        self.robot.reconnect()
        time.sleep(1.0)
        self.assertEqual(self.robot.said()[count:], [])

    # Promise stands: a kill while it drives, with the watchdog that the base has
    def test_killed_the_robot_stops_by_itself(self):
        self.robot.drive()
        pid = pid_of('calibration_drive')
        os.kill(pid, signal.SIGKILL)
        wait_until(lambda: not is_running(pid), 'the process ends')
        self.assertFalse(is_zero(self.robot.said()[-1][1]))
        self.wait_for_watchdog()
        self.assertStands()

    def test_start_drive_says_that_the_node_is_silent(self):
        """Which tells nobody that it was killed, or has stopped as here; alone or with the clock."""
        for names in (('calibration_drive',), ('calibration_drive', 'simulation')):
            with self.subTest(stopped=names):
                self.robot.forget()
                with subprocess.Popen(['rosrun', 'bearing_calibration', 'start_drive', 'dance'],
                                      stdout=subprocess.PIPE, text=True) as program:
                    wait_until(self.robot.is_moving, 'the robot moves')
                    pids = [pid_of(name) for name in names]
                    for pid in pids:
                        os.kill(pid, signal.SIGSTOP)
                    try:
                        words, _ = program.communicate(timeout=30.0)
                    finally:
                        for pid in pids:
                            os.kill(pid, signal.SIGCONT)
                        program.kill()
                self.assertIn('calibration_drive is silent', words)
                wait_until(self.robot.is_standing, 'the last command is to stand')
                self.wait_for_watchdog()
                self.assertStands()

    def test_start_drive_says_that_it_waits_for_the_node_also_while_time_stands_still(self):
        self.robot.forget()
        pid = pid_of('simulation')
        with subprocess.Popen(['rosrun', 'bearing_calibration', 'start_drive', '--node', 'nobody'],
                              stdout=subprocess.PIPE, text=True) as program:
            self.addCleanup(program.kill)
            while 'waiting for nobody' not in program.stdout.readline():
                self.assertIsNone(program.poll())
            os.kill(pid, signal.SIGSTOP)
            try:
                time.sleep(7.0)  # it says so every 5 s
                program.send_signal(signal.SIGINT)
                words, _ = program.communicate(timeout=30.0)
            finally:
                os.kill(pid, signal.SIGCONT)
        self.assertIn('waiting for nobody', words)

    # Promise stands: a clock that stands still
    def test_it_stops_when_time_stands_still(self):
        self.robot.drive()
        pid = pid_of('simulation')
        os.kill(pid, signal.SIGSTOP)
        self.addCleanup(os.kill, pid, signal.SIGCONT)
        wait_until(self.robot.is_standing, 'the last command is to stand')
        wait_until(self.robot.client.get_result, 'the drive ends')
        result = self.robot.client.get_result()
        self.assertEqual(result.end, CalibrationDriveResult.CLOCK_LOST, result.end_text)

    # Promise stands: a stop while the clock stands still
    def test_it_is_stopped_while_time_stands_still(self):
        stops = {
            'cancel': (lambda: self.robot.client.cancel_goal(), CalibrationDriveResult.CANCELLED),
            'stop': (lambda: self.robot.stop_service(), CalibrationDriveResult.CANCELLED),
            'obstacle': (lambda: self.robot.obstacle.say(True), CalibrationDriveResult.OBSTACLE),
            'enable false': (lambda: self.robot.enable.say(False), CalibrationDriveResult.DISABLED)}
        pid = pid_of('simulation')
        for name, (act, end) in stops.items():
            with self.subTest(stop=name):
                self.robot.forget()
                self.robot.drive()
                os.kill(pid, signal.SIGSTOP)
                try:
                    act()
                    result = wait_until(self.robot.client.get_result, 'the drive ends')
                    wait_until(self.robot.is_standing, 'the last command is to stand')
                finally:
                    os.kill(pid, signal.SIGCONT)
                self.assertEqual(result.end, end, result.end_text)


if __name__ == '__main__':
    rostest.rosrun('bearing_calibration', 'calibration_drive_killed', CalibrationDriveKilledTest,
                   sys.argv)
