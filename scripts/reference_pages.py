#!/usr/bin/env python3
"""Writes doc/reference/parameters.md, doc/reference/messages.md and doc/background/promises.md from what they describe:

    ./scripts/run scripts/reference_pages.py

A test (reference_pages) holds the pages against them, so neither can go stale.
"""

import os
import re
import subprocess
import sys
import textwrap

REPOSITORY = os.path.abspath(os.path.join(os.path.dirname(__file__), '..'))

CONFIGURATIONS = (
    ('calibration.yaml', 'Calibration', 'live.launch, calibrate.launch, replay.launch, demo.launch, calibrate_bag'),
    ('detection.yaml', 'Light detection', 'live.launch, detect.launch, replay.launch, demo.launch, calibrate_bag'),
    ('adapter.yaml', 'Bearing adapter', 'adapter.launch'),
    ('drive.yaml', 'Calibration drive', 'live.launch and drive.launch, with the groups `wheels` and `bearings` of the '
     'calibration'),
    ('simulation.yaml', 'Simulation', 'demo.launch, simulate_bag, render_scene'),
)
INTERFACES = (
    ('msg', 'WheelTicks', 'in: `wheel_ticks`'),
    ('msg', 'LightBearings', 'in: `bearings`; out: those of the light detection'),
    ('msg', 'LightBearing', 'one candidate in LightBearings'),
    ('msg', 'CalibrationEstimate', 'out: `~estimate` of the calibration'),
    ('msg', 'CalibrationLight', 'one light in CalibrationEstimate'),
    ('msg', 'RobotError', 'one error of the robot in CalibrationEstimate'),
    ('msg', 'PredictedBearing', 'out: `~predicted_bearing` of the calibration; in: the detection'),
    ('srv', 'FindMirror', '`~find_mirror` of the light detection'),
    ('srv', 'StartDrive', '`~start` of the drive'),
    ('action', 'CalibrationDrive', '`~drive` of the drive'),
)
PARAMETERS_HEAD = """# Parameters

Made from `config/*.yaml`, and the bounds from the code, by `scripts/reference_pages.py`: change the comments there. SI
units and radians. The launch files load these files first, then the numbers of your robot (`robot:=FILE`), then other
values of yours: `overrides:=FILE`, which in live.launch and replay.launch is the calibration's; the detection's is
`detection_overrides` there, the drive's `drive_overrides`. Where the default is `required` there is none: only you know
that number ([robots.md](../tutorials/robots.md), [camera.md](../tutorials/camera.md)). Bounds include their ends and
hold whatever else is set; where one parameter limits another, the error says so. Parameters that are missing, misspelt
or out of bounds stop the node, which lists all of them, with the bounds. Write only what differs into your file:

```yaml
wheels:
  separation: 0.40
converged: {position_stddev: 0.005}
```

`calibrate_bag` takes the same files by `--config`, and single values by `--set wheels/separation=0.40`.
`config/robots` has the files of known robots, and of [the simulated one](../../config/robots/simulated.yaml).
"""
MESSAGES_HEAD = """# Messages, services, actions

Made from `msg/`, `srv/` and `action/` by `scripts/reference_pages.py`. Units are in the names; an angle grows
counter-clockwise; NaN means "not known".

## Topics and services of the calibration

Those of the drive are in [driving.md](../how-to/driving.md).

| topic or service | type | |
|---|---|---|
| `wheel_ticks` | bearing_calibration/WheelTicks | in: both wheel counters, cumulative, with a stamp ([robots.md](../tutorials/robots.md)) |
| `joint_states` | sensor_msgs/JointState | in, instead (`wheel_source:=joint_states`): two joints by name |
| `left_ticks`, `right_ticks` | std_msgs/Int32 or similar | in, instead (`wheel_source:=separate_ticks`): one topic for each wheel |
| `odom` | nav_msgs/Odometry | in, instead (`wheel_source:=odometry`): the wheels' own odometry ([robots.md](../tutorials/robots.md)) |
| `bearings` | bearing_calibration/LightBearings | in: the candidates for the light in each image or scan |
| `~estimate` | bearing_calibration/CalibrationEstimate | out: the whole estimate ([result.md](../how-to/result.md)) |
| `~base_from_camera` | geometry_msgs/PoseWithCovarianceStamped | out: the pose in `base_link` with its 6x6 covariance |
| `~transform` | geometry_msgs/TransformStamped | out: the same pose as a transform |
| `~predicted_bearing` | bearing_calibration/PredictedBearing | out: the direction and distance at which the light is expected next |
| `~markers` | visualization_msgs/MarkerArray | out: robot, light, sensor, ellipses, ray and path for RViz ([live.md](../how-to/live.md)) |
| `/tf` | tf2_msgs/TFMessage | out, only with `publish_tf:=true` ([result.md](../how-to/result.md)); the start frame while somebody subscribes to `~markers` |
| `/diagnostics` | diagnostic_msgs/DiagnosticArray | out, once a second ([live.md](../how-to/live.md)) |
| `~reset` | std_srvs/Trigger | discards the estimate and starts again; a pause goes on |
| `~pause` | std_srvs/SetBool | true pauses the calibration: bearings are ignored; false, and nothing else, resumes it |
| `~save` | std_srvs/Trigger | writes `result.yaml`, the URDF joint and more ([result.md](../how-to/result.md)) |

## Topics and services of the light detection

| topic or service | type | |
|---|---|---|
| `image`, `camera_info` | sensor_msgs/Image, CameraInfo | in: raw, or `image/compressed` with `image_transport:=compressed` |
| `/tf_static` | tf2_msgs/TFMessage | in, with `mirror/kind: none`: the images' frame in the sensor's ([camera.md](../tutorials/camera.md)) |
| `predicted_bearing` | bearing_calibration/PredictedBearing | in: the calibration's `~predicted_bearing` |
| `bearings` | bearing_calibration/LightBearings | out: the candidates for the light in each image |
| `~annotated` | sensor_msgs/Image | out: the image with mask, light and rejected candidates, while somebody subscribes |
| `~advice` | std_msgs/String | out: what to change about focus and exposure ([camera.md](../tutorials/camera.md)) |
| `/diagnostics` | diagnostic_msgs/DiagnosticArray | out, once a second ([live.md](../how-to/live.md)) |
| `~find_mirror` | bearing_calibration/FindMirror | finds the mirror's rim in the newest image ([camera.md](../tutorials/camera.md)) |
| `~thresholds` | dynamic_reconfigure | changes thresholds while it runs ([live.md](../how-to/live.md)) |
"""

