#!/usr/bin/env python3
"""Draws doc/images/overview.png: the rig, and what a simulated drive (seed 1) tells of the mount.

The drive is that of simulate_bag with rendered images, the result that of calibrate_bag.
"""

import argparse
import csv
import math
import os
import subprocess
import sys
import tempfile

import matplotlib
matplotlib.use('Agg')  # no window
import matplotlib.pyplot as plt  # noqa: E402  (after the choice of the backend)
import numpy as np  # noqa: E402
import yaml  # noqa: E402
from matplotlib.patches import Circle, Ellipse, FancyBboxPatch, Polygon  # noqa: E402

REPOSITORY = os.path.abspath(os.path.join(os.path.dirname(os.path.realpath(__file__)), '..', '..'))
BLUE, RED, GREEN, LIGHT, GREY = '#1d6fb8', '#b3271e', '#1a7f1a', '#e8a200', '#4b5563'
SIZE_IN = (10.0, 4.3)
DPI = 200  # twice the size at which a page shows it
SIGMAS = 3
FONT_PT = 11  # 12 px and more where the picture is shown 850 px wide
CONE_HALF_ANGLE = math.radians(52.5)  # that of config/simulation.yaml
METADATA = {'Software': None}  # no version: the same picture has the same bytes


def run(program, *arguments):
    done = subprocess.run(['rosrun', 'bearing_calibration', program] + list(arguments),
                          stdout=subprocess.DEVNULL)
    if done.returncode != 0:
        sys.exit('overview: %s failed' % program)


def measure(folder):
    """(truth, result, details, images) of the drive."""
    bag, output = os.path.join(folder, 'drive.bag'), os.path.join(folder, 'result')
    run('simulate_bag', '--output', bag)
    run('calibrate_bag', bag, '--config', os.path.join(REPOSITORY, 'config', 'robots', 'simulated.yaml'),
        '--output', output, '--quiet')
    with open(os.path.join(REPOSITORY, 'config', 'simulation.yaml')) as file:
        truth = yaml.safe_load(file)['mount']
    with open(os.path.join(output, 'result.yaml')) as file:
        result = yaml.safe_load(file)
    with open(os.path.join(output, 'details.yaml')) as file:
        details = yaml.safe_load(file)
    with open(os.path.join(output, 'images.csv')) as file:
        images = list(csv.DictReader(file))
    return truth, result, details, images


def addEllipse(axes, at, covariance, **style):
    """Of three standard deviations."""
    values, vectors = np.linalg.eigh(covariance)
    width, height = 2 * SIGMAS * np.sqrt(values)
    angle = math.degrees(math.atan2(vectors[1, 0], vectors[0, 0]))
    axes.add_patch(Ellipse(at, width, height, angle=angle, **style))


def clean(axes, title):
    axes.set_title(title, fontsize=FONT_PT + 1, fontweight='bold', loc='left')
    axes.set_aspect('equal', adjustable='box')
    axes.set_anchor('NW')
    axes.set_xticks([])
    axes.set_yticks([])
    for spine in axes.spines.values():
        spine.set_visible(False)


