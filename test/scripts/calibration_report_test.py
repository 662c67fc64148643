"""calibration_report: a page that holds all it shows, right in a real browser."""

import html.parser
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

import matplotlib.image
import numpy
import roslib.packages
import rosbag
import rospy
from geometry_msgs.msg import PoseWithCovarianceStamped

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [os.path.join(HERE, '..', 'ros'), os.path.join(HERE, '..', '..', 'tools', 'owner')]
from calibration_world import SIMULATED_ROBOT, World, recordBag  # noqa: E402  (lies beside the nodes)
import calibration_report  # noqa: E402
from report import data, plots, words  # noqa: E402  (lies beside the program)

REPORT = ['rosrun', 'bearing_calibration', 'calibration_report']
CHROMIUM = shutil.which('chromium') or shutil.which('chromium-browser')
FIGURES = ('estimates.png', 'sigmas.png', 'trajectory.png', 'residuals.png', 'nis.png', 'mount.png',
           'targets.png')
PNG = b'\x89PNG'

# Appended to a copy of the page: says what a browser made of it.
PROBE = """<script>
document.querySelectorAll('details').forEach(each => each.open = true);
window.addEventListener('load', () => {
  const images = [...document.images];
  const boxes = images.map(each => each.getBoundingClientRect());
  const overlaps = (a, b) => a.left < b.right - 1 && b.left < a.right - 1 &&
                             a.top < b.bottom - 1 && b.top < a.bottom - 1;
  let overlapping = 0;
  boxes.forEach((a, i) => boxes.slice(i + 1).forEach(b => { if (overlaps(a, b)) ++overlapping; }));
  document.title = 'PROBE images=' + images.length +
    ' broken=' + images.filter(each => each.naturalWidth < 400).length +
    ' overlapping=' + overlapping +
    ' overflow=' + (document.documentElement.scrollWidth - document.documentElement.clientWidth);
});
</script>"""


class Page(html.parser.HTMLParser):
    """What a page refers to, and its text."""

    def __init__(self, text):
        super().__init__()
        self.sources, self.text = [], ''
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self.sources += [value for name, value in attributes if name in ('src', 'href')]

    def handle_data(self, text):
        self.text += text


