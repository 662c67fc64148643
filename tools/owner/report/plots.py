"""The report's figures. Units stand on every axis; colours are those of Okabe and Ito, which
colour-blind readers tell apart."""

import math

import matplotlib
matplotlib.use('Agg')
import matplotlib.patches as patches  # noqa: E402  (after the choice of the backend)
import matplotlib.patheffects as patheffects  # noqa: E402
import matplotlib.pyplot as plt  # noqa: E402
import matplotlib.ticker as ticker  # noqa: E402
import numpy as np  # noqa: E402

BLUE, ORANGE, GREEN, RED, PURPLE, GREY = (
    '#0072B2', '#E69F00', '#009E73', '#D55E00', '#CC79A7', '#6b7280')
STATE_COLOURS = {'CONVERGED': '#009E73', 'CONVERGING': '#E69F00', 'INITIALISING': '#9ca3af',
                 'DEGENERATE_MOTION': '#9ca3af', 'INCONSISTENT': '#D55E00'}
SIGMAS = 3  # of every band and ellipse
WIDTH_IN = 9.0
LONG_GAP_S = 1.0  # between two images: the path between them is not known from the record

plt.rcParams.update({
    'figure.dpi': 110, 'savefig.dpi': 160, 'font.size': 10, 'axes.titlesize': 11,
    'axes.spines.top': False, 'axes.spines.right': False, 'axes.grid': True,
    'grid.color': '#e5e7eb', 'axes.edgecolor': '#9ca3af', 'axes.axisbelow': True,
    'legend.frameon': False, 'axes.labelcolor': '#374151', 'xtick.color': '#374151',
    'ytick.color': '#374151', 'figure.constrained_layout.use': True})

# Of x, y and yaw: name, unit, factor from SI.
QUANTITIES = (('x', 'mm', 1000.0), ('y', 'mm', 1000.0), ('yaw', 'deg', math.degrees(1.0)))


def shadeStates(axes, estimates):
    """The running calibration's states as a strip along the bottom; returns those that appear."""
    distance, states = estimates['distance_m'], estimates['state']
    changes = [0] + [i for i in range(1, len(states)) if states[i] != states[i - 1]]
    for begin, end in zip(changes, changes[1:] + [len(states) - 1]):
        axes.axvspan(distance[begin], distance[end], ymax=0.035, linewidth=0,
                     color=STATE_COLOURS.get(states[begin], GREY))
    return list(dict.fromkeys(states))


