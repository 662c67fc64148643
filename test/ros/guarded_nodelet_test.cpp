#include "bearing_calibration_ros/guarded_nodelet.h"

#include <gtest/gtest.h>
#include <nodelet/detail/callback_queue_manager.h>
#include <ros/ros.h>
#include <std_msgs/String.h>

#include <boost/make_shared.hpp>
#include <boost/weak_ptr.hpp>
#include <memory>
#include <stdexcept>
#include <string>

namespace bearing_calibration_ros {
namespace {

/// Does not start, when it has subscribed to something already.
struct HalfStarted : GuardedNodelet {
  ~HalfStarted() override { endCallbacks(); }
  void start() override {
    subscriber = getNodeHandle().subscribe("words", 1, &HalfStarted::hear, this);
    throw XmlRpc::XmlRpcException("a wrong type");  // no std::exception
  }
  void hear(const std_msgs::StringConstPtr&) {}
  ros::Subscriber subscriber;
};

// As the loader does it: the queue goes first.
// Promise alive: a nodelet that cannot start after it has subscribed
TEST(GuardedNodelet, KeepsItsQueueWhereItDoesNotStart) {
  nodelet::detail::CallbackQueueManager manager(1);
  auto queue = boost::make_shared<nodelet::detail::CallbackQueue>(&manager);
  manager.addQueue(queue, false);
  auto nodelet = std::make_unique<HalfStarted>();
  try {
    nodelet->init("/half_started", {}, {}, queue.get(), queue.get());
    ADD_FAILURE() << "it has started";
  } catch (const std::runtime_error& error) {
    EXPECT_EQ(error.what(), std::string("a wrong type"));
  }
  manager.removeQueue(queue);
  const boost::weak_ptr<nodelet::detail::CallbackQueue> left = queue;
  queue.reset();
  ASSERT_FALSE(left.expired());
  nodelet.reset();
  EXPECT_TRUE(left.expired());
}

}  // namespace
}  // namespace bearing_calibration_ros
