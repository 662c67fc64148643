#include "tools/owner/bounded_queue.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>

namespace bearing_calibration::core {
namespace {

// Promise bounded: a bag that is read faster than it is worked on
TEST(BoundedQueue, KeepsTheOrderAndItsBound) {
  constexpr int kItems = 10000;
  constexpr int kCapacity = 3;
  BoundedQueue<int> queue(kCapacity);
  std::atomic<int> pushed{0};
  std::thread producer([&] {
    for (int i = 0; i < kItems; ++i) {
      if (!queue.push(i)) return;
      ++pushed;
    }
    queue.finish();
  });
  for (int i = 0; i < kItems; ++i) {
    ASSERT_EQ(queue.pop(), i);
    EXPECT_LE(pushed, i + 1 + kCapacity);  // taken, and those in the queue
  }
  EXPECT_EQ(queue.pop(), std::nullopt);
  producer.join();
}

TEST(BoundedQueue, WhatWasPushedBeforeTheEndIsTaken) {
  BoundedQueue<int> queue(2);
  EXPECT_TRUE(queue.push(7));
  queue.finish();
  EXPECT_EQ(queue.pop(), 7);
  EXPECT_EQ(queue.pop(), std::nullopt);
}

TEST(BoundedQueue, ClosingFreesWhoWaitsForRoom) {
  BoundedQueue<int> queue(1);
  EXPECT_TRUE(queue.push(1));
  std::atomic<bool> accepted{true};
  std::thread producer([&] { accepted = queue.push(2); });
  std::this_thread::sleep_for(std::chrono::milliseconds(20));  // in most runs it waits by then
  queue.close();
  producer.join();
  EXPECT_FALSE(accepted);
  EXPECT_FALSE(queue.push(3));
}

}  // namespace
}  // namespace bearing_calibration::core
