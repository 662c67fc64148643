#include <gtest/gtest.h>
#include <ros/callback_queue.h>

#include <vector>

#include "bearing_calibration_ros/image_input.h"

namespace bearing_calibration_ros {
namespace {

/// A subscriber's callback: hands the work on its message over.
struct Arrival : ros::CallbackInterface {
  Arrival(WaitingWork* waiting, WaitingWork::Work work) : waiting_(waiting), work_(work) {}
  CallResult call() override {
    waiting_->add(work_);
    return Success;
  }
  WaitingWork* waiting_;
  WaitingWork::Work work_;
};

class Waiting : public testing::Test {
 protected:
  /// Messages that take no time but the first, during which `meanwhile` happens.
  void arrive(WaitingWork* waiting, int first, int last, const WaitingWork::Work& meanwhile = {}) {
    for (int i = first; i <= last; ++i) {
      queue_.addCallback(boost::make_shared<Arrival>(waiting, [this, i, first, meanwhile] {
        if (i == first && meanwhile) meanwhile();
        done_.push_back(i);
      }));
    }
  }
  void serve() {
    while (!queue_.isEmpty()) queue_.callOne();
  }
  ros::CallbackQueue queue_;
  std::vector<int> done_;
};

TEST_F(Waiting, WhatComesMeanwhileIsDroppedButTheNewest) {
  WaitingWork waiting(&queue_, 1);
  arrive(&waiting, 1, 1, [&] { arrive(&waiting, 2, 6); });
  serve();
  EXPECT_EQ(done_, (std::vector<int>{1, 6}));
  EXPECT_EQ(waiting.dropped(), 4u);
  arrive(&waiting, 7, 7);
  serve();
  EXPECT_EQ(done_.back(), 7);
}

TEST_F(Waiting, ALongerQueueKeepsTheNewestInTheirOrder) {
  WaitingWork waiting(&queue_, 3);
  arrive(&waiting, 1, 5);
  serve();
  EXPECT_EQ(done_, (std::vector<int>{3, 4, 5}));
  EXPECT_EQ(waiting.dropped(), 2u);
}

TEST_F(Waiting, NothingIsDoneAfterItsEnd) {
  {
    WaitingWork waiting(&queue_, 1);
    waiting.add([this] { done_.push_back(1); });
  }
  serve();
  EXPECT_TRUE(done_.empty());
}

}  // namespace
}  // namespace bearing_calibration_ros
