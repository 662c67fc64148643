"""The other end of a drive: passes the robot's messages on until told not to, and remembers what the
drive node says on cmd_vel."""

import math
import os
import random
import threading
import time
import xmlrpc.client

import actionlib
import rosgraph
import rospy
from actionlib_msgs.msg import GoalStatus
from bearing_calibration.msg import (CalibrationDriveAction, CalibrationDriveGoal,
                                     CalibrationEstimate, LightBearings, WheelTicks)
from bearing_calibration.srv import StartDrive
from geometry_msgs.msg import PoseStamped, Twist
from std_msgs.msg import Bool
from std_srvs.srv import Trigger

from calibration_world import wait_until, wrap

SILENCE_S = 1.0  # of cmd_vel, at least, while there is no drive
MOST_STOPPING_S = 1.0  # 0.2 s of braking, and what a busy machine adds on the way here
SPEED = 0.2  # [m/s] limits/wheel_speed
MOVING = 0.9  # of that speed
REPEAT_HZ = 10.0  # of enable and obstacle
SEPARATION = 0.25
TICK_RATE = 50.0  # [Hz] wheels/rate
TICKS_PER_METRE = 65536.0 / (2.0 * math.pi * 0.05)
BEARING_STDDEV = 0.01  # [rad] what the calibration is told, too


def wheels_of(twist):
    turn = 0.5 * SEPARATION * twist.angular.z
    return twist.linear.x - turn, twist.linear.x + turn


def is_zero(twist):
    return twist.linear.x == 0.0 and twist.angular.z == 0.0


def wait_until_active(client):
    """Until the client knows that its goal was taken up: one that it cancels before that it calls
    lost, without a result, when an older status comes."""
    wait_until(lambda: client.get_state() == GoalStatus.ACTIVE, 'the goal is active')


def pid_of(name):
    node = rosgraph.Master('/test').lookupNode(rospy.resolve_name(name))
    _, _, pid = xmlrpc.client.ServerProxy(node).getPid('/test')
    return pid


def is_running(pid):
    try:
        os.kill(pid, 0)
        return True
    except ProcessLookupError:
        return False


class Repeater:
    """A publisher of std_msgs/Bool that says the same again and again until told otherwise."""

    def __init__(self, topic):
        self.publisher = rospy.Publisher(topic, Bool, queue_size=1)
        self.value = None
        threading.Thread(target=self.repeat, daemon=True).start()

    def repeat(self):
        while not rospy.is_shutdown():
            if self.value is not None:
                self.publisher.publish(self.value)
            time.sleep(1.0 / REPEAT_HZ)

    def say(self, value):
        self.value = value
        self.publisher.publish(value)

    def fall_silent(self):
        self.value = None

    def get_num_connections(self):
        return self.publisher.get_num_connections()


class DrivableRobot:
    """Relays, the action client, and every command with the time of its receipt."""

    def __init__(self):
        self.lock = threading.Lock()
        self.commands = []  # (seconds, Twist)
        self.arrivals = []  # of the commands, in real seconds
        self.base = None
        self.cut = set()
        self.claims_convergence = False
        self.push_mps = 0.0  # what the wheels report beyond what they do
        self.pushed_m = 0.0
        self.ticks_ahead_s = 0.0  # of the clock, by their stamps
        self.view_width = 0.0  # [rad] of the sensor, about its x axis; 0: all around
        self.random = random.Random(1)
        self.relay('robot/wheel_ticks', 'wheel_ticks', WheelTicks, 'ticks')
        self.relay('simulation/truth/bearings', 'bearings', LightBearings, 'light')
        self.relay('calibration/estimate', 'passed_on/estimate', CalibrationEstimate, 'estimate')
        rospy.Subscriber('cmd_vel', Twist, self.keep_command, tcp_nodelay=True)
        rospy.Subscriber('simulation/truth/base', PoseStamped, self.keep_base)
        self.obstacle = Repeater('obstacle')
        self.enable = Repeater('calibration_drive/enable')
        self.start_service = rospy.ServiceProxy('calibration_drive/start', StartDrive)
        self.stop_service = rospy.ServiceProxy('calibration_drive/stop', Trigger)
        self.reset_service = rospy.ServiceProxy('calibration/reset', Trigger)
        self.reconnect()

    def reconnect(self):
        """Waits for the drive node, which may be a new one."""
        self.start_service.wait_for_service(20.0)
        self.client = self.new_client()
        wait_until(lambda: self.base is not None and self.obstacle.get_num_connections()
                   and self.enable.get_num_connections(), 'the robot is there')

    def new_client(self):
        """One client follows one goal."""
        client = actionlib.SimpleActionClient('calibration_drive/drive', CalibrationDriveAction)
        wait_until(lambda: client.wait_for_server(rospy.Duration(0.5)), 'the action server')
        return client

    def relay(self, source, target, kind, name):
        publisher = rospy.Publisher(target, kind, queue_size=1000)

        def pass_on(message):
            if name in self.cut:
                return
            if name == 'ticks':
                self.pushed_m += self.push_mps / TICK_RATE
                message.left += round(self.pushed_m * TICKS_PER_METRE)
                message.right += round(self.pushed_m * TICKS_PER_METRE)
                message.header.stamp += rospy.Duration(self.ticks_ahead_s)
            if name == 'estimate' and self.claims_convergence:
                message.state = CalibrationEstimate.CONVERGED
            if name == 'light':  # the truth is too good to be a sensor's
                for candidate in message.candidates:
                    candidate.azimuth += self.random.gauss(0.0, BEARING_STDDEV)
                message.view_width = self.view_width
                if self.view_width > 0.0:
                    message.candidates = [candidate for candidate in message.candidates
                                          if abs(wrap(candidate.azimuth)) < 0.5 * self.view_width]
            publisher.publish(message)
        rospy.Subscriber(source, kind, pass_on, tcp_nodelay=True)

    def keep_command(self, message):
        with self.lock:
            self.commands.append((rospy.get_time(), message))
            self.arrivals.append(time.monotonic())

    def keep_base(self, message):
        self.base = message.pose

    def forget(self):
        """Everything is as it should be again, and nothing has been said."""
        self.cut.clear()
        self.claims_convergence = False
        self.push_mps = 0.0
        self.ticks_ahead_s = 0.0
        self.view_width = 0.0
        self.reset_service()  # else a drive would end at once where the one before has converged
        self.obstacle.say(False)
        self.enable.say(True)
        rospy.sleep(0.3)
        with self.lock:
            del self.commands[:], self.arrivals[:]

    def said(self):
        with self.lock:
            return list(self.commands)

    def is_moving(self):
        said = self.said()
        return bool(said) and abs(wheels_of(said[-1][1])[1]) > MOVING * SPEED

    def drive(self, motion='dance'):
        """Sends a goal and waits until the robot is at its speed."""
        self.client.send_goal(CalibrationDriveGoal(motion=motion))
        wait_until(self.is_moving, 'the robot moves')
        wait_until_active(self.client)

    def is_standing(self):
        said = self.said()
        return bool(said) and is_zero(said[-1][1])

    def said_after_the_drive(self):
        """What comes on cmd_vel in SILENCE_S after a drive that has ended: nothing, as it should
        be. Its result and its last word to stand are on two connections: that word may be late."""
        wait_until(self.is_standing, 'the last command is to stand')
        count = len(self.said())
        time.sleep(SILENCE_S)
        later = [twist for _, twist in self.said()[count:]]
        return later[1:] if later and is_zero(later[0]) else later

    def place(self):
        return (self.base.position.x, self.base.position.y, self.base.orientation.z)