def drawRig(axes):
    """From the side, not to scale; the ray is reflected as a cone of 52.5 deg does it."""
    clean(axes, 'The rig')
    middle, apex, reach = 0.42, 0.78, 0.24
    base = apex + reach / math.tan(CONE_HALF_ANGLE)
    axes.plot([-0.1, 1.75], [0, 0], color=GREY, linewidth=1)
    axes.add_patch(FancyBboxPatch((0.07, 0.12), 0.7, 0.22, boxstyle='round,pad=0,rounding_size=0.04',
                                  facecolor='#d1d5db', edgecolor=GREY))
    axes.add_patch(Circle((0.42, 0.13), 0.13, facecolor=GREY, edgecolor='white'))
    axes.add_patch(FancyBboxPatch((middle - 0.07, 0.34), 0.14, 0.13, facecolor='#374151',
                                  boxstyle='round,pad=0,rounding_size=0.02', edgecolor='none'))
    for side in (-1, 1):
        axes.plot([middle + side * reach] * 2, [0.34, base], color='#9ca3af', linewidth=1.5)
    axes.add_patch(Polygon([(middle, apex), (middle - reach, base), (middle + reach, base)],
                           facecolor='#bfdbfe', edgecolor=BLUE))
    lens = np.array([middle, 0.47])
    hit = np.array([middle + 0.06, apex + 0.06 / math.tan(CONE_HALF_ANGLE)])
    up = (hit - lens) / np.linalg.norm(hit - lens)
    normal = np.array([math.cos(CONE_HALF_ANGLE), -math.sin(CONE_HALF_ANGLE)])
    out = up - 2 * up.dot(normal) * normal
    light = hit + out * (1.55 - hit[0]) / out[0]
    axes.plot(*zip(light, hit, lens), color=LIGHT, linewidth=2)
    axes.plot([light[0]] * 2, [0, light[1]], color=GREY, linewidth=2)
    axes.plot(*light, marker='*', color=LIGHT, markersize=20, markeredgecolor='black')
    for text, at, align in (('conic mirror', (middle, base + 0.04), 'center'),
                            ('light', (light[0], light[1] + 0.11), 'center'),
                            ('camera', (0.72, 0.42), 'left'),
                            ('robot with two\nwheel encoders', (0.83, 0.12), 'left')):
        axes.text(*at, text, fontsize=FONT_PT, ha=align)
    axes.set_xlim(-0.1, 1.78)
    axes.set_ylim(-0.05, 1.12)


