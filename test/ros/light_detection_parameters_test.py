#!/usr/bin/env python3
"""Wrong parameters of the light detection nodelet are refused, all at once."""

import sys

import rospy
import rostest
from rosgraph_msgs.msg import Log

from calibration_world import wait_until
from refused_parameters import RefusedParameters


class LightDetectionParametersTest(RefusedParameters):

    NODELET = 'bearing_calibration/LightDetectionNodelet'
    CONFIG = 'detection.yaml'
    FAULTS = (
        (lambda c: c['mirror'].pop('half_angle'), 'mirror/half_angle is missing'),
        (lambda c: c['mirror'].update(handedness=0), 'mirror/handedness must be 1 or -1'),
        (lambda c: c['lens'].update(aperture='4e-3'), 'lens/aperture must be a finite number'),
        (lambda c: c['lens'].update(focus_distance=0.001),
         'lens/focus_distance must be greater than lens/focal_length'),
        (lambda c: c['sensor'].update(width=0), 'sensor/width must lie in'),
        (lambda c: c['mask'].update(posts=[[0.1]]), 'mask/posts must be a list of lists of 2'),
        (lambda c: c['mask'].update(inner_radius=300.0),
         'mask/inner_radius must be less than mask/outer_radius'),
        (lambda c: c['mask'].update(first_row=479, last_row=478), 'mask/first_row must not be greater than mask/last_row'),
        (lambda c: c['light'].update(min_radius=0.03), 'light/min_radius must not be greater than light/radius'),
        (lambda c: c['gates'].update(min_fil=0.9), 'min_fil is not known'),
        (lambda c: c['mirror'].update(kind='hyperbola'),
         "mirror/kind must be one of (cone, other, none), but is 'hyperbola'"),
        (lambda c: c['lens'].update(focus_stddev=0.9), 'lens/focus_stddev must lie in'),
        (lambda c: c['defocus'].update(sigma=-1.0), 'defocus/sigma must lie in'),
        (lambda c: c['prediction'].update(full_scan_every=0), 'prediction/full_scan_every must lie in'),
        (lambda c: c['time'].update(row_time=50.0), 'time/row_time must lie in'),
        (lambda c: c['frames'].update(sensor=''), 'frames/sensor must not be empty'),
        (lambda c: c['images'].update(queue=0), 'images/queue must lie in'),
        (lambda c: c['colour'].update(lights=[[1e300, 1, 0, 0], [1.5, 0, 1, 0], [2, 0, 0, 1]]),
         'colour/lights: a light_id must be a whole number'),
    )

    # Promise alive: an image_transport that is not installed, in a manager of others
    def test_an_unknown_image_transport_is_refused(self):
        logs = []
        rospy.Subscriber('/rosout', Log, logs.append)
        for transport in ('theora', 'Compressed'):
            config = dict(self.configuration(()), image_transport=transport)
            self.assertFalse(self.load(self.NODELET, '/' + transport, config))
            wait_until(lambda: [log for log in logs if log.level == Log.FATAL and
                                'image_transport must be' in log.msg and
                                "is '%s'" % transport in log.msg], transport + ' is named')
            self.assertNotIn('/' + transport, self.nodelets())  # and the manager answers
        self.assertIn("is 'theora'", self.said_standalone(
            self.NODELET, dict(self.configuration(()), image_transport='theora')))


if __name__ == '__main__':
    rostest.rosrun('bearing_calibration', 'light_detection_parameters',
                   LightDetectionParametersTest, sys.argv)
