"""The demo from images to the transform: right with the detector, a failure without it."""

import os
import re
import signal
import subprocess
import sys
import tempfile
import time
import unittest

REPOSITORY = os.path.abspath(os.path.join(os.path.dirname(__file__), '..', '..'))
PROGRAM = os.path.join(REPOSITORY, 'tools', 'owner', 'demo_monitor.py')
sys.path.insert(0, os.path.join(REPOSITORY, 'tools', 'owner'))
import demo_monitor  # noqa: E402  (lies in tools)

DEMO_DEADLINE_S = 180  # what the demo promises
CRASH = re.compile(r'terminate called|Aborted|Segmentation|Traceback|has died|exit code -')


class Demo(unittest.TestCase):

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def start(self, *arguments):
        """The demo with a master of its own, where nobody else's nodes of the same names appear."""
        environment = dict(os.environ, ROS_LOG_DIR=self.folder, ROS_HOME=self.folder)
        port = demo_monitor.freePort(demo_monitor.masterPorts())
        return subprocess.Popen([sys.executable, PROGRAM, '--port', str(port)] + list(arguments),
                                stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                universal_newlines=True, env=environment)

    def finish(self, process, deadline_s):
        """Output and return code; the nodes' own output is in `self.nodes`."""
        try:
            output, _ = process.communicate(timeout=deadline_s)
        finally:
            if process.poll() is None:
                process.terminate()  # which stops its children
                process.communicate(timeout=DEMO_DEADLINE_S)
        with open(os.path.join(self.folder, 'demo.log')) as log:
            self.nodes = log.read()
        return output, process.returncode

    def testConvergesToTheTruthAndEndsByItself(self):
        output, code = self.finish(self.start(), DEMO_DEADLINE_S)
        print(output)
        self.assertEqual(code, 0, output + self.nodes)
        self.assertIn('right: converged', output)
        self.assertNotRegex(self.nodes, CRASH)
        for saved in ('bearing_calibration_demo/result.yaml', 'bearing_calibration_demo_optics'):
            self.assertTrue(os.path.exists(os.path.join(self.folder, saved)), saved)
        self.followNextSteps(output)

    def followNextSteps(self, output):
        """The commands that the demo ends with lead to the URDF and the report."""
        commands = re.findall(r'^  \./scripts/run (.*)$', output, re.MULTILINE)
        self.assertEqual(len(commands), 2, output)
        for command in commands:
            done = subprocess.run(command.split(), cwd=self.folder, stdout=subprocess.PIPE,
                                  stderr=subprocess.STDOUT, universal_newlines=True, timeout=600)
            self.assertEqual(done.returncode, 0, done.stdout)
        result = os.path.join(self.folder, 'demo_result')
        subprocess.run(['check_urdf', os.path.join(result, 'mount.urdf')], check=True,
                       stdout=subprocess.DEVNULL, timeout=600)
        self.assertGreater(os.path.getsize(os.path.join(result, 'report.html')), 100000)

    def testConvergesAmongClutterFromAColourCamera(self):
        scene = os.path.join(REPOSITORY, 'config', 'scene.yaml')
        output, code = self.finish(self.start('scene:=' + scene, 'rate:=3.0'), DEMO_DEADLINE_S)
        print(output)
        self.assertEqual(code, 0, output + self.nodes)
        self.assertIn('right: converged', output)
        self.assertNotRegex(self.nodes, CRASH)

    def testTheRobotDrivesItself(self):
        output, code = self.finish(self.start('drive:=optimal'), DEMO_DEADLINE_S)
        print(output)
        self.assertEqual(code, 0, output + self.nodes)
        self.assertIn('right: converged', output)
        self.assertNotRegex(self.nodes, CRASH)

    def testFailsWithoutTheDetector(self):
        output, code = self.finish(self.start('--no-detector', '--seconds', '30'), DEMO_DEADLINE_S)
        self.assertEqual(code, 1, output + self.nodes)
        self.assertIn('FAULT: there is no estimate', output, self.nodes)
        self.assertNotRegex(self.nodes, CRASH)

    def testCtrlCStopsEverything(self):
        process = self.start('--period', '0.5', 'drive:=manual')
        said = ''
        for line in process.stdout:
            said += line
            if re.match(r' *\d+ s  ', line):  # a row: the nodes run
                break
        self.assertIn('2. Drive 1 m straight on.', said)
        process.send_signal(signal.SIGINT)
        output, code = self.finish(process, DEMO_DEADLINE_S)
        self.assertEqual(code, 128 + signal.SIGINT, output + self.nodes)
        deadline = time.monotonic() + 60
        while self.processesOfThisDemo() and time.monotonic() < deadline:
            time.sleep(0.2)
        self.assertEqual(self.processesOfThisDemo(), [])

    def processesOfThisDemo(self):
        """Command lines of the processes that inherited this test's log folder."""
        mark = ('ROS_LOG_DIR=' + self.folder).encode()
        found = []
        for number in filter(str.isdigit, os.listdir('/proc')):
            try:
                with open('/proc/%s/environ' % number, 'rb') as environment:
                    is_ours = mark in environment.read().split(b'\0')
                with open('/proc/%s/cmdline' % number, 'rb') as command:
                    words = command.read().split(b'\0')
            except OSError:
                continue  # gone, or another user's
            if is_ours and words[0]:  # a zombie has no command line
                found.append(b' '.join(words).decode())
        return found


if __name__ == '__main__':
    unittest.main()
