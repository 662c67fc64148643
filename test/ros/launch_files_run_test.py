"""Every launch file starts, all its nodes stay, and it ends without a crash on ctrl-C."""

import glob
import os
import subprocess
import sys
import tempfile
import time
import unittest
import unittest.mock

import rosbag
import rospy

from bearing_calibration.msg import WheelTicks
from calibration_world import SIMULATED_ROBOT
from running_launch import CRASH, START_DEADLINE_S, STAY_S, STOP_DEADLINE_S, RunningLaunch

ROBOT = 'robot:=' + SIMULATED_ROBOT
REPOSITORY = os.path.abspath(os.path.join(os.path.dirname(__file__), '..', '..'))
sys.path.insert(0, os.path.join(REPOSITORY, 'tools', 'study'))
import rviz_screenshots  # noqa: E402  (not on the path)


class HiddenScreen:
    """A screen of its own that nobody sees, drawn by software; `environment` leads to it."""

    def __init__(self, folder):
        read, write = os.pipe()
        self.process = subprocess.Popen(
            ['Xvfb', '-displayfd', str(write), '-screen', '0', '1280x800x24', '+extension', 'GLX'],
            pass_fds=[write], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(write)
        with os.fdopen(read) as numbers:
            number = numbers.readline().strip()
        os.chmod(folder, 0o700)
        self.environment = {'DISPLAY': ':' + number, 'LIBGL_ALWAYS_SOFTWARE': '1',
                            'QT_X11_NO_MITSHM': '1', 'XDG_RUNTIME_DIR': folder}

    def close(self):
        self.process.terminate()
        self.process.wait(timeout=STOP_DEADLINE_S)


class LaunchFilesRun(unittest.TestCase):

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def assertRuns(self, name, *arguments):
        launch = RunningLaunch(name, list(arguments), self.folder)
        try:
            launch.waitForNodes()
            self.assertEqual(launch.missingNodes(), set(), launch.output())
            time.sleep(STAY_S)
            self.assertIsNone(launch.process.poll(), launch.output())
            self.assertEqual(launch.missingNodes(), set(), launch.output())
        finally:
            code = launch.stop()
        self.assertEqual(code, 0, launch.output())
        self.assertNotRegex(launch.output(), CRASH)

    def testCalibrate(self):
        self.assertRuns('calibrate.launch', ROBOT)

    def testWithoutARobotEachNodeSaysWhatItNeeds(self):
        launch = RunningLaunch('live.launch', ['drive:=true'], self.folder)
        try:
            for name in ('/calibration/wheels/separation', '/calibration_drive/wheels/separation',
                         '/light_detection/mirror/half_angle'):
                self.assertTrue(launch.waitFor(
                    lambda: 'parameter %s is required' % name in launch.output()), launch.output())
        finally:
            launch.stop()
        self.assertNotRegex(launch.output(), 'terminate called|Aborted|Segmentation')

    def testCalibrateStandalone(self):
        self.assertRuns('calibrate.launch', ROBOT, 'standalone:=true')

    def testTheDemoInRviz(self):
        screen = HiddenScreen(self.folder)
        self.addCleanup(screen.close)
        launch = RunningLaunch('demo.launch', ['rviz:=true'], self.folder, screen.environment)
        try:
            launch.waitForNodes()
            self.assertEqual(launch.missingNodes(), set(), launch.output())
            wanted = {'/calibration/markers', '/light_detection/annotated',
                      '/simulation/truth/marker', '/calibration_drive/plan',
                      '/calibration_drive/expected_base_from_camera'}
            deadline = time.monotonic() + START_DEADLINE_S
            while wanted - launch.topicsOf('/rviz') and time.monotonic() < deadline:
                time.sleep(0.2)
            self.assertEqual(wanted - launch.topicsOf('/rviz'), set())
            time.sleep(STAY_S)
            self.assertEqual(launch.missingNodes(), set(), launch.output())
        finally:
            launch.stop()
        logs = glob.glob(os.path.join(self.folder, '**', 'rviz-*.log'), recursive=True)
        self.assertTrue(logs)
        for path in logs:
            with open(path) as log:
                self.assertNotRegex(log.read(), r'ERROR|could not be loaded')

    def testWhereRvizEndsByItselfTheRobotDrivesOnceMore(self):
        with unittest.mock.patch.object(rviz_screenshots.demo_monitor, 'Demo') as demo, \
                unittest.mock.patch.object(rviz_screenshots, 'takePicture') as take:
            take.side_effect = [rviz_screenshots.RvizEnded('RViz has ended'), None]
            rviz_screenshots.driveAndTake(rviz_screenshots.SETS['room'], self.folder, 1.0)
            self.assertEqual((demo.call_count, demo.return_value.stop.call_count), (2, 2))
            take.side_effect = rviz_screenshots.RvizEnded('RViz has ended')
            with self.assertRaises(rviz_screenshots.RvizEnded):
                rviz_screenshots.driveAndTake(rviz_screenshots.SETS['room'], self.folder, 1.0)

    def testAPictureOfRvizShowsTheCalibration(self):
        screen = HiddenScreen(self.folder)
        self.addCleanup(screen.close)
        done = subprocess.run(
            [sys.executable, os.path.join(REPOSITORY, 'tools', 'study', 'rviz_screenshots.py'), self.folder,
             '--here', 'room', '--rate', '2'], stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT, universal_newlines=True, timeout=400,
            env=dict(os.environ, ROS_LOG_DIR=self.folder, ROS_HOME=self.folder,
                     **screen.environment))
        self.assertEqual(done.returncode, 0, done.stdout)
        self.assertTrue(os.path.exists(os.path.join(self.folder, 'rviz_room.png')))

    def testDetect(self):
        self.assertRuns('detect.launch', ROBOT)

    def testDemo(self):
        self.assertRuns('demo.launch')

    def testDrive(self):
        self.assertRuns('drive.launch', ROBOT)

    def testReplay(self):
        bag_path = os.path.join(self.folder, 'ticks.bag')
        with rosbag.Bag(bag_path, 'w') as bag:
            for second in range(1, 60):  # longer than the test
                ticks = WheelTicks()
                ticks.header.stamp = rospy.Time(second)
                bag.write('wheel_ticks', ticks, ticks.header.stamp)
        self.assertRuns('replay.launch', ROBOT, 'bag:=' + bag_path)


if __name__ == '__main__':
    unittest.main()
