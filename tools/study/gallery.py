#!/usr/bin/env python3
"""Draws the pictures of doc/images from what gallery_data measures on rendered images."""

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
from matplotlib.patches import Circle, Ellipse  # noqa: E402

GREEN = '#3fd13f'
ORANGE = '#ff9f1c'
RED = '#ff5a4f'
BLUE = '#4c9be8'
DPI = 150  # one and a half times the 830 px at which a page shows it, where 9 pt are 12 px
PHOTOGRAPH_DPI = 120  # its grey levels take more bytes
WIDTH_IN = 8.3
# No date and no version in the files: the same pictures have the same bytes.
METADATA = {'Software': None}
plt.rcParams.update({'font.size': 9, 'axes.titlesize': 10})


def rowsOf(folder, name):
    with open(os.path.join(folder, name)) as file:
        return list(csv.DictReader(file))


def save(figure, folder, name, dpi=DPI):
    path = os.path.join(folder, name)
    figure.savefig(path, dpi=dpi, metadata=METADATA)
    plt.close(figure)
    print(path)


def drawFocus(data, output, images):
    """The same light through lenses of different focus, at one scale."""
    rows = rowsOf(data, 'focus.csv')
    figure, axes = plt.subplots(1, len(rows), figsize=(WIDTH_IN, 2.4), constrained_layout=True)
    for axis, row in zip(axes, rows):
        image = plt.imread(os.path.join(data, row['image']))
        axis.imshow(image, cmap='gray', vmin=0, vmax=1, interpolation='nearest')
        focus = float(row['focus_m'])
        axis.set_title('infinity' if focus > 1000 else '%g m' % focus)
        axis.set_xlabel('error %.4f°\nfound %.0f %%'
                        % (float(row['rmse_deg']), 100 * float(row['found'])))
        axis.set_xticks([])
        axis.set_yticks([])
    side = image.shape[0]
    figure.suptitle('One point light, 1 m away, by the distance that the lens is focused on\n'
                    '(simulated, %d images each, %d pixels a side)' % (images, side), fontsize=10)
    save(figure, output, 'focus.png')


def place(mask, azimuth_deg, radius_px):
    """Column and row of a point of the mirror's image."""
    azimuth = math.radians(azimuth_deg) * float(mask['handedness'])
    return (float(mask['column_px']) + radius_px * math.cos(azimuth),
            float(mask['row_px']) - radius_px * math.sin(azimuth))


def drawMask(axis, mask):
    centre = (float(mask['column_px']), float(mask['row_px']))
    for name, style in (('inner_px', '-'), ('outer_px', '-'), ('horizon_px', '--')):
        axis.add_patch(Circle(centre, float(mask[name]), fill=False, color=BLUE, linestyle=style))
    angle = 250
    axis.annotate('horizon', place(mask, angle, 1.04 * float(mask['horizon_px'])), color=BLUE,
                  ha='center', va='bottom')


def labelOffset(spot, places):
    """The one of four places beside a spot that is farthest from the labels that stand already."""
    column, row = spot
    offsets = [(12, -9), (-28, -9), (12, 22), (-28, 22)]
    best = max(offsets, key=lambda offset: min(
        [50.0] + [math.hypot(column + offset[0] - x, row + offset[1] - y) for x, y in places]))
    places.append((column + best[0], row + best[1]))
    return best


def drawSpot(axis, mask, spot, label, colour, places):
    """An ellipse where it was measured, a cross where not. `places` of labels grow by this one's."""
    column, row = float(spot['column_px']), float(spot['row_px'])
    radial, tangential = float(spot['radial_stddev_px']), float(spot['tangential_stddev_px'])
    if radial > 0 and tangential > 0:
        angle = math.degrees(math.atan2(row - float(mask['row_px']),
                                        column - float(mask['column_px'])))
        axis.add_patch(Ellipse((column, row), 4 * radial, 4 * tangential, angle=angle, fill=False,
                               color=colour, linewidth=1.6))
    else:
        axis.plot(column, row, 'x', color=colour, markersize=8, markeredgewidth=1.6)
    right, down = labelOffset((column, row), places)
    axis.annotate(label, (column + right, row + down), color=colour, fontsize=10, fontweight='bold')


