#include "fuzz/byte_reader.h"

#include <cmath>
#include <cstring>
#include <limits>

namespace bearing_calibration::fuzz {

std::uint64_t ByteReader::bits() {
  std::uint64_t bits = 0;
  for (int i = 0; i < 4; ++i) bits = bits << 16U | word();
  return bits;
}

double ByteReader::anyNumber() {
  using Limits = std::numeric_limits<double>;
  static constexpr double kOdd[] = {0.0,
                                    -0.0,
                                    1.0,
                                    -1.0,
                                    3.141592653589793,
                                    -3.141592653589793,
                                    6.283185307179586,
                                    1e-9,
                                    1e9,
                                    1e-300,
                                    -1e300,
                                    Limits::denorm_min(),
                                    Limits::max(),
                                    Limits::lowest(),
                                    Limits::infinity(),
                                    -Limits::infinity(),
                                    Limits::quiet_NaN()};
  constexpr int kKinds = 4;
  switch (byte() % kKinds) {
    case 0:
      return pick(kOdd);
    case 1: {
      const std::uint64_t any = bits();
      double number = 0.0;
      std::memcpy(&number, &any, sizeof(number));
      return number;
    }
    default:
      return between(-10.0, 10.0);
  }
}

double ByteReader::finiteNumber() {
  const double number = anyNumber();
  return std::isfinite(number) ? number : 1.0;
}

std::string ByteReader::text(std::size_t most) {
  std::string text;
  while (!isEmpty() && text.size() < most) text.push_back(static_cast<char>(byte()));
  return text;
}

}  // namespace bearing_calibration::fuzz
