"""Every launch file starts, all its nodes stay, and it ends without a crash on ctrl-C."""

import glob
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
import unittest

import roslaunch.config
import roslaunch.xmlloader
import rosbag
import rosgraph
import rospy

from bearing_calibration.msg import WheelTicks

REPOSITORY = os.path.abspath(os.path.join(os.path.dirname(__file__), '..', '..'))
sys.path.insert(0, os.path.join(REPOSITORY, 'tools'))
import demo_monitor  # noqa: E402  (lies in tools)

START_DEADLINE_S = 120
STAY_S = 2  # a node that refuses its parameters is gone by then
STOP_DEADLINE_S = 60

CRASH = re.compile(r'terminate called|Aborted|Segmentation|Traceback|has died|exit code')


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


class RunningLaunch:
    """A launch file of this package with a master of its own."""

    def __init__(self, name, arguments, folder, more_environment=()):
        self.path = os.path.join(REPOSITORY, 'launch', name)
        self.arguments = arguments
        port = demo_monitor.freePort(demo_monitor.masterPorts())
        self.master_uri = 'http://localhost:%d' % port
        self.log_path = os.path.join(folder, name + '.log')
        environment = dict(os.environ, ROS_MASTER_URI=self.master_uri, ROS_LOG_DIR=folder,
                           **dict(more_environment))
        with open(self.log_path, 'w') as log:
            self.process = subprocess.Popen(
                ['roslaunch', '-p', str(port), self.path] + arguments,
                stdin=subprocess.DEVNULL, stdout=log, stderr=subprocess.STDOUT, env=environment,
                start_new_session=True)

    def expectedNodes(self):
        config = roslaunch.config.ROSLaunchConfig()
        roslaunch.xmlloader.XmlLoader().load(self.path, config, argv=self.arguments, verbose=False)
        return {node.namespace + node.name for node in config.nodes}

    def presentNodes(self):
        master = rosgraph.Master('/launch_files_run_test', master_uri=self.master_uri)
        try:
            return {node for kind in master.getSystemState() for _, nodes in kind for node in nodes}
        except (OSError, rosgraph.MasterException):
            return set()  # not up yet

    def topicsOf(self, node):
        """What a node has subscribed to."""
        subscribers = rosgraph.Master(
            '/launch_files_run_test', master_uri=self.master_uri).getSystemState()[1]
        return {topic for topic, nodes in subscribers if node in nodes}

    def missingNodes(self):
        return self.expectedNodes() - self.presentNodes()

    def waitForNodes(self):
        deadline = time.monotonic() + START_DEADLINE_S
        while self.missingNodes() and self.process.poll() is None:
            if time.monotonic() > deadline:
                break
            time.sleep(0.2)

    def stop(self):
        """Ctrl-C; its return code, or None when it had to be killed."""
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
        try:
            return self.process.wait(timeout=STOP_DEADLINE_S)
        except subprocess.TimeoutExpired:
            os.killpg(self.process.pid, signal.SIGKILL)
            self.process.wait()
            return None

    def output(self):
        with open(self.log_path) as log:
            return log.read()


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
        self.assertRuns('calibrate.launch')

    def testCalibrateStandalone(self):
        self.assertRuns('calibrate.launch', 'standalone:=true')

    def testTheDemoInRviz(self):
        screen = HiddenScreen(self.folder)
        self.addCleanup(screen.close)
        launch = RunningLaunch('demo.launch', ['rviz:=true'], self.folder, screen.environment)
        try:
            launch.waitForNodes()
            self.assertEqual(launch.missingNodes(), set(), launch.output())
            wanted = {'/calibration/markers', '/light_detection/annotated',
                      '/simulation/truth/marker', '/calibration_drive/way_ahead',
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

    def testAPictureOfRvizShowsTheCalibration(self):
        screen = HiddenScreen(self.folder)
        self.addCleanup(screen.close)
        done = subprocess.run(
            [sys.executable, os.path.join(REPOSITORY, 'tools', 'rviz_screenshots.py'), self.folder,
             '--here', 'rviz_room', '--rate', '2'], stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT, universal_newlines=True, timeout=400,
            env=dict(os.environ, ROS_LOG_DIR=self.folder, ROS_HOME=self.folder,
                     **screen.environment))
        self.assertEqual(done.returncode, 0, done.stdout)
        self.assertTrue(os.path.exists(os.path.join(self.folder, 'rviz_room.png')))

    def testDetect(self):
        self.assertRuns('detect.launch')

    def testDemo(self):
        self.assertRuns('demo.launch')

    def testDrive(self):
        self.assertRuns('drive.launch', 'start_manager:=true')

    def testReplay(self):
        bag_path = os.path.join(self.folder, 'ticks.bag')
        with rosbag.Bag(bag_path, 'w') as bag:
            for second in range(1, 60):  # longer than the test
                ticks = WheelTicks()
                ticks.header.stamp = rospy.Time(second)
                bag.write('wheel_ticks', ticks, ticks.header.stamp)
        self.assertRuns('replay.launch', 'bag:=' + bag_path)


if __name__ == '__main__':
    unittest.main()
