"""The launch files as the documents show them, one beside the other: all that was started lives, a
manager that dies ends its launch, and README's command calibrates the simulated robot."""

import os
import re
import signal
import subprocess
import sys
import tempfile
import time
import unittest

import roslib.packages
import rosbag
import rospy
import yaml

from bearing_calibration.msg import WheelTicks
from calibration_world import SIMULATED_ROBOT
from running_launch import CRASH, START_DEADLINE_S, STAY_S, RunningLaunch

REPOSITORY = os.path.abspath(os.path.join(os.path.dirname(__file__), '..', '..'))
sys.path.insert(0, os.path.join(REPOSITORY, 'test', 'repository'))
import documents_test  # noqa: E402  (lies beside the tests of the repository)

README = 'live.launch robot:=$PWD/robot.yaml image:=/camera/image_raw'
DRIVE = 'drive.launch robot:=$PWD/robot.yaml'
CAMERA = 'detect.launch robot:=$PWD/robot.yaml image:=/camera/image_raw'
SENSOR = 'calibrate.launch robot:=$PWD/robot.yaml bearings:=bearings sensor_frame:=laser'
POSE, POSES, TAGS, SCAN = ('adapter.launch ' + arguments for arguments in (
    'source:=pose input:=/marker/pose', 'source:=poses input:=/markers',
    'source:=tf overrides:=$PWD/tags.yaml', 'source:=scan input:=/scan sensor_frame:=laser'))
MARKERS = 'calibrate.launch robot:=$PWD/robot.yaml'
ROBOTS = 'calibrate.launch robot:=$PWD/config/robots/'
TURTLEBOT, KOBUKI = ROBOTS + 'turtlebot3_burger.yaml', ROBOTS + 'kobuki.yaml'
DUCKIEBOT = (ROBOTS + 'duckiebot.yaml left_ticks:=/duckie/left_wheel_encoder_node/tick '
             'right_ticks:=/duckie/right_wheel_encoder_node/tick')
ONE_OF_SEVERAL = 'calibrate.launch robot:=$PWD/robot1.yaml result_folder:=$PWD/robot1'
ODOMETRY = 'calibrate.launch wheel_source:=odometry odom:=/odom wheel_separation:=0.16'

# What a reader may start one after the other and leave running.
COMBINATIONS = (
    (README, DRIVE),
    (README + ' drive:=true',),
    (CAMERA, TURTLEBOT),
    (KOBUKI, CAMERA, DRIVE),
    (DUCKIEBOT,),
    (ONE_OF_SEVERAL,),
    (ODOMETRY,),
    (SENSOR, DRIVE),
    (MARKERS, POSE),
    (POSES,),
    (TAGS,),
    (SENSOR, SCAN),
)
# Those with a clock of their own, alone, and what is started for it where that is something else:
# launch_files_run_test has the window.
ALONE = {
    'demo.launch scene:=$PWD/config/scene.yaml seed:=1': None,
    'demo.launch drive:=optimal rviz:=true': 'demo.launch drive:=optimal',
    'replay.launch bag:=FILE robot:=$PWD/robot.yaml': None,
    'replay.launch bag:=$PWD/landmark_1.bag overrides:=$PWD/litw.yaml detect:=false rate:=20': None,
}
# Of readme_robot.launch, which has the simulated robot's camera.
WHEELS = {'separation': 0.40, 'left_radius': 0.0975, 'right_radius': 0.0975,
          'ticks_per_revolution': 2048.0}

CONVERGE_DEADLINE_S = 400  # the simulated robot takes a minute and a half on a machine that is free
TRUTH_MM_DEG = {'x': 86.60254, 'y': 50.0, 'yaw': 60.0}  # config/simulation.yaml: mount
WANTED_MM_DEG = {'x': 10.0, 'y': 10.0, 'yaw': 0.5}  # config/calibration.yaml: converged
SIGMAS = 5.0


