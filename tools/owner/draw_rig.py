#!/usr/bin/env python3
"""Draws a camera under its conic mirror to scale, and where it sees a light all around.

The numbers are those of your robot's file, as for the light detection: before you build a rig, those that you plan.
"""

import argparse
import math
import sys

import rosparam
import yaml

try:
    import matplotlib
    matplotlib.use('Agg')  # no window
    import matplotlib.pyplot as plt
except ImportError:  # a robot need not have it
    sys.exit('draw_rig: its picture needs matplotlib (apt-get install python3-matplotlib)')

NUMBERS = ('lens/focal_length', 'lens/focus_distance', 'lens/pixel_pitch', 'mirror/lens_to_apex',
           'mirror/half_angle', 'mirror/base_radius', 'mirror/centre_u', 'mirror/centre_v',
           'sensor/width', 'sensor/height', 'mask/inner_radius', 'mask/outer_radius', 'mask/last_row')
FIRST_ROW = 'mask/first_row'  # 0 where it is not stated
MOST_M = {'lens/focal_length': 10, 'lens/pixel_pitch': 0.01, 'mirror/lens_to_apex': 10,
          'mirror/base_radius': 10}  # as the detection has it
MAY_BE_ZERO = ('mask/inner_radius', FIRST_ROW)
IS_TEXT = ' but text to YAML, which needs a point and no quotes: 4.0e-3'
DISTANCES_M = (0.5, 1.0, 2.0, 3.0)  # of the light, printed
BLUE, LIGHT, GREY = '#1d6fb8', '#e8a200', '#4b5563'
FONT_PT = 11  # 12 px and more where a page shows the picture 850 px wide
SIZE_IN = (10.0, 4.4)
DPI = 200
METADATA = {'Software': None}  # no version: the same picture has the same bytes


def isSize(name, value):
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return False
    if name == 'lens/focus_distance' and value == math.inf:  # as the detection allows it
        return True
    return 0 < value < math.inf or (value == 0 and name in MAY_BE_ZERO)


def numbersOf(files):
    """{name: number} of NUMBERS in parameter files, read as roslaunch reads them."""
    numbers = {FIRST_ROW: 0}
    for file in files:
        try:
            for parameters, _ in rosparam.load_file(file):
                for name in NUMBERS + (FIRST_ROW, 'mirror/kind'):
                    room, key = name.split('/')
                    group = parameters.get(room) if isinstance(parameters, dict) else None
                    if isinstance(group, dict) and key in group:
                        numbers[name] = group[key]
        except (rosparam.RosParamException, yaml.YAMLError) as error:
            sys.exit('draw_rig: %s: %s' % (file, error))
    if numbers.get('mirror/kind', 'cone') != 'cone':
        sys.exit('draw_rig: mirror/kind is %s: only a conic mirror can be drawn' % numbers['mirror/kind'])
    faults = ['%s is missing' % name for name in NUMBERS if name not in numbers]
    faults += ['%s is %s, which is not a number above 0%s' % (name, value, IS_TEXT * isinstance(value, str))
               for name, value in numbers.items() if name in NUMBERS + (FIRST_ROW,) and not isSize(name, value)]
    if not faults:
        faults = ['%s is %s m, more than %g: in millimetres?' % (name, numbers[name], most)
                  for name, most in MOST_M.items() if numbers[name] > most]
    if not faults and numbers['mirror/half_angle'] >= 0.5 * math.pi:
        faults.append('mirror/half_angle is %s rad, which is no cone' % numbers['mirror/half_angle'])
    if not faults and numbers['lens/focus_distance'] <= numbers['lens/focal_length']:
        faults.append('lens/focus_distance is not beyond lens/focal_length')
    if faults:
        sys.exit('\n'.join('draw_rig: %s: %s' % (', '.join(files), fault) for fault in faults))
    return numbers