def drawClutter(data, output):
    """A scene with what was accepted, and with what was rejected and why."""
    mask, = rowsOf(data, 'clutter_mask.csv')
    spots = rowsOf(data, 'clutter.csv')
    image = plt.imread(os.path.join(data, 'clutter.png'))
    height, width = image.shape
    figure = plt.figure(figsize=(WIDTH_IN, 4.6))
    axis = figure.add_axes([0.01, 0.01, 0.64, 0.87])
    axis.imshow(image, cmap='gray', vmin=0, vmax=1)
    axis.set_axis_off()
    axis.set_xlim(0, width - 1)
    axis.set_ylim(height - 1, 0)
    drawMask(axis, mask)
    truth = float(mask['true_azimuth_deg'])
    places = []  # of labels [px]
    figure.text(0.01, 0.90, 'A simulated scene of the clutter table: what was taken for a light, what not and why\n'
                '(one image; the light is at %.2f°; blue: mask and horizon)' % truth, fontsize=10)
    for index, spot in enumerate(spots, 1):
        azimuth = float(spot['azimuth_deg'])
        line = '%d  %s' % (index, spot['rejection'])
        colour = RED
        if spot['rejection'] == 'accepted':
            is_light = abs(math.remainder(azimuth - truth, 360)) < 1
            colour = GREEN if is_light else ORANGE
            line = '%d  %s at %.2f°, probability %.2f' % (
                index, 'light' if is_light else 'reflection', azimuth, float(spot['probability']))
        drawSpot(axis, mask, spot, str(index), colour, places)
        # Bright on the picture, dark enough on paper.
        figure.text(0.66, 0.87 - 0.05 * index, line,
                    color={GREEN: '#1a7f1a', ORANGE: '#b86a00', RED: '#b3271e'}[colour])
    save(figure, output, 'clutter.png', PHOTOGRAPH_DPI)


def drawDistance(data, output, images):
    """Error against distance, and what the bearings said of themselves."""
    rows = rowsOf(data, 'distance.csv')
    figure, axis = plt.subplots(figsize=(WIDTH_IN, 5), constrained_layout=True)
    for name in dict.fromkeys(row['series'] for row in rows):
        own = [row for row in rows if row['series'] == name]
        distance = [float(row['distance_m']) for row in own]
        line, = axis.loglog(distance, [float(row['rmse_deg']) for row in own], 'o-', label=name)
        axis.loglog(distance, [float(row['predicted_deg']) for row in own], '--',
                    color=line.get_color(), alpha=0.7)
    axis.plot([], [], '--', color='grey', label='as the variance says')
    axis.set_xlabel('distance of the light [m]')
    axis.set_ylabel('error of the bearing, root mean square [deg]')
    ticks = sorted({float(row['distance_m']) for row in rows})
    axis.set_xticks(ticks)
    axis.set_xticks([], minor=True)
    axis.set_xticklabels(['%g' % tick for tick in ticks])
    axis.grid(True, which='both', alpha=0.3)
    axis.legend(loc='upper right', framealpha=0.9)
    axis.set_title('Bearing error against distance (simulated, exposed for the distance, %d images a point)'
                   % images)
    save(figure, output, 'distance.png')


def measure(folder, images):
    done = subprocess.run(['rosrun', 'bearing_calibration', 'gallery_data', folder, str(images)])
    if done.returncode != 0:
        sys.exit('gallery: gallery_data failed')


def main(arguments):
    parser = argparse.ArgumentParser(prog='gallery', description=__doc__)
    parser.add_argument('output', help='folder to draw into, as doc/images')
    parser.add_argument('--images', type=int, default=40,
                        help='measured for each point of a curve (default %(default)s)')
    options = parser.parse_args(arguments)
    os.makedirs(options.output, exist_ok=True)
    with tempfile.TemporaryDirectory() as data:
        measure(data, options.images)
        drawFocus(data, options.output, options.images)
        drawClutter(data, options.output)
        drawDistance(data, options.output, options.images)


if __name__ == '__main__':
    main(sys.argv[1:])
