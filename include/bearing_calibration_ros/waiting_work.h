#pragma once

#include <ros/callback_queue_interface.h>

#include <boost/make_shared.hpp>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <utility>

namespace bearing_calibration_ros {

/// The work on messages that wait while one is worked on: of more than `most` the oldest is dropped
/// and counted, which a subscriber's own queue does not tell.
///
/// add() is called by callbacks of `queue`, which serves one at a time. The work is a callback of
/// its own, behind those that wait already: so by then all that has come meanwhile is here.
class WaitingWork {
 public:
  using Work = std::function<void()>;

  WaitingWork(ros::CallbackQueueInterface* queue, std::size_t most) : queue_(queue), most_(most) {}
  ~WaitingWork() { queue_->removeByID(id()); }
  WaitingWork(const WaitingWork&) = delete;
  WaitingWork& operator=(const WaitingWork&) = delete;

  void add(Work work) {
    waiting_.push_back(std::move(work));
    if (waiting_.size() <= most_) {
      queue_->addCallback(boost::make_shared<Turn>(this), id());
      return;
    }
    waiting_.pop_front();  // its turn is the next one's
    ++dropped_;
  }

  std::uint64_t dropped() const { return dropped_; }

 private:
  struct Turn : ros::CallbackInterface {
    explicit Turn(WaitingWork* all) : all_(all) {}
    CallResult call() override {
      all_->doFirst();
      return Success;
    }
    WaitingWork* all_;
  };

  void doFirst() {
    const Work first = std::move(waiting_.front());
    waiting_.pop_front();
    first();
  }
  std::uint64_t id() const { return reinterpret_cast<std::uintptr_t>(this); }

  ros::CallbackQueueInterface* queue_;
  std::size_t most_;
  std::deque<Work> waiting_;
  std::uint64_t dropped_ = 0;
};

}  // namespace bearing_calibration_ros
