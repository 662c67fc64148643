#include "bearing_calibration/track/former_track.h"

#include <bitset>

namespace bearing_calibration::core {
namespace {

constexpr unsigned kLookBack = 5;   // images
constexpr std::size_t kFewest = 4;  // of these, which after a slip happens by chance once in 10^5
constexpr double kVaguer = 4.0;     // variance of an expectation that says less
/// Images, six seconds of another light at 10 Hz: more than the batch needs (record_track.cpp).
constexpr int kPatience = 60;

}  // namespace

Association FormerTrack::fuse(const std::vector<Bearing>& candidates, const OdometryWindow& nearby,
                              const FusionConfig& fusion, const Association& present) {
  ++images_;
  const Association association =
      associate(filter_.predictAzimuth(nearby), candidates, fusion.gate);
  const bool found = association.kind == Association::Kind::kFound;
  if (found) filter_.update(fusion.widened(candidates[association.candidate]), nearby);
  const bool expected_there_too =
      present.kind == Association::Kind::kFound && present.candidate == association.candidate &&
      present.innovation.variance < kVaguer * association.innovation.variance;
  found_ = found_ << 1U | static_cast<unsigned>(found && !expected_there_too);
  return association;
}

bool FormerTrack::isBack() const {
  constexpr unsigned kLast = 1U;
  constexpr unsigned kMask = (1U << kLookBack) - 1U;
  return (found_ & kLast) != 0 && std::bitset<kLookBack>(found_ & kMask).count() >= kFewest;
}

bool FormerTrack::isHistory() const { return images_ > kPatience; }

}  // namespace bearing_calibration::core
