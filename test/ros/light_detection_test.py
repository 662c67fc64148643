#!/usr/bin/env python3
"""The light detection nodelet: images in, bearings out; in a manager and alone."""

import math
import os
import shutil
import subprocess
import sys
import threading
import time
import unittest

import dynamic_reconfigure.client
import rospy
import rostest
import yaml
from bearing_calibration.msg import LightBearing, LightBearings, PredictedBearing
from bearing_calibration.srv import FindMirror
from diagnostic_msgs.msg import DiagnosticArray
from rosgraph_msgs.msg import Log
from sensor_msgs.msg import CameraInfo, CompressedImage, Image, RegionOfInterest
from std_msgs.msg import String

from calibration_world import DEADLINE_S, wait_until
from mirror_images import (APERTURE_M, CENTRE_U, CENTRE_V, HANDEDNESS, HEIGHT, IMAGE_PX, WIDTH, Spot,
                           camera_info, image_of, png_of, with_rim)

ROW_TIME_S, STAMP_TO_MID_EXPOSURE_S = 5e-5, -0.01  # light_detection.test
FULL_SCAN_EVERY = 10  # config/detection.yaml


class Detection:
    """The other end of one detection node."""

    def __init__(self, namespace, transport='', image_type=Image):
        self.namespace = '/' + namespace
        self.lock = threading.Lock()
        self.answers = []
        rospy.Subscriber(self.namespace + '/bearings', LightBearings, self.store)
        self.images = rospy.Publisher(self.namespace + '/camera/image_raw' + transport, image_type,
                                      queue_size=100)
        self.infos = rospy.Publisher(self.namespace + '/camera/camera_info', CameraInfo,
                                     queue_size=100)
        self.predictions = rospy.Publisher(self.namespace + '/calibration/predicted_bearing',
                                           PredictedBearing, queue_size=100)
        wait_until(lambda: self.images.get_num_connections() and
                   self.infos.get_num_connections() and self.predictions.get_num_connections(),
                   'the node subscribes')

    def store(self, message):
        with self.lock:
            self.answers.append(message)

    def answer_to(self, *images):
        """Of the last one; those before it are ignored, or their answers would come before."""
        with self.lock:
            self.answers = []
        for image in images:
            self.images.publish(image)
        answers = wait_until(lambda: self.answers[:], 'an answer to an image on ' + self.namespace)
        assert len(answers) == 1, 'one message for one image, but there are %d' % len(answers)
        assert answers[0].header.stamp == images[-1].header.stamp, 'an answer to another image'
        return answers[0]


