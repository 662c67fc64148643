#include "bearing_calibration/calibration/fits_beside.h"

#include <utility>

namespace bearing_calibration::core {
namespace {

/// So few images are left to the inputs' thread: one more round of the worker would find as many.
constexpr std::size_t kFewFrames = 2;
/// Ten minutes at 10 Hz. A fit that is later is of no use, and memory is bounded.
constexpr std::size_t kMostFrames = 6000;

}  // namespace

FitsBeside::FitsBeside(const CalibratorConfig& config, FitsRun fits_run)
    : fits_run_(fits_run), live_(std::make_unique<SeveralLights>(config, fits_run)) {
  if (fits_run_ == FitsRun::kAtOnce) return;
  copy_ = std::make_unique<SeveralLights>(*live_);
  worker_ = std::thread([this] { serve(); });
}

FitsBeside::~FitsBeside() {
  if (!worker_.joinable()) return;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    is_ending_ = true;
    ++epoch_;
  }
  wake_.notify_one();
  worker_.join();
}

FitsReport FitsBeside::report() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return {stage_ != Stage::kIdle, taken_, dropped_};
}

AssociationOutcome FitsBeside::process(const Frame& frame) {
  if (fits_run_ == FitsRun::kAtOnce) return live_->process(frame);
  takeOver();
  const int starts = live_->newStarts();
  const AssociationOutcome outcome = live_->process(frame);
  if (live_->newStarts() != starts) drop();
  const std::lock_guard<std::mutex> lock(mutex_);
  if (stage_ != Stage::kIdle) {
    frames_.push_back(frame);
  } else if (live_->isWorkDue()) {
    begin();
  }
  return outcome;
}

/// Copies into what is there already: memory is neither asked for nor given back.
void FitsBeside::begin() {
  *copy_ = *live_;
  frames_.clear();
  fit_epoch_ = epoch_;
  stage_ = Stage::kAtWork;
  wake_.notify_one();
}

void FitsBeside::takeOver() {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (stage_ == Stage::kAtWork && frames_.size() > kMostFrames && fit_epoch_ == epoch_) {
    ++epoch_;
    ++dropped_;
  }
  if (stage_ != Stage::kEnded) return;
  stage_ = Stage::kIdle;
  if (fit_epoch_ != epoch_) return;
  seeAll(frames_);
  std::swap(live_, copy_);
  ++taken_;
  if (live_->isWorkDue()) begin();
}

void FitsBeside::rethrow() {
  std::exception_ptr error;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    std::swap(error, error_);
  }
  if (error) std::rethrow_exception(error);
}

void FitsBeside::drop() {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (stage_ != Stage::kIdle && fit_epoch_ == epoch_) ++dropped_;
  ++epoch_;
}

void FitsBeside::forget(const CalibratorConfig& config) {
  drop();
  live_ = std::make_unique<SeveralLights>(config, fits_run_);
  const std::lock_guard<std::mutex> lock(mutex_);
  error_ = nullptr;
}

void FitsBeside::resume(const StateEstimate& earlier) {
  drop();
  live_->resume(earlier);
}

/// The worker's thread.
void FitsBeside::serve() {
  std::unique_lock<std::mutex> lock(mutex_);
  for (;;) {
    wake_.wait(lock, [this] { return is_ending_ || stage_ == Stage::kAtWork; });
    if (is_ending_) return;
    lock.unlock();
    std::exception_ptr error;
    bool has_ended = false;
    try {
      fit();
      has_ended = true;
    } catch (const Cancelled&) {
    } catch (...) {
      error = std::current_exception();
    }
    lock.lock();
    // Its stage says so since takeFrames(): by now it may be that of the next fit, begun meanwhile.
    if (has_ended) continue;
    stage_ = Stage::kIdle;
    if (fit_epoch_ == epoch_) error_ = error;
  }
}

void FitsBeside::fit() {
  const WorkOfEpoch work(epoch_, fit_epoch_);
  copy_->work();
  for (;;) {
    const std::vector<Frame> frames = takeFrames();
    if (frames.empty()) return;
    seeAll(frames);
  }
}

/// @returns what the copy has to see next; none: it has ended
std::vector<Frame> FitsBeside::takeFrames() {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (frames_.size() <= kFewFrames) {
    stage_ = Stage::kEnded;
    return {};
  }
  return std::exchange(frames_, {});
}

void FitsBeside::seeAll(const std::vector<Frame>& frames) {
  for (const Frame& frame : frames) {
    endIfCancelled();
    copy_->process(frame);
  }
}

}  // namespace bearing_calibration::core
