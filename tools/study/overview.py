#!/usr/bin/env python3
"""Draws doc/images/overview.png: the rig, and RViz when the calibration of demo.launch has converged."""

import argparse
import math
import os
import sys
import tempfile

import matplotlib
matplotlib.use('Agg')  # no window
import matplotlib.pyplot as plt  # noqa: E402  (after the choice of the backend)
import numpy as np  # noqa: E402
import yaml  # noqa: E402
from matplotlib.patches import Circle, FancyBboxPatch, Polygon  # noqa: E402

import rviz_screenshots  # noqa: E402

BLUE, LIGHT, GREY = '#1d6fb8', '#e8a200', '#4b5563'
SIZE_IN = (10.0, 4.35)
DPI = 200  # twice the size at which a page shows it
FONT_PT = 11  # 12 px and more where the picture is shown 850 px wide
CONE_HALF_ANGLE = math.radians(52.5)  # that of config/simulation.yaml
METADATA = {'Software': None}  # no version: the same picture has the same bytes


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


def drawScreen(figure, left, title, path, legend):
    """A picture of RViz, pixel by pixel, with the colours of its markers explained."""
    width, height = (size / DPI / whole for size, whole in zip(rviz_screenshots.FRONT, SIZE_IN))
    axes = figure.add_axes([left, 0.90 - height, width, height])
    clean(axes, title)
    axes.imshow(plt.imread(path), interpolation='none')
    for i, (colour, text) in enumerate(legend):
        y = -0.055 - 0.08 * i
        axes.text(0.0, y, '\u25a0', color=colour, fontsize=FONT_PT + 3, va='center_baseline',
                  transform=axes.transAxes)
        axes.text(0.07, y, text, fontsize=FONT_PT, va='center_baseline', transform=axes.transAxes)


def writeValues(figure, path):
    with open(path) as file:
        values = yaml.safe_load(file)
    lines = []
    for name, unit, scale, digits in (('x', 'mm', 1e3, 1), ('y', 'mm', 1e3, 1), ('yaw', '°', math.degrees(1), 2)):
        value, stddev, truth = (scale * values[name][key] for key in ('value', 'stddev', 'truth'))
        lines.append('%-4s%5.*f ± %.*f %-3s(%.*f)' % (name, digits, value, digits, stddev, unit, digits, truth))
    figure.text(0.01, 0.31, 'The mount (in brackets: the truth)', fontsize=FONT_PT, fontweight='bold')
    figure.text(0.01, 0.285, '\n'.join(lines), fontsize=FONT_PT, family='monospace', va='top')
    figure.text(0.01, 0.03, 'One simulated drive: the light is\ndetected in rendered images', fontsize=FONT_PT,
                color=GREY)


def main(arguments):
    parser = argparse.ArgumentParser(prog='overview', description=__doc__)
    parser.add_argument('output', help='folder to draw into, as doc/images')
    options = parser.parse_args(arguments)
    os.makedirs(options.output, exist_ok=True)
    figure = plt.figure(figsize=SIZE_IN, facecolor='white')
    drawRig(figure.add_axes([0.01, 0.10, 0.35, 0.80]))
    with tempfile.TemporaryDirectory() as folder:
        if rviz_screenshots.takeOnHiddenScreen('front', folder, rate=1.0) != 0:
            sys.exit('overview: there are no pictures of RViz')
        drawScreen(figure, 0.375, 'RViz: the drive, from above', os.path.join(folder, 'front_room.png'), (
            ('#57b5e8', 'driven path'), ('#e69e00', 'light, place found'), ('#f0e342', 'last bearing')))
        drawScreen(figure, 0.69, 'RViz: the mount', os.path.join(folder, 'front_mount.png'), (
            ('#f26b1a', 'estimate, 3 standard deviations'), ('#00bf73', 'truth')))
        writeValues(figure, os.path.join(folder, rviz_screenshots.VALUES))
    path = os.path.join(options.output, 'overview.png')
    figure.savefig(path, dpi=DPI, metadata=METADATA)
    print(path)


if __name__ == '__main__':
    main(sys.argv[1:])
