#!/usr/bin/env python3
"""What bad input gets: a message with the topic, the value and what was done; a count; and no other
effect. The node lives on."""

import math
import sys
import time

import rospy
import rostest
from bearing_calibration.msg import LightBearings
from diagnostic_msgs.msg import DiagnosticStatus

from bad_input import BadInput, later
from calibration_world import DEADLINE_S, NAN, taken_in, wait_until

MAX_WAITING = 100  # config/calibration.yaml


def wrapped(ticks):
    """The counters of a 16-bit encoder."""
    ticks.left %= 2**16
    ticks.right %= 2**16
    return ticks


class CalibrationBadInputTest(BadInput):

    WHEELS = 'wheel_ticks'

    @staticmethod
    def READING(world):
        return wrapped(world.ticks())

    def bearings(self, **changes):
        """The next image, of which one candidate is as `changes` say."""
        message = later(self.world.bearings(self.world.candidate(**changes)), 0.01)
        self.node.bearings.publish(message)

    # Promise refused: an azimuth that is not a number
    def test_azimuth_nan(self):
        self.bearings(azimuth=NAN)
        self.assert_refused('bearings azimuth not finite', '/bearings', 'nan rad', 'left out')

    # Promise refused: an infinite azimuth
    def test_azimuth_infinite(self):
        self.bearings(azimuth=math.inf)
        self.assert_refused('bearings azimuth not finite', '/bearings', 'rad', 'left out')

    # Promise refused: a variance of zero
    def test_variance_zero(self):
        self.bearings(azimuth_variance=0.0)
        self.assert_refused('bearings variance not positive', '/bearings', 'rad^2', 'left out')

    # Promise refused: a negative variance
    def test_variance_negative(self):
        self.bearings(azimuth_variance=-0.1)
        self.assert_refused('bearings variance not positive', '/bearings', 'rad^2', 'left out')

    # Promise refused: a variance that is not a number
    def test_variance_nan(self):
        self.bearings(azimuth_variance=NAN)
        self.assert_refused('bearings variance not positive', '/bearings', 'rad^2', 'left out')

    # Promise refused: a variance of more than a turn
    def test_variance_absurd(self):
        self.bearings(azimuth_variance=100.0)
        self.assert_refused('bearings variance too large', '/bearings', '100', 'left out')

    # Promise refused: an azimuth in degrees
    def test_azimuth_in_degrees(self):
        self.bearings(azimuth=-57.3)
        self.assert_refused('bearings azimuth beyond 2 pi (in degrees?)', '/bearings', '-57.3',
                            'is it in degrees? bearings are in radians')

    # Promise refused: a sensor that speaks in degrees, which the advice then says
    def test_a_sensor_in_degrees_is_named(self):
        for _ in range(3):
            self.world.advance()
            self.bearings(azimuth=math.degrees(self.world.azimuth()) + 360.0)
        estimate = self.node.wait_for(lambda e: 'in degrees? bearings are in radians' in e.advice,
                                      'the advice')
        self.assertIn('azimuth beyond 2 pi', estimate.rejections)

    # Promise unharmed: a variance that no sensor has; it is raised, and counted
    def test_variance_that_no_sensor_has(self):
        """Used with the least variance that is allowed, counted, and said."""
        images = 2  # more than one of a hundred, which would be a glitch
        for _ in range(images):
            self.world.advance()
            self.node.wheels.publish(wrapped(self.world.ticks()))
            self.node.bearings.publish(self.world.bearings(self.world.candidate(azimuth_variance=1e-12)))
        estimate = self.node.wait_for(lambda e: taken_in(e) == taken_in(self.before) + images, 'they are used')
        reason = 'variance raised to that of bearings/min_stddev'
        self.assertEqual(estimate.rejections, 'bearings %s: %d' % (reason, images))
        self.assertEqual(estimate.bearings_rejected, 0)
        self.assertIn('bearings/min_stddev', estimate.advice)
        wait_until(lambda: self.node.warnings('/bearings', '1e-12 rad^2', 'bearings/min_stddev'),
                   'a warning')
        wait_until(lambda: any(value.key == 'inputs refused' and reason in value.value
                               for status in self.statuses for value in status.values),
                   'the count in /diagnostics')

    # Promise refused: a probability of 1.5
    def test_probability_out_of_range(self):
        self.bearings(probability=1.5)
        self.assert_refused('bearings probability not in 0 to 1', '/bearings', '1.5', 'left out')

    # Promise refused: bearings without a stamp
    def test_bearing_stamp_zero(self):
        message = self.world.bearings()
        message.header.stamp = rospy.Time()
        self.node.bearings.publish(message)
        self.assert_refused('bearings stamp is zero', '/bearings', 'stamp is zero', 'left out')

    # Promise refused: bearings with a stamp in the future
    def test_bearing_stamp_in_the_future(self):
        message = self.world.bearings()
        message.header.stamp = rospy.Time.now() + rospy.Duration(5.0)
        self.node.bearings.publish(message)
        self.assert_refused('bearings stamp in the future', '/bearings', 'after the time of receipt')

    # Promise refused: bearings older than the last
    def test_bearing_stamp_before_the_last(self):
        self.node.bearings.publish(later(self.world.bearings(), -0.5))
        self.assert_refused('bearings stamp not after the last', '/bearings', '0.5', 'left out')

    # Promise refused: ticks without a stamp
    def test_tick_stamp_zero(self):
        message = wrapped(self.world.ticks())
        message.header.stamp = rospy.Time()
        self.node.wheels.publish(message)
        self.assert_refused('ticks stamp is zero', '/wheel_ticks', 'stamp is zero', 'left out')

    # Promise refused: ticks with a stamp in the future
    def test_tick_stamp_in_the_future(self):
        message = wrapped(self.world.ticks())
        message.header.stamp = rospy.Time.now() + rospy.Duration(5.0)
        self.node.wheels.publish(message)
        self.assert_refused('ticks stamp in the future', '/wheel_ticks', 'after the time of receipt')

    # Promise refused: the same ticks twice
    def test_tick_stamp_repeated(self):
        self.node.wheels.publish(wrapped(self.world.ticks()))
        self.assert_refused('ticks stamp not after the last', '/wheel_ticks', 'left out')

    # Promise refused: a count of more bits than the counter has
    def test_ticks_that_do_not_fit_the_counter(self):
        message = later(wrapped(self.world.ticks()), 0.01)
        message.left = 2**20
        self.node.wheels.publish(message)
        self.assert_refused('ticks count exceeds the counter', '/wheel_ticks', '1048576', 'left out')

    # Promise refused: ticks that jump
    def test_ticks_faster_than_the_wheels(self):
        message = later(self.world.ticks(), 0.01)
        message.left += 20000  # 20000 of 65536 ticks in 10 ms: 9.6 m/s, the wheels reach 2
        self.node.wheels.publish(wrapped(message))
        self.assert_refused('ticks wheel faster than possible', '/wheel_ticks', 'max_speed')

    # Promise refused: one bad candidate among good ones
    def test_one_bad_candidate_does_not_spoil_the_others(self):
        self.world.advance()
        self.node.wheels.publish(wrapped(self.world.ticks()))
        self.node.bearings.publish(self.world.bearings(self.world.candidate(azimuth=NAN),
                                                       self.world.candidate()))
        estimate = self.node.wait_for(lambda e: taken_in(e) == taken_in(self.before) + 1,
                                      'the good candidate is used')
        self.assertEqual(estimate.bearings_rejected, 1)

    # Promise unharmed: images without the light
    def test_an_image_without_light_is_no_fault(self):
        self.world.advance()
        self.node.wheels.publish(wrapped(self.world.ticks()))
        empty = LightBearings()
        empty.header.stamp = self.world.stamp()
        self.node.bearings.publish(empty)
        self.node.wait_for(lambda e: e.ticks_used == self.before.ticks_used + 1, 'one more reading')
        self.assert_lives_on()
        self.assertEqual(self.node.estimate().rejections, '')

    # Promise unharmed: bearings that stop coming; a warning names the topic
    def test_ticks_without_bearings_are_said(self):
        self.assert_silence_said('wheel readings without bearings', '/bearings',
                                 with_bearings=False)

    # Promise bounded: bearings without wheel readings
    def test_bearings_without_ticks_are_said_and_do_not_pile_up(self):
        self.assert_silence_said('bearings without wheel readings', '/wheel_ticks',
                                 with_wheels=False)
        for _ in range(2 * MAX_WAITING):
            self.world.step += 1
            self.node.bearings.publish(self.world.bearings())
            time.sleep(0.002)
        estimate = self.node.wait_for(lambda e: 'too many bearings wait' in e.rejections, 'dropped')
        self.assertLessEqual(estimate.bearings_waiting, MAX_WAITING)
        self.assertEqual(taken_in(estimate), taken_in(self.before))

    def assert_silence_said(self, sentence, topic, **drive):
        """One stream goes on for longer than diagnostics/input_timeout, the other does not."""
        end = time.monotonic() + DEADLINE_S
        del self.statuses[:]
        while not self.node.warnings(sentence, topic):
            self.assertLess(time.monotonic(), end, 'no warning: ' + sentence)
            self.node.drive(self.world, 0.1, wheels=self.READING, **drive)
            time.sleep(0.05)
        wait_until(lambda: [s for s in self.statuses if s.level == DiagnosticStatus.WARN and
                            sentence in s.message], 'a diagnostic warning: ' + sentence)

    # Promise unharmed: bearings of another frame; a warning names both
    def test_an_unknown_frame_is_said(self):
        message = later(self.world.bearings(), 0.01)
        message.header.frame_id = 'lidar'
        self.node.bearings.publish(message)
        wait_until(lambda: self.node.warnings('/bearings', "'lidar'", "'camera'"), 'a warning')

    # Promise bounded: a new wrong frame with each message, in the log
    def test_frames_without_end_are_not_said_one_by_one(self):
        period_s = 5.0  # of warnings of one kind
        began = time.monotonic()
        for i in range(50):
            message = later(self.world.bearings(), 0.001 * (i + 1))
            message.header.frame_id = 'frame_%d' % i
            self.node.bearings.publish(message)
        self.node.bearings.publish(later(self.world.bearings(), -0.5))  # is said after all of them
        wait_until(lambda: self.node.warnings('/bearings', 'left out'), 'all have come')
        said = self.node.warnings('/bearings', "'frame_")
        self.assertIn(len(said), range(1, 2 + int((time.monotonic() - began) / period_s)), said)


if __name__ == '__main__':
    rostest.rosrun('bearing_calibration', 'calibration_bad_input', CalibrationBadInputTest, sys.argv)