def drawRobot(axes, separation, radius, pose=(0.0, 0.0, 0.0)):
    x, y, yaw = pose
    R = np.array([[math.cos(yaw), -math.sin(yaw)], [math.sin(yaw), math.cos(yaw)]])
    axes.add_patch(Circle((x, y), 0.5 * separation, facecolor='#e5e7eb', edgecolor=GREY, zorder=2))
    for side in (-1, 1):
        corners = [(sx * radius, side * 0.5 * separation + sy * 0.25 * radius)
                   for sx, sy in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
        axes.add_patch(Polygon([R @ corner + (x, y) for corner in corners], color=GREY, zorder=3))


def drawDrive(axes, result, details, images):
    """From above, to scale, in the base frame of the first image."""
    clean(axes, 'The drive, from above')
    x, y, yaw = (np.array([float(row[name]) for row in images])
                 for name in ('base_x_m', 'base_y_m', 'base_yaw_rad'))
    axes.plot(x, y, color=BLUE, linewidth=2, zorder=4)
    settings, mount = details['settings'], result['base_from_camera']
    end = x[-1], y[-1], yaw[-1]
    drawRobot(axes, settings['wheel_separation_m'], settings['wheel_separation_m'] / 5, end)
    R = np.array([[math.cos(end[2]), -math.sin(end[2])], [math.sin(end[2]), math.cos(end[2])]])
    camera = R @ (mount['x'], mount['y']) + end[:2]
    light = details['light_in_first_base']['x'], details['light_in_first_base']['y']
    axes.plot(*zip(camera, light), color=LIGHT, linewidth=2, zorder=4)
    axes.plot(*camera, 'o', color=RED, markersize=5, zorder=5)
    axes.plot(*light, marker='*', color=LIGHT, markersize=20, markeredgecolor='black', zorder=5)
    axes.text(light[0], light[1] - 0.22, 'light, place\nnot known before', fontsize=FONT_PT,
              ha='center', va='top')
    axes.text(0.5 * (camera[0] + light[0]) - 0.06, 0.5 * (camera[1] + light[1]), 'bearing',
              fontsize=FONT_PT, ha='right', va='center')
    axes.text(np.min(x), np.max(y) + 0.1, 'path: straight, turn, repeat', fontsize=FONT_PT,
              color=BLUE)
    bar = np.max(x) - 0.25, 0.5 * (np.min(y) + light[1])
    axes.plot([bar[0], bar[0] + 0.5], [bar[1]] * 2, color='black', linewidth=2)
    axes.text(bar[0] + 0.25, bar[1] + 0.05, '0.5 m', fontsize=FONT_PT, ha='center')
    axes.set_xlim(np.min(x) - 0.25, np.max(x) + 0.3)
    axes.set_ylim(light[1] - 0.72, np.max(y) + 0.28)


def drawEstimate(axes, truth, result):
    """The true pose as an arrow; the estimate's ellipse and the directions that its yaw may have."""
    mount, stddev = result['base_from_camera'], result['stddev']
    axes.arrow(truth['x'], truth['y'], 0.1 * math.cos(truth['yaw']), 0.1 * math.sin(truth['yaw']),
               color=GREEN, width=0.0001, head_width=0.012, linewidth=2, zorder=5)
    axes.plot(truth['x'], truth['y'], 'o', color=GREEN, markersize=4, zorder=6)
    at = mount['x'], mount['y']
    for side in (-1, 1):
        yaw = mount['yaw'] + side * SIGMAS * stddev['yaw']
        axes.plot([at[0], at[0] + 0.13 * math.cos(yaw)], [at[1], at[1] + 0.13 * math.sin(yaw)],
                  color=RED, linewidth=1.2, zorder=6)
    addEllipse(axes, at, np.array(result['covariance_x_y_yaw'])[:2, :2], facecolor='none',
               edgecolor=RED, linewidth=1.5, zorder=7)


def drawMount(axes, truth, result, details):
    """From above, to scale, in the base frame."""
    clean(axes, 'The result: the mount')
    mount, stddev = result['base_from_camera'], result['stddev']
    separation = details['settings']['wheel_separation_m']
    drawRobot(axes, separation, separation / 5)
    for length, name, at in (((0.09, 0), 'x', (0.10, -0.005)), ((0, 0.09), 'y', (-0.012, 0.096))):
        axes.annotate('', length, (0, 0), arrowprops=dict(arrowstyle='->', color='black'), zorder=5)
        axes.text(*at, name, fontsize=FONT_PT, zorder=6)
    drawEstimate(axes, truth, result)
    lines = ['%-4s%6.2f ± %.2f cm   (%.2f)' % (name, 100 * mount[name], 100 * stddev[name],
                                               100 * truth[name]) for name in ('x', 'y')]
    lines.append('yaw %6.2f ± %.2f °    (%.2f)' % tuple(
        math.degrees(value) for value in (mount['yaw'], stddev['yaw'], truth['yaw'])))
    axes.text(-0.15, -0.172, '\n'.join(lines), fontsize=FONT_PT, family='monospace', va='top')
    axes.text(-0.15, 0.245, 'estimate, 3 standard deviations', fontsize=FONT_PT, color=RED, va='top')
    axes.text(-0.15, 0.215, 'truth', fontsize=FONT_PT, color=GREEN, va='top')
    axes.set_xlim(-0.16, 0.26)
    axes.set_ylim(-0.26, 0.25)


def main(arguments):
    parser = argparse.ArgumentParser(prog='overview', description=__doc__)
    parser.add_argument('output', help='folder to draw into, as doc/images')
    options = parser.parse_args(arguments)
    os.makedirs(options.output, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        truth, result, details, images = measure(folder)
    figure = plt.figure(figsize=SIZE_IN, facecolor='white')
    drawRig(figure.add_axes([0.01, 0.10, 0.35, 0.80]))
    drawDrive(figure.add_axes([0.385, 0.10, 0.26, 0.80]), result, details, images)
    drawMount(figure.add_axes([0.68, 0.10, 0.32, 0.80]), truth, result, details)
    figure.text(0.01, 0.025, 'Simulated, one run (seed 1, %.0f m): images are rendered, the light is '
                'detected in them. In brackets: the truth.' % details['motion']['path_m'],
                fontsize=FONT_PT, color=GREY)
    path = os.path.join(options.output, 'overview.png')
    figure.savefig(path, dpi=DPI, metadata=METADATA)
    print(path)


if __name__ == '__main__':
    main(sys.argv[1:])
