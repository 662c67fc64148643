"""Launch and configuration files as they are shipped: they load, and they say what they take."""

import glob
import os
import re
import shlex
import tempfile
import unittest
import xml.etree.ElementTree as ElementTree

import roslaunch.config
import roslaunch.core
import roslaunch.xmlloader
import roslib.packages
import rospy
import yaml
from bearing_calibration.msg import CalibrationEstimate

REPOSITORY = os.path.abspath(os.path.join(os.path.dirname(__file__), '..', '..'))
LAUNCH_FILES = sorted(glob.glob(os.path.join(REPOSITORY, 'launch', '*.launch')))
CONFIG_FILES = sorted(glob.glob(os.path.join(REPOSITORY, 'config', '*.yaml')))
EXPECTED_LAUNCH_FILES = {'adapter.launch', 'calibrate.launch', 'demo.launch', 'detect.launch',
                         'drive.launch', 'live.launch', 'manager.launch', 'replay.launch'}

# Arguments that have no default because only the user knows them.
REQUIRED_ARGUMENTS = {'manager.launch': ['manager:=some_manager'],
                      'replay.launch': ['bag:=/tmp/some.bag']}

# "name: value  # comment"; a group's name has no value.
PARAMETER = re.compile(r'^ *[A-Za-z_]\w*:\s*(?P<value>[^#]*?)\s*(#\s*(?P<comment>.*))?$')
UNIT = re.compile(r'\[[^\])]+[\])]')  # [m], [rad], [0 to 1)


def load(path, *arguments):
    config = roslaunch.config.ROSLaunchConfig()
    name = os.path.basename(path)
    roslaunch.xmlloader.XmlLoader().load(
        path, config, argv=REQUIRED_ARGUMENTS.get(name, []) + list(arguments), verbose=False)
    return config


def loadWith(files, path, *arguments):
    """Parameters of a launch file with {argument: text} as files of these texts."""
    with tempfile.TemporaryDirectory() as folder:
        for name, text in files.items():
            with open(os.path.join(folder, name), 'w') as file:
                file.write(text)
        return load(path, *arguments, *('%s:=%s' % (name, os.path.join(folder, name)) for name in files)).params


def declaredNodelets():
    tree = ElementTree.parse(os.path.join(REPOSITORY, 'nodelet_plugins.xml'))
    return {element.get('name') for element in tree.iter('class')}


