"""A robot without errors but its sensor's noise, and the calibration node's other end.

The expected values of the tests come from here: exact arcs of a differential drive and the exact
bearing of a light (model.md), written a second time and independently of the package.
"""

import math
import os
import random
import subprocess
import threading
import time

import genpy.dynamic
import numpy
import rosbag
import roslib.packages
import rospy
from bearing_calibration.msg import CalibrationEstimate, LightBearing, LightBearings, WheelTicks
from geometry_msgs.msg import PoseWithCovarianceStamped, TransformStamped
from nav_msgs.msg import Odometry
from nodelet.srv import NodeletLoad, NodeletLoadRequest
from rosgraph_msgs.msg import Log
from sensor_msgs.msg import JointState
from std_srvs.srv import SetBool, Trigger

# What the package has to know of this robot, for robot:= and --config.
SIMULATED_ROBOT = os.path.abspath(os.path.join(os.path.dirname(__file__), '..', '..', 'config',
                                               'robots', 'simulated.yaml'))
NAN = float('nan')
DEADLINE_S = 60.0  # for anything that should happen at once, on a slow and busy machine
WHEEL_TYPES = {'wheel_ticks': WheelTicks, 'joint_states': JointState, 'odom': Odometry}  # by topic
PIECE_S = 10.0  # of a drive: half of what the calibration node's queues hold
CHI_SQUARE_LIMIT = 25.0  # with 3 degrees of freedom: by chance once in 65000


def wait_until(condition, what, deadline_s=DEADLINE_S):
    """Polls until condition() is true and returns its value; fails at the deadline."""
    end = time.monotonic() + deadline_s
    while time.monotonic() < end:
        value = condition()
        if value:
            return value
        time.sleep(0.02)
    raise AssertionError('not within %g s: %s' % (deadline_s, what))


def wrap(angle):
    return math.remainder(angle, 2.0 * math.pi)


