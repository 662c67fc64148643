#include "tools/owner/recording_csv.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <set>

#include "bearing_calibration/common/angle.h"

namespace bearing_calibration::core {
namespace {

constexpr double kEarliestStamp_s = 1e-9;  // zero is no stamp
/// ros::Time counts seconds in 32 bits.
constexpr double kLatestStamp_s = 4294967295.0;
/// Half of what 64 bits hold: differences of two counts still fit.
constexpr double kLargestCount_ticks = 4.6e18;

std::vector<std::string> cellsOf(const std::string& line) {
  std::vector<std::string> cells;
  std::size_t begin = 0;
  for (std::size_t comma = line.find(','); comma != std::string::npos;
       comma = line.find(',', begin)) {
    cells.push_back(line.substr(begin, comma - begin));
    begin = comma + 1;
  }
  cells.push_back(line.substr(begin));
  for (std::string& cell : cells) {
    const std::size_t first = cell.find_first_not_of(" \t");
    const std::size_t last = cell.find_last_not_of(" \t");
    cell = first == std::string::npos ? std::string() : cell.substr(first, last - first + 1);
  }
  return cells;
}

/// Rows of a CSV file by column name, with the place of each for the errors.
class CsvReader {
 public:
  CsvReader(std::istream& stream, std::string file) : stream_(stream), file_(std::move(file)) {
    if (!nextLine()) throw error("the file is empty or cannot be read");
    columns_ = cells_;
  }

  bool hasColumn(const std::string& name) const {
    return std::find(columns_.begin(), columns_.end(), name) != columns_.end();
  }

  std::size_t column(const std::string& name) const {
    if (!hasColumn(name)) throw formError("column '" + name + "' is missing: it has " + line_);
    return static_cast<std::size_t>(std::find(columns_.begin(), columns_.end(), name) -
                                    columns_.begin());
  }

  /// The next row that is not blank; false at the end.
  bool nextRow() {
    if (!nextLine()) return false;
    if (cells_.size() != columns_.size()) {
      const bool is_split = cells_.size() > columns_.size();
      throw formError("has " + std::to_string(cells_.size()) +
                      " cells where the first line names " + std::to_string(columns_.size()) +
                      " columns" + (is_split ? ": a decimal comma? numbers have points" : ""));
    }
    return true;
  }

  double number(std::size_t column) const {
    const std::string& cell = cells_[column];
    char* end = nullptr;
    const double value = std::strtod(cell.c_str(), &end);
    if (cell.empty() || *end != '\0') throw formError(describe(column) + " is not a number");
    if (!std::isfinite(value)) throw error(describe(column) + " is not finite");
    return value;
  }

  std::int64_t wholeNumber(std::size_t column) const {
    const std::string& cell = cells_[column];
    char* end = nullptr;
    errno = 0;
    const std::int64_t value = std::strtoll(cell.c_str(), &end, 10);
    if (cell.empty() || *end != '\0') throw formError(describe(column) + " is not a whole number");
    if (errno == ERANGE) throw error(describe(column) + " does not fit 64 bits");
    return value;
  }

  Stamp stamp(std::size_t column, double start_time_s) const {
    const double time_s = start_time_s + number(column);
    if (!(time_s >= kEarliestStamp_s && time_s <= kLatestStamp_s)) {  // a start time may be NaN
      throw error(describe(column) + " becomes the stamp " + std::to_string(time_s) +
                  " s, which ROS cannot hold: stamps lie above zero and below 2^32 s");
    }
    return stampFromSeconds(time_s);
  }

  RecordingError error(const std::string& sentence) const {
    return RecordingError(file_, line_number_, sentence);
  }
  RecordingError noRows() const {
    return error("there are no rows below the names of the columns");
  }
  std::string describe(std::size_t column) const {
    return columns_[column] + " '" + cells_[column] + "'";
  }

 private:
  void removeByteOrderMark() {
    constexpr char kMark[] = "\xEF\xBB\xBF";  // of UTF-8
    if (line_.compare(0, sizeof(kMark) - 1, kMark) == 0) line_.erase(0, sizeof(kMark) - 1);
  }

  /// An error in a line that is as spreadsheets write it, or else the sentence.
  RecordingError formError(const std::string& sentence) const {
    const auto holds = [this](const auto& what) { return line_.find(what) != std::string::npos; };
    const std::string begin = line_.substr(0, 2);
    if (begin == "\xFF\xFE" || begin == "\xFE\xFF") {
      return error("the file is in UTF-16: save it as UTF-8");
    }
    if (holds('\0')) {
      return error("has zero bytes: the file is damaged, or in UTF-16 (save it as UTF-8)");
    }
    if (holds(';')) {
      return error(
          "cells are separated by semicolons: separate them by commas, and write numbers "
          "with points");
    }
    if (holds('\r')) {
      return error(
          "lines end with carriage returns alone: save it with line feeds (Unix or Windows)");
    }
    if (holds('"')) return error("has quotes: write the cells without them, numbers with points");
    if (holds('\t') && !holds(',')) {
      return error("cells are separated by tabs: separate them by commas");
    }
    return error(sentence);
  }

