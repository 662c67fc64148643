#pragma once

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/formatted.h"

namespace bearing_calibration::core {

/// What no robot needs, from one of millimetres to a truck, and no room: a parameter beyond has a
/// wrong unit or a slip of the keyboard, and its arithmetic would fail long after the start.
namespace plausible {

inline constexpr double kShortest_m = 1e-4;
inline constexpr double kFarthest_m = 1000.0;
inline constexpr double kFastest_mps = 100.0;
inline constexpr double kSlowest_mps = 1e-4;
inline constexpr double kFastestTurn_radps = 100.0;
inline constexpr double kBriefest_s = 1e-3;
inline constexpr double kLongest_s = 86400.0;        // a day
inline constexpr double kLongestHistory_s = 3600.0;  // of wheel readings: 360000 at 100 Hz
inline constexpr double kRarest_hz = 1e-3;
inline constexpr double kMostFrequent_hz = 1e4;
inline constexpr double kTurn_rad = 2.0 * kPi;
inline constexpr double kLeastAngle_rad = 1e-9;  // of a standard deviation; a simulated sensor's
inline constexpr double kLeastLength_m = 1e-9;   // the same
inline constexpr double kMostSigmas = 1000.0;
inline constexpr double kLargestRatio = 100.0;  // of two things that should be of one size
// Of an image: wider ones are stitched or wrong; integer moments and memory are made for this.
inline constexpr double kLargestSide_px = 16384.0;
inline constexpr int kMostOfAKind = 1000000;  // bearings, images: a day of them

}  // namespace plausible

/// To whom a configuration declares its parameters, each once, by name, member and bounds:
///
///     void BearingInputConfig::declare(Parameters& params) {
///       params.number("bearings/latency", latency_s, -kLongestLatency_s, kLongestLatency_s);
///
/// This class checks what the members hold; one that reads fills them first. Either collects a
/// sentence for each error, which has the parameter's name as a word.
class Parameters {
 public:
  /// A list of lists of as many numbers each.
  struct Rows {
    std::size_t size;
    std::vector<std::vector<double>> rows;
  };
  /// Where a value goes that is read; a list of numbers has its size already.
  using Target = std::variant<double*, int*, bool*, std::string*, std::vector<double>*, Rows*>;

  virtual ~Parameters() = default;

  /// A finite number in [least, most], whatever the other parameters are.
  void number(const std::string& name, double& value, double least, double most) {
    read(name, value);
    between(name, value, least, most);
  }
  void integer(const std::string& name, int& value, double least, double most) {
    read(name, value);
    between(name, value, least, most);
  }
  /// One of `names`, which are those of the enumeration in its order.
  template <typename Enumeration>
  void choice(const std::string& name, const std::vector<std::string>& names, Enumeration& value) {
    std::string chosen = names.at(static_cast<std::size_t>(value));
    read(name, chosen);
    oneOf(name, chosen, names);
    const auto found = std::find(names.begin(), names.end(), chosen);
    if (found != names.end()) value = static_cast<Enumeration>(found - names.begin());
  }
  /// A list of items of `row_size` finite numbers each.
  template <typename Item, typename ItemFrom>
  void list(const std::string& name, std::size_t row_size, std::vector<Item>& items,
            ItemFrom item_from) {
    Rows rows{row_size, {}};
    read(name, rows);
    for (const std::vector<double>& row : rows.rows) items.push_back(item_from(row));
  }

  /// Of a number that only its owner knows, but need not give beside the others: `value` takes its
  /// place where it is not given. To be called before the number is declared.
  virtual void standIn(const std::string& /*name*/, double /*value*/) {}

  /// What is read as it is, without bounds. @returns whether it was read
  template <typename Value>
  bool read(const std::string& name, Value& value) {
    return readInto(name, &value);
  }

  /// The names in a group that its owner chooses; none where nothing is read.
  virtual std::vector<std::string> namesIn(const std::string& /*group*/) const { return {}; }

  /// What must hold beyond the bounds.
  void that(bool holds, const std::string& sentence) {
    if (!holds) addError(sentence);
  }
  void notNegative(const std::string& name, double value) {
    that(std::isfinite(value) && value >= 0.0,
         name + " must not be negative, but is " + textOf(value));
  }
  virtual void between(const std::string& name, double value, double least, double most) {
    that(std::isfinite(value) && value >= least && value <= most,
         name + " must lie in [" + textOf(least) + ", " + textOf(most) + "], but is " +
             textOf(value));
  }
  virtual void oneOf(const std::string& name, const std::string& value,
                     const std::vector<std::string>& names) {
    that(std::find(names.begin(), names.end(), value) != names.end(),
         name + " must be one of (" + joined(names, ", ") + "), but is '" + value + "'");
  }
  void notEmpty(const std::string& name, const std::string& value) {
    that(!value.empty(), name + " must not be empty");
  }

  virtual void addError(const std::string& sentence) { errors_.push_back(sentence); }
  const std::vector<std::string>& errors() const { return errors_; }

 private:
  virtual bool readInto(const std::string& /*name*/, const Target& /*target*/) { return false; }
  static std::string textOf(double value) { return formatted("%.10g", value); }

  std::vector<std::string> errors_;
};

/// One sentence for each value of a configuration that cannot be; empty when all is well.
template <typename Config>
std::vector<std::string> errorsOf(Config config) {
  Parameters params;
  config.declare(params);
  return params.errors();
}

/// `config` itself, for use in an initialiser list.
/// @throws std::invalid_argument with every sentence of errorsOf().
template <typename Config>
const Config& validated(const Config& config) {
  const std::vector<std::string> errors = errorsOf(config);
  if (!errors.empty()) throw std::invalid_argument(joined(errors, "; "));
  return config;
}

}  // namespace bearing_calibration::core
