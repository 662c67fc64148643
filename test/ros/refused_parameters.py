"""What every nodelet does with wrong parameters: it does not start, names all of them at once, and
its manager lives on. A test gives the nodelet, its configuration file and the faults."""

import os
import subprocess
import unittest

import rosgraph
import rospy
import yaml
from nodelet.srv import NodeletLoad, NodeletLoadRequest, NodeletList

from calibration_world import DEADLINE_S, SIMULATED_ROBOT

CONFIG_FOLDER = os.path.join(os.path.dirname(__file__), '..', '..', 'config')


class Nodelets(unittest.TestCase):
    """Loads nodelets with any parameters; needs a nodelet manager /manager."""

    @classmethod
    def setUpClass(cls):
        rospy.init_node('refused_parameters_test')
        rospy.wait_for_service('/manager/load_nodelet', DEADLINE_S)

    def load(self, nodelet, name, config):
        rospy.set_param(name, config)
        request = NodeletLoadRequest(name=name, type=nodelet)
        try:
            return rospy.ServiceProxy('/manager/load_nodelet', NodeletLoad)(request).success
        except rospy.ServiceException:
            return False  # how the manager answers when a nodelet does not load

    def nodelets(self):
        return rospy.ServiceProxy('/manager/list', NodeletList)().nodelets

    def said_standalone(self, nodelet, config):
        """By a process of its own, which ends."""
        if rospy.has_param('/broken'):
            rospy.delete_param('/broken')
        rospy.set_param('/broken', config)
        process = subprocess.run(
            ['rosrun', 'nodelet', 'nodelet', 'standalone', nodelet, '__name:=broken'],
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, universal_newlines=True,
            timeout=DEADLINE_S)
        self.assertGreater(process.returncode, 0, process.stdout)  # less: ended by a signal
        return process.stdout


class RefusedParameters(Nodelets):
    """Base of the tests of one nodelet."""

    NODELET = None  # package/Class
    CONFIG = None   # a file in config/
    FAULTS = ()     # (what is done to the configuration, a piece of the sentence that names it)

    @classmethod
    def setUpClass(cls):
        if cls.NODELET is None:
            raise unittest.SkipTest('the base class alone')
        super().setUpClass()

    def configuration(self, faults):
        """The node's file, with the simulated robot's numbers where it has none."""
        with open(os.path.join(CONFIG_FOLDER, self.CONFIG)) as stream:
            config = yaml.safe_load(stream)
        with open(SIMULATED_ROBOT) as stream:
            robot = yaml.safe_load(stream)
        for group, values in config.items():
            for name, value in values.items():
                if value == 'required':
                    values[name] = robot[group][name]
        for spoil, _ in faults:
            spoil(config)
        return config

    def test_standalone_ends_with_every_error(self):
        said = self.said_standalone(self.NODELET, self.configuration(self.FAULTS))
        for _, sentence in self.FAULTS:
            self.assertIn(sentence, said)
        self.assertEqual(said.count('not started: '), 1, said)

    def test_manager_lives_on(self):
        self.assertFalse(self.load(self.NODELET, '/wrong', self.configuration(self.FAULTS)))
        self.assertNotIn('/wrong', self.nodelets())
        published = rosgraph.Master(rospy.get_name()).getSystemState()[0]
        self.assertEqual([topic for topic, _ in published if topic.startswith('/wrong')], [])
        self.assertTrue(self.load(self.NODELET, '/right', self.configuration(())))
        self.assertIn('/right', self.nodelets())
