#pragma once

#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>

/// One harness is one library that defines run(): for libFuzzer (scripts/fuzz), and for a test that
/// runs its seeds and some random inputs.
namespace bearing_calibration::fuzz {

/// Feeds what a fuzzer's bytes stand for into the package.
/// @return whether it came far: past the first checks
/// @throws std::logic_error when something that must hold does not
bool run(const std::uint8_t* data, std::size_t size);

inline void require(bool holds, const std::string& sentence) {
  if (!holds) throw std::logic_error(sentence);
}

}  // namespace bearing_calibration::fuzz
