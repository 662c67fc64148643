"""calibrate_bag as its user meets it: bags in; a table, files and an exit status out."""

import csv
import math
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

import rosbag
import roslib.packages
import yaml
from bearing_calibration.msg import LightBearings
from sensor_msgs.msg import JointState

REPOSITORY = os.path.abspath(os.path.join(os.path.dirname(__file__), '..', '..'))
sys.path.insert(0, os.path.join(REPOSITORY, 'test', 'ros'))
from calibration_world import SIMULATED_ROBOT, World, recordBag  # noqa: E402  (lies beside the nodes)

CONVERGED, FAILED, USAGE, DEGENERATE, UNCERTAIN, DISAGREE = range(6)
START_S = 1000.0
CHI_SQUARE_3_AT_999 = 16.27  # what the squared error stays below in 999 of 1000 honest runs

JOINTS = '/joint_states', World.joint_state
ODOMETRY = '/base/odom', World.odometry
NOISE = 'wheels/noise_independent=1.0e-6'  # the world's robot does not slip


def worldOf(seed=1, sensor=None):
    world = World(START_S, seed=seed)
    world.sensor = sensor or world.sensor
    return world


class Drives(unittest.TestCase):
    """Three drives of one robot, and a folder for each test."""

    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.drives = [recordBag(os.path.join(folder.name, 'drive_%d.bag' % seed), worldOf(seed))
                      for seed in (1, 2, 3)]

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        self.output = os.path.join(self.folder, 'out')
        self.program = roslib.packages.find_node('bearing_calibration', 'calibrate_bag')[0]

    def path(self, name):
        return os.path.join(self.folder, name)

    def record(self, name, *arguments, **options):
        return recordBag(self.path(name), *arguments, **options)


