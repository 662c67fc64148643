#pragma once

#include <cstddef>
#include <cstdio>
#include <string>

namespace bearing_calibration::core {

/// printf into a string, of any length.
template <typename... Values>
std::string formatted(const char* format, Values... values) {
  const int length = std::snprintf(nullptr, 0, format, values...);
  std::string text(static_cast<std::size_t>(length) + 1, '\0');
  std::snprintf(text.data(), text.size(), format, values...);
  text.pop_back();  // the closing zero
  return text;
}

}  // namespace bearing_calibration::core
