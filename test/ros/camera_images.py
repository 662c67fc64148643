"""Images of a round light in cameras without a mirror, by the formulas of OpenCV's documentation, which are
written here a second time and independently of the package."""

import math

import numpy
from sensor_msgs.msg import CameraInfo, Image

from calibration_world import World

WIDTH, HEIGHT = 320, 240
FRAME = 'camera_optical_frame'
BACKGROUND, LIGHT = 20.0, 150.0
LIGHT_RADIUS_M, BLUR_PX = 0.03, 0.8
LIGHT_HEIGHT_M = 0.3  # over the camera
PITCH, ROLL = 0.15, 0.05  # of the camera on its mast
# distortion_model, K as fx, fy, cx, cy, D, and the least cosine of the angle to the axis that is drawn
LENSES = {
    'perspective': ('plumb_bob', (200.0, 202.0, 163.0, 117.5), (-0.25, 0.08, 1e-3, -5e-4, -0.01), 0.65),
    'fisheye': ('equidistant', (95.0, 95.5, 158.0, 121.0), (0.02, -0.005, 0.001, -2e-4), -0.5),
}


def pixel_of(lens, place):
    """Of a place in the optical frame: x to the right, y down, z ahead."""
    _, (fx, fy, cx, cy), d, _ = LENSES[lens]
    x, y, z = place
    if lens == 'fisheye':
        r = numpy.hypot(x, y)
        theta = numpy.arctan2(r, z)
        scale = theta * (1 + d[0] * theta**2 + d[1] * theta**4 + d[2] * theta**6 + d[3] * theta**8) / r
        return fx * scale * x + cx, fy * scale * y + cy
    x, y = x / z, y / z
    r2 = x * x + y * y
    k1, k2, p1, p2, k3 = d
    radial = 1 + k1 * r2 + k2 * r2**2 + k3 * r2**3
    return (fx * (radial * x + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)) + cx,
            fy * (radial * y + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y) + cy)


def image_of(lens, place, stamp, random):
    """A message with the light at a place in the optical frame; none of it beside what is drawn."""
    rows = numpy.full((HEIGHT, WIDTH), BACKGROUND)
    distance = numpy.linalg.norm(place)
    if place[2] > LENSES[lens][3] * distance:
        u, v = pixel_of(lens, place)
        radius_px = LENSES[lens][1][0] * LIGHT_RADIUS_M / distance
        across = numpy.hypot(numpy.arange(WIDTH) - u, (numpy.arange(HEIGHT) - v)[:, None])
        edge = numpy.clip((across - max(radius_px, 1.5)) / (0.5 * BLUR_PX), None, 50.0)
        rows += LIGHT / (1.0 + numpy.exp(edge))
    noise = random.normal(0.0, 0.5, rows.shape)
    message = Image(width=WIDTH, height=HEIGHT, encoding='mono8', step=WIDTH)
    message.header.stamp, message.header.frame_id = stamp, FRAME
    message.data = numpy.clip(numpy.round(rows + noise), 0, 255).astype(numpy.uint8).tobytes()
    return message


def camera_info(lens, stamp, **changes):
    model, (fx, fy, cx, cy), d, _ = LENSES[lens]
    values = dict(width=WIDTH, height=HEIGHT, distortion_model=model, D=list(d),
                  K=[fx, 0, cx, 0, fy, cy, 0, 0, 1])
    values.update(changes)
    message = CameraInfo(**values)
    message.header.stamp, message.header.frame_id = stamp, FRAME
    return message


def link_from_mast():
    """The link is the optical frame with x ahead and z up."""
    sine, cosine = math.sin(PITCH), math.cos(PITCH)
    pitch = numpy.array([[cosine, 0, sine], [0, 1, 0], [-sine, 0, cosine]])
    sine, cosine = math.sin(ROLL), math.cos(ROLL)
    roll = numpy.array([[1, 0, 0], [0, cosine, -sine], [0, sine, cosine]])
    return (pitch @ roll).T


def is_in_image(lens, azimuth, elevation):
    """Whether an image shows what is in this direction of the mast's frame."""
    in_mast = (math.cos(elevation) * math.cos(azimuth), math.cos(elevation) * math.sin(azimuth),
               math.sin(elevation))
    ahead, left, up = link_from_mast() @ in_mast
    if ahead < LENSES[lens][3]:
        return False
    u, v = pixel_of(lens, numpy.array([-left, -up, ahead]))
    return 0.0 <= u <= WIDTH - 1 and 0.0 <= v <= HEIGHT - 1


class CameraWorld(World):
    """The sensor is a camera on a level mast, whose bearings are so exact that the wheels' noise counts."""

    WHEEL_NOISE_M = 1e-6  # variance over way of each wheel, as the tests state it

    def __init__(self, lens, start_stamp_s):
        super().__init__(start_stamp_s)
        self.lens = lens
        self.noise = numpy.random.RandomState(1)
        self.seen = {}  # azimuth and elevation in the mast's frame, by stamp

    def advance(self):
        super().advance()
        stddev = math.sqrt(self.WHEEL_NOISE_M * self.WHEEL_SPEED / self.TICK_RATE)
        self.left_m += self.random.gauss(0.0, stddev)
        self.right_m += self.random.gauss(0.0, stddev)

    def image(self):
        azimuth = self.azimuth()
        cosine, sine = math.cos(self.heading), math.sin(self.heading)
        x = self.x + cosine * self.sensor[0] - sine * self.sensor[1]
        y = self.y + sine * self.sensor[0] + cosine * self.sensor[1]
        distance = math.hypot(x - self.light[0], y - self.light[1])
        in_mast = distance * math.cos(azimuth), distance * math.sin(azimuth), LIGHT_HEIGHT_M
        ahead, left, up = link_from_mast() @ in_mast
        self.seen[self.stamp()] = azimuth, math.atan2(LIGHT_HEIGHT_M, distance)
        return image_of(self.lens, numpy.array([-left, -up, ahead]), self.stamp(), self.noise)