class CalibrateBag(Drives):

    def run_(self, *arguments):
        return subprocess.run([self.program, '--config', SIMULATED_ROBOT, *arguments,
                               '--output', self.output],
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                              universal_newlines=True, timeout=600)

    def assertStatus(self, done, status):
        self.assertEqual(done.returncode, status, done.stdout + done.stderr)

    def result(self, *folders):
        with open(os.path.join(self.output, *folders, 'result.yaml')) as file:
            return yaml.safe_load(file)

    def filesIn(self, *folders):
        """What each file holds, by its name; but for the hidden list of them."""
        folder = os.path.join(self.folder, *folders)
        texts = {}
        for name in os.listdir(folder):
            path = os.path.join(folder, name)
            if os.path.isfile(path) and name != '.bearing_calibration':
                with open(path) as file:
                    texts[name] = file.read()
        return texts

    def assertRight(self, result, world):
        """Within the estimate's own covariance of the world's truth."""
        error = [result['base_from_camera'][key] - true
                 for key, true in zip(('x', 'y', 'yaw'), world.sensor)]
        error[2] = math.remainder(error[2], 2.0 * math.pi)
        squared = sum(e * e / s**2 for e, s in zip(error, result['stddev'].values()))
        # the axes taken apart: at least a third of the true chi-square, so the bar is that high
        self.assertLess(squared, 3.0 * CHI_SQUARE_3_AT_999, (error, result['stddev']))

    def testFindsTheMountAndWritesWhatItFound(self):
        done = self.run_(self.drives[0], '--set', NOISE)
        self.assertStatus(done, CONVERGED)
        self.assertIn('drive_1: CONVERGED', done.stdout)
        self.assertRegex(done.stdout, r'yaw +0\.2\d+ \+- 0\.00\d+ rad')
        result = self.result()
        self.assertRight(result, worldOf())
        self.assertEqual(result['record']['bearings_used'] + result['record']['bearings_gated'],
                         1200)
        self.assertEqual([(block['name'], block['status']) for block in result['blocks']],
                         [('time_offset', 'estimated'), ('wheel_scales', 'estimated'),
                          ('wheel_separation', 'held at its prior'), ('mirror_harmonic', 'off'),
                          ('sensor_tilt', 'off'),
                          ('bearing_noise', 'estimated'), ('wheel_noise', 'estimated'),
                          ('light_size', 'held at its prior'),
                          ('bearing_correlation', 'off')])
        covariance, mount = result['covariance_x_y_yaw'], result['base_from_camera']
        levers = ((1, 0, mount['y']), (0, 1, 3.0 - mount['x']))  # of a light 3 m ahead
        (a, b), (_, c) = [[sum(u[i] * covariance[i][j] * v[j] for i in range(3) for j in range(3))
                           for v in levers] for u in levers]
        worst_m = math.sqrt(0.5 * (a + c) + math.hypot(0.5 * (a - c), b))
        self.assertIn('within %.1f mm (68 %%)' % (1e3 * worst_m), result['quality'][0])
        for sentence in result['quality']:
            self.assertIn('\n  %s\n' % sentence, done.stdout)
        self.assertIn('drive_1.bag: /wheel_ticks, /bearings', result['provenance']['source'])
        self.assertEqual(result['parameters']['frames/base'], 'base_link')
        self.assertEqual(result['parameters']['wheels/noise_independent'], 1e-6)
        for name in ('mount.urdf', 'mount.urdf.xacro', 'static_transform.launch',
                     'kalibr_camchain.yaml', 'vins_extrinsics.yaml', 'diff_drive_controller.yaml'):
            self.assertTrue(os.path.exists(os.path.join(self.output, name)), name)

    def testCalibratesWithTwoLightsThatTheSensorTellsApart(self):
        def seeBoth(world):
            first = world.candidate(light_id=3)
            place, world.light = world.light, (1.4, 2.2)
            second = world.candidate(light_id=7)
            world.light = place
            return [first, second]

        bag = self.record('two.bag', worldOf(), look=seeBoth)
        self.assertStatus(self.run_(bag, '--set', NOISE, '--set', 'session/max_lights=2'), CONVERGED)
        both = self.result()
        self.assertRight(both, worldOf())
        self.assertEqual([(light['id'], light['in_estimate']) for light in both['lights']],
                         [(3, True), (7, True)])
        # seen from the base at the end, which the odometry knows to centimetres
        end = worldOf()
        for _ in range(1199 * end.TICKS_PER_BEARING):
            end.advance()
        for light, place in zip(both['lights'], ((0.0, 0.0), (1.4, 2.2))):
            east, north = place[0] - end.x, place[1] - end.y
            cosine, sine = math.cos(end.heading), math.sin(end.heading)
            self.assertAlmostEqual(light['x_m'], cosine * east + sine * north, delta=0.1)
            self.assertAlmostEqual(light['y_m'], cosine * north - sine * east, delta=0.1)
        self.assertStatus(self.run_(bag, '--set', NOISE), CONVERGED)
        one = self.result('1')  # beside the better one
        self.assertEqual([light['id'] for light in one['lights']], [3])
        for key in ('x', 'y', 'yaw'):
            self.assertLess(both['stddev'][key], one['stddev'][key])

    def testWritesWhatTheReportIsMadeFrom(self):
        done = self.run_(self.drives[0], '--set', NOISE)
        self.assertStatus(done, CONVERGED)
        with open(os.path.join(self.output, 'images.csv')) as file:
            looks = list(csv.DictReader(file))
        self.assertEqual(len(looks), 1200)
        used = [row for row in looks if row['fit'] == 'used']
        self.assertGreater(len(used), 1100)
        stddev = math.sqrt(sum(float(row['residual_rad'])**2 for row in used) / len(used))
        # of about 1200 residuals of 0.5 deg each: within five of its standard errors (2 %)
        self.assertAlmostEqual(math.degrees(stddev), 0.5, delta=0.05)
        nis = [float(row['nis']) for row in used]
        self.assertAlmostEqual(sum(nis) / len(nis), 1.0, delta=5.0 * math.sqrt(2.0 / len(nis)))
        # the smoothed path is the world's, seen from its first pose (2, 0, 90 deg)
        world = worldOf()
        for _ in range(1199 * world.TICKS_PER_BEARING):
            world.advance()
        x, y = float(looks[-1]['base_x_m']), float(looks[-1]['base_y_m'])
        self.assertAlmostEqual(-y + 2.0, world.x, delta=0.05)
        self.assertAlmostEqual(x, world.y, delta=0.05)
        with open(os.path.join(self.output, 'details.yaml')) as file:
            details = yaml.safe_load(file)
        # what is printed; the robot turns on the spot, at a constant rate, and never stands
        self.assertIn('turning on the spot', ' '.join(details['sensor']))
        for sentence in details['sensor']:
            self.assertIn(sentence, done.stdout)
        light = details['light_in_first_base']  # 2 m to the left
        self.assertLess(math.hypot(light['x'], light['y'] - 2.0), 0.05)
        with open(os.path.join(self.output, 'estimates.csv')) as file:
            estimates = list(csv.DictReader(file))
        self.assertGreater(len(estimates), 50)
        self.assertEqual(estimates[-1]['state'], 'CONVERGED')

    def testTheRunningEstimateEndsAsTheResult(self):
        """Also where the robot turns on the spot at the end, and its distance does not grow."""
        self.assertStatus(self.run_(self.record('spin.bag', worldOf(), seconds=117.0), '--set', NOISE),
                          CONVERGED)
        with open(os.path.join(self.output, 'estimates.csv')) as file:
            last = list(csv.DictReader(file))[-1]
        result = self.result()
        for name, unit in (('x', 'm'), ('y', 'm'), ('yaw', 'rad')):
            self.assertEqual(float(last['%s_%s' % (name, unit)]), result['base_from_camera'][name])
            self.assertEqual(float(last['%s_stddev_%s' % (name, unit)]), result['stddev'][name])

    def testTheParametersOfAResultAreTakenAgain(self):
        self.assertStatus(self.run_(self.drives[0], '--set', NOISE), CONVERGED)
        first = self.result()
        groups = {}
        for name, value in first['parameters'].items():
            group, key = name.split('/', 1)
            groups.setdefault(group, {})[key] = value
        with open(self.path('again.yaml'), 'w') as file:
            yaml.safe_dump(groups, file)
        self.assertStatus(self.run_(self.drives[0], '--config', self.path('again.yaml')), CONVERGED)
        self.assertEqual(self.result()['parameters'], first['parameters'])

    def testTheSameBagGivesTheSameBits(self):
        """Reading and calibrating go on at once, on two threads."""
        texts = []
        for _ in range(2):
            self.assertStatus(self.run_(self.drives[0], '--set', NOISE), CONVERGED)
            for name in ('images.csv', 'estimates.csv'):
                with open(os.path.join(self.output, name)) as file:
                    texts.append(file.read())
        self.assertEqual(texts[:2], texts[2:])

    def testReadsJointStates(self):
        world = worldOf()
        done = self.run_(self.record('joints.bag', world, wheels=JOINTS), '--set', NOISE,
                         '--set', 'wheels/source=joint_states')
        self.assertStatus(done, CONVERGED)
        self.assertRight(self.result(), world)

    def testOtherJointsOnTheTopicDisturbNothing(self):
        world = worldOf()
        bag = self.record('arm.bag', world, seconds=2.0, wheels=JOINTS)
        with rosbag.Bag(bag, 'a') as file:
            arm = JointState(name=['elbow'], position=[0.0])
            arm.header.stamp = world.stamp()
            file.write('/joint_states', arm, world.stamp())
        done = self.run_(bag, '--set', 'wheels/source=joint_states')
        self.assertNotIn('joint', done.stdout.replace('/joint_states', ''))

    def testSaysWhichJointsWereThere(self):
        bag = self.record('joints.bag', worldOf(), seconds=2.0, wheels=JOINTS)
        done = self.run_(bag, '--set', 'wheels/source=joint_states',
                         '--set', 'wheels/left_joint=left')
        self.assertStatus(done, FAILED)
        self.assertIn("'left' and 'right_wheel_joint'", done.stdout)
        self.assertIn('(arm, left_wheel_joint, right_wheel_joint)', done.stdout)

    def testReadsOdometry(self):
        world = worldOf()
        bag = self.record('odometry.bag', world, wheels=ODOMETRY)
        done = self.run_(bag, '--set', NOISE, '--set', 'wheels/source=odometry')
        self.assertStatus(done, CONVERGED)
        self.assertRight(self.result(), world)
        self.assertNotIn('refused or changed', done.stdout)
        self.assertIn('odometry.bag: /base/odom, /bearings', self.result()['provenance']['source'])

    def testSaysWhoseOdometryItIs(self):
        bag = self.record('odometry.bag', worldOf(), seconds=2.0, wheels=ODOMETRY)
        done = self.run_(bag, '--set', 'wheels/source=odometry', '--set', 'frames/base=base')
        self.assertIn("frame 'base_link' of the odometry is not frames/base 'base'", done.stdout)

    def testAFrameWithASlashInFrontIsTheSame(self):
        with rosbag.Bag(self.record('drive.bag', worldOf(), seconds=2.0)) as plain, \
                rosbag.Bag(self.path('slash.bag'), 'w') as bag:
            for topic, message, time in plain:
                if topic == '/bearings':
                    message.header.frame_id = '/camera'
                bag.write(topic, message, time)
        self.assertNotIn('frames/sensor', self.run_(self.path('slash.bag')).stdout)

    def testNamesATopicWithoutOdometry(self):
        done = self.run_(self.drives[0], '--set', 'wheels/source=odometry')
        self.assertStatus(done, FAILED)
        self.assertIn('no topic of type nav_msgs/Odometry', done.stdout)

    def testSeveralBagsOfOneMountAgree(self):
        done = self.run_(*self.drives, '--set', NOISE, '--compare')
        self.assertStatus(done, CONVERGED)
        self.assertRegex(done.stdout, r'with 6 degrees of freedom, p = [\d.e-]+: they agree')
        with open(os.path.join(self.output, 'comparison.yaml')) as file:
            comparison = yaml.safe_load(file)
        self.assertEqual([row['name'] for row in comparison['mounts']],
                         ['drive_1', 'drive_2', 'drive_3'])
        self.assertAlmostEqual(sum(row['chi_square'] for row in comparison['mounts']),
                               comparison['together']['chi_square'])
        self.assertRight(comparison['together'], worldOf())
        self.assertRight(self.result('drive_2'), worldOf())

    def testANameOfAnyLengthLeavesItsRowWhole(self):
        bags = [self.path('%d%s.bag' % (i, 'drive' * 40)) for i in (1, 2)]
        for drive, bag in zip(self.drives, bags):
            shutil.copy(drive, bag)
        done = self.run_(*bags, '--set', NOISE, '--compare')
        self.assertStatus(done, CONVERGED)
        number = r' +-?\d+\.\d{4} \+- \d\.\d{4}'
        rows = re.findall(r'(?m)^(\d)(?:drive){40}%s +\d+\.\d$' % (3 * number), done.stdout)
        self.assertEqual(rows, ['1', '2'], done.stdout)

    def testBagsOfTwoMountsDisagree(self):
        moved = worldOf(2, sensor=(0.15, 0.12, math.radians(12.0)))
        done = self.run_(self.drives[0], self.record('moved.bag', moved), '--set', NOISE, '--compare')
        self.assertStatus(done, DISAGREE)
        self.assertIn('they DISAGREE', done.stdout)
        self.assertIn('comparison.yaml', os.listdir(self.output))
        self.assertStatus(self.run_(*self.drives[:2], '--set', NOISE), CONVERGED)
        self.assertNotIn('comparison.yaml', os.listdir(self.output), 'it is of other estimates')

    def testEachLightOfABag(self):
        other = (3.5, 1.5)

        def look(world):
            first = world.candidate(light_id=4)
            here, world.light = world.light, other
            second = world.candidate(light_id=9)
            world.light = here
            return [first, second]
        bag = self.record('two.bag', worldOf(), look=look)
        done = self.run_(bag, '--set', NOISE, '--each-light', '--compare')
        self.assertStatus(done, CONVERGED)
        self.assertRight(self.result('two_light_4'), worldOf())
        self.assertRight(self.result('two_light_9'), worldOf())
        self.assertIn('they agree', done.stdout)
        self.assertStatus(self.run_(bag, '--set', NOISE, '--light', '9'), CONVERGED)
        done = self.run_(bag, '--light', '5')
        self.assertStatus(done, FAILED)
        self.assertIn('! no bearing has the light_id 5, only: 4, 9', done.stdout)

    # Promise kept: a bag of a straight line over a good result
    def testAStraightLineIsDegenerateAndLeavesAnEarlierResultAlone(self):
        self.assertStatus(self.run_(self.drives[0], '--set', NOISE), CONVERGED)
        before = self.filesIn('out')
        world = worldOf()
        world.STRAIGHT_S = 100.0
        line = self.record('line.bag', world, seconds=20.0)
        done = self.run_(line)
        self.assertStatus(done, DEGENERATE)
        self.assertIn('line: DEGENERATE_MOTION', done.stdout)
        self.assertIn('written to %s; %s is of an earlier run' % (
            os.path.join(self.output, '1'), os.path.join(self.output, 'result.yaml')), done.stdout)
        self.assertIn('calibration_report ' + os.path.join(self.output, '1'), done.stdout)
        self.assertEqual(self.filesIn('out'), before)
        self.assertEqual(sorted(self.filesIn('out', '1')),
                         ['details.yaml', 'estimates.csv', 'images.csv', 'plans.csv'])
        shutil.rmtree(self.output)
        self.run_(line)
        self.assertEqual(sorted(self.filesIn('out')),
                         ['details.yaml', 'estimates.csv', 'images.csv', 'plans.csv'])

    def testAFailureSaysThatWhatIsThereIsOfAnEarlierRun(self):
        done = self.run_(self.path('absent.bag'))
        self.assertStatus(done, FAILED)
        self.assertRegex(done.stdout, r'nothing was written\n')
        self.assertNotIn('a report of it', done.stdout)
        self.assertEqual(os.listdir(self.output), [])
        self.assertStatus(self.run_(self.drives[0], '--set', NOISE), CONVERGED)
        before = self.filesIn('out')
        done = self.run_(self.path('absent.bag'))
        self.assertStatus(done, FAILED)
        self.assertIn('nothing was written; %s is of an earlier run' % os.path.join(
            self.output, 'result.yaml'), done.stdout)
        self.assertNotIn('a report of it', done.stdout)
        self.assertEqual(self.filesIn('out'), before)

    # Promise kept: a worse bag of the same mount
    def testAWorseResultOfTheSameMountIsWrittenBesideTheBetterOne(self):
        self.assertStatus(self.run_(self.drives[0], '--set', NOISE), CONVERGED)
        before = self.filesIn('out')
        short = self.record('short.bag', worldOf(2), seconds=25.0)
        done = self.run_(short, '--set', NOISE)
        self.assertIn('%s stays: it is CONVERGED, this one CONVERGING; this one is written to %s' % (
            os.path.join(self.output, 'result.yaml'),
            os.path.join(self.output, '1', 'result.yaml')), done.stdout)
        self.assertStatus(done, UNCERTAIN)
        self.assertEqual(self.filesIn('out'), before)
        self.assertIn('short.bag', self.result('1')['provenance']['source'])

    def testAResultIsThePriorOfTheNextRecording(self):
        first = self.run_(self.drives[0], '--set', NOISE, '--set', 'session/resume=true')
        self.assertIn('! nothing to resume: no %s' % os.path.join(self.output, 'result.yaml'), first.stdout)
        alone = self.result()
        self.assertRight(alone, worldOf())
        second = self.run_(self.drives[1], '--set', NOISE, '--set', 'session/resume=true')
        self.assertIn('! resumed from %s, written ' % os.path.join(self.output, 'result.yaml'), second.stdout)
        self.assertStatus(second, CONVERGED)
        both = self.result()
        self.assertIn('drive_2.bag', both['provenance']['source'])
        self.assertRight(both, worldOf())
        self.assertLess(both['stddev']['yaw'], 0.85 * alone['stddev']['yaw'])

    # Promise kept: a bag of another mount
    def testAnotherMountsResultIsKept(self):
        self.assertStatus(self.run_(self.drives[0], '--set', NOISE), CONVERGED)
        before = self.filesIn('out')
        moved = worldOf(2, sensor=(0.12, 0.08, 0.21))
        done = self.run_(self.record('moved.bag', moved), '--set', NOISE)
        self.assertStatus(done, CONVERGED)
        self.assertIn('what was there before is kept in %s: it contradicts this one' %
                      os.path.join(self.output, '1'), done.stdout)
        self.assertRight(self.result(), moved)
        self.assertEqual(self.filesIn('out', '1'), before)

    # Promise inside: an output folder with somebody else's files
    def testBesideOthersFilesItHasAFolderOfItsOwn(self):
        os.mkdir(self.output)
        for name in ('result.yaml', 'mount.urdf', 'details.yaml', 'comparison.yaml', 'drive_1'):
            with open(os.path.join(self.output, name), 'w') as file:
                file.write("the robot's own\n")
        before = self.filesIn('out')
        own = os.path.join(self.output, 'bearing_calibration')
        done = self.run_(self.drives[0], '--set', NOISE)
        self.assertStatus(done, CONVERGED)
        self.assertIn('written to ' + os.path.join(own, 'result.yaml'), done.stdout)
        self.assertIn('calibration_report ' + own, done.stdout)
        done = self.run_(*self.drives[:2], '--set', NOISE, '--compare')
        self.assertStatus(done, CONVERGED)
        self.assertEqual(self.filesIn('out'), before)
        self.assertLessEqual({'comparison.yaml', 'result.yaml'}, set(os.listdir(own)))
        self.assertRight(self.result('bearing_calibration', 'drive_2'), worldOf())

    # Promise alive: one unreadable bag among several
    def testABagThatCannotBeReadFailsAloneAndIsNamed(self):
        with open(self.path('broken.bag'), 'w') as file:
            file.write('no bag')
        done = self.run_(self.path('broken.bag'), self.path('absent.bag'),
                         self.drives[0], '--set', NOISE)
        self.assertStatus(done, FAILED)
        self.assertIn('broken: FAILED', done.stdout)
        self.assertIn('absent: FAILED', done.stdout)
        self.assertIn('drive_1: CONVERGED', done.stdout)

    # Promise named: an output folder that can no longer be written to after the calibrations
    def testWhatCannotBeWrittenAtTheEndLosesNothing(self):
        os.makedirs(os.path.join(self.output, '.bearing_calibration'))  # it is a file that gives way to a new one
        done = self.run_(*self.drives[:2], '--set', NOISE, '--compare')
        self.assertStatus(done, FAILED)
        self.assertEqual(done.stdout.count('Is a directory'), 2, done.stdout)
        self.assertIn('they agree', done.stdout)
        self.assertIn('a report of it', done.stdout)
        for drive in ('drive_1', 'drive_2'):
            self.assertRight(self.result(drive), worldOf())

    def cureOf(self, bag, what):
        """Runs the command that calibrate_bag names for a bag that it cannot read."""
        done = self.run_(bag, '--set', NOISE)
        self.assertStatus(done, FAILED)
        self.assertIn('%s %s' % (bag, what), done.stdout)
        command = re.search(r'rosbag reindex \S+', done.stdout).group(0)
        subprocess.run(command.split(), check=True, stdout=subprocess.DEVNULL, timeout=60)

    # Promise named: a bag that is cut short
    def testABagThatIsCutShortNamesItsCure(self):
        bag = self.record('cut.bag', worldOf(), chunk_threshold=8192)
        with open(bag, 'r+b') as file:
            file.truncate(os.path.getsize(bag) * 9 // 10)
        self.cureOf(bag, 'is cut short or damaged')
        self.assertStatus(self.run_(bag, '--set', NOISE), CONVERGED)
        self.assertRight(self.result(), worldOf())

    # Promise named: a bag without an index
    def testABagWithoutAnIndexNamesItsCure(self):
        """As a recorder leaves it that was killed: the index is not there and not spoken of."""
        bag = self.record('killed.bag', worldOf(), chunk_threshold=8192)
        with rosbag.Bag(bag) as read:
            index = read._index_data_pos
        active = self.path('drive.bag.active')
        with open(bag, 'rb') as whole, open(active, 'wb') as file:
            content = whole.read(index)
            field = content.index(b'index_pos=') + len(b'index_pos=')
            file.write(content[:field] + bytes(8) + content[field + 8:])
        self.cureOf(active, 'has no index')
        self.assertStatus(self.run_(active, '--set', NOISE), CONVERGED)
        self.assertRight(self.result(), worldOf())

    # Promise named: a bag that is damaged inside
    def testABagThatIsDamagedInsideNamesItsCure(self):
        bag = self.record('damaged.bag', worldOf(), chunk_threshold=8192)
        with open(bag, 'r+b') as file:
            file.seek(os.path.getsize(bag) // 2)
            file.write(bytes(4000))
        done = self.run_(bag)
        self.assertStatus(done, FAILED)
        self.assertIn('damaged.bag is cut short or damaged', done.stdout)
        self.assertIn('rosbag reindex ' + bag, done.stdout)

    # Promise named: a file that is no bag
    def testWhatIsNoBagIsSaid(self):
        for name, content in (('empty.bag', ''), ('text.bag', 'no bag')):
            with open(self.path(name), 'w') as file:
                file.write(content)
            done = self.run_(self.path(name))
            self.assertStatus(done, FAILED)
            self.assertIn('%s is no bag, or an empty one' % self.path(name), done.stdout)
        done = self.run_(self.path('absent.bag'))
        self.assertStatus(done, FAILED)
        self.assertIn('absent.bag: No such file or directory', done.stdout)

    # Promise named: an output that cannot be written
    def testAnOutputThatCannotBeWrittenIsSaidBeforeAnythingIsRead(self):
        done = subprocess.run([self.program, self.drives[0], '--config', SIMULATED_ROBOT,
                               '--output', '/proc/nope'],
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                              universal_newlines=True, timeout=600)
        self.assertStatus(done, USAGE)
        self.assertIn('--output /proc/nope cannot be made: No such file or directory', done.stderr)

    # Promise bounded: a file of parameters with endless aliases
    def testABombOfAliasesEndsAtOnce(self):
        with open(self.path('bomb.yaml'), 'w') as file:
            file.write('a0: &a0 [x, x, x, x, x, x, x, x, x]\n')
            for i in range(1, 9):
                file.write('a%d: &a%d [%s]\n' % (i, i, ', '.join(9 * ['*a%d' % (i - 1)])))
        done = self.run_(self.drives[0], '--config', self.path('bomb.yaml'))
        self.assertStatus(done, USAGE)
        self.assertRegex(done.stderr, r'bomb.yaml: line 1: more than \d+ values')

    def testANumberThatNoDoubleHoldsNamesItsParameter(self):
        done = self.run_(self.drives[0], '--set', 'wheels/separation=1.0e+999')
        self.assertStatus(done, USAGE)
        self.assertIn('wheels/separation must be a finite number', done.stderr)

    # Promise named: a bag without the topics
    def testABagWithoutTheTopicsSaysWhatItHolds(self):
        bag = self.record('drive.bag', worldOf(), seconds=1.0)
        done = self.run_(bag, '--set', 'wheels/source=joint_states')
        self.assertStatus(done, FAILED)
        self.assertIn('no topic of type sensor_msgs/JointState', done.stdout)
        self.assertIn('/wheel_ticks (bearing_calibration/WheelTicks)', done.stdout)
        self.assertNotIn('choose', done.stdout)
        with rosbag.Bag(self.path('wheels.bag'), 'w') as alone, rosbag.Bag(bag) as both:
            for topic, message, time in both.read_messages(topics=['/wheel_ticks']):
                alone.write(topic, message, time)
        done = self.run_(self.path('wheels.bag'))
        self.assertStatus(done, FAILED)
        self.assertIn('no bearings (bearing_calibration/LightBearings) and no images (sensor_msgs/Image or '
                      'sensor_msgs/CompressedImage); the bag holds', done.stdout)
        done = self.run_(bag, '--image-topic', 'camera/image_raw')
        self.assertStatus(done, FAILED)
        self.assertIn('no topic camera/image_raw of type sensor_msgs/Image or '
                      'sensor_msgs/CompressedImage', done.stdout)

    def testMessagesOfAnotherVersionAreNamed(self):
        class Others(LightBearings):
            _md5sum = '0' * 32

        with rosbag.Bag(self.record('drive.bag', worldOf(), seconds=1.0)) as ours, \
                rosbag.Bag(self.path('others.bag'), 'w') as others:
            for topic, message, time in ours:
                if topic == '/bearings':
                    message = Others(*(getattr(message, name) for name in message.__slots__))
                others.write(topic, message, time)
        done = self.run_(self.path('others.bag'))
        self.assertStatus(done, FAILED)
        self.assertIn('/bearings (bearing_calibration/LightBearings of another version of this package)',
                      done.stdout)

    # Promise named: an empty bag
    def testAnEmptyBagFailsAndSaysWhatIsMissing(self):
        with rosbag.Bag(self.path('empty.bag'), 'w'):
            pass
        done = self.run_(self.path('empty.bag'))
        self.assertStatus(done, FAILED)
        self.assertIn('the bag holds nothing', done.stdout)

    def testSaysEveryWrongParameterAtOnce(self):
        """The drive's limits, which are not read here, are none."""
        with open(self.path('robot.yaml'), 'w') as file:
            file.write('wheels: {seperation: 0.4, left_radius: left}\n'
                       'region: {polygon: [[1, 1], [-1, 1], [0, -1]]}\n')
        done = self.run_('any.bag', '--config', self.path('robot.yaml'),
                         '--set', 'filter/gate_probability=2.0', '--set', 'lens/focal=1.0')
        self.assertStatus(done, USAGE)
        self.assertIn('4 wrong parameter(s)', done.stderr)
        for part in ('wheels/seperation is not known (misspelt?): ' + self.path('robot.yaml'),
                     "wheels/left_radius must be a finite number, but is the string 'left'",
                     'filter/gate_probability', 'lens/focal is not known'):
            self.assertIn(part, done.stderr)

    def testWrongArgumentsAreSaid(self):
        for arguments, said in ((['--set', 'wheels/separation'], 'NAME=VALUE'),
                                (['--jobs', '-1'], '--jobs'),
                                (['--light', '1', '--each-light'], 'exclude each other'),
                                (['--colour'], 'colour')):
            done = self.run_('any.bag', *arguments)
            self.assertStatus(done, USAGE)
            self.assertIn(said, done.stderr)
        done = self.run_()
        self.assertStatus(done, USAGE)
        self.assertIn('BAG is missing', done.stderr)
        self.assertStatus(self.run_('--help'), CONVERGED)

    def testHelpNamesEveryExitStatus(self):
        done = self.run_('--help')
        for status in range(6):
            self.assertTrue(re.search(r'\b%d\b' % status, done.stdout), status)

class JobQueues(Drives):
    """The commands of calibrate_bag.md for many bags, as they stand there."""

    def setUp(self):
        super().setUp()
        os.mkdir(self.path('bags'))
        for bag in self.drives[:2]:
            os.symlink(bag, self.path(os.path.join('bags', os.path.basename(bag))))
        shutil.copy(SIMULATED_ROBOT, self.path('robot.yaml'))

    def documented(self, pattern):
        with open(os.path.join(REPOSITORY, 'doc', 'how-to', 'calibrate_bag.md')) as file:
            return re.search(pattern, file.read()).group(1)

    def runInFolder(self, command, **environment):
        done = subprocess.run(['bash', '-c', command], cwd=self.folder, stdin=subprocess.DEVNULL,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                              universal_newlines=True, timeout=600,
                              env=dict(os.environ, **environment))
        self.assertEqual(done.returncode, 0, done.stdout)

    def testGnuParallel(self):
        if not shutil.which('parallel'):
            self.skipTest('GNU parallel is not installed')
        self.runInFolder(self.documented(r'\./scripts/run (parallel (?:.*\\\n)*.*)'))
        for name in ('drive_1', 'drive_2'):
            self.assertTrue(os.path.exists(self.path('results/%s/result.yaml' % name)), name)
        with open(self.path('jobs.log')) as file:
            self.assertEqual(len(file.readlines()), 1 + 2)

    def testSlurmsJob(self):
        """What sbatch is given to run; Slurm itself is not asked for."""
        self.runInFolder(self.documented(r"sbatch --array=\S+ --wrap '([^']*)'"),
                         SLURM_ARRAY_TASK_ID='1')
        self.assertEqual(os.listdir(self.path('results')), ['drive_2'])


if __name__ == '__main__':
    unittest.main()