GROUP = re.compile(r'^([a-z_]\w*):\s*(?:#\s*(.*))?$')
PARAMETER = re.compile(r'^  ([a-z_]\w*):\s*([^#]*?)\s*(?:#\s*(.*))?$')
COMMENT = re.compile(r'^(\s*)#\s*(.*)$')


def readText(*path):
    with open(os.path.join(REPOSITORY, *path), encoding='utf-8') as file:
        return file.read()


def parametersOf(text):
    """[(group, what the group is, [[name, value, comment]])] of a configuration file."""
    groups, above = [], []
    for line in text.splitlines():
        group, parameter, comment = GROUP.match(line), PARAMETER.match(line), COMMENT.match(line)
        if comment:
            continues = groups and groups[-1][2] and len(comment.group(1)) > 2
            if continues:
                groups[-1][2][-1][2] += ' ' + comment.group(2)
            else:
                above.append(comment.group(2))
            continue
        if group:
            groups.append((group.group(1), group.group(2) or '', []))
        elif parameter:
            own = parameter.group(3) or ''
            groups[-1][2].append([parameter.group(1), parameter.group(2),
                                  ' '.join(above + [own]).strip()])
        above = []
    return groups


def cell(text):
    return text.replace('|', '\\|').replace('*', '\\*').replace('<', '&lt;')


def boundsOfParameters():
    """{(configuration file, name): its bounds}, as the code declares them."""
    told = subprocess.run(['rosrun', 'bearing_calibration', 'parameter_bounds'], stdout=subprocess.PIPE,
                          check=True, universal_newlines=True).stdout
    return {tuple(words[:2]): words[2] for words in (line.split(' ', 2) for line in told.splitlines())}


def parametersPage():
    bounds = boundsOfParameters()
    parts = [PARAMETERS_HEAD]
    for name, title, users in CONFIGURATIONS:
        parts.append('\n## %s\n\n[config/%s](../../config/%s), read by %s.\n' % (title, name, name, users))
        for group, about, rows in parametersOf(readText('config', name)):
            parts.append('\n### %s\n' % group)
            if about:
                parts.append('\n%s\n' % cell(about))
            parts.append('\n| parameter | default | bounds | |\n|---|---|---|---|\n')
            parts += ['| `%s/%s` | `%s` | %s | %s |\n' % (
                group, key, value, bounds.get((name, '%s/%s' % (group, key)), ''), cell(comment))
                      for key, value, comment in rows]
    return ''.join(parts)


