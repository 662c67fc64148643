"""What a calibration's numbers mean, in sentences."""

import math

import numpy as np

STATES = {
    'CONVERGED': ('good', 'The standard deviations of the mount are below your targets.'),
    'CONVERGING': ('fair', 'The mount is found, but not confirmed, or its standard deviations are '
                           'larger than your targets.'),
    'DEGENERATE_MOTION': ('bad', 'The mount is not observable with this motion.'),
    'INITIALISING': ('bad', 'The record is too short to determine the mount.'),
    'INCONSISTENT': ('bad', 'The bearings do not fit the motion: do not use this result.'),
    'WAITING_FOR_TICKS': ('bad', 'There were no wheel readings that could be used.'),
    'WAITING_FOR_LIGHT': ('bad', 'There was no bearing that could be used.'),
    'PAUSED': ('bad', 'The calibration was paused.'),
}

# A NIS has the mean 1; its mean over a record scatters by a few hundredths.
MEAN_NIS_RANGE = (0.6, 1.6)
MANY = 0.05  # share of bearings that is worth a warning
HIGH_CORRELATION = 0.2
PRIOR_SIGMAS = 3  # an error beyond so many of its prior's is not what the owner has allowed
UNITS = {'[s]': ('ms', 1e3), '[m]': ('mm', 1e3), '[rad]': ('deg', math.degrees(1.0))}
SECOND_CURVATURE_M = 0.15  # what the initialiser wants (init/initializer.h)


def shareOf(words, *wanted):
    seen = words != 'nothing seen'
    return np.isin(words[seen], wanted).mean() if seen.any() else 0.0


def meanNis(record):
    nis = record.images['nis']
    return np.nanmean(nis) if np.isfinite(nis).any() else math.nan


def warningsOf(record):
    """What the owner should know before using the result."""
    details, images = record.details, record.images
    found = []
    if details['state'] != 'CONVERGED':
        found.append('%s: %s.' % (details['state'], details['advice']))
    found += ['%s.' % warning for warning in details['warnings']]
    if details['rejections']:
        found.append('Some inputs were refused or changed (%s).' % details['rejections'])
    if not details['has_estimate']:
        return found
    if not details['settled']:
        found.append('The fit of the whole record did not settle: its images are not judged.')
    gated = shareOf(images['live'], 'gated', 'ambiguous')
    if gated > MANY:
        found.append('%.0f %% of the bearings were not used by the running filter: other lights, '
                     'reflections, or a robot that slips.' % (100 * gated))
    left_out = shareOf(images['fit'], 'left out')
    if left_out > MANY:
        found.append('%.0f %% of the bearings do not fit the result and were left out.'
                     % (100 * left_out))
    low, high = MEAN_NIS_RANGE
    if meanNis(record) > high:
        found.append('The bearings scatter more than the noise they are weighed with (mean NIS %.1f): raise '
                     'bearings/extra_stddev, or the wheels\' noise.' % meanNis(record))
    if meanNis(record) < low:
        found.append('The bearings scatter less than the noise they are weighed with (mean NIS %.1f): the '
                     'standard deviations given here are too large.' % meanNis(record))
    if details['bearing_correlation'] > HIGH_CORRELATION:
        found.append('The errors of successive bearings are correlated (%.1f); the standard '
                     'deviations include this.'
                     % details['bearing_correlation'])
    if details['slips']:
        found.append('%d motion(s) between two images look like a slipping wheel and were '
                     'disregarded.' % details['slips'])
    parameters = record.result['parameters']
    for block in record.result['blocks']:
        prior = parameters.get('errors/%s_stddev' % block['name'], 0)
        off = math.hypot(*block['value'].values())
        if block['name'] in ('time_offset', 'wheel_scales', 'wheel_separation') and (
                off > PRIOR_SIGMAS * prior > 0):
            found.append('%s: %.1f times errors/%s_stddev off what is configured: %s.' % (
                block['name'].replace('_', ' ').capitalize(), off / prior, block['name'],
                'correct bearings/latency' if block['name'] == 'time_offset' else
                'measure the wheels and their separation, for all lengths may be as wrong'))
    return found


def drivenText(record):
    motion = record.details['motion']
    return ('The robot drove %.1f m and turned by %.1f full turns, all within %.1f m.'
            % (motion['path_m'], motion['turn_rad'] / (2 * math.pi), motion['extent_m']))


