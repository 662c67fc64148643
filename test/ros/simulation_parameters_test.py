#!/usr/bin/env python3
"""Wrong parameters of the simulation nodelet are refused, all at once."""

import sys

import rostest

from refused_parameters import RefusedParameters


class SimulationParametersTest(RefusedParameters):

    NODELET = 'bearing_calibration/SimulationNodelet'
    CONFIG = 'simulation.yaml'
    FAULTS = (
        (lambda c: c['wheels'].pop('separation'), 'wheels/separation is missing'),
        (lambda c: c['wheels'].update(counter_bits=12), 'wheels/counter_bits must be 8, 16, 32 or 64'),
        (lambda c: c['camera'].update(handedness=0), 'camera/handedness must be 1 or -1'),
        (lambda c: c['camera'].update(rate=7.0), 'camera/rate must be trajectory/step_rate divided by'),
        (lambda c: c['camera'].update(focal_length='4e-3'),
         'camera/focal_length must be a finite number'),
        (lambda c: c['trajectory'].update(kind='waltz'), 'trajectory/kind must be one of'),
        (lambda c: c['trajectory'].update(wheel_speeed=0.1), 'wheel_speeed is not known'),
        (lambda c: c['world'].update(lights=[[0.0, 0.0]]), 'world/lights must be a list of lists of 5'),
        (lambda c: c['clock'].update(publish=True),
         'clock/publish is true, but /use_sim_time is not'),
        (lambda c: c['exposure'].update(reference_value=400.0),
         'exposure/reference_value must lie in'),
    )


if __name__ == '__main__':
    rostest.rosrun('bearing_calibration', 'simulation_parameters', SimulationParametersTest,
                   sys.argv)
