#pragma once

#include <rosbag/bag.h>
#include <rosbag/exceptions.h>

#include <cstdio>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

namespace bearing_calibration::core {

/// A bag that is being written: it appears under its name when it is complete, or not at all.
/// Where that cannot be, as on a full disk, all of it throws std::runtime_error with that name.
class BagWriter {
 public:
  explicit BagWriter(const std::string& file) : BagWriter(file, std::make_unique<rosbag::Bag>()) {
    attempt([this] { bag_->open(unfinished_, rosbag::bagmode::Write); });
  }
  ~BagWriter() {
    std::remove(unfinished_.c_str());  // finished, it is not there any more
    if (bag_) given_up_ = bag_.release();
  }
  BagWriter(const BagWriter&) = delete;
  BagWriter& operator=(const BagWriter&) = delete;

  template <typename Message>
  void write(const std::string& topic, const ros::Time& time, const Message& message) {
    attempt([&] { bag_->write(topic, time, message); });
  }

  void finish() {
    attempt([this] { bag_->close(); });
    bag_.reset();
    std::filesystem::rename(unfinished_, file_);
  }

 private:
  BagWriter(const std::string& file, std::unique_ptr<rosbag::Bag> bag)
      : file_(file), unfinished_(file + ".unfinished"), bag_(std::move(bag)) {}

  template <typename Work>
  void attempt(Work work) {
    try {
      work();
    } catch (const rosbag::BagException& error) {
      throw std::runtime_error(file_ + " cannot be written: " + error.what());
    }
  }

  /// The destructor of a bag writes on, and where it cannot, it ends the program: it is not called.
  static inline rosbag::Bag* given_up_ = nullptr;

  std::string file_, unfinished_;
  std::unique_ptr<rosbag::Bag> bag_;  ///< until it is finished
};

}  // namespace bearing_calibration::core
