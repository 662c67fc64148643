#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "bearing_calibration/optics/bearing.h"
#include "bearing_calibration/vision/search_region.h"

namespace bearing_calibration::core {

/// Evidence over images: follows every candidate by its azimuth and its image radius, and says with
/// which probability what it has followed is a light. One image's errors are in the next one, too,
/// for they are those of the object's shape: a hundred images say little more than ten
/// (detection.md).
class LightTracks {
 public:
  explicit LightTracks(const SearchConfig& config) : config_(config) {}

  /// Sets the candidates' track_probability. Sets come in the order of their stamps, one for every
  /// image, empty ones too; an earlier stamp than the last begins anew.
  /// @param part_searched  of the mask, which the candidates' probabilities contain; where it is
  ///   all of it, what is not among the candidates was not found
  /// @param expected  by the calibration at about this moment. It is not asked whether a candidate
  ///   is the light, for it was made of the candidates: what it adds to their probabilities, by the
  ///   part that was searched, is taken off again. It only says how the robot turns, so that what
  ///   turns with the robot is known.
  void follow(double part_searched, const std::optional<BearingPrediction>& expected,
              BearingSet* set);

 private:
  /// Where something was seen, and where the calibration expected its light then.
  struct Sighting {
    double azimuth_rad;
    double radius_px;
    std::optional<BearingPrediction> expected;
  };
  struct Track {
    void take(const Sighting& sighting, double log_odds, Stamp stamp);
    void weigh(double log_odds);
    bool isOnTheRobot() const;
    double probability() const;

    Sighting first;
    Sighting last;
    Stamp seen;
    double turn_radps;     ///< of its azimuth
    double mean_log_odds;  ///< of the images
    int images;            ///< that were searched for it
    bool is_matched;       ///< in this image
  };

  Track* trackOf(const Bearing& candidate, Stamp stamp);

  SearchConfig config_;
  std::vector<Track> tracks_;
  Stamp last_stamp_;
};

}  // namespace bearing_calibration::core
