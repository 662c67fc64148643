#!/usr/bin/env python3
"""Hours of operation, faster than they happen: every few minutes something happens to the robot.
No CONVERGED may be wrong; memory, CPU time, log and files must not grow.
BEARING_CALIBRATION_SOAK_HOURS says how long; without it every event happens once, but for a
displaced mount: how soon that is noticed at such a speed depends on what a fit takes.

In the table of hours, files are those of the result that holds: each result that a displacement makes wrong,
and each saving that is asked for, is kept beside it."""

import collections
import math
import os
import random
import shutil
import time
import unittest

import numpy
import rospy
import rostest
from bearing_calibration.msg import CalibrationEstimate
from rosgraph_msgs.msg import Clock

from calibration_world import CHI_SQUARE_LIMIT, Manager, Node, World, chi_square_of, wait_until

HOURS = float(os.environ.get('BEARING_CALIBRATION_SOAK_HOURS', '0'))
EVENT_S = 180.0 if HOURS else 90.0  # of the drive, from one event to the next
SPEED = 10.0  # times as fast as it happens
SPEED_OF_ONE_LIGHT = 25.0  # ... for hours: with N lights a fit takes N times as long
SENSORS_LATE = rospy.Duration(0.5)  # so that none is early, however late the clock is heard
DISPLACEMENT_NOTICED_S = 100.0  # 10 m of way (faults.md): until then no claim is judged
KILL_EVERY = 36  # events, so that memory has hours to grow in
FEWEST_HOURS = 8.0  # in which a growth would show
MOST_GROWTH = 1.2  # of the last quarter's median over the second quarter's
Usage = collections.namedtuple('Usage', 'memory_mb cpu_s log_kb files_kb')


class SoakWorld(World):
    """Several lights that the sensor tells apart, wheels that slip as much as is stated, and a mount
    that can be displaced."""

    WHEEL_VARIANCE_PER_M = 1.0e-6  # wheels/noise_independent

    def __init__(self, start_stamp_s):
        super().__init__(start_stamp_s)
        self.lights = {0: self.somewhere()}
        self.displaced_at = -math.inf  # step

    def somewhere(self):
        """2 to 4 m from the middle of the square that it drives."""
        angle, distance = self.random.uniform(-math.pi, math.pi), self.random.uniform(2.0, 4.0)
        return 1.5 + distance * math.cos(angle), 0.5 + distance * math.sin(angle)

    def advance(self):
        left, right = self.left_m, self.right_m
        super().advance()
        self.left_m += self.slip(self.left_m - left)
        self.right_m += self.slip(self.right_m - right)

    def slip(self, way):
        return self.random.gauss(0.0, math.sqrt(self.WHEEL_VARIANCE_PER_M * abs(way)))

    def bearings(self, *candidates):
        seen = []
        for light, self.light in self.lights.items():
            seen.append(self.candidate(light_id=light))
        return super().bearings(*seen)

    def displaceMount(self):
        """By up to 10 cm."""
        self.displaced_at = self.step
        away = self.random.uniform(-math.pi, math.pi)
        self.sensor = (0.15 + 0.05 * math.cos(away), 0.08 + 0.05 * math.sin(away),
                       self.sensor[2] + self.random.choice((-1.0, 1.0)) * math.radians(8.0))

    def isJustDisplaced(self):
        return self.step - self.displaced_at < DISPLACEMENT_NOTICED_S * self.TICK_RATE


