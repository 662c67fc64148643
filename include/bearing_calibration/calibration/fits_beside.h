#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "bearing_calibration/calibration/several_lights.h"
#include "bearing_calibration/common/cancellation.h"

namespace bearing_calibration::core {

/// What became of the fits that run beside.
struct FitsReport {
  bool under_way = false;     ///< begun, and not yet taken over
  std::uint32_t taken = 0;    ///< taken over
  std::uint32_t dropped = 0;  ///< because what they were begun on no longer holds
};

/// The estimation, with its fits at once or on a thread of their own. Beside: when an image makes a
/// fit due, the live estimation goes on without it, a copy of it does the fit, sees the images that
/// have come meanwhile, and takes the live one's place. One fit is under way at a time.
///
/// Threading: all functions are for one thread at a time, that of the inputs; only it touches the
/// live estimation. The copy belongs to the worker while a fit is under way, else to the inputs'.
class FitsBeside {
 public:
  /// @throws std::system_error when there is no thread to be had
  FitsBeside(const CalibratorConfig& config, FitsRun fits_run);
  /// Waits until a fit under way has noticed that it is cancelled.
  ~FitsBeside();
  FitsBeside(const FitsBeside&) = delete;
  FitsBeside& operator=(const FitsBeside&) = delete;

  const SeveralLights& live() const { return *live_; }
  FitsReport report() const;

  /// See SeveralLights::process().
  AssociationOutcome process(const Frame& frame);
  /// Takes over a fit that has ended, if there is one.
  void takeOver();
  /// Throws what has ended a fit since the last call, if anything has.
  void rethrow();

  /// A fit that is under way was begun on what no longer holds: nothing of it is taken over.
  void drop();
  /// Begins again from nothing.
  void forget(const CalibratorConfig& config);
  /// See SeveralLights::resume().
  void resume(const StateEstimate& earlier);

 private:
  enum class Stage : std::uint8_t { kIdle, kAtWork, kEnded };

  void begin();
  void serve();
  void fit();
  std::vector<Frame> takeFrames();
  void seeAll(const std::vector<Frame>& frames);

  const FitsRun fits_run_;
  std::unique_ptr<SeveralLights> live_;
  std::unique_ptr<SeveralLights> copy_;  ///< see above whose it is
  std::atomic<Epoch> epoch_{0};          ///< a fit of an earlier one counts for nothing

  mutable std::mutex mutex_;  ///< of all below; held for moments only
  std::condition_variable wake_;
  Stage stage_ = Stage::kIdle;
  Epoch fit_epoch_ = 0;        ///< of the fit under way
  std::vector<Frame> frames_;  ///< since it was begun, that the copy has not seen
  std::exception_ptr error_;
  bool is_ending_ = false;
  std::uint32_t taken_ = 0;
  std::uint32_t dropped_ = 0;
  std::thread worker_;  ///< last: it uses the others
};

}  // namespace bearing_calibration::core