class LightDetectionTest(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        rospy.init_node('light_detection_test')
        cls.logs, cls.statuses = [], []
        rospy.Subscriber('/rosout', Log, cls.logs.append)
        rospy.Subscriber('/diagnostics', DiagnosticArray,
                         lambda message: cls.statuses.extend(message.status))
        cls.managed, cls.rolling, cls.wide, cls.blinking, cls.late, cls.learning = map(
            Detection, ('managed', 'rolling', 'wide', 'blinking', 'late', 'learning'))
        cls.compressed = Detection('compressed', '/compressed', CompressedImage)

    def assert_seen(self, answer, spots):
        self.assertEqual(len(answer.candidates), len(spots), answer)
        candidates = sorted(answer.candidates, key=lambda candidate: candidate.azimuth)
        for candidate, spot in zip(candidates, sorted(spots, key=lambda spot: spot.azimuth)):
            self.assertLess(abs(math.remainder(candidate.azimuth - spot.azimuth, 2.0 * math.pi)),
                            5.0 * math.sqrt(candidate.azimuth_variance))
            self.assertLess(math.sqrt(candidate.azimuth_variance), math.radians(0.01))
            self.assertLess(abs(candidate.image_radius - spot.image_radius),
                            5.0 * math.sqrt(candidate.image_radius_variance))
            self.assertGreater(candidate.probability, 0.5)
            self.assertLess(candidate.elevation, 0.0, 'the light is below the apex')
            self.assertEqual(candidate.light_id, candidate.UNKNOWN_LIGHT)

    def test_every_encoding(self):
        spot = Spot(azimuth=0.7)
        for encoding in ('mono8', '8UC1', 'bgr8', 'rgb8', 'bgra8', 'rgba8', 'bayer_rggb8',
                         'bayer_bggr8', 'bayer_gbrg8', 'bayer_grbg8', 'yuv422', 'yuv422_yuy2'):
            image = image_of([spot], rospy.Time.now(), encoding)
            answer = self.managed.answer_to(image)
            self.assert_seen(answer, [spot])
            self.assertEqual(answer.header.stamp, image.header.stamp, encoding)
            self.assertEqual(answer.header.frame_id, 'camera')

    def test_sixteen_bits(self):
        spot = Spot(azimuth=-2.0)
        for encoding in ('mono16', 'bayer_rggb16', 'bayer_bggr16', 'bayer_gbrg16', 'bayer_grbg16'):
            self.assert_seen(self.wide.answer_to(image_of([spot], rospy.Time.now(), encoding)), [spot])

    def test_compressed_images(self):
        spot = Spot(azimuth=-2.0)
        broken = png_of(image_of([spot], rospy.Time.now()))
        broken.data = broken.data[:100]
        png = png_of(image_of([spot], rospy.Time.now()))
        self.assert_seen(self.compressed.answer_to(broken, png), [spot])
        self.assert_said('/compressed/camera/image_raw', 'not decoded', '100 bytes')

    def test_rows_with_padding(self):
        spot = Spot(azimuth=2.5)
        image = image_of([spot], rospy.Time.now(), padding=13)
        self.assert_seen(self.managed.answer_to(image), [spot])

    # Promise unharmed: an image without any light
    def test_an_image_without_light_is_answered(self):
        image = image_of([], rospy.Time.now())
        answer = self.managed.answer_to(image)
        self.assertEqual(answer.candidates, [])
        self.assertEqual(answer.header.stamp, image.header.stamp)

    def test_rolling_shutter_and_camera_info(self):
        spot = Spot(azimuth=1.3)
        image = image_of([spot], rospy.Time.now())

        def is_said(*pieces):
            self.rolling.images.publish(image)  # again: camera_info comes on a topic of its own
            return self.said('/rolling/camera/image_raw', *pieces)
        wait_until(lambda: is_said('no camera_info', '/rolling/camera/camera_info'),
                   'a warning that camera_info is required')
        self.rolling.infos.publish(camera_info(image.header.stamp, width=2 * WIDTH))
        wait_until(lambda: is_said('wrong imager', '1280x480'), 'a warning of another imager')
        self.assertEqual(self.rolling.answers, [], 'images without the right camera_info')

        self.rolling.infos.publish(camera_info(image.header.stamp, width=0, height=0))
        wait_until(lambda: is_said('empty camera_info', '0x0'), 'a warning that it says nothing')
        self.assertEqual(self.rolling.answers, [], 'images with an empty camera_info')

        self.rolling.infos.publish(camera_info(image.header.stamp, width=2 * WIDTH,
                                               height=2 * HEIGHT, binning_x=2, binning_y=2))

        def answered():
            self.rolling.images.publish(image)
            return self.rolling.answers
        answer = wait_until(answered, 'an answer with the right camera_info')[0]
        self.assert_seen(answer, [spot])
        self.assertEqual(answer.header.frame_id, 'omni')
        late_s = (answer.header.stamp - image.header.stamp).to_sec()
        tenth_of_a_row_s = 0.1 * ROW_TIME_S
        self.assertAlmostEqual(late_s, STAMP_TO_MID_EXPOSURE_S + spot.v * ROW_TIME_S,
                               delta=tenth_of_a_row_s)

    def last_value(self, detection, key):
        """Of a key in its diagnostics; None before the first."""
        values = [value.value for status in self.statuses
                  if status.name.startswith(detection.namespace[1:] + '/')
                  for value in status.values if value.key == key]
        return values[-1] if values else None

    def test_camera_info_that_is_not_required_refuses_nothing(self):
        spot = Spot(azimuth=1.3)
        region = RegionOfInterest(x_offset=9, width=2 * WIDTH, height=2 * HEIGHT)
        whole = dict(width=2 * WIDTH, height=2 * HEIGHT)
        binned = dict(whole, binning_x=2, binning_y=2)
        doubled = [2.0 * IMAGE_PX] + 8 * [0.0]
        for expected, fields in (
                ('0x0', dict(width=0, height=0)),  # a driver without a calibration
                ('fits', binned),
                ('lens/pixel_pitch', dict(K=doubled)),
                ('fits', dict(binned, K=doubled)),
                ('images of 1280x960', whole),
                ('fits', dict(binned, width=3000, height=2000, roi=region))):
            def is_taken():
                self.managed.infos.publish(camera_info(rospy.Time.now(), **fields))
                return expected in (self.last_value(self.managed, 'camera_info') or '')
            wait_until(is_taken, '"%s" in /diagnostics' % expected)
            self.assert_seen(self.managed.answer_to(image_of([spot], rospy.Time.now())), [spot])
        self.assert_said('/managed/camera/camera_info', 'images of 1280x960')
        self.assert_said('/managed/camera/camera_info', 'lens/pixel_pitch')

    # Promise bounded: images that come faster than they can be searched
    def test_a_late_machine_drops_the_oldest_images_and_counts_them(self):
        image = image_of([Spot(azimuth=0.7)], rospy.Time.now())
        start, sent, dropped, burst = image.header.stamp, 0, 0, 20

        def counted(key):
            return int(self.last_value(self.late, key) or 0)
        while dropped == 0:
            self.assertLess(sent, 10 * burst, 'none is dropped')
            for _ in range(burst):
                sent += 1
                image.header.stamp = start + rospy.Duration(0.01 * sent)
                self.late.images.publish(image)
            wait_until(lambda: self.late.answers and
                       counted('images used') == len(self.late.answers) and
                       self.late.answers[-1].header.stamp == image.header.stamp,
                       'an answer to the newest, counted with all others')
            dropped = counted('images dropped for newer ones')
        self.assertEqual(dropped + len(self.late.answers), sent)

    def test_a_slow_camera_is_no_silent_one(self):
        """One image in two seconds, and a status each second."""
        image = image_of([Spot(azimuth=0.7)], rospy.Time.now())
        period_s, known_after, images, statuses = 2.0, 2, 20, 6

        def said():
            return [each.message for each in self.statuses if each.name.startswith('blinking/')]
        for sent in range(images):
            if sent <= known_after:
                self.statuses.clear()
            if len(said()) >= statuses:
                break
            self.blinking.answer_to(image)
            time.sleep(period_s)
        self.assertGreaterEqual(len(said()), statuses)
        self.assertNotIn('no images', said())
        wait_until(lambda: 'no images' in said(), 'that it is silent now')

    def test_the_predicted_region_comes_first(self):
        spots = [Spot(azimuth=0.7), Spot(azimuth=-2.0)]
        image = image_of(spots, rospy.Time.now())
        prediction = PredictedBearing(azimuth=0.75, azimuth_variance=1e-4)
        prediction.header.stamp = image.header.stamp
        self.managed.predictions.publish(prediction)
        wait_until(lambda: len(self.managed.answer_to(image).candidates) == 1,
                   'the prediction is followed')
        answers = [self.managed.answer_to(image) for _ in range(FULL_SCAN_EVERY)]
        whole = [answer for answer in answers if len(answer.candidates) == 2]
        self.assertEqual(len(whole), 1, 'one image of %d is searched whole' % FULL_SCAN_EVERY)
        for answer in answers:
            self.assert_seen(answer, spots if len(answer.candidates) == 2 else spots[:1])
        # An old prediction is none.
        self.assert_seen(self.managed.answer_to(image_of(spots, rospy.Time.now() + rospy.Duration(9))),
                         spots)

    def test_the_optics_are_learnt_from_a_light_at_known_distances(self):
        aperture = 1.25 * APERTURE_M
        start, count = rospy.Time.now(), 0
        self.assertIn('configured: 0.0017', wait_until(
            lambda: self.last_value(self.learning, 'lens/aperture'), 'the aperture in /diagnostics'))

        def is_learnt():
            nonlocal count
            count += 1
            spot = Spot(azimuth=math.remainder(2.4 * count, 2.0 * math.pi),
                        distance=0.6 + 0.4 * (count % 4), aperture=aperture)
            stamp = start + rospy.Duration(count)
            prediction = PredictedBearing(azimuth=spot.azimuth, azimuth_variance=1e-4,
                                          distance=spot.distance, distance_variance=1e-4)
            prediction.header.stamp = stamp
            self.learning.predictions.publish(prediction)
            time.sleep(0.05)  # its topic is another one than that of the image
            self.learning.answer_to(image_of([spot], stamp))
            return 'learnt' in self.last_value(self.learning, 'lens/aperture')
        wait_until(is_learnt, 'that the aperture is learnt')
        self.assertIn('learnt', self.last_value(self.learning, 'mirror/half_angle'))

        folder = rospy.get_param('/learning/light_detection/optics/folder')
        self.addCleanup(shutil.rmtree, folder)

        def saved():
            if not os.path.exists(folder + '/learning.light_detection.yaml'):
                return None
            with open(folder + '/learning.light_detection.yaml') as file:
                return yaml.safe_load(file)
        optics = wait_until(saved, 'the file of optics')
        lens = optics['lens']
        self.assertLess(lens['aperture_stddev'], 0.125, 'half of what is configured')
        self.assertLess(abs(math.log(lens['aperture'] / aperture)), 3.0 * lens['aperture_stddev'])
        self.assertGreater(lens['aperture'], 1.1 * APERTURE_M)
        self.assertEqual(sorted(optics['mirror']), ['half_angle', 'half_angle_stddev'])

    def test_the_light_that_blinks_is_named_among_steady_ones(self):
        steady, blinking = Spot(azimuth=0.7), Spot(azimuth=-2.0)
        start = rospy.Time.now()
        both, one = image_of([steady, blinking], start), image_of([steady], start)
        for i in range(61):  # 5 Hz at 20 images a second: two on, two off
            image = both if i % 4 < 2 else one
            image.header.stamp = start + rospy.Duration(0.05 * i)
            answer = self.blinking.answer_to(image)
        named = {candidate.light_id: candidate for candidate in answer.candidates}
        self.assertEqual(sorted(named), [LightBearing.UNKNOWN_LIGHT, 7])
        self.assertAlmostEqual(named[7].azimuth, blinking.azimuth, delta=0.01)
        self.assertGreater(named[7].probability, 0.5)
        self.assertEqual(named[LightBearing.UNKNOWN_LIGHT].probability, 0.0)

    def test_the_annotated_image_shows_the_light(self):
        spot = Spot(azimuth=0.7)
        pictures = []
        subscriber = rospy.Subscriber('/managed/light_detection/annotated', Image, pictures.append)
        self.addCleanup(subscriber.unregister)
        wait_until(subscriber.get_num_connections, 'a connection to the annotated image')

        def asked():
            self.managed.answer_to(image_of([spot], rospy.Time.now()))
            return pictures
        picture = wait_until(asked, 'an annotated image')[0]
        self.assertEqual((picture.width, picture.height, picture.encoding), (WIDTH, HEIGHT, 'bgr8'))

        def is_green(u, v):
            blue, green, red = picture.data[3 * (v * WIDTH + u):][:3]
            return green > 150 and blue < 100 and red < 100
        outline = [is_green(round(spot.u) + du, round(spot.v) + dv)
                   for du in range(-12, 13) for dv in range(-12, 13)]
        self.assertGreater(sum(outline), 20, 'green pixels around the light')

    def find_mirror(self, image, apply=False):
        self.managed.answer_to(image)
        rospy.wait_for_service('/managed/light_detection/find_mirror', DEADLINE_S)
        return rospy.ServiceProxy('/managed/light_detection/find_mirror', FindMirror)(apply)

    def test_find_mirror_compares_the_rim_with_the_configuration(self):
        spot = Spot(azimuth=0.7)
        right = self.find_mirror(with_rim(image_of([spot], rospy.Time.now()), CENTRE_U, CENTRE_V))
        self.assertTrue(right.found and right.consistent, right)
        self.assertAlmostEqual(right.centre_u, CENTRE_U, delta=0.1)
        self.assertAlmostEqual(right.centre_v, CENTRE_V, delta=0.1)
        self.assertLess(right.centre_u_stddev, 0.1)

        moved = self.find_mirror(
            with_rim(image_of([spot], rospy.Time.now()), CENTRE_U + 4, CENTRE_V))
        self.assertTrue(moved.found)
        self.assertFalse(moved.consistent)
        self.assertAlmostEqual(moved.centre_u, CENTRE_U + 4, delta=0.1)
        self.assertIn("set them to the rim's centre", moved.text)

        none = self.find_mirror(image_of([spot], rospy.Time.now()), apply=True)
        self.assertFalse(none.found or none.consistent or none.applied)
        self.assertTrue(math.isnan(none.centre_u))
        self.assertIn('no rim', none.text)

    def test_a_centre_that_is_applied_counts_from_the_next_image_on(self):
        spot = Spot(azimuth=0.7)

        def azimuth():
            answer = self.managed.answer_to(image_of([spot], rospy.Time.now()))
            return answer.candidates[0].azimuth

        def rim_at(centre_u):
            return with_rim(image_of([spot], rospy.Time.now()), centre_u, CENTRE_V)
        right = self.find_mirror(rim_at(CENTRE_U))
        self.assertFalse(right.applied)
        self.assertAlmostEqual(azimuth(), spot.azimuth, delta=0.002)
        try:
            moved = self.find_mirror(rim_at(CENTRE_U + 4), apply=True)
            self.assertTrue(moved.applied, moved.text)
            about_moved = HANDEDNESS * math.atan2(CENTRE_V - spot.v, spot.u - moved.centre_u)
            self.assertGreater(abs(about_moved - spot.azimuth), 0.01)
            self.assertAlmostEqual(azimuth(), about_moved, delta=0.002)
            self.thresholds().update_configuration({'min_contrast': 31.0})
            self.assertAlmostEqual(azimuth(), about_moved, delta=0.002)  # thresholds leave it
        finally:
            back = self.find_mirror(rim_at(CENTRE_U), apply=True)
        self.assertTrue(back.applied, back.text)
        self.assertAlmostEqual(azimuth(), spot.azimuth, delta=0.002)

    def test_advice_on_exposure_stands_in_its_topic_and_in_diagnostics(self):
        said = []
        subscriber = rospy.Subscriber('/managed/light_detection/advice', String,
                                      lambda message: said.append(message.data))
        self.addCleanup(subscriber.unregister)
        bright = image_of([Spot(azimuth=0.7)], rospy.Time.now(), light=600)
        good = image_of([Spot(azimuth=0.7)], rospy.Time.now())

        def last_word_after(image):
            self.managed.answer_to(image)
            return said[-1] if said else ''
        wait_until(lambda: 'shorten the exposure' in last_word_after(bright), 'advice')
        wait_until(lambda: any(status.name.startswith('managed/') and
                               'shorten the exposure' in status.message
                               for status in self.statuses), 'the advice in /diagnostics')
        wait_until(lambda: last_word_after(good) == '', 'the advice is withdrawn')

    def thresholds(self):
        """A client of the thresholds that leaves them as they are now."""
        client = dynamic_reconfigure.client.Client('/managed/light_detection/thresholds',
                                                   timeout=DEADLINE_S)
        self.addCleanup(client.close)
        before = client.get_configuration(timeout=DEADLINE_S)
        self.addCleanup(client.update_configuration, {
            name: value for name, value in before.items() if name not in ('groups', 'refusal')})
        return client

    def test_thresholds_begin_as_configured(self):
        config = rospy.get_param('/managed/light_detection')
        expected = {name: value for group in ('threshold', 'gates')
                    for name, value in config[group].items()
                    if name not in ('mirror', 'max_candidates')}
        found = self.thresholds().get_configuration(timeout=DEADLINE_S)
        self.assertEqual({name: found[name] for name in expected}, expected)
        self.assertEqual(set(found) - set(expected), {'groups', 'refusal'})

    def test_thresholds_change_while_it_runs(self):
        spot = Spot(azimuth=0.7)
        thresholds = self.thresholds()
        self.assert_seen(self.managed.answer_to(image_of([spot], rospy.Time.now())), [spot])
        changed = thresholds.update_configuration({'min_contrast': 240.0})
        self.assertEqual((changed['min_contrast'], changed['refusal']), (240.0, ''))
        self.assertEqual(self.managed.answer_to(image_of([spot], rospy.Time.now())).candidates, [])
        subprocess.run(['rosrun', 'dynamic_reconfigure', 'dynparam', 'set',
                        '/managed/light_detection/thresholds', 'min_contrast', '12.0'],
                       check=True, timeout=DEADLINE_S)
        self.assert_seen(self.managed.answer_to(image_of([spot], rospy.Time.now())), [spot])

    # Promise named: impossible thresholds while it runs
    def test_impossible_thresholds_are_refused_and_those_before_stay(self):
        spot = Spot(azimuth=0.7)
        thresholds = self.thresholds()
        for wrong, sentence in (
                ({'min_pixels': 50, 'max_pixels': 40, 'spreads': 3.0},
                 'gates/min_pixels must not be greater than gates/max_pixels'),
                ({'min_probability': -0.1}, 'gates/min_probability must lie in'),
                ({'min_contrast': float('nan'), 'min_probability': 2.0},
                 'gates/min_probability must lie in')):
            before = thresholds.get_configuration(timeout=DEADLINE_S)
            answer = thresholds.update_configuration(wrong)
            self.assertIn(sentence, answer['refusal'])
            for name in wrong:
                self.assertEqual(answer[name], before[name], 'taken: %s' % name)
            self.assert_said('thresholds refused', sentence)
            self.assert_seen(self.managed.answer_to(image_of([spot], rospy.Time.now())), [spot])

    def test_clients_know_the_thresholds_bounds_beyond_which_they_are_refused(self):
        thresholds = self.thresholds()
        told = {each['name']: (each['min'], each['max'])
                for each in thresholds.get_parameter_descriptions(timeout=DEADLINE_S) if each['name'] != 'refusal'}
        self.assertEqual(set(told), set(thresholds.get_configuration()) - {'groups', 'refusal'})
        for name, (least, most) in told.items():
            for beyond in (least - 1, most + 1):
                refusal = thresholds.update_configuration({name: beyond})['refusal']
                self.assertIn('/%s must lie in [%.10g, %.10g], but is %.10g' % (name, least, most, beyond), refusal)

    def said(self, *pieces):
        return [log for log in self.logs if log.level == Log.WARN and
                all(piece in log.msg for piece in pieces)]

    def assert_said(self, *pieces):
        wait_until(lambda: self.said(*pieces), 'a warning with %s' % (pieces,))

    def assert_counted(self, kind):
        wait_until(lambda: any(status.name.startswith('managed/') and value.key.endswith(kind) and
                               int(value.value) >= 1
                               for status in self.statuses for value in status.values),
                   'a count of "%s" in /diagnostics' % kind)

    # Promise refused: images that are empty, cut short, of another size or encoding, or without a stamp
    def test_bad_images_are_named_counted_and_ignored(self):
        spot = Spot(azimuth=-0.4)
        rows = (
            ('empty', 'it is 640x480 with 0 bytes', dict(data=b'')),
            ('empty', 'it is 0x0', dict(width=0, height=0, step=0, data=b'')),
            ('truncated', '307199 bytes instead of step * height = 307200',
             dict(data=bytes(WIDTH * HEIGHT - 1))),
            ('short rows', 'step 639 is less than the 640 bytes',
             dict(step=WIDTH - 1, data=bytes((WIDTH - 1) * HEIGHT))),
            ('unsupported encoding', "encoding '32FC1' is not one of (mono8", dict(encoding='32FC1')),
            ('wrong size', 'it is 1x1', dict(width=1, height=1, step=1, data=b'\xff')),
            ('wrong size', 'it is 16384x1',
             dict(width=16384, height=1, step=16384, data=bytes(16384))),
            ('zero stamp', 'stamp is zero', {}),
        )
        said = set()
        for kind, text, changes in rows:
            stamp = rospy.Time() if kind == 'zero stamp' else rospy.Time.now()
            image = image_of([spot], stamp)
            for field, value in changes.items():
                setattr(image, field, value)
            good = image_of([spot], rospy.Time.now())
            self.assert_seen(self.managed.answer_to(image, good), [spot])
            self.assert_counted(kind)
            if kind not in said:  # the same kind is said again only after some seconds
                self.assert_said('/managed/camera/image_raw', 'image ignored', kind, text)
            said.add(kind)


if __name__ == '__main__':
    rostest.rosrun('bearing_calibration', 'light_detection', LightDetectionTest, sys.argv)
