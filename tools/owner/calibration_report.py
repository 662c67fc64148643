#!/usr/bin/env python3
"""Makes report.html (and its figures as PNG files) from a folder that calibrate_bag has written.

The page holds everything that it shows: it can be sent to somebody as one file.
"""

import argparse
import base64
import io
import os
import re
import sys

import jinja2
import yaml

try:
    import matplotlib.pyplot as plt
except ImportError:  # a robot need not have it
    sys.exit('calibration_report: its figures need matplotlib (apt-get install python3-matplotlib)')

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
from report import data, plots, words  # noqa: E402  (lies beside this file)

# Rows of the page: name of the PNG file, what draws it, title, caption; with an estimate only.
FIGURES = (
    (('estimates', plots.estimatesFigure, 'The estimate as the robot drove',
      'The band should shrink around the dashed line, and the line stay inside it. Strip at the '
      'bottom: the state of the running calibration.'),),
    (('sigmas', plots.sigmasFigure, 'How fast it became known',
      'Standard deviations of the running calibration. Dots, where the robot drove by a plan: what '
      'it expected to know at the end of its plan, when it chose that plan.'),),
    (('trajectory', plots.trajectoryFigure, 'Where the robot drove',
      "Smoothed by odometry and bearings; the light's ellipse: three standard deviations, as seen "
      'from the end.'),),
    (('residuals', plots.residualsFigure, 'Do the bearings fit?',
      'Measured bearing minus what the result says. A pattern in time means that something is not '
      'as assumed: a slip, a second light, a latency. Marks at the edge lie beyond it.'),),
    (('nis', plots.nisFigure, 'Is the noise as the sensor says?',
      'Squared innovation of each bearing over its variance. Too flat: the noise is larger than '
      'assumed; too steep: smaller.'),),
    (('mount', plots.mountFigure, 'The camera on the robot',
      'From above, to scale; forward is up. Ellipse and lines: three standard deviations.'),
     ('targets', plots.targetsFigure, 'How sure is it?',
      'Standard deviations beside converged/position_stddev and converged/yaw_stddev.')),
)
WITHOUT_ESTIMATE = ((FIGURES[2][0][:3] + ('By the wheels alone.',),),)


def embedded(figure, path):
    """Writes a figure to a PNG file; returns it as a data URI."""
    buffer = io.BytesIO()
    figure.canvas.draw()  # one round of the layout leaves the labels of axes to scale outside
    figure.savefig(buffer, format='png')
    plt.close(figure)
    with open(path, 'wb') as file:
        file.write(buffer.getvalue())
    data.addToOwnFiles(path)
    return 'data:image/png;base64,' + base64.b64encode(buffer.getvalue()).decode()


def figuresOf(record):
    if not len(record.images['t_s']):
        return []
    rows = FIGURES if record.result is not None else WITHOUT_ESTIMATE
    return [[{'title': title, 'caption': caption,
              'source': embedded(draw(record), os.path.join(record.folder, name + '.png'))}
             for name, draw, title, caption in row] for row in rows]


def cellsOf(value, stddev, scale, digits=2):
    return '%.*f' % (digits, scale * value), '\u00b1 %.*f' % (digits, scale * stddev)


def rowsOf(record):
    if record.result is None:
        return []
    settings = record.details['settings']
    rows = []
    for (name, unit, scale), meaning, target in zip(
            plots.QUANTITIES, ('forward', 'left', 'counter-clockwise'),
            (settings['position_stddev_target_m'], settings['position_stddev_target_m'],
             settings['yaw_stddev_target_rad'])):
        value, stddev = cellsOf(record.result['base_from_camera'][name],
                                record.result['stddev'][name], scale)
        rows.append(['%s (%s)' % (name, meaning), '%s %s' % (value, unit), '%s %s' % (stddev, unit),
                     '%.2g %s' % (scale * target, unit)])
    return rows


def jointOf(record):
    """The joint out of mount.urdf; None where the result is not to be used."""
    path = os.path.join(record.folder, 'mount.urdf')
    if record.result is None or not os.path.exists(path):
        return None
    with open(path, encoding='utf-8') as file:
        return re.search(r'<joint.*</joint>', file.read(), re.DOTALL).group(0).replace('\n  ', '\n')


def sourceOf(record):
    details = record.details
    text = '%s, topics %s and %s' % (details['bag'], details['wheels_topic'],
                                     details['bearings_topic'])
    if record.result is not None:
        counts = record.result['record']
        text += ' \u2014 %d bearings used, %d gated' % (counts['bearings_used'],
                                                        counts['bearings_gated'])
    return text


def sectionOf(record):
    tone, sentence = words.STATES[record.details['state']]
    return {'name': record.name, 'state': record.details['state'], 'tone': tone, 'sentence': sentence,
            'rows': rowsOf(record), 'source': sourceOf(record),
            'warnings': words.warningsOf(record), 'observable': words.observable(record),
            'unobservable': words.unobservable(record), 'errors': words.estimatedErrors(record),
            'sensor': words.sensorByItself(record), 'figures': figuresOf(record),
            'joint': jointOf(record)}


def comparisonOf(comparison, folder):
    if comparison is None:
        return None
    rows = []
    for each in comparison['mounts'] + [comparison['together']]:
        cells = [' '.join(cellsOf(each['base_from_camera'][name], each['stddev'][name], scale, 1 if
                                  unit == 'mm' else 2)) for name, unit, scale in plots.QUANTITIES]
        rows.append([each['name']] + cells + ['%.1f' % each['chi_square']])
    figure = embedded(plots.comparisonFigure(comparison), os.path.join(folder, 'comparison.png'))
    return {'agrees': comparison['agrees'], 'text': words.agreementText(comparison), 'rows': rows,
            'figure': figure}


def subtitleOf(records):
    for record in records:
        if record.result is not None:
            origin = record.result['provenance']
            return 'bearing_calibration %s, %s' % (
                record.result['versions']['bearing_calibration'], origin['written_at'])
    return 'bearing_calibration'


def makeReport(folder):
    """@returns the page's path."""
    folder = data.ownFolder(folder)
    records, comparison = data.readFolder(folder)
    title = ('Where the camera sits: ' + records[0].name if len(records) == 1
             else 'Where the camera sits: %d calibrations' % len(records))
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(os.path.dirname(os.path.realpath(data.__file__))),
        autoescape=True, trim_blocks=True, lstrip_blocks=True, undefined=jinja2.StrictUndefined)
    page = environment.get_template('page.html').render(
        title=title, subtitle=subtitleOf(records), comparison=comparisonOf(comparison, folder),
        records=[sectionOf(record) for record in records])
    path = os.path.join(folder, 'report.html')
    with open(path, 'w', encoding='utf-8') as file:
        file.write(page)
    data.addToOwnFiles(path)
    return path


def main(arguments):
    parser = argparse.ArgumentParser(prog='calibration_report', description=__doc__)
    parser.add_argument('folder', help="calibrate_bag's --output")
    options = parser.parse_args(arguments)
    try:
        print('written to ' + makeReport(options.folder))
        return 0
    except (OSError, ValueError, KeyError, yaml.YAMLError) as error:
        print('calibration_report: %s: %s' % (options.folder, error), file=sys.stderr)
        return 1


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
