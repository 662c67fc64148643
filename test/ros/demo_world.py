"""What the tests of demo.launch see of it: the robot's true pose, the estimate, and the truth."""

import math

import rospy
from bearing_calibration.msg import CalibrationEstimate
from geometry_msgs.msg import PoseStamped

from calibration_world import wait_until


def yaw_of(pose):
    return 2.0 * math.atan2(pose.orientation.z, pose.orientation.w)


class Demo:
    """The other end of demo.launch: (x, y, yaw) of the base as it goes, in the world."""

    def __init__(self):
        self.estimate, self.mount, self.way = None, None, []
        rospy.Subscriber('calibration/estimate', CalibrationEstimate, self.keep_estimate)
        rospy.Subscriber('simulation/truth/base', PoseStamped, self.keep_base)
        rospy.Subscriber('simulation/truth/base_from_camera', PoseStamped, self.keep_mount)
        wait_until(lambda: self.estimate and self.mount and self.way, 'the demo runs')

    def keep_estimate(self, message):
        self.estimate = message

    def keep_mount(self, message):
        self.mount = message.pose

    def keep_base(self, message):
        pose = message.pose
        self.way.append((pose.position.x, pose.position.y, yaw_of(pose)))

    def wait_until_it_stands(self):
        """Half a second of the robot's poses, 10 in a second, that are all the same."""
        wait_until(lambda: len(set(self.way[-5:])) == 1, 'the robot stands')

    def wait_for_state(self, state, deadline_s):
        """Says what the calibration said last when the state does not come."""
        try:
            wait_until(lambda: self.estimate.state == state, 'state %d' % state, deadline_s)
        except AssertionError as error:
            raise AssertionError('%s: %s: %s' % (error, self.estimate.state_text,
                                                 self.estimate.advice))

    def errors(self):
        """Of the estimate: across the floor [m] and of the yaw [rad]."""
        estimate = self.estimate
        return (math.hypot(estimate.x_m - self.mount.position.x,
                           estimate.y_m - self.mount.position.y),
                abs(math.remainder(estimate.yaw_rad - yaw_of(self.mount), 2.0 * math.pi)))