def messagesPage():
    parts = [MESSAGES_HEAD]
    for folder, name, where in INTERFACES:
        path = '%s/%s.%s' % (folder, name, folder)
        parts.append('\n## %s\n\n[%s](../../%s), %s.\n\n```\n%s```\n'
                     % (name, path, path, where, readText(path)))
    return ''.join(parts)


PAGE_WIDTH = 120
# A test says above itself which promise it holds against which fault: "Promise refused: ticks that jump".
PROMISES = (
    ('refused', 'An input that cannot be right changes no estimate',
     'It is left out, counted by its reason in `~estimate` and in the diagnostics, and a warning names its topic '
     'and its value. Good input beside and after it is used.'),
    ('unharmed', 'What happens on every robot does not end the calibration',
     'The estimate goes on, and with it the motion; what could not be used is counted, what is missing is reported.'),
    ('honest', 'CONVERGED is not reported of a wrong mount',
     'The state is another one, or the mount is right; where a fault can be identified, the advice names it.'),
    ('kept', 'A result is not lost, not damaged and not replaced by a worse one',
     'What has been estimated is saved before the process ends. A kill leaves the file of before or the new one, '
     'whole. What is worse or of another mount is written beside.'),
    ('inside', 'No file outside of the configured folder is touched',
     'Nor one in it that this package did not write.'),
    ('stands', 'The robot does not move without a goal, and stops',
     'The last command is to stand, and the goal ends with the reason.'),
    ('alive', 'Nothing takes the nodelet manager down',
     'An exception ends at its callback, with an error message; the other nodelets go on, and so do other bags.'),
    ('named', 'What is wrong with a parameter or a file is said, all at once',
     'The program or nodelet ends with errors that name each of them, and writes nothing. While it runs, the values '
     'of before stay.'),
    ('bounded', 'Memory, time and the log are bounded',
     'What is too much is dropped and counted, the oldest first.'),
)
PROMISES_HEAD = """# Promises

Made from the tests by `scripts/reference_pages.py`: what never happens, and %d faults that tests try. Each row is a
test, which has a line `Promise NAME: FAULT` above it. What nobody has thought of is [fuzzed](../background/reliability.md).
"""
PROMISE = re.compile(r' *(?:#|//) Promise (\w+): (.+)')
TEST = re.compile(r' *def (test\w+)\(|TEST\w*\((\w+), (\w+)\)')


def promisesIn(text, path):
    """(promise, fault, name of the test) of each mark in a test's source."""
    found, marks = [], []
    for line in text.splitlines():
        mark, test = PROMISE.match(line), TEST.match(line)
        if mark:
            marks.append(mark.groups())
        elif test:
            name = test.group(1) or '.'.join(test.groups()[1:])
            found += [mark + (name,) for mark in marks]
            marks = []
        elif marks:
            raise ValueError('%s: a promise that stands above no test: %s' % (path, marks[0][1]))
    return found


def promisesPage():
    rows = {name: [] for name, _, _ in PROMISES}
    for folder, _, names in sorted(os.walk(os.path.join(REPOSITORY, 'test'))):
        for name in sorted(names):
            if not name.endswith(('_test.py', '_test.cpp')):
                continue
            path = os.path.relpath(os.path.join(folder, name), REPOSITORY)
            for promise, fault, test in promisesIn(readText(path), path):
                rows[promise].append('| %s | [%s](../../%s) |\n' % (cell(fault), test, path))
    parts = [PROMISES_HEAD % sum(map(len, rows.values()))]
    for promise, title, about in PROMISES:
        parts.append('\n## %s\n\n%s\n\n| fault | test |\n|---|---|\n' % (title, textwrap.fill(about, PAGE_WIDTH)))
        parts += rows[promise]
    return ''.join(parts)


PAGES = {'reference/parameters.md': parametersPage, 'reference/messages.md': messagesPage,
         'background/promises.md': promisesPage}


def main():
    for name, text in [(name, page()) for name, page in PAGES.items()]:
        with open(os.path.join(REPOSITORY, 'doc', name), 'w', encoding='utf-8') as file:
            file.write(text)
    return 0


if __name__ == '__main__':
    sys.exit(main())
