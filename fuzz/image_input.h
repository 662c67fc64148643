#pragma once

#include <sensor_msgs/Image.h>

#include <cstddef>
#include <cstdint>

namespace bearing_calibration_ros {

/// Takes a fuzzer's bytes one after another; zeros when there are no more.
class ByteReader {
 public:
  ByteReader(const std::uint8_t* data, std::size_t size) : data_(data), left_(size) {}

  std::uint8_t byte();
  std::uint16_t word() { return static_cast<std::uint16_t>(byte() | byte() << 8U); }
  bool isEmpty() const { return left_ == 0; }

 private:
  const std::uint8_t* data_;
  std::size_t left_;
};

/// An image message as a broken or a sound driver may send it: a size and an encoding out of lists
/// (with unknown ones), now and then a wrong step, a truncated body or a zero stamp, and in it
/// black, white, noise, or ellipses drawn one by one, so that the fuzzer finds its way to spots.
sensor_msgs::Image imageFrom(ByteReader* bytes);

}  // namespace bearing_calibration_ros
