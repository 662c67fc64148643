#pragma once

#include <cstddef>
#include <cstdint>
#include <iterator>
#include <string>

namespace bearing_calibration::fuzz {

/// Takes a fuzzer's bytes one after another; zeros when there are no more. The arguments of a call
/// in (), and the sides of most operators, are evaluated in any order: two readings of one
/// expression stand in {}, or in statements of their own.
class ByteReader {
 public:
  ByteReader(const std::uint8_t* data, std::size_t size) : data_(data), left_(size) {}

  std::uint8_t byte() {
    if (left_ == 0) return 0;
    --left_;
    return *data_++;
  }
  std::uint16_t word() {
    const std::uint8_t low = byte();
    return static_cast<std::uint16_t>(low | byte() << 8U);
  }
  bool isEmpty() const { return left_ == 0; }

  bool flag() { return (byte() & 1U) != 0; }
  /// In 65536 steps.
  double between(double low, double high) { return low + (high - low) * word() / 65535.0; }
  /// Any 64 bits.
  std::uint64_t bits();
  /// Of every kind of number: none, endless, tiny, huge, of everyday size, or of any bits.
  double anyNumber();
  double finiteNumber();
  /// At most so many bytes of text.
  std::string text(std::size_t most);

  template <typename List>
  const auto& pick(const List& list) {
    return list[byte() % std::size(list)];
  }

 private:
  const std::uint8_t* data_;
  std::size_t left_;
};

}  // namespace bearing_calibration::fuzz
