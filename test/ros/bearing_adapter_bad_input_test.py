#!/usr/bin/env python3
"""What bad input of the bearing adapter gets: a warning with its topic and what is wrong, a count in
/diagnostics, and no bearing; good input beside it and after it is used."""

import math
import sys
import unittest

import rospy
import rostest
from bearing_calibration.msg import LightBearings
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import Point, Pose, PoseArray, TransformStamped
from rosgraph_msgs.msg import Log
from sensor_msgs.msg import LaserScan
from tf2_msgs.msg import TFMessage

from calibration_world import NAN, wait_until

GOOD = (1.0, 1.0, 0.0)  # ahead on the left


class Adapter:
    """The other end of one adapter."""

    def __init__(self, namespace, kind):
        self.topic = '/%s/input' % namespace
        self.bearings, self.statuses = [], []
        rospy.Subscriber('/%s/bearings' % namespace, LightBearings, self.bearings.append)
        rospy.Subscriber('/diagnostics', DiagnosticArray, lambda message: self.statuses.extend(
            status for status in message.status if status.name.startswith(namespace + '/')))
        self.input = rospy.Publisher(self.topic, kind, queue_size=100)
        wait_until(self.input.get_num_connections, 'the adapter subscribes')

    def count(self, key):
        """The newest in /diagnostics, of any status after now."""
        del self.statuses[:]
        status = wait_until(lambda: self.statuses and self.statuses[-1], 'diagnostics')
        return int({value.key: value.value for value in status.values}.get(key, '0'))

    def answerTo(self, message):
        before = len(self.bearings)
        self.input.publish(message)
        wait_until(lambda: len(self.bearings) > before, 'an answer')
        return self.bearings[-1]


def poses(*points, **header):
    message = PoseArray(poses=[Pose(position=Point(*point)) for point in points])
    message.header.stamp = header.get('stamp', rospy.Time.now())
    message.header.frame_id = header.get('frame', 'mast')
    return message


def scan(**changes):
    """A bright post ahead of the 90th of 180 rays."""
    values = dict(angle_min=-1.5, angle_max=1.5, angle_increment=3.0 / 180, time_increment=1e-4,
                  range_min=0.1, range_max=10.0, ranges=[5.0] * 180, intensities=[0.0] * 180)
    for ray in (89, 90, 91):
        values['ranges'][ray], values['intensities'][ray] = 2.0, 200.0
    values.update(changes)
    message = LaserScan(**values)
    message.header.stamp = rospy.Time.now()
    message.header.frame_id = 'mast'
    return message


def tag(stamp):
    transform = TransformStamped(child_frame_id='tag_1')
    transform.header.frame_id, transform.header.stamp = 'mast', stamp
    transform.transform.translation.x = transform.transform.rotation.w = 1.0
    return TFMessage([transform])