class Combinations(unittest.TestCase):

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        os.symlink(os.path.join(REPOSITORY, 'config'), os.path.join(self.folder, 'config'))
        with open(SIMULATED_ROBOT) as file:
            robot = dict(yaml.safe_load(file), wheels=WHEELS)
        for name in ('robot.yaml', 'robot1.yaml', 'litw.yaml'):
            with open(os.path.join(self.folder, name), 'w') as file:
                yaml.safe_dump(robot, file)
        with open(os.path.join(self.folder, 'tags.yaml'), 'w') as file:
            file.write('tf: {lights: {tag_1: 1, tag_2: 2}}\n')
        for name in ('FILE', 'landmark_1.bag'):
            with rosbag.Bag(os.path.join(self.folder, name), 'w') as bag:
                for second in range(1, 6000):  # longer than the test
                    ticks = WheelTicks()
                    ticks.header.stamp = rospy.Time(second)
                    bag.write('wheel_ticks', ticks, ticks.header.stamp)

    def start(self, command, beside=None):
        words = command.replace('$PWD', self.folder).replace(
            '=FILE', '=' + os.path.join(self.folder, 'FILE')).split()
        launch = RunningLaunch(words[0], words[1:], self.folder, beside=beside)
        self.addCleanup(launch.stop)
        return launch

    def startAll(self, commands):
        """Each when the one before lives."""
        launches = []
        for command in commands:
            launches.append(self.start(command, launches[0] if launches else None))
            launches[-1].waitFor(lambda: not launches[-1].faults())
        return launches

    def testEveryCommandOfTheDocumentsIsAmongThem(self):
        shown = set()
        for _, command in documents_test.allCommands():
            found = re.search(r'roslaunch bearing_calibration (\w+\.launch.*)', command)
            if found:
                shown.add(' '.join(found.group(1).split()))
        self.assertGreater(len(shown), 8)
        self.assertEqual(shown - set(ALONE) - {each for all_ in COMBINATIONS for each in all_}, set())

    def testAllThatWasStartedLives(self):
        for commands in COMBINATIONS + tuple((of or command,) for command, of in ALONE.items()):
            with self.subTest(commands=commands):
                launches = self.startAll(commands)
                time.sleep(STAY_S)
                said = '\n'.join(launch.output() for launch in launches)
                for launch in launches:
                    self.assertEqual(launch.faults(), [], said)
                for launch in reversed(launches):
                    self.assertEqual(launch.stop(), 0, said)
                    self.assertNotRegex(launch.output(), CRASH)

    def testAManagerThatDiesEndsItsLaunch(self):
        robot = ' robot:=$PWD/robot.yaml'
        for command in ('live.launch' + robot, 'calibrate.launch' + robot, 'detect.launch' + robot,
                        'demo.launch', 'replay.launch bag:=FILE' + robot):
            with self.subTest(command=command):
                launch = self.start(command)
                self.assertTrue(launch.waitFor(lambda: not launch.faults()), launch.output())
                manager, = launch.managers()
                os.kill(launch.pidOf(manager), signal.SIGKILL)
                try:
                    launch.process.wait(timeout=START_DEADLINE_S)
                except subprocess.TimeoutExpired:
                    self.fail('it goes on: ' + launch.output())
                self.assertIn('REQUIRED process [%s' % manager[1:], launch.output())

    def testAManagerThatIsMissingIsNamedUntilItIsThere(self):
        launch = self.start('detect.launch robot:=$PWD/robot.yaml start_manager:=false '
                            'manager:=camera_manager')
        self.assertTrue(launch.waitFor(lambda: 'the nodelet manager /camera_manager' in
                                       launch.output()), 'it says nothing')
        self.start('manager.launch manager:=camera_manager', launch)
        self.assertTrue(launch.waitFor(lambda: not launch.faults()), launch.output())

    def testReadmesCommandCalibratesTheSimulatedRobot(self):
        robot = os.path.join(REPOSITORY, 'test', 'ros', 'readme_robot.launch')
        launch, simulation = self.startAll((README, robot))
        self.assertEqual(simulation.faults(), [], simulation.output())
        watch = roslib.packages.find_node('bearing_calibration', 'watch')[0]
        deadline = time.monotonic() + CONVERGE_DEADLINE_S
        said = ''
        while not said.startswith('CONVERGED') and time.monotonic() < deadline:
            said = subprocess.run(
                [watch, '--once'], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                universal_newlines=True, timeout=START_DEADLINE_S,
                env=dict(os.environ, ROS_MASTER_URI=launch.master_uri)).stdout
        self.assertTrue(said.startswith('CONVERGED'), said + launch.output())
        for name, truth in TRUTH_MM_DEG.items():
            row = re.search(r'^ +%s +([-\d.]+) (?:mm|deg) +([\d.]+) ' % name, said, re.M)
            value, stddev = map(float, row.groups())
            self.assertLess(stddev, WANTED_MM_DEG[name], said)
            self.assertLess(abs(value - truth), SIGMAS * stddev, said)


if __name__ == '__main__':
    unittest.main()