def decimals(value):
    """Two significant digits for small numbers, none behind the point for large ones."""
    return '%.0f' % value if abs(value) >= 10 else '%.1f' % value if abs(value) >= 1 else (
        '%.2f' % value)


def asSentences(clauses):
    return ['%s.' % (clause[0].upper() + clause[1:]) for clause in clauses]


def sensorByItself(record):
    """What the bearings show without any mount."""
    return asSentences(record.details['sensor'])


def observable(record):
    """What was observable with this motion."""
    if not len(record.images['t_s']):
        return ['Nothing: no bearing was used.']
    sentences = [drivenText(record)]
    lights = [light for light in (record.result or {}).get('lights', []) if light['in_estimate']]
    if len(lights) > 1:
        sentences.append('The mount rests on %d lights.' % len(lights))
        for light in lights:
            stddev = np.sqrt(np.diag(light['covariance_x_y']))
            sentences.append('Light %s, with %d bearings, stands at x %.3f \u00b1 %.3f m, y %.3f \u00b1 %.3f m '
                             'of the base at the end.' % (
                                 light.get('id', 'without a number'), light['bearings_used'],
                                 light['x_m'], stddev[0], light['y_m'], stddev[1]))
    if not record.details['has_estimate']:
        second = record.details['motion']['second_curvature_m']
        if second < SECOND_CURVATURE_M:
            sentences.append('Two different curvatures are needed, a line and a turn on the spot for '
                             'instance: beside the main one there were %.2f m of another, %.2f m are '
                             'needed.' % (second, SECOND_CURVATURE_M))
        return sentences
    return sentences + asSentences(record.result['quality'])


def unobservable(record):
    """What is not observable with any motion past one light, or was not with this one."""
    sentences = []
    result = record.result
    if result is None:
        return ['The mount.']
    rest = result['not_estimated']
    sentences.append('Height, roll and pitch of the camera: bearings of one light in the plane do not '
                  'depend on them. They are passed on as configured: z %.3f \u00b1 %.3f m, roll '
                  '%.1f \u00b1 %.1f\u00b0, pitch %.1f \u00b1 %.1f\u00b0.'
                  % (rest['z_m'], rest['z_stddev_m'], math.degrees(rest['roll_rad']),
                     math.degrees(rest['roll_stddev_rad']), math.degrees(rest['pitch_rad']),
                     math.degrees(rest['pitch_stddev_rad'])))
    separation = record.details['settings']['wheel_separation_m']
    mount = result['base_from_camera']
    offset = math.hypot(mount['x'], mount['y'])
    sentences.append('The scale: all lengths are proportional to the wheel separation of %.4g m. An '
                  'error of 1 %% in it moves the camera by %s mm.'
                  % (separation, decimals(10 * offset)))
    if not result['paper_state']['phi_psi_determined']:
        sentences.append('phi and psi one by one: the camera sits so near to the base\'s origin that '
                      'only their sum, the yaw, means something.')
    for light in result.get('lights', []):
        if not light['in_estimate']:
            sentences.append('Anything from light %s: %s.' % (light.get('id', 'without a number'),
                                                           light.get('note', 'it is left out')))
    for block in result['blocks']:
        if 'note' in block:
            sentences.append('%s is %s: %s.' % (block['name'].replace('_', ' '), block['status'],
                                             block['note']))
    return sentences


def estimatedErrors(record):
    """Rows: what was estimated beside the mount, its value and standard deviation, what they rest on."""
    rows = []
    for block in (record.result or {}).get('blocks', []):
        for key, value in block['value'].items() if block['status'] != 'off' else ():
            name, _, unit = key.partition(' ')
            unit, scale = UNITS.get(unit, ('', 1) if name.endswith('factor') else ('%', 100))
            rows.append([name.replace('_', ' '), '%.2f %s' % (scale * value, unit),
                         '\u00b1 %.2f %s' % (scale * block['stddev'][key], unit), block['status']])
    return rows


def agreementText(comparison):
    count = len(comparison['mounts'])
    together = comparison['together']
    head = ('%d estimates of the same mount, chi-square %.1f with %d degrees of freedom: so large a '
            'value comes up by chance with p = %.2g. '
            % (count, together['chi_square'], comparison['degrees_of_freedom'],
               comparison['p_value']))
    if comparison['agrees']:
        return head + 'They agree.'
    worst = max(comparison['mounts'], key=lambda each: each['chi_square'])
    return head + ('They disagree by more than their standard deviations say; %s contributes most. '
                   'Check for a moved light, a slip, a wrong wheel separation.' % worst['name'])
