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
  WorkOfEpoch(const std::atomic<Epoch>& present, Epoch own);
  ~WorkOfEpoch();
  WorkOfEpoch(const WorkOfEpoch&) = delete;
  WorkOfEpoch& operator=(const WorkOfEpoch&) = delete;
};

/// For every round of a loop that can take more than a few milliseconds. Does nothing on a thread
/// without a WorkOfEpoch.
/// @throws Cancelled
void endIfCancelled();

}  // namespace bearing_calibration::core
