"""Images of a point light in the default rig's conic mirror, drawn from the closed forms of
detection.md, which are written here a second time and independently of the package."""

import math
import struct
import zlib

from sensor_msgs.msg import CameraInfo, CompressedImage, Image

WIDTH, HEIGHT = 640, 480
CENTRE_U, CENTRE_V, HANDEDNESS = 319.5, 239.5, -1
FOCAL_M, APERTURE_M, FOCUS_M, PIXEL_M = 4e-3, 1.7e-3, 0.06, 5.6e-6
IMAGE_PX = 1.0 / (1.0 / FOCAL_M - 1.0 / FOCUS_M) / PIXEL_M
APEX_M, TAU, RIM_M = 0.08, math.radians(52.5), 0.035
DARK, BACKGROUND, LIGHT = 2, 20, 160
SUBSAMPLES = 8  # along a pixel's side


class Spot:
    """The image of a light at a distance and height (over the apex) [m] and an azimuth [rad]."""

    def __init__(self, azimuth, distance=1.0, height=-0.03, aperture=APERTURE_M):
        below = math.atan2(distance, height)
        apex_to_light = math.hypot(distance, height)
        x = apex_to_light * math.sin(2.0 * TAU - below)  # the light's reflection in the cone's edge
        z = APEX_M + apex_to_light * math.cos(2.0 * TAU - below)
        theta = math.atan2(x, z)
        hit = APEX_M / (1.0 / math.tan(theta) - 1.0 / math.tan(TAU))
        to_mirror = hit / math.sin(theta)
        to_light = (distance - hit) / math.sin(2.0 * TAU - theta)
        sagittal = 1.0 / (1.0 / to_light + (math.sin(2.0 * TAU - theta) - math.sin(theta)) / hit)
        image_m = 1.0 / (1.0 / FOCAL_M - 1.0 / FOCUS_M)
        scale = aperture * image_m / PIXEL_M
        self.azimuth = azimuth
        self.distance = distance
        self.image_radius = image_m / PIXEL_M * math.tan(theta)
        self.tangential = scale * abs(1.0 / FOCUS_M - 1.0 / ((to_mirror + sagittal) * math.cos(theta)))
        self.radial = scale * abs(1.0 / FOCUS_M - 1.0 / z)
        self.screen_angle = HANDEDNESS * azimuth
        self.u = CENTRE_U + self.image_radius * math.cos(self.screen_angle)
        self.v = CENTRE_V - self.image_radius * math.sin(self.screen_angle)

    def coverage(self, u, v):
        """The part of a pixel that lies inside the spot."""
        inside = 0
        for i in range(SUBSAMPLES ** 2):
            du = u - self.u - 0.5 + (i % SUBSAMPLES + 0.5) / SUBSAMPLES
            dv = v - self.v - 0.5 + (i // SUBSAMPLES + 0.5) / SUBSAMPLES
            outward = math.cos(self.screen_angle) * du - math.sin(self.screen_angle) * dv
            across = math.sin(self.screen_angle) * du + math.cos(self.screen_angle) * dv
            inside += (2.0 * outward / self.radial) ** 2 + (2.0 * across / self.tangential) ** 2 <= 1.0
        return inside / SUBSAMPLES ** 2


def levels(spots, light=LIGHT):
    """Rows of grey levels, 255 at most."""
    rows = [[BACKGROUND] * WIDTH for _ in range(HEIGHT)]
    for spot in spots:
        reach = int(spot.radial)
        for v in range(int(spot.v) - reach, int(spot.v) + reach):
            for u in range(int(spot.u) - reach, int(spot.u) + reach):
                rows[v][u] = min(255, rows[v][u] + round(light * spot.coverage(u, v)))
    return rows


BYTES_PER_LEVEL = {'bgr8': 3, 'rgb8': 3, 'bgra8': 4, 'rgba8': 4, 'yuv422': 2, 'yuv422_yuy2': 2}
NO_COLOUR = 128  # of U and V


def image_of(spots, stamp, encoding='mono8', padding=0, light=LIGHT):
    """A message with `padding` unused bytes after each row. Of 16 bits a level is 16 steps."""
    message = Image(width=WIDTH, height=HEIGHT, encoding=encoding, is_bigendian=0)
    message.header.stamp = stamp
    message.header.frame_id = 'camera_optical'
    bytes_per_level = BYTES_PER_LEVEL.get(encoding, 2 if encoding.endswith('16') else 1)
    message.step = WIDTH * bytes_per_level + padding
    data = bytearray()
    for row in levels(spots, light):
        if encoding.endswith('16'):
            for level in row:
                data += (16 * level).to_bytes(2, 'little')
        elif encoding.startswith('yuv422'):
            for level in row:
                data += bytes([NO_COLOUR, level] if encoding == 'yuv422' else [level, NO_COLOUR])
        else:
            for level in row:
                data += bytes([level]) * bytes_per_level
        data += bytes([255]) * padding
    message.data = bytes(data)
    return message


def png_of(image):
    """A mono8 image as image_transport's plugin compresses it."""
    rows = bytearray()
    for v in range(image.height):
        rows += b'\0' + image.data[v * image.step:][:image.width]  # no filter

    def chunk(kind, content):
        return struct.pack('>I', len(content)) + kind + content + struct.pack(
            '>I', zlib.crc32(kind + content))
    head = struct.pack('>IIBBBBB', image.width, image.height, 8, 0, 0, 0, 0)
    message = CompressedImage(header=image.header, format=image.encoding + '; png compressed ')
    message.data = (b'\x89PNG\r\n\x1a\n' + chunk(b'IHDR', head) +
                    chunk(b'IDAT', zlib.compress(bytes(rows), 1)) + chunk(b'IEND', b''))
    return message


def with_rim(image, u, v):
    """A mono8 image that is dark past the mirror's rim, which has its centre there."""
    rim_px = RIM_M * IMAGE_PX / (APEX_M + RIM_M / math.tan(TAU))
    data = bytearray(image.data)
    for row in range(HEIGHT):
        for column in range(WIDTH):
            if math.hypot(column - u, row - v) > rim_px:
                data[row * image.step + column] = DARK
    image.data = bytes(data)
    return image


def camera_info(stamp, width=WIDTH, height=HEIGHT, **fields):
    message = CameraInfo(width=width, height=height, **fields)
    message.header.stamp = stamp
    return message