class World:
    """Robot, light and sensor. Drives 1 m straight, spins by 450 degrees, and so on (the paper's
    second trajectory): two curvatures, so that everything is observable."""

    WHEEL_SEPARATION = 0.25
    WHEEL_RADIUS = 0.05
    TICKS_PER_REVOLUTION = 65536.0
    WHEEL_SPEED = 0.2
    TICK_RATE = 50
    TICKS_PER_BEARING = 5
    BEARING_RATE = TICK_RATE // TICKS_PER_BEARING
    STRAIGHT_S = 5.0
    SPIN_S = 2.5 * math.pi * WHEEL_SEPARATION / 2.0 / WHEEL_SPEED
    FOUND_S = 15.0  # of this drive tell where the sensor is

    def __init__(self, start_stamp_s, seed=1, bearing_stddev=math.radians(0.5)):
        self.sensor = (0.15, 0.08, math.radians(12.0))  # x, y, yaw in the base frame
        self.light = (0.0, 0.0)
        self.start = 2.0, 0.0, math.radians(90.0)
        self.x, self.y, self.heading = self.start
        self.left_m = self.right_m = 0.0
        self.start_stamp_s = start_stamp_s
        self.step = 0
        self.bearing_stddev = bearing_stddev
        self.random = random.Random(seed)

    def stamp(self):
        # integers, so that stamps repeat exactly from one run to the next
        return rospy.Time.from_sec(self.start_stamp_s) + rospy.Duration(
            nsecs=self.step * (10**9 // self.TICK_RATE))

    def advance(self):
        """One tick period on the exact arc."""
        time_in_cycle = (self.step / self.TICK_RATE) % (self.STRAIGHT_S + self.SPIN_S)
        way = self.WHEEL_SPEED / self.TICK_RATE
        left = way if time_in_cycle < self.STRAIGHT_S else -way
        turn = (way - left) / self.WHEEL_SEPARATION
        self.x += 0.5 * (left + way) * math.cos(self.heading)  # straight or on the spot: no arc
        self.y += 0.5 * (left + way) * math.sin(self.heading)
        self.heading += turn
        self.left_m += left
        self.right_m += way
        self.step += 1

    def ticks(self):
        per_metre = self.TICKS_PER_REVOLUTION / (2.0 * math.pi * self.WHEEL_RADIUS)
        message = WheelTicks(left=round(self.left_m * per_metre),
                             right=round(self.right_m * per_metre))
        message.header.stamp = self.stamp()
        return message

    def joint_state(self, left_joint='left_wheel_joint', right_joint='right_wheel_joint'):
        message = JointState(name=['arm', left_joint, right_joint])
        message.position = [0.5, self.left_m / self.WHEEL_RADIUS, self.right_m / self.WHEEL_RADIUS]
        message.header.stamp = self.stamp()
        return message

    def wrapping_joint_state(self):
        """Continuous joints, as a simulator has them: within +-pi."""
        message = self.joint_state()
        message.position = [wrap(position) for position in message.position]
        return message

    def odometry(self):
        """Of a driver that begins at zero; its twist is left out, as many do."""
        x, y, heading = self.start
        cosine, sine = math.cos(heading), math.sin(heading)
        east, north = self.x - x, self.y - y
        message = Odometry(child_frame_id='base_link')
        message.header.stamp = self.stamp()
        message.header.frame_id = 'odom'
        message.pose.pose.position.x = cosine * east + sine * north
        message.pose.pose.position.y = cosine * north - sine * east
        message.pose.pose.orientation.z = math.sin(0.5 * (self.heading - heading))
        message.pose.pose.orientation.w = math.cos(0.5 * (self.heading - heading))
        return message

    def azimuth(self):
        cosine, sine = math.cos(self.heading), math.sin(self.heading)
        sensor_x = self.x + cosine * self.sensor[0] - sine * self.sensor[1]
        sensor_y = self.y + sine * self.sensor[0] + cosine * self.sensor[1]
        direction = math.atan2(self.light[1] - sensor_y, self.light[0] - sensor_x)
        return wrap(direction - self.heading - self.sensor[2])

    def candidate(self, **changes):
        values = dict(azimuth=wrap(self.azimuth() + self.random.gauss(0.0, self.bearing_stddev)),
                      azimuth_variance=self.bearing_stddev**2, image_radius=NAN,
                      image_radius_variance=NAN, elevation=NAN, elevation_variance=NAN,
                      light_id=LightBearing.UNKNOWN_LIGHT, probability=1.0)
        values.update(changes)
        return LightBearing(**values)

    def bearings(self, *candidates):
        message = LightBearings(candidates=list(candidates) or [self.candidate()])
        message.header.stamp = self.stamp()
        message.header.frame_id = 'camera'
        return message


def recordBag(path, world, seconds=120.0, wheels=('/wheel_ticks', World.ticks), look=None, **options):
    """A bag of the world as it drives; `look(world)` gives the candidates of an image."""
    with rosbag.Bag(path, 'w', **options) as bag:
        for step in range(int(seconds * world.TICK_RATE)):
            stamp = world.stamp()
            bag.write(wheels[0], wheels[1](world), stamp)
            if step % world.TICKS_PER_BEARING == 0:
                candidates = look(world) if look else [world.candidate()]
                bag.write('/bearings', world.bearings(*candidates), stamp)
            world.advance()
    return path


def duckietownCount():
    """The class of a message as Duckietown's robots send it, one for each wheel."""
    name = 'duckietown_msgs/WheelEncoderStamped'
    definition = """
uint8 ENCODER_TYPE_ABSOLUTE=0
uint8 ENCODER_TYPE_INCREMENTAL=1
std_msgs/Header header
int32 data
uint16 resolution
uint8 type
================================================================================
MSG: std_msgs/Header
uint32 seq
time stamp
string frame_id
"""
    return genpy.dynamic.generate_dynamic(name, definition)[name]


class Manager:
    """A nodelet manager with the calibration in it, for tests that kill it."""

    def __init__(self):
        program = roslib.packages.find_node('nodelet', 'nodelet')[0]
        self.process = subprocess.Popen([program, 'manager', '__name:=manager'])
        try:
            wait_until(self.loads, 'the nodelet is loaded')
        except AssertionError:
            self.kill()
            raise

    def loads(self):
        load = rospy.ServiceProxy('manager/load_nodelet', NodeletLoad)
        try:
            return load(NodeletLoadRequest(name='/calibration',
                                           type='bearing_calibration/CalibrationNodelet')).success
        except (rospy.ServiceException, rospy.ROSException):
            return False

    def kill(self):
        self.process.kill()
        self.process.wait()


class Node:
    """The other end of the topics and services of one calibration node."""

    def __init__(self, name='calibration', wheels='wheel_ticks', bearings='bearings',
                 wheels_type=None):
        self.name = rospy.resolve_name(name)
        self.lock = threading.Lock()
        self.estimates, self.poses, self.transforms, self.logs = [], [], [], []
        rospy.Subscriber(name + '/estimate', CalibrationEstimate, self._into(self.estimates))
        rospy.Subscriber(name + '/base_from_camera', PoseWithCovarianceStamped,
                         self._into(self.poses))
        rospy.Subscriber(name + '/transform', TransformStamped, self._into(self.transforms))
        rospy.Subscriber('/rosout', Log, self._into(self.logs))  # no /rosout_agg in a rostest
        kind = wheels_type or WHEEL_TYPES[wheels.split('/')[-1]]
        self.wheels = rospy.Publisher(wheels, kind, queue_size=10000)
        self.bearings = rospy.Publisher(bearings, LightBearings, queue_size=10000)
        self.reset_service = rospy.ServiceProxy(name + '/reset', Trigger)
        self.pause_service = rospy.ServiceProxy(name + '/pause', SetBool)
        self.save_service = rospy.ServiceProxy(name + '/save', Trigger)
        wait_until(lambda: self.wheels.get_num_connections() and
                   self.bearings.get_num_connections() and self.estimates,
                   'the node subscribes and publishes')

    def _into(self, messages):
        def keep(message):
            with self.lock:
                messages.append(message)
        return keep

    def estimate(self):
        with self.lock:
            return self.estimates[-1]

    def forget(self):
        """Drops the estimates that have come."""
        with self.lock:
            del self.estimates[:]

    def wait_for(self, condition, what):
        """Waits for an estimate that fulfils the condition; says the last one when none comes."""
        try:
            wait_until(lambda: condition(self.estimate()), what)
        except AssertionError as error:
            raise AssertionError('%s\nlast estimate:\n%s' % (error, self.estimate()))
        return self.estimate()

    def reset(self):
        with self.lock:
            del self.logs[:]
        assert self.reset_service().success
        return self.wait_for(lambda e: e.ticks_used == e.bearings_used == 0 and
                             e.ticks_rejected == e.bearings_rejected == 0, 'reset')

    def warnings(self, *parts):
        """The warnings and errors of the log that contain all the parts."""
        with self.lock:
            return [log.msg for log in self.logs
                    if log.level >= Log.WARN and all(part in log.msg for part in parts)]

    def drive(self, world, seconds, wheels=World.ticks, with_wheels=True, with_bearings=True):
        """Publishes what the robot's sensors say, ten times faster than it happens."""
        for _ in range(round(seconds * World.TICK_RATE)):
            world.advance()
            if with_wheels:
                self.wheels.publish(wheels(world))
            if world.step % World.TICKS_PER_BEARING == 0:
                if with_bearings:
                    self.bearings.publish(world.bearings())
                time.sleep(0.1 * World.TICKS_PER_BEARING / World.TICK_RATE)
        return world

    def feed(self, world, seconds, wheels=World.ticks):
        """Drives, and waits until the node has taken every bearing in; in pieces that fit into its
        queues, however slow it is."""
        for piece in range(math.ceil(seconds / PIECE_S)):
            taken = taken_in(self.estimate())
            piece_s = min(PIECE_S, seconds - piece * PIECE_S)
            self.drive(world, piece_s, wheels=wheels)
            estimate = self.wait_for(
                lambda e: taken_in(e) >= taken + round(piece_s * World.BEARING_RATE),
                'all bearings of %g s are taken in' % piece_s)
        return estimate


def taken_in(estimate):
    """Its bearings, but for those that were refused."""
    return estimate.bearings_used + estimate.bearings_gated


def errors_in_stddevs(estimate, world):
    return [abs(estimate.x_m - world.sensor[0]) / estimate.x_stddev_m,
            abs(estimate.y_m - world.sensor[1]) / estimate.y_stddev_m,
            abs(wrap(estimate.yaw_rad - world.sensor[2])) / estimate.yaw_stddev_rad]


def chi_square_of(estimate, mount):
    """Of x, y and yaw."""
    error = numpy.array([estimate.x_m - mount[0], estimate.y_m - mount[1],
                         wrap(estimate.yaw_rad - mount[2])])
    return error @ numpy.linalg.solve(numpy.array(estimate.covariance_x_y_yaw).reshape(3, 3), error)


def assert_finds_the_mount(case, estimate, world, name):
    """Right by its own covariance, and a useful one. @param name  of what was tried, for the log"""
    case.assertIn(estimate.state, (CalibrationEstimate.CONVERGED, CalibrationEstimate.CONVERGING), estimate)
    chi_square = chi_square_of(estimate, world.sensor)
    print('%s: chi-square %.1f, x +- %.4f, y +- %.4f m, yaw +- %.4f rad' % (
        name, chi_square, estimate.x_stddev_m, estimate.y_stddev_m, estimate.yaw_stddev_rad))
    case.assertLess(chi_square, CHI_SQUARE_LIMIT, estimate)
    case.assertLess(max(estimate.x_stddev_m, estimate.y_stddev_m), 0.02)
    case.assertLess(estimate.yaw_stddev_rad, math.radians(1.0))
    case.assertEqual(estimate.bearings_rejected, 0, estimate.rejections)
