#!/usr/bin/env python3
"""Wrong parameters of the bearing adapter nodelet are refused, all at once."""

import sys

import rostest

from refused_parameters import RefusedParameters


class BearingAdapterParametersTest(RefusedParameters):

    NODELET = 'bearing_calibration/BearingAdapterNodelet'
    CONFIG = 'adapter.yaml'
    FAULTS = (
        (lambda c: c['frames'].update(sensor='camera_optical_frame'), 'frames/sensor must have z up'),
        (lambda c: c['bearings'].update(source='points'),
         "bearings/source must be one of (point, pose, poses, tf, scan), but is 'points'"),
        (lambda c: c['bearings'].update(azimuth_stddev=0.0), 'bearings/azimuth_stddev must lie in'),
        (lambda c: c['bearings'].update(light_id=-2), 'bearings/light_id must lie in'),
        (lambda c: c['bearings'].update(stddev=0.1), 'bearings/stddev is not known'),
        (lambda c: c['tf'].update(lights={'tag_1': 'one'}), 'tf/lights/tag_1 must be an integer'),
        (lambda c: c['scan'].update(min_jump=-0.1), 'scan/min_jump must lie in'),
        (lambda c: c['scan'].pop('min_width'), 'scan/min_width is missing'),
        (lambda c: c['scan'].update(max_width='wide'), 'scan/max_width must be a finite number'),
    )

    # Promise named: a parameter of the bearing adapter that its source lacks
    def test_what_only_a_source_needs_is_asked_for(self):
        for faults, sentence in (
                ([(lambda c: c['bearings'].update(source='tf'), '')], 'tf/lights must give a frame'),
                ([(lambda c: c['scan'].update(min_jump=0.0), '')],
                 'one of scan/min_intensity and scan/min_jump'),
                ([(lambda c: c['scan'].update(min_width=0.3), '')], 'scan/max_width must be greater')):
            with self.subTest(sentence=sentence):
                self.assertIn(sentence, self.said_standalone(self.NODELET, self.configuration(faults)))


if __name__ == '__main__':
    rostest.rosrun('bearing_calibration', 'bearing_adapter_parameters',
                   BearingAdapterParametersTest, sys.argv)
