#!/usr/bin/env python3
"""The terminal view beside a running calibration: once, and in a terminal until ctrl-C."""

import os
import pty
import select
import signal
import subprocess
import sys
import time
import unittest

import rospy
import rostest

from calibration_world import DEADLINE_S, Node, World, wait_until

COMMAND = ['rosrun', 'bearing_calibration', 'watch']
LEAVE_SCREEN = b'\x1b[?1049l'  # what brings the terminal's own content back


class Terminal:
    """The program in a terminal of its own."""

    def __init__(self, kind='xterm', locale='C.UTF-8'):
        self.master, slave = pty.openpty()
        environment = dict(os.environ, TERM=kind, LINES='30', COLUMNS='100', LC_ALL=locale)
        self.process = subprocess.Popen(COMMAND, stdin=slave, stdout=slave, stderr=slave,
                                        env=environment)
        os.close(slave)
        self.output = b''

    def read(self):
        """Whether there was something."""
        if not select.select([self.master], [], [], 0.1)[0]:
            return False
        try:
            self.output += os.read(self.master, 65536)
            return True
        except OSError:  # the program has ended
            return False

    def waitFor(self, text):
        end = time.monotonic() + DEADLINE_S
        while text.encode() not in self.output and time.monotonic() < end:
            self.read()
        assert text.encode() in self.output, '%r is not in %r' % (text, self.output)

    def end(self, how):
        how()
        code = self.process.wait(timeout=DEADLINE_S)
        while self.read():
            pass
        os.close(self.master)
        return code


class WatchTest(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        rospy.init_node('terminal_watch_test')
        cls.node = Node()
        cls.node.feed(World(rospy.Time.now().to_sec() - 1000.0), 20.0)

    def test_once_prints_what_there_is_though_it_comes_late(self):
        done = subprocess.run(COMMAND + ['--once'], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                              universal_newlines=True, timeout=DEADLINE_S)
        self.assertEqual((done.returncode, done.stderr), (0, ''))
        # a fit that ends meanwhile changes the estimate: what is printed is one that was published
        wait_until(lambda: any(self.isPrinted(estimate, done.stdout) for estimate in
                               list(self.node.estimates)), done.stdout)
        self.assertIn('10.00 mm', done.stdout, 'converged/position_stddev')

    def isPrinted(self, estimate, text):
        return (text.startswith(estimate.state_text + ' of /calibration/estimate\n') and
                '%8.2f mm' % (1e3 * estimate.x_m) in text and
                '%10.2f mm' % (1e3 * estimate.x_stddev_m) in text and
                'driven %.2f m' % estimate.distance_travelled_m in text)

    def test_once_ends_quietly_when_nobody_reads_on(self):
        reader, writer = os.pipe()
        os.close(reader)
        done = subprocess.run(COMMAND + ['--once'], stdout=writer, stderr=subprocess.PIPE,
                              universal_newlines=True, timeout=DEADLINE_S)
        os.close(writer)
        self.assertEqual(done.stderr, '')

    def test_once_without_a_calibration_says_what_is_missing(self):
        done = subprocess.run(COMMAND + ['--once', '--estimate', 'nobody/estimate'],
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                              universal_newlines=True, timeout=DEADLINE_S)
        self.assertEqual(done.returncode, 1)
        self.assertIn('waiting for /nobody/estimate: does the calibration run?', done.stdout)

    def test_a_terminal_shows_it_until_ctrl_c_and_is_left_clean(self):
        terminal = Terminal()
        terminal.waitFor('/calibration/estimate')
        terminal.waitFor('driven')
        self.assertEqual(terminal.end(lambda: terminal.process.send_signal(signal.SIGINT)), 0)
        self.assertIn(LEAVE_SCREEN, terminal.output)
        self.assertNotIn(b'Traceback', terminal.output)

    def test_a_terminal_without_colours_and_a_locale_that_is_not_there_do(self):
        for kind, locale in (('vt100', 'C.UTF-8'), ('xterm', 'de_XX.UTF-8')):
            with self.subTest(kind=kind, locale=locale):
                terminal = Terminal(kind, locale)
                terminal.waitFor('q: quit')
                self.assertEqual(terminal.end(lambda: os.write(terminal.master, b'q')), 0)
                self.assertNotIn(b'Traceback', terminal.output)

    def test_q_ends_it(self):
        terminal = Terminal()
        terminal.waitFor('q: quit')
        self.assertEqual(terminal.end(lambda: os.write(terminal.master, b'q')), 0)
        self.assertIn(LEAVE_SCREEN, terminal.output)


if __name__ == '__main__':
    rostest.rosrun('bearing_calibration', 'terminal_watch', WatchTest, sys.argv)