def estimatesFigure(record):
    """x, y and yaw against the distance driven, with their 3-sigma bands."""
    estimates = record.estimates
    figure, rows = plt.subplots(3, 1, sharex=True, figsize=(WIDTH_IN, 6.2))
    final = record.result['base_from_camera']
    stddev = record.result['stddev']
    distance = estimates['distance_m']
    states = []
    for axes, (name, unit, scale) in zip(rows, QUANTITIES):
        suffix = 'rad' if name == 'yaw' else 'm'
        value = scale * estimates['%s_%s' % (name, suffix)]
        if name == 'yaw':  # as the branch nearest to the final value
            value = scale * (final[name] + np.remainder(
                value / scale - final[name] + math.pi, 2 * math.pi) - math.pi)
        band = SIGMAS * scale * estimates['%s_stddev_%s' % (name, suffix)]
        axes.fill_between(distance, value - band, value + band, color=BLUE, alpha=0.18, linewidth=0,
                          label='\u00b1 %d standard deviations' % SIGMAS)
        axes.plot(distance, value, color=BLUE, linewidth=1.4, label='running estimate')
        axes.axhline(scale * final[name], color=RED, linewidth=1.0, linestyle='--',
                     label='result')
        # what is far off at the start would hide the rest
        late = band[len(band) // 4:]
        reach = max(8.0 * scale * stddev[name], 1.3 * np.max(late) if len(late) else 0.0)
        axes.set_ylim(scale * final[name] - reach, scale * final[name] + reach)
        axes.set_ylabel('%s [%s]' % (name, unit))
        states = shadeStates(axes, estimates)
    handles, labels = rows[0].get_legend_handles_labels()
    for state in states:
        handles.append(patches.Patch(color=STATE_COLOURS.get(state, GREY)))
        labels.append(state)
    most_in_a_row = 4  # more are wider than the page
    rows[0].legend(handles, labels, loc='lower center', bbox_to_anchor=(0.5, 1.0),
                   ncol=min(len(labels), most_in_a_row), fontsize=8.5, columnspacing=1.2,
                   handletextpad=0.5)
    rows[-1].set_xlabel('distance driven [m]')
    return figure


def sigmasFigure(record):
    """Standard deviations against time, with what a drive's plan expected of them."""
    estimates, plans = record.estimates, record.plans
    settings = record.details['settings']
    targets = {'x': settings['position_stddev_target_m'], 'y': settings['position_stddev_target_m'],
               'yaw': settings['yaw_stddev_target_rad']}
    figure, rows = plt.subplots(3, 1, sharex=True, figsize=(WIDTH_IN, 5.4))
    for axes, (name, unit, scale) in zip(rows, QUANTITIES):
        column = '%s_stddev_%s' % (name, 'rad' if name == 'yaw' else 'm')
        axes.plot(estimates['t_s'], scale * estimates[column], color=BLUE, linewidth=1.4,
                  label='running estimate')
        axes.axhline(scale * targets[name], color=RED, linewidth=1.0, linestyle='--', label='wanted')
        if len(plans['t_s']):
            axes.plot(plans['t_s'], scale * plans[column], 'o', color=PURPLE, markersize=4,
                      label='expected of the plan')
        axes.set_yscale('log')
        axes.yaxis.set_major_locator(ticker.LogLocator(subs=(1.0, 2.0, 5.0)))
        axes.yaxis.set_major_formatter(ticker.StrMethodFormatter('{x:g}'))
        axes.yaxis.set_minor_locator(ticker.NullLocator())
        axes.set_ylabel('%s [%s]' % (name, unit))
    rows[0].legend(loc='lower center', bbox_to_anchor=(0.5, 1.0), ncol=3, fontsize=8.5)
    rows[-1].set_xlabel('time [s]')
    return figure


def ellipseOf(covariance):
    """Width, height and angle [deg] of the 3-sigma ellipse of a 2x2 covariance."""
    values, vectors = np.linalg.eigh(covariance)
    width, height = 2 * SIGMAS * np.sqrt(np.maximum(values, 0.0))
    return width, height, math.degrees(math.atan2(vectors[1, 0], vectors[0, 0]))


def rotation(angle_rad):
    cosine, sine = math.cos(angle_rad), math.sin(angle_rad)
    return np.array([[cosine, -sine], [sine, cosine]])


def lastSeen(images):
    """Index of the last image with a bearing."""
    return np.flatnonzero(images['live'] != 'nothing seen')[-1]


def drawRobot(axes, pose, separation_m, mount, scale=1.0):
    """Axle, heading and camera to scale."""
    x, y, yaw = pose
    R = rotation(yaw)
    left, right = ((np.array([x, y]) + R @ [0.0, side * separation_m / 2]) for side in (1, -1))
    axes.plot(*zip(left, right), color='black', linewidth=1.5 * scale, zorder=4)
    nose = np.array([x, y]) + R @ [0.75 * separation_m, 0.0]
    axes.plot([x, nose[0]], [y, nose[1]], color='black', linewidth=1.0 * scale, zorder=4)
    camera = np.array([x, y]) + R @ [mount['x'], mount['y']]
    axes.plot(*camera, 'o', color=RED, markersize=4, zorder=5)


def trajectoryFigure(record):
    """The path with light and robot to scale."""
    images, details = record.images, record.details
    figure, axes = plt.subplots(figsize=(WIDTH_IN, 6.0))
    axes.plot(images['base_x_m'], images['base_y_m'], color='#d1d5db', linewidth=0.8,
              label='between images')
    unseen = np.concatenate([[False], np.diff(images['t_s']) > LONG_GAP_S])
    axes.plot(np.where(unseen, np.nan, images['base_x_m']), images['base_y_m'], color=BLUE,
              linewidth=1.0, label='path of the base')
    axes.plot(images['base_x_m'][0], images['base_y_m'][0], 's', color=GREEN, markersize=7,
              label='start', zorder=4)
    if record.result is not None and 'light_in_first_base' in details:
        last = lastSeen(images)
        pose = [images[key][last] for key in ('base_x_m', 'base_y_m', 'base_yaw_rad')]
        drawRobot(axes, pose, details['settings']['wheel_separation_m'],
                  record.result['base_from_camera'])
        axes.plot([], [], color='black', linewidth=1.5, label='robot at the end, to scale')
        axes.plot([], [], 'o', color=RED, markersize=4, label='camera')
        light = details['light_in_first_base']
        covariance = np.array(record.result['cartesian_state']['covariance'])[:2, :2]
        R = rotation(pose[2])
        width, height, angle = ellipseOf(R @ covariance @ R.T)
        axes.add_patch(patches.Ellipse((light['x'], light['y']), width, height, angle=angle,
                                       facecolor=ORANGE, alpha=0.35))
        axes.plot(light['x'], light['y'], '*', color=ORANGE, markersize=16,
                  markeredgecolor='black', markeredgewidth=0.6, label='light', zorder=5)
    axes.set_aspect('equal', adjustable='datalim')
    axes.set_xlabel('x [m], forward at the start')
    axes.set_ylabel('y [m], left at the start')
    axes.legend(loc='center left', bbox_to_anchor=(1.0, 0.5))
    return figure


def mountFigure(record):
    """The camera on the robot, seen from above, to scale."""
    result = record.result
    mount, separation = result['base_from_camera'], record.details['settings']['wheel_separation_m']
    radius = result['provenance']['left_wheel_radius_m']
    figure, axes = plt.subplots(figsize=(WIDTH_IN / 2, 4.6))
    # x forward is up on the page, y left is left: (x, y) -> (-y, x)
    axes.plot([-separation / 2, separation / 2], [0, 0], color='#9ca3af', linewidth=2)
    for side in (-1, 1):
        axes.add_patch(patches.FancyBboxPatch(
            (side * separation / 2 - 0.15 * radius, -radius), 0.3 * radius, 2 * radius,
            boxstyle='round,pad=0,rounding_size=%g' % (0.1 * radius), color='#4b5563'))
    reach = 0.45 * separation
    is_ahead = mount['x'] >= 0  # the names stand on either side of the two
    drawAxes(axes, 0.0, 0.0, 0.0, 0.5 * reach, 'base', GREY, name_above=not is_ahead)
    drawAxes(axes, -mount['y'], mount['x'], mount['yaw'], 0.6 * reach, 'camera', 'black',
             name_above=is_ahead)
    covariance = np.array(result['covariance_x_y_yaw'])[:2, :2]
    turn = np.array([[0.0, -1.0], [1.0, 0.0]])
    width, height, angle = ellipseOf(turn @ covariance @ turn.T)
    axes.add_patch(patches.Ellipse((-mount['y'], mount['x']), width, height, angle=angle,
                                   facecolor=RED, alpha=0.4, zorder=6))
    for sign in (-1, 1):  # the yaw's cone
        yaw = mount['yaw'] + sign * SIGMAS * result['stddev']['yaw']
        axes.plot([-mount['y'], -mount['y'] - 1.5 * reach * math.sin(yaw)],
                  [mount['x'], mount['x'] + 1.5 * reach * math.cos(yaw)], color=RED, linewidth=0.7)
    axes.set_aspect('equal', adjustable='datalim')
    axes.margins(0.15)
    axes.set_xlabel('\u2212y [m]  (right)')
    axes.set_ylabel('x [m]  (forward)')
    return figure


def drawAxes(axes, across, along, yaw, length, name, colour, name_above):
    """A frame: x red, y green, its name beside the origin. Forward is up."""
    for angle, arrow in ((0.0, RED), (math.pi / 2, GREEN)):
        direction = (-math.sin(yaw + angle), math.cos(yaw + angle))
        axes.annotate('', (across + length * direction[0], along + length * direction[1]),
                      (across, along), arrowprops={'arrowstyle': '-|>', 'color': arrow,
                                                   'shrinkA': 0, 'shrinkB': 0, 'linewidth': 1.5})
    axes.plot(across, along, 'o', color=colour, markersize=3, zorder=7)
    axes.annotate(name, (across, along), xytext=(6, 5 if name_above else -12),
                  textcoords='offset points', zorder=8, color=colour, fontsize=9,  # legible on wheels and ellipse, too
                  path_effects=[patheffects.withStroke(linewidth=2.5, foreground='white')])


def residualsFigure(record):
    """Measured bearing minus what the result says, against time."""
    images = record.images
    figure, axes = plt.subplots(figsize=(WIDTH_IN, 3.4))
    residual = np.degrees(images['residual_rad'])
    stddev = np.degrees(images['azimuth_stddev_rad'])
    limit = 8.0 * np.nanmedian(stddev)
    seen = np.isfinite(residual)
    band = SIGMAS * stddev
    axes.fill_between(images['t_s'][seen], -band[seen], band[seen], color=BLUE, alpha=0.12,
                      linewidth=0, label="\u00b1 %d of the sensor's standard deviations" % SIGMAS)
    gated = np.isin(images['live'], ('gated', 'ambiguous'))
    left_out = images['fit'] == 'left out'
    used = (images['fit'] == 'used') & ~gated
    for chosen, style, label in (
            (used, {'marker': '.', 'color': BLUE, 'markersize': 3}, 'used'),
            (left_out, {'marker': 'x', 'color': ORANGE, 'markersize': 6}, 'left out at the end'),
            (gated & seen, {'marker': 'o', 'color': RED, 'markersize': 6, 'fillstyle': 'none'},
             'gated by the running filter')):
        axes.plot(images['t_s'][chosen], np.clip(residual[chosen], -limit, limit), linestyle='',
                  label='%s (%d)' % (label, np.count_nonzero(chosen)), **style)
    axes.axhline(0.0, color=GREY, linewidth=0.8)
    axes.set_ylim(-1.08 * limit, 1.08 * limit)
    axes.set_xlabel('time since the first image [s]')
    axes.set_ylabel('residual [deg]')
    axes.legend(loc='lower center', bbox_to_anchor=(0.5, 1.0), ncol=4, fontsize=8.5)
    return figure


def chiSquareBelow(value):
    """Of one degree of freedom."""
    return math.erf(math.sqrt(value / 2))


def nisFigure(record):
    """Normalised innovations squared against the chi-square that they should follow."""
    nis = record.images['nis'][np.isfinite(record.images['nis'])]
    figure, axes = plt.subplots(figsize=(WIDTH_IN, 3.0))
    edges = np.linspace(0.0, 8.0, 33)
    axes.hist(np.minimum(nis, edges[-1] - 1e-9), bins=edges, color=BLUE, alpha=0.45,
              label='%d bearings' % len(nis))
    expected = [len(nis) * (chiSquareBelow(high) - chiSquareBelow(low))
                for low, high in zip(edges[:-1], edges[1:])]
    expected[-1] = len(nis) * (1 - chiSquareBelow(edges[-2]))  # with all beyond
    axes.step(edges, [expected[0]] + expected, color=RED, linewidth=1.3,
              label='chi-square, 1 degree of freedom')
    axes.set_yscale('log')
    axes.set_ylim(bottom=0.5)
    axes.set_xlabel('NIS [1]; the last bar holds all beyond')
    axes.set_ylabel('bearings [1]')
    axes.legend(loc='upper right', fontsize=8.5)
    return figure


def targetsFigure(record):
    """Standard deviations beside what was asked for."""
    settings, stddev = record.details['settings'], record.result['stddev']
    targets = (settings['position_stddev_target_m'], settings['position_stddev_target_m'],
               settings['yaw_stddev_target_rad'])
    figure, axes = plt.subplots(figsize=(WIDTH_IN / 2, 4.6))
    for row, ((name, unit, scale), target) in enumerate(zip(QUANTITIES, targets)):
        ratio = stddev[name] / target
        axes.barh(row, ratio, height=0.55, color=GREEN if ratio <= 1 else ORANGE, alpha=0.8)
        axes.annotate('%.2g of %.2g %s' % (scale * stddev[name], scale * target, unit),
                      (max(1.0, ratio), row), xytext=(8, 0), textcoords='offset points',
                      va='center')
    axes.axvline(1.0, color=RED, linewidth=1.2, linestyle='--')
    axes.set_yticks(range(3))
    axes.set_yticklabels([name for name, _, _ in QUANTITIES])
    axes.invert_yaxis()
    axes.set_xlim(0, 2.0 * max(1.0, max(stddev[name] / target for (name, _, _), target in zip(
        QUANTITIES, targets))))
    axes.set_xlabel('standard deviation over its target [1]')
    axes.grid(axis='y', visible=False)
    return figure


def comparisonFigure(comparison):
    """Every estimate with its 3-sigma bar, beside their weighted mean."""
    mounts, together = comparison['mounts'], comparison['together']
    figure, columns = plt.subplots(1, 3, sharey=True,
                                   figsize=(WIDTH_IN, 1.2 + 0.34 * len(mounts)))
    for axes, (name, unit, scale) in zip(columns, QUANTITIES):
        mean = together['base_from_camera'][name]
        middle = scale * mean
        band = SIGMAS * scale * together['stddev'][name]
        axes.axvspan(middle - band, middle + band, color=RED, alpha=0.15, linewidth=0)
        axes.axvline(middle, color=RED, linewidth=1.0, linestyle='--')
        for row, each in enumerate(mounts):
            value = each['base_from_camera'][name]
            if name == 'yaw':  # as the branch nearest to the mean
                value = mean + math.remainder(value - mean, 2 * math.pi)
            axes.errorbar(scale * value, row,
                          xerr=SIGMAS * scale * each['stddev'][name], fmt='o', color=BLUE,
                          markersize=4, capsize=2.5, linewidth=1.2)
        axes.set_xlabel('%s [%s]' % (name, unit))
    columns[0].set_yticks(range(len(mounts)))
    # between two dollars is a formula
    columns[0].set_yticklabels([each['name'].replace('$', r'\$') for each in mounts])
    columns[0].set_ylim(len(mounts) - 0.5, -0.5)
    return figure