class LaunchFiles(unittest.TestCase):

    def testAllOfThemAreThere(self):
        self.assertLessEqual(EXPECTED_LAUNCH_FILES, set(map(os.path.basename, LAUNCH_FILES)))

    def testTheyLoadAndTheirProgramsExist(self):
        for path in LAUNCH_FILES:
            with self.subTest(launch=os.path.basename(path)):
                config = load(path)
                self.assertEqual(config.config_errors, [])
                self.assertTrue(config.nodes)
                for node in config.nodes:
                    self.assertTrue(roslib.packages.find_node(node.package, node.type),
                                    '%s/%s is not there' % (node.package, node.type))

    def testTheDemoDrivesInEveryWayItNames(self):
        demo = os.path.join(REPOSITORY, 'launch', 'demo.launch')
        for drive, motion in (('optimal', 'optimal'), ('paper', 'dance')):
            nodes = {node.name: node for node in load(demo, 'drive:=' + drive).nodes}
            self.assertIn('calibration_drive', nodes)
            self.assertEqual(nodes['start_drive'].args, motion)
        for arguments in (['drive:=manual'], []):
            names = {node.name for node in load(demo, *arguments).nodes}
            self.assertNotIn('calibration_drive', names)
        with self.assertRaises(roslaunch.core.RLException):
            load(demo, 'drive:=fast')

    def testTheirManagersAreRequiredAndHaveNamesOfTheirOwn(self):
        names = []
        for path in LAUNCH_FILES:
            config = load(path)
            for node in config.nodes:
                if node.args == 'manager':
                    names.append(node.name)
                    self.assertTrue(node.required, path)
                    self.assertIn('/%s/num_worker_threads' % node.name, config.params)
        self.assertGreater(len(names), 4)
        self.assertEqual(len(names), len(set(names)), names)

    def testTheyForgetTheParametersOfAnEarlierLaunch(self):
        """Where the roscore goes on, a misspelt name would still be refused after its file was mended."""
        for path in LAUNCH_FILES:
            config = load(path)
            nodelets = {rospy.names.ns_join(node.namespace, node.name) + '/' for node in config.nodes
                        if 'bearing_calibration/' in node.args}
            with self.subTest(launch=os.path.basename(path)):
                self.assertEqual(nodelets - set(config.clear_params), set())

    def testLiveGivesItsPartsWhatTheyAreToHave(self):
        params = loadWith({'overrides': 'wheels: {max_apart: 0.11}',
                           'detection_overrides': 'blink: {rate: 7.5}',
                           'drive_overrides': 'limits: {wheel_speed: 0.05}'},
                          os.path.join(REPOSITORY, 'launch', 'live.launch'),
                          'drive:=true', 'wheel_separation:=0.4', 'sensor_frame:=eye')
        expected = {'/calibration/wheels/separation': 0.4, '/calibration/wheels/max_apart': 0.11,
                    '/calibration_drive/wheels/separation': 0.4,
                    '/calibration_drive/wheels/max_apart': 0.11,
                    '/calibration_drive/limits/wheel_speed': 0.05,
                    '/calibration/frames/sensor': 'eye', '/light_detection/frames/sensor': 'eye',
                    '/light_detection/blink/rate': 7.5}
        self.assertEqual({name: params[name].value for name in expected}, expected)
        self.assertNotIn('/light_detection/wheels/separation', params)

    def testNamesMayBeDigits(self):
        parameters = load(os.path.join(REPOSITORY, 'launch', 'calibrate.launch'), 'result_folder:=2026',
                          'left_joint:=1', 'base_frame:=0').params
        for name, value in (('output/folder', '2026'), ('wheels/left_joint', '1'), ('frames/base', '0')):
            self.assertEqual(parameters['/calibration/' + name].value, value)

    def testTheDriveTakesItsParametersFromTheRobotsFileToo(self):
        params = loadWith({'robot': 'region: {radius: 0.7}\nlimits: {wheel_speed: 0.06}',
                           'overrides': 'limits: {wheel_speed: 0.05}'},
                          os.path.join(REPOSITORY, 'launch', 'drive.launch'))
        self.assertEqual(params['/calibration_drive/region/radius'].value, 0.7)
        self.assertEqual(params['/calibration_drive/limits/wheel_speed'].value, 0.05)

    def testReplayPlaysCompressedImages(self):
        config = load(os.path.join(REPOSITORY, 'launch', 'replay.launch'),
                      'image_transport:=compressed', 'image:=/eye/image_raw')
        player, = [node for node in config.nodes if node.name == 'player']
        self.assertIn('/eye/image_raw/compressed', player.args.split())
        self.assertEqual(config.params['/light_detection/image_transport'].value, 'compressed')

    def testReplayPlaysTheCameraInfoOfTheImage(self):
        """By default the one beside it, which the detection reads; another one takes its place."""
        for arguments, played in (([], '/eye/camera_info'), (['camera_info:=/lens'], '/lens')):
            config = load(os.path.join(REPOSITORY, 'launch', 'replay.launch'), 'image:=/eye/image_raw',
                          *arguments)
            nodes = {node.name: node for node in config.nodes}
            self.assertIn(played, nodes['player'].args.split())
            remaps = dict(nodes['light_detection'].remap_args)
            self.assertEqual(remaps['/eye/camera_info'], played)

    def testReplayPlaysBearingsOnlyWhereNoneAreDetected(self):
        for detect, is_played in (('true', False), ('false', True)):
            config = load(os.path.join(REPOSITORY, 'launch', 'replay.launch'),
                          'bearings:=/eye/bearings', 'detect:=' + detect)
            player, = [node for node in config.nodes if node.name == 'player']
            self.assertEqual('/eye/bearings' in player.args.split(), is_played)

    def testBagsMayHaveSpacesInTheirNames(self):
        for launch, name, word in (('replay.launch', 'player', '--bags=/tmp/a robot\'s/a.bag'),
                                   ('demo.launch', 'recorder', '/tmp/a robot\'s/a.bag')):
            config = load(os.path.join(REPOSITORY, 'launch', launch), "bag:=/tmp/a robot's/a.bag")
            node, = [node for node in config.nodes if node.name == name]
            self.assertIn(word, shlex.split(node.args))

    def testTheirNodeletsAreDeclared(self):
        loaded = set()
        for path in LAUNCH_FILES:
            for node in load(path).nodes:
                loaded.update(re.findall(r'bearing_calibration/\w+', node.args))
        self.assertTrue(loaded)
        self.assertLessEqual(loaded, declaredNodelets())

    def testTheirArgumentsAreDocumented(self):
        for path in LAUNCH_FILES:
            for argument in ElementTree.parse(path).getroot().findall('arg'):
                if argument.get('value') is None:  # those with a value are no arguments to the user
                    with self.subTest(launch=os.path.basename(path), arg=argument.get('name')):
                        self.assertTrue(argument.get('doc'))

    def testTheirOtherFilesExist(self):
        for path in LAUNCH_FILES:
            with open(path) as file:
                names = re.findall(r'\$\(find bearing_calibration\)/([\w./-]+)', file.read())
            for name in names:
                with self.subTest(launch=os.path.basename(path), file=name):
                    self.assertTrue(os.path.exists(os.path.join(REPOSITORY, name)))


