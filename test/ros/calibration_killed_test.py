#!/usr/bin/env python3
"""kill -9 of the nodelet manager while it saves: result.yaml is always whole, the files beside it
are its own, and the next save leaves nothing behind. BEARING_CALIBRATION_KILLS says how often."""

import os
import random
import shutil
import threading
import time
import unittest

import rospy
import rostest
import yaml
from bearing_calibration.msg import CalibrationEstimate

from calibration_world import Manager, Node, World, wait_until

KILLS = int(os.environ.get('BEARING_CALIBRATION_KILLS', '5'))
MOST_KILLS = 20 * KILLS  # until one falls into a save, which a busy machine makes rarer
START_DEADLINE_S = 60.0
LONGEST_DELAY_S = 0.02  # from the first trace of a save to the kill: about as long as one takes
TRUSTED = (CalibrationEstimate.CONVERGING, CalibrationEstimate.CONVERGED)
FILES = {'result.yaml', '.bearing_calibration', 'mount.urdf', 'mount.urdf.xacro',
         'static_transform.launch', 'kalibr_camchain.yaml', 'vins_extrinsics.yaml',
         'diff_drive_controller.yaml'}


class CalibrationKilledTest(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        rospy.init_node('calibration_killed_test')
        cls.folder = rospy.get_param('/folder')
        cls.addClassCleanup(shutil.rmtree, cls.folder, ignore_errors=True)

    def start(self):
        """A manager with the nodelet in it, driven until there is something to save."""
        self.manager = Manager()
        self.addCleanup(self.manager.kill)
        if not hasattr(self, 'node'):
            self.node = Node()
        self.node.forget()
        wait_until(lambda: self.node.wheels.get_num_connections() == 1 and
                   self.node.bearings.get_num_connections() == 1, 'it listens', START_DEADLINE_S)
        world = World(rospy.Time.now().to_sec() - 1000.0, seed=random.randrange(10**6))
        wait_until(lambda: self.node.drive(world, 1.0) and self.node.estimates
                   and self.node.estimate().state in TRUSTED,
                   'an estimate that may be trusted', START_DEADLINE_S)
        answer = self.save()
        self.assertTrue(answer.success, answer.message)

    def save(self):
        return self.node.save_service()

    def saveAndKill(self):
        """Kills the manager somewhere in a row of savings."""
        def saveForEver():
            try:
                while True:
                    self.save()
            except (rospy.ServiceException, rospy.ROSException):
                pass  # it is dead
        thread = threading.Thread(target=saveForEver)
        thread.start()
        deadline = time.monotonic() + START_DEADLINE_S
        while not self.unfinished() and time.monotonic() < deadline:
            pass
        time.sleep(random.uniform(0.0, LONGEST_DELAY_S))
        self.manager.kill()
        thread.join()

    def writtenAt(self):
        with open(os.path.join(self.folder, 'result.yaml')) as file:
            result = yaml.safe_load(file)
        self.assertTrue(result['complete'])
        return result['provenance']['written_at']

    def assertWhole(self):
        written_at = None
        while written_at != self.writtenAt():  # a manager that lives saves every second
            written_at, texts = self.writtenAt(), {}
            for name in os.listdir(self.folder):
                path = os.path.join(self.folder, name)
                if name not in ('result.yaml', '.bearing_calibration') and os.path.isfile(path):
                    with open(path) as file:
                        texts[name] = file.read()
        for name, text in texts.items():
            self.assertIn(written_at, text, name + ' is of another result')

    def unfinished(self):
        """What lies there while something is written, and nothing else."""
        return [name for name in os.listdir(self.folder)
                if name not in FILES and not name.isdigit()]

    # Promise kept: a kill while it saves
    def test_killed_while_it_saves(self):
        random.seed(1)
        hits = kills = 0
        while kills < KILLS or (hits == 0 and kills < MOST_KILLS):
            self.start()
            self.assertEqual(self.unfinished(), [], 'after kill %d and a save' % kills)
            self.assertWhole()
            self.saveAndKill()
            kills += 1
            hits += bool(self.unfinished())
            self.assertWhole()
        self.start()
        self.assertEqual(self.unfinished(), [])
        print('%d kills, %d of them in the midst of a save' % (kills, hits))
        self.assertGreater(hits, 0)


if __name__ == '__main__':
    rostest.rosrun('bearing_calibration', 'calibration_killed', CalibrationKilledTest)
