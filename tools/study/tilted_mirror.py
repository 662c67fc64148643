#!/usr/bin/env python3
"""The mount under a mirror that is tilted and stands beside the lens' axis, from images to the result.

Renders drives of the simulated robot whose mirror is tilted and decentred in random directions,
calibrates with nothing told, or as find_mirror says of the rim, and prints a table of the errors:

    tilted_mirror.py [--runs N] [--find-mirror] [--tilt DEG] [--offset MM] [--seconds S]
"""

import argparse
import math
import os
import random
import subprocess
import sys
import tempfile

import numpy
import roslib.packages
import yaml

IMAGES_OF_THE_RIM = 12


def run(program, *arguments, statuses=(0,)):
    path = roslib.packages.find_node('bearing_calibration', program)[0]
    done = subprocess.run([path] + [str(argument) for argument in arguments],
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE, universal_newlines=True)
    if done.returncode not in statuses:
        raise RuntimeError('%s ended with %d: %s' % (program, done.returncode, done.stderr))
    return done.stdout


def config(*names):
    return os.path.join(roslib.packages.get_pkg_dir('bearing_calibration'), 'config', *names)


def simulation():
    with open(config('simulation.yaml')) as file:
        return yaml.safe_load(file)


def robot():
    return ['--config', config('robots', 'simulated.yaml')]


def leaningMirror(tilt_deg, offset_mm, seed):
    """Parameters of the simulation, the directions drawn by the seed."""
    draw = random.Random(seed)
    lean, beside = draw.uniform(0, 2 * math.pi), draw.uniform(0, 2 * math.pi)
    size = math.tan(math.radians(tilt_deg))
    return {'mirror': {'lean_x': size * math.cos(lean), 'lean_y': size * math.sin(lean),
                       'offset_x': 1e-3 * offset_mm * math.cos(beside),
                       'offset_y': 1e-3 * offset_mm * math.sin(beside)}}


def calibrate(arguments, seed, folder):
    """result.yaml of one drive."""
    scene, bag, result = (os.path.join(folder, name)
                          for name in ('scene.yaml', 'drive.bag', 'result'))
    with open(scene, 'w') as file:
        yaml.safe_dump(leaningMirror(arguments.tilt, arguments.offset, seed), file)
    run('simulate_bag', '--scene', scene, '--seed', seed, '--seconds', arguments.seconds,
        '--output', bag)
    told = ['--config', foundMirror(scene, seed, folder)] if arguments.find_mirror else []
    run('calibrate_bag', bag, '--quiet', *robot(), *told, '--output', result, statuses=(0, 1, 3, 4))
    with open(os.path.join(result, 'result.yaml')) as file:
        return yaml.safe_load(file)


def foundMirror(scene, seed, folder):
    """The file of what find_mirror says of a scene's mirror."""
    images, found = (os.path.join(folder, name) for name in ('images', 'found.yaml'))
    run('render_scene', '--scene', scene, '--seed', seed, '--images', IMAGES_OF_THE_RIM,
        '--output', images)
    world = simulation()
    pictures = sorted(os.path.join(images, name) for name in os.listdir(images)
                      if name.endswith('.png'))
    with open(found, 'w') as file:
        file.write(run('find_mirror', *pictures, *robot(),
                       '--principal-point', world['camera']['centre_u'], world['camera']['centre_v'],
                       '--light-height=%g' % world['world']['lights'][0][2]))
    return found


def errorsOf(result, truth):
    """(errors of x, y [m] and yaw [rad], error of rho [m], its sigma, chi-square)."""
    mount = result['base_from_camera']
    errors = numpy.array([mount['x'] - truth['x'], mount['y'] - truth['y'],
                          math.remainder(mount['yaw'] - truth['yaw'], 2 * math.pi)])
    covariance = numpy.array(result['covariance_x_y_yaw']).reshape(3, 3)
    rho = math.hypot(mount['x'], mount['y']) - math.hypot(truth['x'], truth['y'])
    ray = numpy.array([mount['x'], mount['y']]) / math.hypot(mount['x'], mount['y'])
    rho_stddev = math.sqrt(ray @ covariance[:2, :2] @ ray)
    return errors, rho, rho_stddev, errors @ numpy.linalg.solve(covariance, errors)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--runs', type=int, default=8, help='drives, one after the other')
    parser.add_argument('--find-mirror', action='store_true',
                        help='configure what find_mirror finds')
    parser.add_argument('--tilt', type=float, default=1.0, help='of the mirror [deg]')
    parser.add_argument('--offset', type=float, default=0.5, help='of its apex [mm]')
    parser.add_argument('--seconds', type=float, default=150.0, help='of each drive')
    arguments = parser.parse_args()
    truth = simulation()['mount']
    print('| seed | state | x, y [mm] | yaw [deg] | rho, its sigma [mm] | chi-square |\n'
          '|---|---|---|---|---|---|')
    for seed in range(1, arguments.runs + 1):
        with tempfile.TemporaryDirectory() as folder:
            result = calibrate(arguments, seed, folder)
        errors, rho, rho_stddev, chi_square = errorsOf(result, truth)
        print('| %d | %s | %.1f, %.1f | %.2f | %.1f, %.1f | %.1f |' % (
            seed, result['state'], 1e3 * errors[0], 1e3 * errors[1], math.degrees(errors[2]),
            1e3 * rho, 1e3 * rho_stddev, chi_square), flush=True)
    return 0


if __name__ == '__main__':
    sys.exit(main())
