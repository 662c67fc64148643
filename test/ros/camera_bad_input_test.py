#!/usr/bin/env python3
"""A camera without a mirror whose camera_info or place is not known: each of its images gets a warning that
names what is missing, a count in /diagnostics, and no bearing; once it is known, images are used."""

import sys
import unittest

import dynamic_reconfigure.client
import numpy
import rospy
import rostest
from bearing_calibration.msg import LightBearings
from bearing_calibration.srv import FindMirror
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import TransformStamped
from rosgraph_msgs.msg import Log
from sensor_msgs.msg import CameraInfo, Image
from tf2_msgs.msg import TFMessage

from calibration_world import DEADLINE_S, NAN, wait_until
from camera_images import FRAME, camera_info, image_of

PLACE = 0.2, -0.1, 1.5  # of the light, in the optical frame


class CameraBadInputTest(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        rospy.init_node('camera_bad_input_test')
        cls.logs, cls.bearings, cls.statuses = [], [], []
        rospy.Subscriber('/rosout', Log, cls.logs.append)
        rospy.Subscriber('bearings', LightBearings, cls.bearings.append)
        rospy.Subscriber('/diagnostics', DiagnosticArray,
                         lambda message: cls.statuses.extend(message.status))
        cls.images = rospy.Publisher('camera/image_raw', Image, queue_size=100)
        cls.infos = rospy.Publisher('camera/camera_info', CameraInfo, queue_size=100)
        cls.static = rospy.Publisher('/tf_static', TFMessage, queue_size=100)
        wait_until(lambda: all(each.get_num_connections() for each in
                               (cls.images, cls.infos, cls.static)), 'the node subscribes')

    def image(self, frame=FRAME):
        message = image_of('perspective', PLACE, rospy.Time.now(), numpy.random.RandomState(1))
        message.header.frame_id = frame
        return message

    def assert_refused(self, kind, *said, frame=FRAME, **changes):
        """With that camera_info; it comes on a topic of its own, so the image is sent again."""
        count = len(self.bearings)

        def is_said():
            if changes:
                self.infos.publish(camera_info('perspective', rospy.Time.now(), **changes))
            self.images.publish(self.image(frame))
            return any(all(part in log.msg for part in ('/camera/image_raw', kind) + said)
                       for log in self.logs if log.level >= Log.WARN)
        wait_until(is_said, 'a warning: %s %s' % (kind, said))
        wait_until(lambda: any(value.key == 'images refused: ' + kind
                               for status in self.statuses for value in status.values
                               if status.level == DiagnosticStatus.WARN), kind + ' in /diagnostics')
        self.assertEqual(len(self.bearings), count, 'images without rays have no answer')

    def connect(self, x=0.0):
        transform = TransformStamped(child_frame_id=FRAME)
        transform.header.frame_id = 'mast'
        transform.transform.translation.x = x
        rotation = transform.transform.rotation
        rotation.x, rotation.y, rotation.z, rotation.w = -0.5, 0.5, -0.5, 0.5
        self.static.publish(TFMessage([transform]))

    def test_what_is_missing_is_named_until_nothing_is(self):
        self.assert_refused('no camera_info', '/camera/camera_info')
        self.assert_refused('wrong imager', '640x480', width=640, height=480)
        self.assert_refused('wrong imager', '0x0', width=0, height=0)
        self.assert_refused('uncalibrated camera', 'K[0]', K=[0.0] * 9)
        wait_until(lambda: any(value.key == 'camera_info' and 'K[0]' in value.value
                               for status in self.statuses for value in status.values), 'the doubt in /diagnostics')
        self.assert_refused('uncalibrated camera', 'D', D=[NAN] * 5)
        self.assert_refused('distortion_model', "'unknown'", distortion_model='unknown')
        self.assert_refused('distortion coefficients', 'no 2 D', D=[0.1, 0.2])
        self.assert_refused('no static transform', FRAME, 'mast', 'static_transform_publisher', height=240)
        self.assert_refused('frame_id is empty', 'driver', frame='')
        self.assert_refused('frame of the image', '-1.5708', frame='mast')
        self.connect(x=0.02)
        self.assert_refused('lens beside frames/sensor', '0.0200 m')
        self.connect()

        def is_answered():
            self.images.publish(self.image())
            return len(self.bearings) > 0
        wait_until(is_answered, 'a bearing')
        (candidate,) = self.bearings[-1].candidates
        self.assertAlmostEqual(candidate.azimuth, -numpy.arctan2(0.2, 1.5), delta=0.003)
        self.assertGreater(candidate.elevation, 0.0)

        count = len(self.bearings)
        thresholds = dynamic_reconfigure.client.Client('light_detection/thresholds', timeout=DEADLINE_S)
        thresholds.update_configuration({'min_contrast': 30.0})
        self.images.publish(self.image())
        wait_until(lambda: len(self.bearings) > count, 'a bearing with other thresholds')

        rospy.wait_for_service('light_detection/find_mirror', DEADLINE_S)
        answer = rospy.ServiceProxy('light_detection/find_mirror', FindMirror)()
        self.assertFalse(answer.found)
        self.assertIn('there is no mirror', answer.text)


if __name__ == '__main__':
    rostest.rosrun('bearing_calibration', 'camera_bad_input', CameraBadInputTest, sys.argv)