class CalibrationReport(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = folder.name
        drives = [recordBag(os.path.join(cls.folder, 'drive_%d.bag' % seed),
                            World(1000.0, seed=seed)) for seed in (1, 2)]
        cls.addPlan(drives[0])
        cls.single = cls.calibrate('single', drives[0])
        cls.double = cls.calibrate('double', *drives, '--compare')
        straight = World(1000.0)
        straight.STRAIGHT_S = 100.0
        cls.line = cls.calibrate('line', recordBag(os.path.join(cls.folder, 'line.bag'), straight,
                                                   seconds=20.0))
        cls.pages = {each: cls.makePage(each) for each in (cls.single, cls.double, cls.line)}

    @classmethod
    def addPlan(cls, path):
        """What a drive would have expected of its way ahead."""
        with rosbag.Bag(path, 'a') as bag:
            for second in range(1020, 1080, 10):
                expected = PoseWithCovarianceStamped()
                expected.header.stamp = rospy.Time(second)
                for entry in (0, 7, 35):
                    expected.pose.covariance[entry] = (20.0 / second) ** 2
                bag.write('/calibration_drive/expected_base_from_camera', expected,
                          expected.header.stamp)

    @classmethod
    def calibrate(cls, name, *arguments):
        program = roslib.packages.find_node('bearing_calibration', 'calibrate_bag')[0]
        output = os.path.join(cls.folder, name)
        subprocess.run([program, *arguments, '--config', SIMULATED_ROBOT, '--output', output],
                       stdout=subprocess.DEVNULL,
                       timeout=600)
        return output

    @classmethod
    def makePage(cls, folder):
        subprocess.run(REPORT + [folder], check=True, stdout=subprocess.DEVNULL,
                       timeout=600)
        with open(os.path.join(folder, 'report.html'), encoding='utf-8') as file:
            return file.read()

    def testHoldsEverythingItself(self):
        for page in self.pages.values():
            sources = Page(page).sources
            self.assertTrue(sources)
            for source in sources:
                self.assertTrue(source.startswith('data:image/png;base64,'), source[:60])
            written = re.sub(r'base64,[A-Za-z0-9+/=]+', '', page)  # a picture may spell anything
            self.assertNotIn('http', written.replace('http://www.ros.org', ''))

    def testARobotWithoutMatplotlibIsToldWhatIsMissing(self):
        with tempfile.TemporaryDirectory() as folder:
            with open(os.path.join(folder, 'matplotlib.py'), 'w') as file:
                file.write('raise ImportError("as if it were not installed")\n')
            path = os.pathsep.join([folder, os.environ.get('PYTHONPATH', '')])
            done = subprocess.run(REPORT + [self.single], stdout=subprocess.PIPE,
                                  stderr=subprocess.STDOUT, universal_newlines=True, timeout=600,
                                  env=dict(os.environ, PYTHONPATH=path))
        self.assertEqual(done.returncode, 1)
        self.assertIn('apt-get install python3-matplotlib', done.stdout)
        self.assertNotIn('Traceback', done.stdout)

    def testFiguresAreFilesToo(self):
        for name in FIGURES:
            with open(os.path.join(self.single, name), 'rb') as file:
                self.assertEqual(file.read(4), PNG)
        self.assertTrue(os.path.exists(os.path.join(self.double, 'comparison.png')))

    def testSaysWhatWasFoundAndHowSure(self):
        text = Page(self.pages[self.single]).text
        self.assertIn('CONVERGED', text)
        self.assertRegex(text, r'\u00b1 0\.\d\d deg')
        self.assertRegex(text, r'A light 3 m ahead is placed within \d+\.\d mm \(68 %\)')
        self.assertIn('Height, roll and pitch of the camera', text)
        self.assertIn('Turning on the spot', text)
        self.assertIn('<joint name="camera_joint" type="fixed">', text)
        self.assertRegex(text, r'Warnings\s+None\.')

    def testThePlansExpectationsAreThoseOfTheBag(self):
        with open(os.path.join(self.single, 'plans.csv')) as file:
            rows = [dict(zip(('t', 'x', 'y', 'yaw'), map(float, line.split(','))))
                    for line in file.read().split()[1:]]
        self.assertEqual(len(rows), 6)
        for row, second in zip(rows, range(1020, 1080, 10)):
            self.assertAlmostEqual(row['t'], second - 1000.0, delta=0.01)  # of the first image
            for name in ('x', 'y', 'yaw'):
                self.assertAlmostEqual(row[name], 20.0 / second, delta=1e-9)
        with open(os.path.join(self.line, 'plans.csv')) as file:
            self.assertEqual(len(file.read().split()), 1, 'the names alone')

    def testTheNamesOfBaseAndCameraDoNotOverlap(self):
        record = data.readRecord(self.single)
        for x, y in ((0.004, 0.003), (-0.004, 0.003), (0.0, 0.0), (0.03, 0.0), (-0.03, 0.0)):
            record.result['base_from_camera'].update(x=x, y=y)
            figure = plots.mountFigure(record)
            figure.canvas.draw()
            names = [text.get_window_extent() for text in figure.axes[0].texts if text.get_text()]
            self.assertEqual(len(names), 2)
            self.assertFalse(names[0].overlaps(names[1]), (x, y))

    def testNoLabelIsCutOff(self):
        record = data.readRecord(self.single)
        path = os.path.join(self.folder, 'labels.png')
        along = numpy.linspace(-1.5, 1.0, len(record.images['t_s']))
        record.images.update(base_x_m=along, base_y_m=along)
        for x, y in ((2.2, 1.4), (6.0, 1.0), (2.0, -8.0)):
            record.details['light_in_first_base'] = {'x': x, 'y': y}
            calibration_report.embedded(plots.trajectoryFigure(record), path)
            pixels = matplotlib.image.imread(path)[..., :3]
            for edge in (pixels[:2], pixels[-2:], pixels[:, :2], pixels[:, -2:]):
                self.assertEqual(edge.min(), 1.0, 'with the light at (%g, %g)' % (x, y))

    def testComparesSeveral(self):
        text = Page(self.pages[self.double]).text
        self.assertIn('with 3 degrees of freedom', text)
        self.assertIn('They agree.', text)
        self.assertIn('drive_1: CONVERGED', text)
        self.assertIn('drive_2: CONVERGED', text)

    def testYawsOnEitherSideOfAHalfTurnLieTogether(self):
        def mount(yaw):
            return {'name': 'with $_$', 'base_from_camera': {'x': 0.1, 'y': 0.0, 'yaw': yaw},
                    'stddev': {'x': 0.01, 'y': 0.01, 'yaw': 0.01}}
        figure = plots.comparisonFigure({'mounts': [mount(3.14), mount(-3.14)], 'together': mount(3.1415)})
        figure.canvas.draw()
        low, high = figure.axes[2].get_xlim()
        self.assertLess(high - low, 10.0, 'degrees')

    def testABagMayHaveANumberForItsName(self):
        bag = os.path.join(self.folder, '20261129.bag')
        shutil.copy(os.path.join(self.folder, 'drive_1.bag'), bag)
        page = Page(self.makePage(self.calibrate('dated', bag)))
        self.assertIn('Where the camera sits: 20261129', page.text)

    def testABagsNameIsReadAsItWasWrittenWhateverTheLocaleIs(self):
        bag = os.path.join(self.folder, 'M\u00fcnster.bag')
        shutil.copy(os.path.join(self.folder, 'drive_1.bag'), bag)
        folder = self.calibrate('named', bag)
        ascii_alone = dict(os.environ, LC_ALL='POSIX', PYTHONCOERCECLOCALE='0', PYTHONUTF8='0')
        done = subprocess.run(REPORT + [folder], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                              env=ascii_alone, timeout=600)
        self.assertEqual(done.returncode, 0, done.stderr)
        with open(os.path.join(folder, 'report.html'), encoding='utf-8') as file:
            self.assertIn('M\u00fcnster', file.read())

    def testLightsStandInTheOrderOfTheirNumbers(self):
        folder = os.path.join(self.folder, 'ordered')
        for number in (2, 10, 1):
            shutil.copytree(self.single, os.path.join(folder, 'drive_light_%d' % number))
            path = os.path.join(folder, 'drive_light_%d' % number, 'details.yaml')
            with open(path) as file:
                text = file.read()
            with open(path, 'w') as file:
                file.write(re.sub('(?m)^name: .*', 'name: light_%d' % number, text))
        self.assertEqual(re.findall(r'<summary>light_(\d+)', self.makePage(folder)), ['1', '2', '10'])

    def testADegenerateDriveIsSaidInPlainWords(self):
        text = Page(self.pages[self.line]).text
        self.assertIn('The mount is not observable with this motion', text)
        self.assertIn('Two different curvatures are needed', text)
        self.assertNotIn('<joint', text)

    def testADriveThatFitsNoMountIsNotBlamedOnItsMotion(self):
        record = data.readRecord(self.line)
        record.details['motion']['second_curvature_m'] = 50.0
        self.assertNotIn('curvatures', ' '.join(words.observable(record)))
        record.images['t_s'] = []
        self.assertEqual(words.observable(record), ['Nothing: no bearing was used.'])

    def testListsTheLightsOnWhichTheMountRests(self):
        record = data.readRecord(self.single)
        light = {'x_m': 1.5, 'y_m': -0.25, 'covariance_x_y': [[1e-4, 0.0], [0.0, 4e-4]], 'in_estimate': True,
                 'bearings_used': 321}
        record.result['lights'] = [dict(light, id=7), dict(light, y_m=2.0)]
        self.assertIn('Light 7, with 321 bearings, stands at x 1.500 \u00b1 0.010 m, y -0.250 \u00b1 0.020 m of '
                      'the base at the end.', words.observable(record))
        self.assertIn('Light without a number', ' '.join(words.observable(record)))

    def testSaysWhatElseWasEstimated(self):
        text = Page(self.pages[self.single]).text
        for error in ('time offset', 'left wheel scale', 'bearing noise factor', 'wheel noise factor'):
            self.assertRegex(text, error + r'-?\d+\.\d\d [ms%]*\s*\u00b1 \d+\.\d\d')
        record = data.readRecord(self.single)
        for block in record.result['blocks']:
            if block['name'] == 'wheel_scales':
                block['value']['right_wheel_scale'] = -0.12
        self.assertEqual([warning for warning in words.warningsOf(record) if 'Wheel scales' in warning],
                         ['Wheel scales: 4.0 times errors/wheel_scales_stddev off what is configured: measure '
                          'the wheels and their separation, for all lengths may be as wrong.'])

    def testItGoesWithItsResult(self):
        """What is kept, because another mount was found, is kept with its report."""
        folder = os.path.join(self.folder, 'moved')
        for name, sensor in (('before', (0.15, 0.08, 0.2)), ('after', (0.1, 0.08, 0.2))):
            world = World(1000.0)
            world.sensor = sensor
            self.calibrate('moved', recordBag(os.path.join(self.folder, name + '.bag'), world,
                                              seconds=60.0))
            page = Page(self.makePage(folder)).text
            self.assertIn('Where the camera sits: ' + name, page, 'it is of the newest alone')
        for part in ('1', ''):
            self.assertLessEqual({'report.html', *FIGURES},
                                 set(os.listdir(os.path.join(folder, part))))
        with open(os.path.join(folder, '1', 'report.html'), encoding='utf-8') as file:
            self.assertIn('Where the camera sits: before', file.read())

    def testShowsTheLastCalibrationsBagsAlone(self):
        drives = [os.path.join(self.folder, 'drive_%d.bag' % seed) for seed in (1, 2)]
        three = ['drive_1', 'drive_2', 'third']
        third = shutil.copy(drives[0], os.path.join(self.folder, 'third.bag'))
        for bags, shown in ((drives + [third], three), (drives, three[:2]), (drives[1:], ['drive_2']),
                            (drives[::-1], three[1::-1])):
            page = self.makePage(self.calibrate('in_turn', *bags))
            names = re.findall(r'<summary>(\w+): CONVERGED|<title>Where the camera sits: (\w+)</title>', page)
            self.assertEqual([several or alone for several, alone in names], shown)

    def testIsMadeInTheSubfolderThatCalibrateBagHasTaken(self):
        folder = os.path.join(self.folder, 'others')
        os.mkdir(folder)
        with open(os.path.join(folder, 'report.html'), 'w') as file:
            file.write('not of this package')
        self.calibrate('others', os.path.join(self.folder, 'drive_1.bag'))
        self.assertEqual(self.makePage(folder), 'not of this package')
        self.assertIn('report.html', os.listdir(os.path.join(folder, 'bearing_calibration')))

    def testAFolderOfSomethingElseIsRefused(self):
        done = subprocess.run(REPORT + [HERE], stderr=subprocess.PIPE, timeout=600,
                              universal_newlines=True)
        self.assertEqual(done.returncode, 1)
        self.assertIn('nothing that calibrate_bag has written', done.stderr)

    def testADamagedFileIsNamed(self):
        for name in ('details.yaml', 'result.yaml', 'images.csv'):
            folder = os.path.join(self.folder, 'damaged_' + name)
            shutil.copytree(self.single, folder)
            with open(os.path.join(folder, name), 'w'):
                pass
            done = subprocess.run(REPORT + [folder], stderr=subprocess.PIPE, timeout=600,
                                  universal_newlines=True)
            self.assertEqual(done.returncode, 1)
            self.assertRegex(done.stderr, r'calibration_report: .*%s is empty' % name)

    def probe(self, page, width):
        path = os.path.join(self.folder, 'probe.html')
        with open(path, 'w', encoding='utf-8') as file:
            file.write(page.replace('</body>', PROBE + '</body>'))
        with tempfile.TemporaryDirectory() as profile:
            done = subprocess.run(
                [CHROMIUM, '--headless', '--no-sandbox', '--disable-gpu', '--no-first-run',
                 '--disable-background-networking', '--disable-component-update', '--disable-sync',
                 '--disable-quic', '--user-data-dir=' + profile, '--window-size=%d,1000' % width,
                 '--virtual-time-budget=5000', '--dump-dom', 'file://' + path],
                stdout=subprocess.PIPE, stderr=subprocess.PIPE, universal_newlines=True, timeout=600)
        found = re.search(r'<title>PROBE ([^<]*)</title>', done.stdout)
        self.assertTrue(found, done.stderr[-2000:])
        return dict(pair.split('=') for pair in found.group(1).split())

    @unittest.skipUnless(CHROMIUM, 'chromium is not installed: the page is not shown in a browser')
    def testABrowserShowsEveryFigureAndNothingOverlaps(self):
        for folder, images in ((self.single, 7), (self.double, 15), (self.line, 1)):
            for width in (1200, 600):
                with self.subTest(folder=folder, width=width):
                    self.assertEqual(self.probe(self.pages[folder], width),
                                     {'images': str(images), 'broken': '0', 'overlapping': '0',
                                      'overflow': '0'})


if __name__ == '__main__':
    unittest.main()
