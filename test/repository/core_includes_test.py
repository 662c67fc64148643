"""The core stands without ROS, and include arrows between its rooms run one way.

On Debian ROS headers lie in the compiler's default path: that the core's libraries link no ROS
library does not show that they include none.
"""

import os
import re
import unittest

REPOSITORY = os.path.abspath(os.path.join(os.path.dirname(__file__), '..', '..'))
INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]', re.MULTILINE)

# Folders of headers in ROS packages' names: ros/ros.h, tf2/..., sensor_msgs/Image.h.
ROS_HEADER = re.compile(r'^(ros|rosbag|rosgraph|roscpp|rosconsole|xmlrpcpp|nodelet|pluginlib|tf2|'
                        r'cv_bridge|image_transport|diagnostic_updater|dynamic_reconfigure|'
                        r'bearing_calibration_ros)(_\w+)?/|^\w+_(msgs|srvs)/|^XmlRpc|'
                        # generated messages of this package: their names are CamelCase
                        r'^bearing_calibration/[A-Z]\w+\.h$')

FILTER = {'common', 'geometry', 'odometry', 'optics', 'filter'}
# What each room of the core may include besides itself.
ROOMS = {
    'common': set(),
    'geometry': {'common'},
    'odometry': {'common', 'geometry'},
    'optics': {'common', 'geometry'},
    'filter': {'common', 'geometry', 'odometry', 'optics'},
    'input': {'common', 'optics'},
    'record': FILTER,
    'solve': FILTER | {'record'},
    'noise': FILTER | {'record', 'solve'},
    'init': FILTER | {'record', 'solve', 'noise'},
    'track': FILTER | {'solve'},
    'judge': FILTER | {'record', 'solve', 'noise', 'init', 'track'},
    'output': FILTER | {'record', 'solve', 'noise', 'init', 'track', 'judge'},
    'calibration': FILTER | {'input', 'record', 'solve', 'noise', 'init', 'track', 'judge', 'output'},
    'planning': FILTER | {'judge'},
    'vision': {'common', 'geometry', 'optics'},
    'simulation': {'common', 'geometry', 'odometry'},
}
# A bare value that the simulator's Gaussian sensor may share: what a bearing is, not how it is made.
SHARED_VALUES = {'bearing_calibration/optics/bearing.h'}


def coreFiles():
    """(room, path) of each header and source of the core."""
    for top in (os.path.join('include', 'bearing_calibration'), 'src'):
        for folder, _, names in os.walk(os.path.join(REPOSITORY, top)):
            parts = os.path.relpath(folder, os.path.join(REPOSITORY, top)).split(os.sep)
            if parts[0] == 'ros':
                continue
            for name in sorted(names):
                if name.endswith(('.h', '.cpp')):
                    yield parts[0], os.path.join(folder, name)


def includesOf(path):
    with open(path) as file:
        return INCLUDE.findall(file.read())


class CoreIncludes(unittest.TestCase):

    def testTheCoreIsThere(self):
        rooms = {room for room, _ in coreFiles()}
        self.assertLessEqual({'common', 'geometry', 'odometry', 'filter'}, rooms)

    def testNoRosHeader(self):
        found = ['%s includes <%s>' % (os.path.relpath(path, REPOSITORY), header)
                 for _, path in coreFiles() for header in includesOf(path)
                 if ROS_HEADER.search(header)]
        self.assertEqual(found, [])

    def testThePatternKnowsRosHeaders(self):
        for header in ('ros/ros.h', 'sensor_msgs/Image.h', 'std_srvs/Trigger.h', 'tf2_ros/buffer.h',
                       'bearing_calibration/WheelTicks.h', 'tf2/utils.h', 'XmlRpcValue.h',
                       'bearing_calibration_ros/conversions.h'):
            self.assertTrue(ROS_HEADER.search(header), header)
        for header in ('cmath', 'Eigen/Core', 'opencv2/core.hpp', 'yaml-cpp/yaml.h',
                       'bearing_calibration/odometry/wheel_readings.h'):
            self.assertFalse(ROS_HEADER.search(header), header)

    def testArrowsRunOneWay(self):
        wrong = []
        for room, path in coreFiles():
            self.assertIn(room, ROOMS, '%s lies in no known room' % path)
            for header in includesOf(path):
                parts = header.split('/')
                if parts[0] != 'bearing_calibration' or header in SHARED_VALUES:
                    continue
                if parts[1] != room and parts[1] not in ROOMS[room]:
                    wrong.append('%s includes %s' % (os.path.relpath(path, REPOSITORY), header))
        self.assertEqual(wrong, [])


if __name__ == '__main__':
    unittest.main()
