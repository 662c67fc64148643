"""The Debian package's description and the workflows agree with the rest of the repository."""

import datetime
import email.utils
import glob
import os
import re
import subprocess
import tempfile
import unittest
import xml.etree.ElementTree as ElementTree

import yaml

REPOSITORY = os.path.abspath(os.path.join(os.path.dirname(__file__), '..', '..'))

# Sections of scripts/install_dependencies, and what debian/control takes of them.
BUILD_SECTIONS = ('libraries', 'ROS, to build')
RUN_SECTIONS = ('ROS, to run', 'the report')
RECOMMENDED_SECTIONS = ("ROS's command line", 'its figures')


def textOf(*path):
    with open(os.path.join(REPOSITORY, *path)) as file:
        return file.read()


def installedPackages():
    """{section: packages} of scripts/install_dependencies."""
    lists = re.findall(r'^packages_\w+=\((.*?)\n\)', textOf('scripts', 'install_dependencies'),
                       re.S | re.M)
    sections, current = {}, None
    for line in ''.join(lists).splitlines():
        if line.strip().startswith('#'):
            current = sections.setdefault(line.strip(' #').split(':')[0], set())
        elif line.strip():
            current.update(line.split())
    return sections


def relations(field):
    """Packages of a field of debian/control, without versions and ${...}."""
    found = re.search(r'^%s:((?:[^\n]*\n)(?: [^\n]*\n?)*)' % field, textOf('debian', 'control'), re.M)
    names = [part.strip().split(' ')[0] for part in found.group(1).split(',')]
    return {name for name in names if name and not name.startswith('${')}


class DebianPackage(unittest.TestCase):

    def setUp(self):
        self.sections = installedPackages()

    def packagesOf(self, names):
        return set().union(*(self.sections[name] for name in names))

    def testItsVersionIsThePackages(self):
        version = ElementTree.parse(os.path.join(REPOSITORY, 'package.xml')).findtext('version')
        first = textOf('debian', 'changelog').splitlines()[0]
        self.assertRegex(first, r'^bearing-calibration \(%s\) ' % re.escape(version))

    def testTheChangelogsNewestReleaseIsThePackages(self):
        """Below what is forthcoming, with the Debian package's date."""
        version = ElementTree.parse(os.path.join(REPOSITORY, 'package.xml')).findtext('version')
        newest = re.search(r'(?m)^(\d+\.\d+\.\d+) \((\d+)-(\d+)-(\d+)\)\n-+$', textOf('CHANGELOG.rst'))
        self.assertEqual(newest.group(1), version)
        date = datetime.date(*(int(number) for number in newest.groups()[1:]))
        said = re.search(r'(?m)^ -- .*>  (.*)$', textOf('debian', 'changelog')).group(1)
        self.assertEqual(email.utils.parsedate_to_datetime(said).date(), date)

    def testItIsBuiltWithWhatTheScriptsInstall(self):
        missing = self.packagesOf(BUILD_SECTIONS) - relations('Build-Depends')
        self.assertEqual(missing, set())

    def testItDependsOnWhatTheScriptsInstallToRun(self):
        self.assertEqual(self.packagesOf(RUN_SECTIONS) - relations('Depends'), set())
        self.assertEqual(self.packagesOf(RECOMMENDED_SECTIONS)
                         - relations('Depends') - relations('Recommends'), set())

    def testItDependsOnNothingThatTheScriptsDoNotKnow(self):
        known = set().union(*self.sections.values()) | {'debhelper-compat'}
        for field in ('Build-Depends', 'Depends', 'Recommends'):
            self.assertEqual(relations(field) - known, set(), field)

    def testItsLicenceIsTheRepositorys(self):
        def words(text):
            return re.sub(r'[\s.]+', ' ', text[text.index('Redistribution and use'):]).split()
        self.assertEqual(words(textOf('debian', 'copyright')), words(textOf('LICENSE')))

    def testTheToolsReadIt(self):
        said = subprocess.run(['dpkg-parsechangelog', '--show-field', 'Source'], cwd=REPOSITORY,
                              stdout=subprocess.PIPE, universal_newlines=True, check=True).stdout
        self.assertEqual(said.strip(), 'bearing-calibration')
        self.assertTrue(os.access(os.path.join(REPOSITORY, 'debian', 'rules'), os.X_OK))


class Workflows(unittest.TestCase):

    def setUp(self):
        self.jobs = {}
        for path in glob.glob(os.path.join(REPOSITORY, '.github', 'workflows', '*.yml')):
            workflow = yaml.safe_load(textOf(path))
            self.assertEqual(set(workflow[True]), {'push', 'pull_request'})  # "on", in YAML 1.1
            self.jobs.update(workflow['jobs'])

    def commandsOf(self, job):
        return [step['run'] for step in self.jobs[job]['steps'] if 'run' in step]

    def testEachStepRunsSomethingThatIsThere(self):
        self.assertTrue(self.jobs)
        for name, job in self.jobs.items():
            self.assertIn('runs-on', job)
            for step in job['steps']:
                with self.subTest(job=name, step=step):
                    self.assertEqual(len({'run', 'uses'} & set(step)), 1)
                    self.assertRegex(step.get('uses', 'a/b@c'), r'^[\w-]+/[\w-]+@\w+$')
                    for script in re.findall(r'\./([\w/]+)', step.get('run', '')):
                        self.assertTrue(os.access(os.path.join(REPOSITORY, script), os.X_OK), script)

    def testDebianRunsEveryTestInItsOwnContainer(self):
        self.assertEqual(self.jobs['debian']['container'], 'debian:${{ matrix.release }}')
        self.assertEqual(self.jobs['debian']['strategy']['matrix'], {'release': [12, 13]})
        self.assertIn('./scripts/test', self.commandsOf('debian'))
        self.assertEqual(self.jobs['debian-package']['container']['image'], 'debian:12')
        self.assertIn('./scripts/package --test', self.commandsOf('debian-package'))

    def testNoeticIsBuiltByIndustrialCi(self):
        noetic = self.jobs['noetic']
        self.assertEqual(noetic['env']['ROS_DISTRO'], 'noetic')
        self.assertTrue(any(step.get('uses', '').startswith('ros-industrial/industrial_ci@')
                            for step in noetic['steps']))

    def testRosOIsBuilt(self):
        self.assertEqual(self.jobs['ros-o']['container'], 'ubuntu:24.04')
        self.assertIn('./scripts/build', self.commandsOf('ros-o'))


class Environment(unittest.TestCase):

    def setupOf(self, *names):
        """The one that the scripts take where these are there; each says its own name."""
        with tempfile.TemporaryDirectory() as folder:
            for name in names:
                os.mkdir(os.path.join(folder, name))
                with open(os.path.join(folder, name, 'setup.bash'), 'w') as file:
                    file.write('said="$said %s"\n' % name)
            return subprocess.run(
                ['bash', '-euc', 'said=; source scripts/environment.sh; echo "$said"'],
                cwd=REPOSITORY, env=dict(os.environ, ros_folder=folder), check=True,
                stdout=subprocess.PIPE, universal_newlines=True).stdout.split()

    def testTakesTheRosThatIsThere(self):
        self.assertEqual(self.setupOf(), [])
        self.assertEqual(self.setupOf('noetic'), ['noetic'])
        self.assertEqual(self.setupOf('one'), ['one'])
        self.assertEqual(self.setupOf('noetic', 'one'), ['one'])
        self.assertEqual(self.setupOf('humble'), [])


if __name__ == '__main__':
    unittest.main()