class Rig:
    """Lengths in metres from the lens, heights over the mirror's apex (doc/background/detection.md)."""

    def __init__(self, numbers):
        self.lens_to_apex_m = numbers['mirror/lens_to_apex']
        self.half_angle_rad = numbers['mirror/half_angle']
        self.base_radius_m = numbers['mirror/base_radius']
        self.height_m = self.base_radius_m / math.tan(self.half_angle_rad)
        focal, focus = numbers['lens/focal_length'], numbers['lens/focus_distance']
        self.image_distance_px = 1.0 / (1.0 / focal - 1.0 / focus) / numbers['lens/pixel_pitch']
        self.rim_px = self.image_distance_px * self.base_radius_m / (self.lens_to_apex_m + self.height_m)
        u, v = numbers['mirror/centre_u'], numbers['mirror/centre_v']
        self.inner_px = max(1, numbers['mask/inner_radius'])  # the apex itself shows no direction
        edge = min(u, numbers['sensor/width'] - 1 - u, v - numbers[FIRST_ROW],
                   numbers['mask/last_row'] - v)
        self.outer_px = min(self.rim_px, numbers['mask/outer_radius'], edge)  # seen all around

    def ray(self, image_radius_px):
        """(radius, height) where a pixel's ray meets the cone, and its elevation behind it."""
        theta = math.atan(image_radius_px / self.image_distance_px)
        radius = self.lens_to_apex_m / (1.0 / math.tan(theta) - 1.0 / math.tan(self.half_angle_rad))
        return (radius, radius / math.tan(self.half_angle_rad)), 0.5 * math.pi - 2.0 * self.half_angle_rad + theta

    def lightHeight(self, image_radius_px, distance_m):
        (radius, height), elevation = self.ray(image_radius_px)
        return height + (distance_m - radius) * math.tan(elevation)


def sizes(rig):
    """What is printed: the cone's sizes, and where a light is seen from any side."""
    low, high = (math.degrees(rig.ray(radius)[1]) for radius in (rig.inner_px, rig.outer_px))
    lines = ['cone: %.1f mm wide, %.1f mm high; the apex %.1f mm over the lens, the base %.1f mm'
             % (2e3 * rig.base_radius_m, 1e3 * rig.height_m, 1e3 * rig.lens_to_apex_m,
                1e3 * (rig.lens_to_apex_m + rig.height_m)),
             'its surface, unrolled: a sector of %.1f mm and %.1f deg'
             % (1e3 * rig.base_radius_m / math.sin(rig.half_angle_rad), 360 * math.sin(rig.half_angle_rad)),
             'its rim in the image: a circle of %.0f px' % rig.rim_px,
             'seen all around: elevations of %.1f to %+.1f deg' % (low, high)]
    for distance in DISTANCES_M:
        lines.append('a light %.1f m away: %+.2f to %+.2f m over the apex'
                     % (distance, rig.lightHeight(rig.inner_px, distance),
                        rig.lightHeight(rig.outer_px, distance)))
    return lines


def clean(axes, title):
    axes.set_title(title, fontsize=FONT_PT + 1, fontweight='bold', loc='left')
    for side in ('top', 'right'):
        axes.spines[side].set_visible(False)
    axes.tick_params(labelsize=FONT_PT)


def dimension(axes, begin, end, text, at, align):
    axes.annotate('', begin, end, arrowprops=dict(arrowstyle='<->', color='black', shrinkA=0, shrinkB=0))
    axes.text(*at, text, fontsize=FONT_PT, ha=align, va='center')