class ConfigFiles(unittest.TestCase):

    def testEveryOneIsLoadedByALaunchFile(self):
        texts = ''
        for path in LAUNCH_FILES:
            with open(path) as file:
                texts += file.read()
        unused = [path for path in CONFIG_FILES if os.path.basename(path) not in texts]
        self.assertEqual(unused, [])

    def testTheSimulatedRobotHasEveryRequiredNumberAsItIsSimulated(self):
        def numbers(*name):
            with open(os.path.join(REPOSITORY, 'config', *name)) as file:
                return {group + '/' + key: value for group, of_group in yaml.safe_load(file).items()
                        for key, value in of_group.items()}
        robot, simulated = numbers('robots', 'simulated.yaml'), numbers('simulation.yaml')
        required = {name for file in ('calibration.yaml', 'detection.yaml')
                    for name, value in numbers(file).items() if value == 'required'}
        self.assertEqual(required, set(robot))
        also = {'sensor/width': 'camera/width', 'sensor/height': 'camera/height',
                'lens/focal_length': 'camera/focal_length', 'lens/aperture': 'camera/aperture',
                'lens/focus_distance': 'camera/focus_distance', 'lens/pixel_pitch': 'camera/pixel',
                'mirror/half_angle': 'mirror/cone_half_angle', 'mirror/base_radius': 'mirror/radius',
                'mirror/centre_u': 'camera/centre_u', 'mirror/centre_v': 'camera/centre_v'}
        own = {'mask/inner_radius', 'mask/outer_radius', 'mask/last_row'}  # of the detector alone
        for name in required - own:
            self.assertEqual(robot[name], simulated[also.get(name, name)], name)

    def testPlotJugglersLayoutPlotsNumbersOfTheEstimate(self):
        kinds = dict(zip(CalibrationEstimate.__slots__, CalibrationEstimate._slot_types))
        topic, = ['/%s/estimate' % node.name for node in load(os.path.join(REPOSITORY, 'launch', 'calibrate.launch')).nodes
                  if 'CalibrationNodelet' in node.args]
        layout = ElementTree.parse(os.path.join(REPOSITORY, 'config', 'plotjuggler.xml')).getroot()
        made = {snippet.get('name'): snippet for snippet in layout.iter('snippet')}
        curves = [curve.get('name') for curve in layout.iter('curve')]
        self.assertLessEqual(set(made), set(curves))
        sources = [source.text for snippet in made.values()
                   for source in [snippet.find('linked_source')] + list(snippet.find('additional_sources'))]
        self.assertEqual(len(sources), 2 * len(made))
        for name in sources + [name for name in curves if name not in made]:
            with self.subTest(name=name):
                self.assertEqual(os.path.dirname(name), topic)
                self.assertIn(kinds.get(os.path.basename(name)), ('float64', 'uint8'))
        for splitter in layout.iter('DockSplitter'):
            self.assertEqual(int(splitter.get('count')), len(splitter))
            self.assertEqual(len(splitter.get('sizes').split(';')), len(splitter))

    def testNumbersAreNumbers(self):
        """YAML 1.1 reads 1e-6 as text: it wants a point."""
        def check(name, value):
            if isinstance(value, dict):
                for key, inner in value.items():
                    check('%s/%s' % (name, key), inner)
            elif isinstance(value, str):
                self.assertNotRegex(value, r'^[-+.0-9]+(e[-+0-9]+)?$', '%s is text' % name)
        for path in CONFIG_FILES:
            with open(path) as file:
                check(os.path.basename(path), yaml.safe_load(file))

    def testEveryParameterHasACommentAndEveryQuantityAUnit(self):
        """The comment stands beside the parameter or on the lines above it."""
        for path in CONFIG_FILES:
            with open(path) as file:
                lines = file.read().split('\n')
            above = ''
            for number, line in enumerate(lines, 1):
                if line.strip().startswith('#'):
                    above += line
                    continue
                parameter = PARAMETER.match(line)
                if parameter is not None and parameter.group('value'):
                    comment = (parameter.group('comment') or '') + above
                    with self.subTest(place='%s:%d: %s' % (os.path.basename(path), number, line)):
                        self.assertTrue(comment, 'has no comment')
                        value = yaml.safe_load(parameter.group('value'))
                        if isinstance(value, float) or value == 'required':
                            self.assertRegex(comment, UNIT, 'has no [unit]')
                above = ''


if __name__ == '__main__':
    unittest.main()
