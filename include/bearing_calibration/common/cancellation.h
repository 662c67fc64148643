#pragma once

#include <atomic>
#include <cstdint>
#include <exception>

namespace bearing_calibration::core {

using Epoch = std::uint64_t;

/// Unwinds work that nobody wants any longer.
class Cancelled : public std::exception {
 public:
  const char* what() const noexcept override { return "cancelled"; }
};

/// While it lives, what its thread does is work of one epoch, and endIfCancelled() ends it once
/// another thread has begun the next one. The thread knows it: a fit runs on one thread throughout,
/// and else each of the functions between would need a parameter for it. They do not nest.
class WorkOfEpoch {
 public:
  WorkOfEpoch(const std::atomic<Epoch>& present, Epoch own) {
    present_ = &present;
    own_ = own;
  }
  ~WorkOfEpoch() { present_ = nullptr; }
  WorkOfEpoch(const WorkOfEpoch&) = delete;
  WorkOfEpoch& operator=(const WorkOfEpoch&) = delete;

  static bool isCancelled() { return present_ != nullptr && *present_ != own_; }

 private:
  static inline thread_local const std::atomic<Epoch>* present_ = nullptr;
  static inline thread_local Epoch own_ = 0;
};

/// For every round of a loop that can take more than a few milliseconds. Does nothing on a thread
/// without a WorkOfEpoch.
/// @throws Cancelled
inline void endIfCancelled() {
  if (WorkOfEpoch::isCancelled()) throw Cancelled();
}

}  // namespace bearing_calibration::core
