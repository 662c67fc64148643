"""What scripts/run installs and builds before it starts a command, and that what is built stays."""

import glob
import os
import re
import shlex
import shutil
import signal
import subprocess
import tempfile
import time
import unittest
from unittest import mock

REPOSITORY = os.path.abspath(os.path.join(os.path.dirname(__file__), '..', '..'))
DOCUMENTS = [os.path.join(REPOSITORY, name) for name in ('README.md', 'CONTRIBUTING.md')] + glob.glob(
    os.path.join(REPOSITORY, 'doc', '**', '*.md'), recursive=True)
PROGRAMS = ['programs']
MEASURING = {'monte_carlo', 'fault_table', 'drive_table', 'render_rate', 'observability_table',
             'gallery_data'}
COMPARING = {'comparison_table'}  # needs Ceres, as benches and tests do
COMMANDS = ('roscore', 'roslaunch', 'rostopic', 'rosservice', 'rosbag', 'rosrun', 'rviz', 'rostest',
            'parallel', 'sbatch')  # stand-ins, so that nothing is started


class CopyOfTheScripts(unittest.TestCase):
    """The scripts in a folder of their own, whose programs note how they were called."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        self.build_folder = self.path('.build', 'release')
        cache = tempfile.TemporaryDirectory()
        self.addCleanup(cache.cleanup)
        patch = mock.patch.dict(os.environ, XDG_CACHE_HOME=cache.name)
        patch.start()
        self.addCleanup(patch.stop)
        # rosrun looks for programs in all of the repository, and finds those of one build only
        self.other_builds = os.path.join(cache.name, 'bearing_calibration') + self.folder
        self.log = self.path('log')
        shutil.copytree(os.path.join(REPOSITORY, 'scripts'), self.path('scripts'))
        os.mkdir(self.path('stand_ins'))
        with open(self.path('scripts', 'environment.sh'), 'a') as file:
            file.write('PATH="%s:$PATH"\n' % self.path('stand_ins'))

    def path(self, *names):
        return os.path.join(self.folder, *names)

    def standIn(self, path, then='exit 0'):
        with open(path, 'w') as file:
            file.write('#!/bin/sh\necho "${0##*/} $*" >> "%s"\n%s\n' % (self.log, then))
        os.chmod(path, 0o755)

    def call(self, *command):
        """Calls of the stand-ins, those of cmake without what is the same for all."""
        if os.path.exists(self.log):
            os.remove(self.log)
        done = subprocess.run(command, cwd=self.folder, stdin=subprocess.DEVNULL,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                              universal_newlines=True, timeout=300)
        self.assertEqual(done.returncode, 0, done.stdout)
        with open(self.log) as file:
            return [line.split() for line in file]

    def assertOneWaits(self, script, *runner):
        """Of two runs of a script at once, as `runner` notices, a program that it runs."""
        self.standIn(os.path.join(*runner), 'mkdir "{0}" || echo there is another >> "{1}"\nsleep 1\n'
                     'rmdir "{0}"'.format(self.path('runs'), self.log))
        runs = [subprocess.Popen([self.path('scripts', script)], stdin=subprocess.DEVNULL,
                                 stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                 universal_newlines=True) for _ in range(2)]
        said = ''.join(run.communicate(timeout=60)[0] for run in runs)
        self.assertEqual([run.returncode for run in runs], [0, 0], said)
        with open(self.log) as file:
            self.assertNotIn('there is another', file.read())
        self.assertEqual(said.count('Waiting for another ./scripts/%s in this clone' % script), 1, said)


class Run(CopyOfTheScripts):
    """After scripts/demo, which leaves a build folder without tests."""

    def setUp(self):
        super().setUp()
        os.makedirs(os.path.join(self.build_folder, 'devel'))
        with open(os.path.join(self.build_folder, 'CMakeCache.txt'), 'w') as file:
            file.write('CATKIN_ENABLE_TESTING:BOOL=OFF\nCMAKE_BUILD_TYPE:STRING=Release\n'
                       'CMAKE_HOME_DIRECTORY:INTERNAL=%s\n' % self.folder)
        for name in ('build.ninja', os.path.join('devel', 'setup.bash')):
            with open(os.path.join(self.build_folder, name), 'w'):
                pass
        for name in ('tools', 'bench'):
            os.symlink(os.path.join(REPOSITORY, name), self.path(name))
        self.standIn(self.path('scripts', 'install_dependencies'))
        for name in COMMANDS + ('cmake',):
            self.standIn(self.path('stand_ins', name))

    def whatItTakes(self, command):
        """Arguments of install_dependencies and of cmake to configure, and the targets."""
        words = command if isinstance(command, list) else shlex.split(command)
        packages, configured, targets = [], [], []
        for name, *arguments in self.call(self.path('scripts', 'run'), *words):
            if name == 'install_dependencies':
                packages.append(arguments)
            elif name == 'cmake' and arguments[0] == '--build':
                targets += arguments[arguments.index('--target') + 1:]
            elif name == 'cmake':
                configured += arguments[arguments.index('-B') + 2:]
        self.assertEqual(len(packages), 1)
        return packages[0], configured, targets

    def assertTakesNothingMore(self, command):
        self.assertEqual(self.whatItTakes(command), (['--to-use'], [], PROGRAMS), command)

    def testWhatAnOwnerStartsTakesNothingMoreThanTheDemo(self):
        for command in ('roscore', 'rosbag --help', 'env', 'rosrun tf2_tools echo.py',
                        'rosrun bearing_calibration calibrate_bag drive.bag --output result',
                        'rosrun bearing_calibration watch --once', 'python3 --version',
                        'roslaunch bearing_calibration calibrate.launch rviz:=false',
                        'parallel rosrun bearing_calibration calibrate_bag {} ::: a.bag'):
            with self.subTest(command=command):
                self.assertTakesNothingMore(command)

    def testWhatWasStoppedWhileItWasConfiguredIsConfiguredAgain(self):
        os.remove(os.path.join(self.build_folder, 'build.ninja'))
        _, configured, targets = self.whatItTakes('env')
        self.assertIn('-DCATKIN_ENABLE_TESTING=OFF', configured)
        self.assertEqual(targets, PROGRAMS)

    def testOfTwoAtOnceTheOneThatFailsSaysWhatItsBuildHasSaid(self):
        self.assertTakesNothingMore('true')
        run, second = self.path('scripts', 'run'), self.path('second')
        self.standIn(self.path('stand_ins', 'cmake'), 'echo an error\nmkdir "%s" || exit 0\n'
                     '"%s" rmdir "%s" > "%s.log" 2>&1 &\nsleep 1\nexit 1' % (second, run, second, second))
        done = subprocess.run([run, 'true'], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                              universal_newlines=True, timeout=60)
        self.assertIn('an error\nrun: the build failed', done.stdout)
        deadline = time.monotonic() + 60
        while os.path.exists(second) and time.monotonic() < deadline:
            time.sleep(0.1)
        self.assertFalse(os.path.exists(second), 'the other one does not run its command')

    def testACommandStillFindsTheWorkspaceThatItsCallerHasSourced(self):
        devel = os.path.join(self.build_folder, 'devel')
        shutil.rmtree(devel)
        os.symlink(os.environ['CMAKE_PREFIX_PATH'].split(':')[0], devel)
        with tempfile.TemporaryDirectory() as workspace, mock.patch.dict(
                os.environ, CMAKE_PREFIX_PATH=workspace, PYTHONPATH=os.path.join(workspace, 'lib/python3/dist-packages')):
            os.makedirs(os.environ['PYTHONPATH'])
            with open(os.path.join(workspace, '.catkin'), 'w'):
                pass
            self.call(self.path('scripts', 'run'), 'sh', '-c', 'echo "sees $PYTHONPATH" >> ' + self.log)
            with open(self.log) as file:
                seen, = [line for line in file if line.startswith('sees ')]
            self.assertIn(os.environ['PYTHONPATH'], seen)
            self.assertIn(os.path.join(devel, 'lib/python3/dist-packages'), seen)

    def testWindowsAreInstalledAndNothingMoreIsBuilt(self):
        for command in ('rviz', 'rosrun rviz rviz', 'rviz --help',
                        'roslaunch bearing_calibration demo.launch rviz:=true'):
            with self.subTest(command=command):
                self.assertEqual(self.whatItTakes(command), ([], [], PROGRAMS))

    def testAProgramThatComparesWithOpenCvGetsAllOfIt(self):
        self.assertEqual(self.whatItTakes('rosrun bearing_calibration detection_table'),
                         ([], [], PROGRAMS + ['detection_table']))

    def testAProgramThatMeasuresIsBuiltBesideThem(self):
        for program in MEASURING:
            with self.subTest(program=program):
                self.assertEqual(self.whatItTakes('rosrun bearing_calibration %s --help' % program),
                                 (['--to-use'], [], PROGRAMS + [program]))

    def testSoIsTheOneOfAScriptThatMeasures(self):
        for script, program in (('tools/study/gallery.py', 'gallery_data'),
                                ('scripts/reference_pages.py', 'parameter_bounds')):
            self.assertEqual(self.whatItTakes('echo ' + script), ([], [], PROGRAMS + [program]))

    def testTestsAndBenchesAreAddedToTheBuildThatIsThere(self):
        for command, target in (('rostest bearing_calibration simulation.test', 'rostests'),
                                ('rosrun bearing_calibration filter_bench', 'filter_bench'),
                                ('rosrun bearing_calibration comparison_table --runs 2',
                                 'comparison_table')):
            with self.subTest(command=command):
                self.assertEqual(self.whatItTakes(command), (
                    [], ['-DCATKIN_ENABLE_TESTING=ON'], PROGRAMS + [target]))

    def testTheDocumentsCommandsBuildWhatTheyStart(self):
        checked = 0
        for path in DOCUMENTS:
            with open(path) as file:
                text = file.read().replace('\\\n', ' ')
            for command in re.findall(r'\./scripts/run (ros\w+ bearing_calibration [^`\n]*)', text):
                checked += 1
                words = [re.sub(r'\W*$', '', word) for word in command.split()]
                with self.subTest(document=os.path.relpath(path, REPOSITORY), command=command):
                    if words[0] == 'rostest':
                        continue
                    _, configured, targets = self.whatItTakes(words)
                    self.assertEqual(configured, ['-DCATKIN_ENABLE_TESTING=ON']
                                     if words[2] in COMPARING else [])
                    self.assertEqual(targets, PROGRAMS + [name for name in words[2:3]
                                                          if name in MEASURING | COMPARING])
        self.assertGreater(checked, 20)


class Build(CopyOfTheScripts):

    def setUp(self):
        super().setUp()
        for name in set(os.listdir(REPOSITORY)) - {'.build', '.git', 'scripts'}:
            os.symlink(os.path.join(REPOSITORY, name), self.path(name))
        cmake = shutil.which('cmake')
        self.standIn(self.path('stand_ins', 'cmake'), '[ "$1" = --build ] || exec %s "$@"' % cmake)

    def commandsOf(self, target='programs'):
        """How its objects are compiled, by object."""
        listed = subprocess.run(['ninja', '-C', self.build_folder, '-t', 'commands', target],
                                stdout=subprocess.PIPE, universal_newlines=True, check=True,
                                timeout=60).stdout
        return {re.search(r' -o (\S+)', line).group(1): line
                for line in listed.splitlines() if ' -c ' in line}

    def testTestsCompileNothingAnewThatIsThereToUse(self):
        if not shutil.which('ninja'):
            self.skipTest('ninja is not installed: its commands cannot be listed')
        self.call(self.path('scripts', 'build'), '--for-core')
        core = self.commandsOf('bearing_calibration_core')
        self.assertTrue(core)
        self.call(self.path('scripts', 'build'), '--to-use')
        self.assertEqual(self.commandsOf('bearing_calibration_core'), core)
        to_use = self.commandsOf()
        for library, above in [('core', 'src/'), ('vision', ''), ('simulation', ''), ('nodelets', '')]:
            folder = '%sCMakeFiles/bearing_calibration_%s.dir/' % (above, library)
            self.assertTrue([name for name in to_use if name.startswith(folder)], library)
        for target in ['calibrate_bag', 'calibrate_bag_parts', 'command_line', 'csv_to_bag',
                       'drive_instructions', 'find_mirror', 'recording_csv', 'render_scene',
                       'simulate_bag', 'simulated_scene']:
            folder = 'tools/CMakeFiles/%s.dir/' % target
            self.assertTrue([name for name in to_use if name.startswith(folder)], target)
        calls = self.call(self.path('scripts', 'build'), '--werror', 'all', 'tests')
        self.assertEqual([call[0:2] for call in calls], [['cmake', '-S'], ['cmake', '--build']])
        self.assertEqual(self.commandsOf(), to_use)
        for option in ('--to-use', '--for-core'):
            self.call(self.path('scripts', 'build'), option)
            self.assertEqual(self.commandsOf(), to_use)

    def testACopyOfABuiltCloneBuildsItself(self):
        self.call(self.path('scripts', 'build'), '--for-core')
        copy = self.path('copy')
        os.mkdir(copy)
        for name in set(os.listdir(self.folder)) - {'copy'}:
            subprocess.run(['cp', '-a', self.path(name), copy], check=True)
        build = (os.path.join(copy, 'scripts', 'build'), '--for-core')
        first, second = self.call(*build), self.call(*build)
        self.assertEqual([call[:2] for call in first], [['cmake', '-S'], ['cmake', '--build']])
        self.assertEqual([call[:3] for call in second], [['cmake', '--build', copy + '/.build/release']])
        with open(os.path.join(copy, '.build', 'release', 'CMakeCache.txt')) as file:
            self.assertIn('CMAKE_HOME_DIRECTORY:INTERNAL=%s\n' % copy, file.read())


class Demo(CopyOfTheScripts):
    """What scripts/demo does before the demo starts."""

    def setUp(self):
        super().setUp()
        self.standIn(self.path('scripts', 'install_dependencies'), 'test "$1" != --to-use || sleep 1')
        self.standIn(self.path('scripts', 'build'))
        self.standIn(self.path('stand_ins', 'python3'))
        os.makedirs(os.path.join(self.build_folder, 'devel'))
        with open(os.path.join(self.build_folder, 'devel', 'setup.bash'), 'w'):
            pass

    def callsOf(self, *arguments):
        return [' '.join(call[:2]) for call in self.call(self.path('scripts', 'demo'), *arguments)[:-1]]

    def testInstallsAndBuildsWhatItNeeds(self):
        built = ['install_dependencies --to-use', 'build --to-use']
        self.assertEqual(self.callsOf(), built)
        self.assertEqual(self.callsOf('rviz:=true'), ['install_dependencies', 'build --to-use'])

    def testCompilesTheCoreWhileRosIsInstalled(self):
        with open(self.path('scripts', 'environment.sh'), 'a') as file:
            file.write('command() { [[ "$2" != roslaunch ]]; }\n')
        calls = self.callsOf()
        self.assertEqual(calls[0], 'install_dependencies --for-core')
        self.assertEqual(sorted(calls[1:3]), ['build --for-core', 'install_dependencies --to-use'])
        self.assertEqual(calls[3:], ['build --to-use'])


class Dependencies(CopyOfTheScripts):
    """What scripts/install_dependencies asks whether it is there."""

    def askedOf(self, program, *arguments):
        calls = self.call(self.path('scripts', 'install_dependencies'), *arguments)
        self.assertEqual([call[0] for call in calls].count(program), 1, calls)
        return [word for call in calls for word in call]  # echo breaks a line at the format's \\n

    def testFuzzNeedsWhatBuildsAndItsOwn(self):
        with open(self.path('scripts', 'environment.sh'), 'a') as file:
            file.write('ros_setup=\n')
        self.standIn(self.path('stand_ins', 'dpkg-query'), 'shift 3\nprintf "installed %s\\n" "$@"')
        to_use = set(self.askedOf('dpkg-query', '--to-use'))
        self.assertLessEqual({'cmake', 'librosbag-dev'}, to_use)
        self.assertEqual(set(self.askedOf('dpkg-query', '--for-fuzz')),
                         to_use | {'clang', 'libclang-rt-dev', 'llvm'})

    def testRosdepIsNotAskedForTestsWhereThereAreNone(self):
        with open(self.path('scripts', 'environment.sh'), 'a') as file:
            file.write('ros_setup=/opt/ros/noetic/setup.bash\n')
        self.standIn(self.path('stand_ins', 'rosdep'))
        self.assertNotIn('-t', self.askedOf('rosdep'))
        asked = self.askedOf('rosdep', '--to-use')
        self.assertEqual([asked[i + 1] for i, word in enumerate(asked) if word == '-t'],
                         ['build', 'build_export', 'buildtool', 'exec'])


class Tests(CopyOfTheScripts):

    def testOfTwoRunsInACloneOneWaits(self):
        for name in ('install_dependencies', 'build'):
            self.standIn(self.path('scripts', name))
        self.standIn(self.path('stand_ins', 'python3'))
        os.makedirs(self.build_folder)
        self.assertOneWaits('test', self.path('stand_ins'), 'ctest')

    def testOfTwoRunsOfMutantsOneWaits(self):
        for name in ('install_dependencies', 'build', 'try_mutants.py'):
            self.standIn(self.path('scripts', name))
        os.makedirs(os.path.join(self.build_folder, 'devel', 'lib'))
        for name in (('setup.bash',), ('lib', 'libcore.so')):
            with open(os.path.join(self.build_folder, 'devel', *name), 'w'):
                pass
        self.assertOneWaits('mutants', self.path('stand_ins'), 'cmake')


class Sanitize(CopyOfTheScripts):
    """What scripts/sanitize makes of a run of tests."""

    def setUp(self):
        super().setUp()
        for name in ('install_dependencies', 'build'):
            self.standIn(self.path('scripts', name))

    def sanitize(self, ctest_does, *arguments):
        self.standIn(self.path('stand_ins', 'ctest'), ctest_does)
        return subprocess.run([self.path('scripts', 'sanitize'), *arguments], stdin=subprocess.DEVNULL,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                              universal_newlines=True, timeout=60)

    def testTestsThatPassWithoutAFindingAreNothingFound(self):
        done = self.sanitize('exit 0')
        self.assertEqual(done.returncode, 0, done.stdout)
        self.assertIn('Nothing found', done.stdout)
        with open(os.path.join(self.other_builds, 'thread', 'devel', 'lib', 'nodelet', 'nodelet')) as file:
            self.assertRegex(file.read(), r'LD_PRELOAD="/\S+libtsan.so [^"]+" \\\n +exec /\S+nodelet "\$@"')

    def testAFindingFailsAlsoWhereAllTestsPass(self):
        finding = os.path.join(self.other_builds, 'thread', 'findings', 'of.1')
        done = self.sanitize('echo A RACE > "%s"' % finding)
        self.assertNotEqual(done.returncode, 0)
        self.assertIn('A RACE', done.stdout)

    def testATestThatFailsFails(self):
        self.assertNotEqual(self.sanitize('exit 8').returncode, 0)

    def testEachBuildsTheTestsThatItRuns(self):
        with open(os.path.join(REPOSITORY, 'test', 'CMakeLists.txt')) as file:
            tests = set(re.findall(r'bearing_calibration_gtest\((\w+)', file.read()))
        for kind, option in (('thread', 'TSAN_OPTIONS'), ('address', 'ASAN_OPTIONS')):
            done = self.sanitize('echo "$%s"' % option, kind)
            self.assertEqual(done.returncode, 0, done.stdout)
            self.assertIn('log_path=' + os.path.join(self.other_builds, kind, 'findings'), done.stdout)
            with open(self.log) as file:
                calls = {line.split()[0]: line.split()[1:] for line in file}
            pattern = calls['ctest'][calls['ctest'].index('-R') + 1]
            run = {name for name in tests if re.search(pattern, '_ctest_bearing_calibration_gtest_' + name)}
            self.assertTrue(run)
            if kind == 'address':
                self.assertEqual((calls['build'], run), (['all', 'tests'], tests))
                with open(os.path.join(self.other_builds, kind, 'devel', 'lib', 'nodelet', 'nodelet')) as file:
                    self.assertRegex(file.read(), r'LD_PRELOAD="\S*libclang_rt\.asan\S*\.so ')
            else:
                self.assertEqual(set(calls['build']) - {'programs', 'rostests'}, run)

    def testARegexChoosesAmongItsTests(self):
        done = self.sanitize('test "$1" != -N || printf "  Test #1: _ctest_a_one\\n  Test #12: _ctest_a_two\\n"',
                             'thread', 'tw')
        self.assertEqual(done.returncode, 0, done.stdout)
        with open(self.log) as file:
            calls = [line.split() for line in file if line.startswith('ctest')]
        self.assertEqual(calls[-1][calls[-1].index('-R') + 1], '_ctest_a_two')
        self.assertIn('none of its tests matches', self.sanitize('exit 0', 'thread', 'three').stdout)

    def testATestThatItLeavesOutIsNoneOfIts(self):
        done = self.sanitize('case "$*" in *" -E "*soak*) ;; *) echo "  Test #1: _ctest_soak" ;; esac',
                             'thread', 'soak')
        self.assertNotEqual(done.returncode, 0)
        self.assertIn('none of its tests matches soak', done.stdout)

    def testOfTwoRunsOfAKindOneWaits(self):
        self.assertOneWaits('sanitize', self.path('stand_ins'), 'ctest')

    def testWrongArgumentsAreNamed(self):
        done = self.sanitize('exit 0', 'memory')
        self.assertNotEqual(done.returncode, 0)
        self.assertIn('usage: scripts/sanitize [thread|address] [REGEX]', done.stdout)


class Root(CopyOfTheScripts):

    @unittest.skipIf(os.geteuid() != 0, 'only root may mount')
    def testCtrlCLeavesNothingMounted(self):
        for name in ('proc', os.path.join('dev', 'pts')):
            os.makedirs(self.path('root', name))
            self.addCleanup(subprocess.run, ['umount', self.path('root', name)], stderr=subprocess.DEVNULL)
        self.standIn(self.path('stand_ins', 'chroot'), 'grep "%s" /proc/mounts\nsleep 60' % self.path('root'))
        with subprocess.Popen(['bash', '-c', 'set -euo pipefail; source "$0"; runInRoot "$@"',
                               self.path('scripts', 'environment.sh'), self.path('root'), 'true'],
                              stdout=subprocess.PIPE, universal_newlines=True, start_new_session=True) as run:
            self.assertIn(self.path('root', 'proc'), run.stdout.readline())
            self.assertIn(self.path('root', 'dev', 'pts'), run.stdout.readline())
            os.killpg(run.pid, signal.SIGINT)
        self.assertNotEqual(run.returncode, 0)
        with open('/proc/mounts') as mounts:
            self.assertNotIn(self.path('root'), mounts.read())


class Package(CopyOfTheScripts):

    def testAToolThatIsMissingIsNamed(self):
        for name in ('mktemp', 'rm'):
            os.symlink(shutil.which(name), self.path('stand_ins', name))
        self.standIn(self.path('stand_ins', 'dpkg-buildpackage'))
        with open(self.path('scripts', 'environment.sh'), 'a') as file:
            file.write('PATH="%s"\n' % self.path('stand_ins'))
        done = subprocess.run([self.path('scripts', 'package')], stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, universal_newlines=True, timeout=60)
        self.assertIn('install the tools first', done.stdout)


if __name__ == '__main__':
    unittest.main()
