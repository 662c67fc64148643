"""package.xml declares what is used directly: the packages of every header, Python module and launched
node, for those who need it, and nothing else."""

import glob
import os
import re
import sys
import unittest
import xml.etree.ElementTree as ElementTree

REPOSITORY = os.path.abspath(os.path.join(os.path.dirname(__file__), '..', '..'))

OWN_FOLDERS = {'bearing_calibration', 'bearing_calibration_ros', 'bench', 'fuzz', 'support', 'tools'}
# Headers whose package has another name than their folder; the first that begins the path.
PACKAGES_OF_HEADERS = (
    ('Eigen/', 'eigen'), ('unsupported/Eigen/', 'eigen'), ('opencv2/', 'libopencv-dev'),
    ('boost/program_options', 'libboost-program-options-dev'), ('boost/', 'libboost-dev'),
    ('ceres/', 'libceres-dev'), ('console_bridge/', 'libconsole-bridge-dev'), ('XmlRpc', 'xmlrpcpp'),
    ('ros/package.h', 'roslib'), ('ros/', 'roscpp'), ('rosbag/', 'rosbag_storage'),
)
PACKAGES_OF_MODULES = {'jinja2': 'python3-jinja2', 'matplotlib': 'python3-matplotlib',
                       'numpy': 'python3-numpy', 'rospkg': 'python3-rospkg',
                       'sympy': 'python3-sympy', 'yaml': 'python3-yaml'}
# Used only where somebody asks for it and has it: said in package.xml.
ASKED_FOR = {'rviz', 'python3-matplotlib'}
# Used in other ways than by a header, a module or a launched node.
OTHERWISE = {
    'catkin': 'builds', 'message_generation': 'generates messages', 'message_runtime': 'what they need',
    'libboost-program-options': 'the library of the programs',
    'roslaunch': "roslaunch starts the launch files, and roslaunch.xmlloader's modules are tests'",
    'libopencv-dev': 'its libraries, too', 'liburdfdom-tools': 'check_urdf, in tests',
    'clang': 'clang++, in tests', 'python3-catkin-lint': 'catkin_lint, in tests', 'xvfb': 'Xvfb, in tests',
    'actionlib_msgs': "an action's messages", 'rosbag': 'rosbag play and record',
}
BUILD, EXPORT, RUN, TEST = 'build_depend', 'build_export_depend', 'exec_depend', 'test_depend'


def declared():
    """{package: the kinds of dependencies that it is}."""
    kinds = {}
    for element in ElementTree.parse(os.path.join(REPOSITORY, 'package.xml')).getroot():
        if element.tag.endswith('depend'):
            of_element = {BUILD, EXPORT, RUN} if element.tag == 'depend' else {element.tag}
            kinds.setdefault(element.text, set()).update(of_element)
    return kinds


def filesIn(folder, *endings):
    return [path for ending in endings
            for path in glob.glob(os.path.join(REPOSITORY, folder, '**', '*' + ending), recursive=True)]


def textOf(path):
    with open(path, encoding='utf-8') as file:
        return file.read()


def packageOfHeader(header):
    """None for this package's own headers, and for those of C, C++ and the system."""
    folder = header.split('/')[0]
    for beginning, package in PACKAGES_OF_HEADERS:
        if header.startswith(beginning):
            return package
    is_system = '/' not in header or folder in ('sys', 'bits')
    return None if folder in OWN_FOLDERS or is_system else folder


def modulesIn(path):
    return set(re.findall(r'^ *(?:import|from) (\w+)', textOf(path), re.M))


def packageOfModule(module, own):
    is_standard = module in sys.stdlib_module_names
    known_elsewhere = module in own or module in ('bearing_calibration', 'kobuki_msgs')  # made by a test
    return None if is_standard or known_elsewhere else PACKAGES_OF_MODULES.get(module, module)


class Dependencies(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        cls.declared = declared()
        cls.used = set()

    def assertDeclared(self, package, kinds, where):
        self.used.add(package)
        if package in ASKED_FOR:
            kinds = {TEST}
        self.assertTrue(self.declared.get(package, set()) & kinds,
                        '%s: %s is none of %s' % (where, package, ', '.join(sorted(kinds))))

    def checkHeaders(self):
        count = 0
        for folder, needed in (('include', (BUILD, EXPORT)), ('src', (BUILD,)), ('tools', (BUILD,)),
                               ('fuzz', (BUILD, TEST)), ('bench', (BUILD, TEST)),
                               ('test', (BUILD, TEST))):
            for path in filesIn(folder, '.h', '.cpp'):
                where = os.path.relpath(path, REPOSITORY)
                for header in set(re.findall(r'^#include [<"]([^>"]+)[>"]', textOf(path), re.M)):
                    package = packageOfHeader(header)
                    if package is None:
                        continue
                    count += 1
                    with self.subTest(file=where, header=header):
                        if folder == 'include':  # whoever includes it needs it, too
                            for kind in needed:
                                self.assertDeclared(package, {kind}, where)
                        else:
                            self.assertDeclared(package, set(needed), where)
        return count

    def checkModules(self):
        count = 0
        own = {os.path.splitext(os.path.basename(path))[0] for path in
               filesIn('tools', '.py') + filesIn('test', '.py') + filesIn('scripts', '.py')} | {'report'}
        for folder, needed in (('tools/owner', {RUN}), ('tools/study', {RUN, TEST}),
                               ('tools/paper', {RUN, TEST}), ('scripts', {RUN, TEST}),
                               ('bench', {RUN, TEST}), ('test', {RUN, TEST})):
            for path in filesIn(folder, '.py'):
                for module in modulesIn(path):
                    package = packageOfModule(module, own)
                    if package is None:
                        continue
                    count += 1
                    with self.subTest(file=os.path.relpath(path, REPOSITORY), module=module):
                        self.assertDeclared(package, needed, path)
        return count

    def checkLaunchedNodes(self):
        count = 0
        for path in filesIn('launch', '.launch'):
            for package in set(re.findall(r'pkg="(\w+)"', textOf(path))) - OWN_FOLDERS:
                count += 1
                with self.subTest(file=os.path.basename(path), package=package):
                    self.assertDeclared(package, {RUN}, path)
        return count

    @unittest.skipUnless(hasattr(sys, 'stdlib_module_names'), 'Python 3.10 and later list their modules')
    def testWhatIsUsedIsDeclaredAndNothingElse(self):
        self.assertGreater(self.checkHeaders(), 200)
        self.assertGreater(self.checkModules(), 80)
        self.assertGreater(self.checkLaunchedNodes(), 5)
        self.assertEqual(set(self.declared) - self.used - set(OTHERWISE), set())

    def testWindowsAndFiguresAreNotForcedOnARobot(self):
        for package in ASKED_FOR:
            self.assertEqual(self.declared[package], {TEST}, package)
        for path in filesIn('launch', '.launch'):
            for node in ElementTree.parse(path).iter('node'):
                if node.get('pkg') == 'rviz':
                    self.assertEqual(node.get('if'), '$(arg rviz)')


if __name__ == '__main__':
    unittest.main()
