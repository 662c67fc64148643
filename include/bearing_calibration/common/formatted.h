#pragma once

#include <cstddef>
#include <cstdio>
#include <string>
#include <vector>

namespace bearing_calibration::core {

/// Lengths are printed in millimetres.
inline constexpr double kMillimetresPerMetre = 1e3;

/// printf into a string, of any length.
template <typename... Values>
std::string formatted(const char* format, Values... values) {
  const int length = std::snprintf(nullptr, 0, format, values...);
  std::string text(static_cast<std::size_t>(length) + 1, '\0');
  std::snprintf(text.data(), text.size(), format, values...);
  text.pop_back();  // the closing zero
  return text;
}

/// "a, b, c", with the separator ", ".
inline std::string joined(const std::vector<std::string>& texts, const std::string& separator) {
  std::string all;
  for (const std::string& text : texts) all += (all.empty() ? "" : separator) + text;
  return all;
}

}  // namespace bearing_calibration::core
