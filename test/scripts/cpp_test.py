"""The core library for C++ programs, as cpp.md has it: installed alone, found by CMake, and an
example that calibrates with it; the pages of its API."""

import concurrent.futures
import glob
import os
import re
import subprocess
import tempfile
import unittest

import roslib.packages

REPOSITORY = os.path.abspath(os.path.join(os.path.dirname(__file__), '..', '..'))
CHI_SQUARE_3_AT_999 = 16.27  # what the squared error stays below in 999 of 1000 honest runs


def buildFolder():
    program = roslib.packages.find_node('bearing_calibration', 'calibrate_bag')[0]
    return os.path.abspath(os.path.join(os.path.dirname(program), '..', '..', '..'))


def page():
    path, = glob.glob(os.path.join(REPOSITORY, 'doc', '**', 'cpp.md'), recursive=True)
    with open(path) as file:
        return file.read()


class CoreAlone(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        """Runs the page's commands as they stand there, but for the building of what is built; without
        any setup file."""
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = folder.name
        cls.prefix = os.path.join(cls.folder, 'bearing_calibration')
        os.symlink(os.path.join(REPOSITORY, 'examples'), os.path.join(cls.folder, 'examples'))
        commands = re.findall(r'^    ((?:cmake|core_only/).*)$', page(), re.M)
        assert len(commands) == 4, commands
        for command in commands:
            cls.said = cls.run_('bash', '-c', command.replace('.build/release', buildFolder()))

    @classmethod
    def run_(cls, *command):
        done = subprocess.run(
            command, cwd=cls.folder, env={'PATH': '/usr/bin:/bin', 'HOME': cls.folder},
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, universal_newlines=True, timeout=600)
        if done.returncode != 0:
            raise AssertionError('%s ended with %d:\n%s' % (command, done.returncode, done.stdout))
        return done.stdout

    def testTheExampleFindsItsMount(self):
        shown = re.search(r'```\n(CONVERGED.*?)```', page(), re.S).group(1)
        rows = r'^(\w+) +(\S+) \+- (\S+) (\w+) +\(true (\S+)\)'
        found = re.findall(rows, self.said, re.M)
        self.assertEqual(self.said.splitlines()[0], shown.splitlines()[0])
        self.assertEqual([(row[0], row[3], row[4]) for row in found],
                         [(row[0], row[3], row[4]) for row in re.findall(rows, shown, re.M)])
        self.assertEqual(len(found), 3, self.said)
        squared = sum(((float(value) - float(true)) / float(stddev))**2
                      for _, value, stddev, _, true in found)
        # the axes taken apart: at least a third of the true chi-square, so the bar is that high
        self.assertLess(squared, 3.0 * CHI_SQUARE_3_AT_999, self.said)

    def testItIsLinkedWithTheInstalledCoreAndNothingOfRos(self):
        linked = self.run_('ldd', os.path.join(self.folder, 'core_only', 'mount_of_a_drive'))
        self.assertIn(os.path.join(self.prefix, 'lib', 'libbearing_calibration_core.so'), linked)
        self.assertNotRegex(linked, 'libros|opencv|not found')
        libraries = {name for name in os.listdir(os.path.join(self.prefix, 'lib')) if '.so' in name}
        self.assertEqual(libraries, {'libbearing_calibration_core.so'})

    def testAProgramWhoseEigenAlignsOtherwiseIsNotLinked(self):
        """As -march=native does it on a machine that has the instructions."""
        build = os.path.join(self.folder, 'wider')
        self.run_('cmake', '-S', 'examples/core_only', '-B', build, '-DCMAKE_PREFIX_PATH=' + self.prefix,
                  '-DCMAKE_CXX_FLAGS=-DEIGEN_MAX_STATIC_ALIGN_BYTES=64')
        with self.assertRaisesRegex(AssertionError, 'undefined reference to .*EigenAlignedTo<64>'):
            self.run_('cmake', '--build', build)

    def testItIsConfiguredWhereThereIsNoRos(self):
        build = os.path.join(self.folder, 'alone')
        said = self.run_('cmake', '-S', REPOSITORY, '-B', build, '-DBEARING_CALIBRATION_CORE_ALONE=ON',
                         '-DCMAKE_DISABLE_FIND_PACKAGE_catkin=ON', '-DCMAKE_DISABLE_FIND_PACKAGE_OpenCV=ON')
        self.assertRegex(said, r'not used by the project:\s+CMAKE_DISABLE_FIND_PACKAGE_OpenCV\s+'
                         r'CMAKE_DISABLE_FIND_PACKAGE_catkin\s')  # nor asked for
        targets = self.run_('cmake', '--build', build, '--target', 'help')
        self.assertRegex(targets, r'\bbearing_calibration_core\b')
        self.assertNotIn('bearing_calibration_vision', targets)

    def testItAsksForCpp17(self):
        targets, = glob.glob(os.path.join(self.prefix, 'lib', 'cmake', '*', '*Targets.cmake'))
        with open(targets) as file:
            text = file.read()
        self.assertIn('INTERFACE_COMPILE_FEATURES "cxx_std_17"', text)
        for path in (REPOSITORY, buildFolder()):
            self.assertNotIn(path, text)  # it may be moved

    def testItHasAVersion(self):
        project = os.path.join(self.folder, 'versions')
        os.makedirs(project)
        with open(os.path.join(REPOSITORY, 'package.xml')) as file:
            major, minor, patch = map(int, re.search(r'<version>(\d+)\.(\d+)\.(\d+)<', file.read()).groups())
        for version, found in (('%d.%d' % (major, minor), 1), ('%d.%d.%d' % (major, minor, patch), 1), ('', 1),
                               ('%d.%d' % (major, minor + 1), 0), ('%d.%d.%d' % (major, minor, patch + 9), 0),
                               ('%d' % (major + 1), 0)):
            with open(os.path.join(project, 'CMakeLists.txt'), 'w') as file:
                file.write('cmake_minimum_required(VERSION 3.16)\nproject(versions LANGUAGES CXX)\n'
                           'find_package(bearing_calibration_core %s)\n'
                           'message("found: ${bearing_calibration_core_FOUND}")\n' % version)
            with self.subTest(version=version):
                self.assertIn('found: %d' % found, self.run_(
                    'cmake', '-S', project, '-B', os.path.join(project, 'build'),
                    '-DCMAKE_PREFIX_PATH=' + self.prefix))


class AnotherCompiler(unittest.TestCase):

    def testClangTakesWhatNeedsNoRos(self):
        """Users build with it, and scripts/fuzz does."""
        rooms = sorted(set(os.listdir(os.path.join(REPOSITORY, 'src'))) - {'CMakeLists.txt', 'ros'})
        self.assertIn('filter', rooms)
        with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
            for room, said in zip(rooms, pool.map(self.clangSaysOf, rooms)):
                with self.subTest(room=room):
                    self.assertEqual(said, (0, ''))

    def clangSaysOf(self, room):
        """Its return code and its words."""
        sources = sorted(glob.glob(os.path.join(REPOSITORY, 'src', room, '*.cpp')))
        self.assertNotEqual(sources, [])
        done = subprocess.run(
            ['clang++', '-std=c++17', '-Wall', '-Wextra', '-Wpedantic', '-Wshadow', '-fsyntax-only',
             '-I' + os.path.join(REPOSITORY, 'include'), '-isystem', '/usr/include/eigen3',
             '-isystem', '/usr/include/opencv4', '-x', 'c++', '-'],
            input=''.join('#include "%s"\n' % source for source in sources), timeout=600,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, universal_newlines=True)
        return done.returncode, done.stdout


class ApiPages(unittest.TestCase):

    def testTheyAreMadeWithoutAWarning(self):
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run([os.path.join(REPOSITORY, 'scripts', 'api_docs'), folder],
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                  universal_newlines=True, timeout=600)
            self.assertEqual(done.returncode, 0, done.stdout)
            with open(os.path.join(folder, 'html', 'index.html')) as file:
                linked = re.findall(r'href="(\w+\.html)', file.read())
            self.assertGreater(len(linked), 2)
            for name in linked:
                self.assertTrue(os.path.exists(os.path.join(folder, 'html', name)), name)


if __name__ == '__main__':
    unittest.main()
