#pragma once

#include <stdexcept>
#include <string>

namespace bearing_calibration::core {

/// `config` itself, for use in an initialiser list.
/// @throws std::invalid_argument with every sentence of config.validate().
template <typename Config>
const Config& validated(const Config& config) {
  std::string message;
  for (const std::string& error : config.validate()) {
    message += (message.empty() ? "" : "; ") + error;
  }
  if (!message.empty()) throw std::invalid_argument(message);
  return config;
}

}  // namespace bearing_calibration::core