class BearingAdapterBadInputTest(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        rospy.init_node('bearing_adapter_bad_input_test')
        cls.logs = []
        rospy.Subscriber('/rosout', Log, cls.logs.append)
        cls.poses, cls.scan = Adapter('poses', PoseArray), Adapter('scan', LaserScan)
        cls.tags = Adapter('tags', TFMessage)

    def assertRefused(self, adapter, message, kind, *said):
        """It is counted and said; the next good message is answered, and it is the first one that is."""
        before, answers = adapter.count('refused: ' + kind), len(adapter.bearings)
        adapter.input.publish(message)
        good = {self.poses: poses(GOOD), self.scan: scan(), self.tags: tag(rospy.Time.now())}[adapter]
        self.assertEqual(len(adapter.answerTo(good).candidates), 1)
        self.assertEqual(len(adapter.bearings), answers + 1, 'the bad one has no answer')
        self.assertEqual(adapter.count('refused: ' + kind), before + 1)
        wait_until(lambda: any(all(part in log.msg for part in (adapter.topic, kind) + said)
                               for log in self.logs if log.level >= Log.WARN), 'a warning: ' + kind)

    # Promise refused: points that are not finite, at the origin or on the sensor's axis
    def test_points(self):
        for point, kind in (((NAN, 0.0, 1.0), 'point not finite'),
                            ((1.0, math.inf, 1.0), 'point not finite'),
                            ((0.0, 0.0, 0.0), 'point at the origin'),
                            ((0.0, 0.0, 2.0), "point on the sensor's z axis")):
            with self.subTest(point=point):
                self.assertRefused(self.poses, poses(point), kind, 'is left out')

    # Promise refused: one bad point among good ones
    def test_one_bad_point_does_not_spoil_the_others(self):
        answer = self.poses.answerTo(poses((NAN, 0.0, 0.0), GOOD))
        self.assertEqual([round(each.azimuth, 9) for each in answer.candidates],
                         [round(math.pi / 4, 9)])

    def test_nothing_seen_is_no_fault(self):
        self.assertEqual(self.poses.answerTo(poses()).candidates, [])
        self.assertEqual(self.scan.answerTo(scan(ranges=[5.0] * 180)).candidates, [])

    # Promise refused: poses without a stamp, without a frame, or of a frame that no transform knows
    def test_headers(self):
        self.assertRefused(self.poses, poses(GOOD, stamp=rospy.Time()), 'stamp is zero', 'driver')
        self.assertRefused(self.poses, poses(GOOD, frame=''), 'frame_id is empty', 'driver')
        self.assertRefused(self.poses, poses(GOOD, frame='eye'), 'no static transform', "'eye'",
                           "'mast'", 'static_transform_publisher X Y Z YAW PITCH ROLL mast eye')

    # Promise refused: transforms of lights without a stamp
    def test_a_transform_without_a_stamp(self):
        for _ in range(2):
            self.assertRefused(self.tags, tag(rospy.Time()), 'stamp is zero', 'driver')

    def test_the_silence_of_frames_is_named(self):
        wait_until(lambda: any(status.level == DiagnosticStatus.WARN and
                               status.message == 'nothing comes on /tags/input for tag_1'
                               for status in self.tags.statuses), 'a warning of silence')

    # Promise refused: a sensor on a moving frame
    def test_a_transform_that_moves_is_none(self):
        """A pan unit between sensor and camera is no part of the mount."""
        moving = rospy.Publisher('/tf', TFMessage, queue_size=10)
        transform = TransformStamped(child_frame_id='pan')
        transform.header.frame_id, transform.header.stamp = 'mast', rospy.Time.now()
        transform.transform.rotation.w = 1.0
        moving.publish(TFMessage([transform]))
        self.assertRefused(self.poses, poses(GOOD, frame='pan'), 'no static transform')

    # Promise refused: scans without rays or intensities, or with impossible angles, times or ranges
    def test_scans(self):
        for changes, kind in (({'ranges': []}, 'scan without rays'),
                              ({'intensities': []}, 'scan without intensities'),
                              ({'angle_increment': 0.0}, "scan's angles are no part of a turn"),
                              ({'angle_increment': 1.0}, "scan's angles are no part of a turn"),
                              ({'angle_min': NAN}, "scan's angles are no part of a turn"),
                              ({'time_increment': NAN}, "scan's time_increment"),
                              ({'range_max': 0.0}, "scan's range_min and range_max")):
            with self.subTest(changes=str(changes)):
                self.assertRefused(self.scan, scan(**changes), kind)

    def test_the_status_warns_of_silence_and_of_refusals(self):
        self.poses.input.publish(poses(GOOD, frame='nose'))
        wait_until(lambda: any(status.level == DiagnosticStatus.WARN and
                               'refused: no static transform' in status.message
                               for status in self.poses.statuses), 'a warning of refusals')
        wait_until(lambda: any(status.level == DiagnosticStatus.WARN and
                               'nothing comes on ' + self.poses.topic in status.message
                               for status in self.poses.statuses), 'a warning of silence')

        def isGood():
            self.poses.answerTo(poses(GOOD))
            return self.poses.statuses[-1].level == DiagnosticStatus.OK
        wait_until(isGood, 'a good status')


if __name__ == '__main__':
    rostest.rosrun('bearing_calibration', 'bearing_adapter_bad_input', BearingAdapterBadInputTest,
                   sys.argv)