class SoakTest(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        rospy.init_node('soak_test')
        cls.clock = rospy.Publisher('/clock', Clock, queue_size=100)
        cls.folder = rospy.get_param('/folder')
        cls.addClassCleanup(shutil.rmtree, cls.folder, ignore_errors=True)

    def setUp(self):
        self.random = random.Random(1)
        self.world = SoakWorld(1.0e6)
        self.node = None
        self.cpu_before_kills_s = 0.0
        self.log_bytes = self.claims = 0
        self.wrong = {}  # chi-squares of each hundredth of an hour
        lights = rospy.get_param('/calibration/session/max_lights')
        self.speed = SPEED_OF_ONE_LIGHT / lights if HOURS else SPEED
        self.start()

    def start(self):
        self.manager = Manager()
        self.addCleanup(self.manager.kill)
        if not self.node:
            self.node = Node()
        wait_until(lambda: self.node.wheels.get_num_connections() == 1 and
                   self.node.bearings.get_num_connections() == 1, 'it listens')

    def drive(self, seconds, seen=True, shares=1.0):
        """@param shares  of the ticks that arrive"""
        for _ in range(round(seconds * World.TICK_RATE)):
            self.world.advance()
            if self.random.random() < shares:
                self.node.wheels.publish(self.world.ticks())
            if self.world.step % World.TICKS_PER_BEARING == 0:
                self.clock.publish(Clock(self.world.stamp() + SENSORS_LATE))
                if seen:
                    self.node.bearings.publish(self.world.bearings())
                self.due += World.TICKS_PER_BEARING / World.TICK_RATE / self.speed
                time.sleep(max(0.0, self.due - time.monotonic()))
                self.due = max(self.due, time.monotonic() - 0.1)
                self.take()

    def take(self):
        """Judges what the node has said, and drops it."""
        with self.node.lock:
            estimates, logs = self.node.estimates[:-1], self.node.logs[:]
            del self.node.estimates[:-1], self.node.logs[:]
            del self.node.poses[:], self.node.transforms[:]
        self.log_bytes += sum(len(log.msg) for log in logs if log.name == '/manager')
        for estimate in estimates:
            if estimate.state == CalibrationEstimate.CONVERGED and not self.world.isJustDisplaced():
                self.claims += 1
                chi_square = chi_square_of(estimate, self.world.sensor)
                if not chi_square < CHI_SQUARE_LIMIT:
                    self.wrong.setdefault('%.2f h' % self.hours(), []).append(chi_square)

    def hours(self):
        return self.world.step / World.TICK_RATE / 3600.0

    # What happens. Each takes some of the time until the next.

    def nothing(self):
        pass

    def light_hidden(self):
        self.drive(60.0, seen=False)

    def light_moved(self):
        self.world.lights[self.random.choice(list(self.world.lights))] = self.world.somewhere()

    def light_added(self):
        if len(self.world.lights) == 4:
            self.world.lights = {0: self.world.lights[0]}
        self.world.lights[len(self.world.lights)] = self.world.somewhere()

    def ticks_lost(self):
        self.drive(30.0, shares=0.5)

    def ticks_silent(self):
        self.drive(2.0, shares=0.0)

    def clock_steps_back_a_little(self):
        self.world.start_stamp_s -= 0.5

    def clock_steps_forward(self):
        self.world.start_stamp_s += 30.0

    def clock_jumps_back(self):
        self.world.start_stamp_s -= 60.0

    def paused(self):
        self.assertTrue(self.node.pause_service(True).success)
        self.drive(30.0)
        self.assertTrue(self.node.pause_service(False).success)

    def mount_displaced(self):
        self.world.displaceMount()

    def saved(self):
        self.node.save_service()  # false where there is nothing to save

    def killed(self):
        self.cpu_before_kills_s += cpuSeconds(self.manager.process.pid)
        self.manager.kill()
        self.start()

    def events(self):
        """In random order, as long as it is to last."""
        kinds = [self.nothing, self.light_hidden, self.light_moved, self.light_added,
                 self.ticks_lost, self.ticks_silent, self.clock_steps_back_a_little,
                 self.clock_steps_forward, self.clock_jumps_back, self.paused, self.mount_displaced,
                 self.saved]
        if not HOURS:
            yield from [kind for kind in kinds if kind != self.mount_displaced] + [self.killed]
            return
        for i in range(1, int(HOURS * 3600.0 / EVENT_S) + 1):
            if i % KILL_EVERY == 0:
                yield self.killed
            else:
                if i % len(kinds) == 1:
                    self.random.shuffle(kinds)
                yield kinds[i % len(kinds)]

    def usage(self):
        pid = self.manager.process.pid
        with open('/proc/%d/statm' % pid) as file:
            pages = int(file.read().split()[1])
        paths = [os.path.join(self.folder, name) for name in os.listdir(self.folder)]
        files = sum(os.path.getsize(path) for path in paths if os.path.isfile(path))
        return Usage(pages * os.sysconf('SC_PAGESIZE') / 1e6,
                     self.cpu_before_kills_s + cpuSeconds(pid), self.log_bytes / 1e3, files / 1e3)

    # Promise bounded: hours of operation, with lights hidden, moved and added, ticks lost, clocks that step, pauses and kills
    def test_soak(self):
        times, ended, hourly = collections.Counter(), collections.Counter(), []
        self.due = time.monotonic()
        self.drive(EVENT_S)
        last = self.usage()
        print('%5s %11s %8s %8s %10s %8s' % ('hour', 'memory [MB]', 'CPU [s]', 'log [kB]', 'files [kB]',
                                             'claims'))
        for event in self.events():
            end = self.world.step + EVENT_S * World.TICK_RATE
            event()
            self.drive((end - self.world.step) / World.TICK_RATE)
            times[event.__name__] += 1
            estimate = self.node.estimate()
            if estimate.state == CalibrationEstimate.CONVERGED:
                ended[event.__name__] += 1
            else:
                print('%.2f h, after %s: %s %s: %s' % (
                    self.hours(), event.__name__, estimate.state_text, estimate.cause_text,
                    estimate.advice), flush=True)
            if self.hours() >= len(hourly) + 1:
                now = self.usage()
                hourly.append(now._replace(cpu_s=now.cpu_s - last.cpu_s, log_kb=now.log_kb - last.log_kb))
                last = now
                print('%5d %11.1f %8.1f %8.1f %10.1f %8d' % ((len(hourly),) + hourly[-1] + (self.claims,)),
                      flush=True)
        print('%-26s %5s %s' % ('event', 'times', 'CONVERGED %g s after it began' % EVENT_S))
        for name in times:
            print('%-26s %5d %5d' % (name, times[name], ended[name]))
        self.assertGreater(self.claims, 0)
        for when, chi_squares in self.wrong.items():
            print('%s: %d wrong, chi-square up to %.1f' % (when, len(chi_squares), max(chi_squares)))
        with self.subTest('claims'):
            self.assertFalse(self.wrong, 'wrong ones among %d' % self.claims)
        if HOURS >= FEWEST_HOURS:
            quarters = numpy.array_split(numpy.array(hourly), 4)
            growth = numpy.median(quarters[3], axis=0) / numpy.median(quarters[1], axis=0)
            with self.subTest('growth'):
                self.assertTrue((growth <= MOST_GROWTH).all(), Usage(*growth))


def cpuSeconds(pid):
    with open('/proc/%d/stat' % pid) as file:
        fields = file.read().rsplit(')', 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf('SC_CLK_TCK')


if __name__ == '__main__':
    rostest.rosrun('bearing_calibration', 'soak', SoakTest)