  bool nextLine() {
    while (std::getline(stream_, line_)) {
      ++line_number_;
      if (line_number_ == 1) removeByteOrderMark();
      if (line_.find('\0') != std::string::npos) throw formError("");
      if (!line_.empty() && line_.back() == '\r') line_.pop_back();
      cells_ = cellsOf(line_);
      if (cells_.size() > 1 || !cells_.front().empty()) return true;
    }
    return false;
  }

  std::istream& stream_;
  std::string file_;
  std::vector<std::string> columns_;
  std::vector<std::string> cells_;
  std::string line_;
  std::size_t line_number_ = 0;
};

/// Sums of wheel increments as counts.
class IncrementSum {
 public:
  explicit IncrementSum(double meters_per_tick) : meters_per_tick_(meters_per_tick) {}

  std::int64_t add(const CsvReader& csv, std::size_t column) {
    sum_m_ += csv.number(column);
    const double ticks = sum_m_ / meters_per_tick_;
    if (std::abs(ticks) > kLargestCount_ticks) {
      throw csv.error(csv.describe(column) + " adds up to more ticks than 64 bits hold");
    }
    return std::llround(ticks);
  }

 private:
  double meters_per_tick_;
  double sum_m_ = 0.0;
};

void requirePositive(double meters_per_tick) {
  if (!(std::isfinite(meters_per_tick) && meters_per_tick > 0.0)) {
    throw std::invalid_argument("meters_per_tick must be greater than 0");
  }
}

}  // namespace

RecordingError::RecordingError(const std::string& file, std::size_t line,
                               const std::string& sentence)
    : std::runtime_error(file + ":" + std::to_string(line) + ": " + sentence) {}

std::vector<CounterRow> readCounters(std::istream& stream, const std::string& file,
                                     const RecordingUnits& units) {
  requirePositive(units.meters_per_tick);
  CsvReader csv(stream, file);
  const bool has_ticks = csv.hasColumn("left_ticks") || csv.hasColumn("right_ticks");
  if (has_ticks && (csv.hasColumn("left_m") || csv.hasColumn("right_m"))) {
    throw csv.error("has columns of metres and of ticks: which ones are meant?");
  }
  const std::size_t time = csv.column("t_s");
  const std::size_t left = csv.column(has_ticks ? "left_ticks" : "left_m");
  const std::size_t right = csv.column(has_ticks ? "right_ticks" : "right_m");

  std::vector<CounterRow> rows;
  IncrementSum left_sum(units.meters_per_tick);
  IncrementSum right_sum(units.meters_per_tick);
  while (csv.nextRow()) {
    const Stamp stamp = csv.stamp(time, units.start_time_s);
    const auto isRepetition = [&] {
      return has_ticks && stamp == rows.back().stamp &&
             csv.wholeNumber(left) == rows.back().left_ticks &&
             csv.wholeNumber(right) == rows.back().right_ticks;
    };
    if (!rows.empty() && stamp <= rows.back().stamp) {
      if (isRepetition()) continue;
      throw csv.error(csv.describe(time) + " is not later than that of the row before");
    }
    if (has_ticks) {
      rows.push_back({stamp, csv.wholeNumber(left), csv.wholeNumber(right)});
    } else {
      rows.push_back({stamp, left_sum.add(csv, left), right_sum.add(csv, right)});
    }
  }
  if (rows.empty()) throw csv.noRows();
  return rows;
}

std::vector<ObservationRow> readObservations(std::istream& stream, const std::string& file,
                                             std::int32_t landmark_id,
                                             const RecordingUnits& units) {
  CsvReader csv(stream, file);
  const std::size_t time = csv.column("t_s");
  const std::size_t landmark = csv.column("landmark_id");
  const std::size_t bearing = csv.column("bearing_rad");

  std::vector<ObservationRow> rows;
  std::set<std::int64_t> landmarks;
  std::optional<Stamp> last;
  while (csv.nextRow()) {
    const ObservationRow row{csv.stamp(time, units.start_time_s), csv.number(bearing)};
    if (std::abs(row.bearing_rad) > 2.0 * kPi) {
      throw csv.error(csv.describe(bearing) +
                      " lies beyond 2 pi: is it in degrees? bearings are in radians");
    }
    if (last && row.stamp < *last) {
      throw csv.error(csv.describe(time) + " is earlier than that of the row before");
    }
    last = row.stamp;
    landmarks.insert(csv.wholeNumber(landmark));
    if (csv.wholeNumber(landmark) == landmark_id) rows.push_back(row);
  }
  if (landmarks.empty()) throw csv.noRows();
  if (rows.empty()) {
    std::string seen;
    for (const std::int64_t id : landmarks) seen += (seen.empty() ? "" : ", ") + std::to_string(id);
    throw csv.error("landmark " + std::to_string(landmark_id) + " is never seen, only (" + seen +
                    ")");
  }
  return rows;
}

}  // namespace bearing_calibration::core
