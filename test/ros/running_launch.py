"""A launch file as a child process with a master that nobody else uses, and what can be seen of it."""

import os
import re
import signal
import subprocess
import sys
import time
import unittest.mock
import xmlrpc.client

import roslaunch.config
import roslaunch.xmlloader
import rosgraph
import rospy
from nodelet.srv import NodeletList

REPOSITORY = os.path.abspath(os.path.join(os.path.dirname(__file__), '..', '..'))
sys.path.insert(0, os.path.join(REPOSITORY, 'tools', 'owner'))
import demo_monitor  # noqa: E402  (lies in tools)

START_DEADLINE_S = 120
STAY_S = 2  # a node that refuses its parameters is gone by then
STOP_DEADLINE_S = 60

CRASH = re.compile(r'terminate called|Aborted|Segmentation|Traceback|has died|exit code')


class RunningLaunch:
    """A launch file, of this package where its name has no path; `beside` another one it shares its
    master."""

    def __init__(self, name, arguments, folder, more_environment=(), beside=None):
        self.path = os.path.join(REPOSITORY, 'launch', name)
        self.arguments = arguments
        self.port = beside.port if beside else demo_monitor.freePort(demo_monitor.masterPorts())
        self.master_uri = 'http://localhost:%d' % self.port
        self.log_path = os.path.join(folder, os.path.basename(name) + '.log')
        environment = dict(os.environ, ROS_MASTER_URI=self.master_uri, ROS_LOG_DIR=folder,
                           HOME=folder, ROS_HOME=folder,  # where results are saved: the owner's stay
                           **dict(more_environment))
        with open(self.log_path, 'w') as log:
            self.process = subprocess.Popen(
                ['roslaunch', '-p', str(self.port), self.path] + arguments,
                stdin=subprocess.DEVNULL, stdout=log, stderr=subprocess.STDOUT, env=environment,
                start_new_session=True)

    def master(self):
        return rosgraph.Master('/running_launch', master_uri=self.master_uri)

    def configuredNodes(self):
        config = roslaunch.config.ROSLaunchConfig()
        roslaunch.xmlloader.XmlLoader().load(self.path, config, argv=self.arguments, verbose=False)
        return config.nodes

    def expectedNodes(self):
        return {node.namespace + node.name for node in self.configuredNodes()}

    def presentNodes(self):
        try:
            return {node for kind in self.master().getSystemState() for _, nodes in kind
                    for node in nodes}
        except (OSError, rosgraph.MasterException):
            return set()  # not up yet

    def topicsOf(self, node):
        """What a node has subscribed to."""
        subscribers = self.master().getSystemState()[1]
        return {topic for topic, nodes in subscribers if node in nodes}

    def missingNodes(self):
        return self.expectedNodes() - self.presentNodes()

    def pidOf(self, node):
        """Of a node that answers; None for one that is still registered, but dead."""
        try:
            uri = self.master().lookupNode(node)
            return xmlrpc.client.ServerProxy(uri).getPid('/running_launch')[2]
        except (OSError, rosgraph.MasterException):
            return None

    def managers(self):
        return sorted(node.namespace + node.name for node in self.configuredNodes()
                      if node.args == 'manager')

    def nodeletsIn(self, manager):
        with unittest.mock.patch.dict(os.environ, ROS_MASTER_URI=self.master_uri):
            try:
                return set(rospy.ServiceProxy(manager + '/list', NodeletList)().nodelets)
            except (OSError, rospy.ServiceException, rosgraph.MasterException):
                return set()

    def faults(self):
        """What is not as the launch file wants it: each node alive, each nodelet in its manager."""
        found = ['no %s' % node for node in sorted(self.expectedNodes()) if not self.pidOf(node)]
        for node in self.configuredNodes():
            words = node.args.split()
            if words[:1] == ['load']:
                manager = node.namespace + words[2]
                if node.namespace + node.name not in self.nodeletsIn(manager):
                    found.append('%s%s is not in %s' % (node.namespace, node.name, manager))
        if self.process.poll() is not None:
            found.append('%s has ended' % os.path.basename(self.path))
        return found

    def waitFor(self, condition):
        """Whether it becomes true before the deadline and the launch's end."""
        deadline = time.monotonic() + START_DEADLINE_S
        while not condition():
            if time.monotonic() > deadline or self.process.poll() is not None:
                return False
            time.sleep(0.2)
        return True

    def waitForNodes(self):
        self.waitFor(lambda: not self.missingNodes())

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