def drawRig(axes, rig):
    """From the side, in millimetres over the lens."""
    clean(axes, 'The rig, to scale [mm]')
    apex, base, radius = (1e3 * value for value in (
        rig.lens_to_apex_m, rig.lens_to_apex_m + rig.height_m, rig.base_radius_m))
    for side in (-1, 1):
        axes.plot([side * radius] * 2, [-10, base], color='#9ca3af', linewidth=1.5)
    axes.fill([-14, 14, 14, -14], [-16, -16, 0, 0], color='#374151')
    axes.text(0, -8, 'camera', fontsize=FONT_PT, color='white', ha='center', va='center')
    axes.text(radius + 2, 0.25 * apex, 'posts, or a\nclear tube', fontsize=FONT_PT, va='center')
    axes.fill([0, -radius, radius], [apex, base, base], facecolor='#bfdbfe', edgecolor=BLUE)
    reach = 2.6 * radius
    for image_radius in (rig.inner_px, rig.outer_px):
        (hit, height), elevation = rig.ray(image_radius)
        hit, height = 1e3 * hit, 1e3 * height + apex
        axes.plot([0, hit, reach], [0, height, height + (reach - hit) * math.tan(elevation)],
                  color=LIGHT, linewidth=1.5)
        axes.text(reach + 2, height + (reach - hit) * math.tan(elevation),
                  ('%+.1f°' % math.degrees(elevation)).replace('-', '\u2212'), fontsize=FONT_PT, va='center')
    left = -radius - 6
    dimension(axes, (left, 0), (left, apex), '%.0f' % apex, (left - 3, 0.5 * apex), 'right')
    dimension(axes, (left, apex), (left, base), '%.0f' % (base - apex), (left - 3, 0.5 * (apex + base)), 'right')
    dimension(axes, (-radius, base + 6), (radius, base + 6), '%.0f' % (2 * radius), (0, base + 13), 'center')
    axes.text(-4, base - 7, '%.1f°' % math.degrees(rig.half_angle_rad), fontsize=FONT_PT, ha='right', va='center')
    axes.plot([0, 0], [apex, base], color=BLUE, linewidth=0.8, linestyle=':')
    axes.set_xlim(left - 18, reach + 26)
    axes.set_ylim(-18, base + 20)
    axes.set_aspect('equal', adjustable='box')
    axes.set_anchor('NW')
    axes.axis('off')


def drawView(axes, rig):
    """The heights at which a light is seen from any side."""
    clean(axes, 'Where a light is seen all around')
    distances = [0.3 + 0.1 * i for i in range(28)]
    low, high = ([rig.lightHeight(radius, distance) for distance in distances]
                 for radius in (rig.inner_px, rig.outer_px))
    axes.fill_between(distances, low, high, color=LIGHT, alpha=0.35, linewidth=0)
    axes.axhline(0.0, color=GREY, linewidth=1)
    axes.text(distances[-1], 0.0, 'the apex', fontsize=FONT_PT, ha='right', va='bottom')
    axes.set_xlabel("distance from the mirror's axis [m]", fontsize=FONT_PT)
    axes.set_ylabel('height over the apex [m]', fontsize=FONT_PT)


def main(arguments):
    parser = argparse.ArgumentParser(prog='draw_rig', description=__doc__)
    parser.add_argument('--config', '-c', action='append', required=True, metavar='FILE',
                        help='the numbers of your camera and mirror; may be repeated')
    parser.add_argument('--output', '-o', default='rig.png', metavar='FILE', help='the picture (default: rig.png)')
    options = parser.parse_args(arguments)
    rig = Rig(numbersOf(options.config))
    if not 0.0 < rig.inner_px < rig.outer_px:
        sys.exit('draw_rig: mask/inner_radius is %g px, but the mirror is seen all around up to %.0f px only'
                 % (rig.inner_px, rig.outer_px))
    print('\n'.join(sizes(rig)))
    figure = plt.figure(figsize=SIZE_IN, facecolor='white')
    drawRig(figure.add_axes([0.01, 0.03, 0.54, 0.88]), rig)
    drawView(figure.add_axes([0.65, 0.16, 0.33, 0.75]), rig)
    try:
        figure.savefig(options.output, dpi=DPI, metadata=METADATA if options.output.endswith('.png') else None)
    except (OSError, ValueError) as error:
        sys.exit('draw_rig: %s: %s' % (options.output, error))


if __name__ == '__main__':
    main(sys.argv[1:])
