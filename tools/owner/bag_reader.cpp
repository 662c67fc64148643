#include "tools/owner/bag_reader.h"

#include <cerrno>
#include <fstream>
#include <mutex>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "tools/common/timing.h"

namespace bearing_calibration::core {
namespace {

using bearing_calibration_ros::WheelSource;

// Messages go in batches, so that taking one costs no lock: some hundred of the encoders', or as
// many images as this, and so many batches ahead.
constexpr std::size_t kMessagesOfBatch = 256;
constexpr std::size_t kBytesOfBatch = 4U << 20U;
constexpr std::size_t kBatchesAhead = 8;

template <typename Message>
std::optional<BagMessage> readAs(const rosbag::MessageInstance& message) {
  auto content = message.instantiate<Message>();
  if (!content) return std::nullopt;  // another type on the same topic
  return BagMessage{message.getTime(), boost::shared_ptr<const Message>(std::move(content))};
}

/// What is wrong with a bag of which rosbag says `what`, and what to do about it.
std::runtime_error unreadable(const std::string& path, const std::string& what) {
  return std::runtime_error(
      path + " is cut short or damaged (" + what +
      "). Copy it again; or save what is whole, up to there: rosbag reindex " + path +
      " (it keeps the old file as .orig)");
}

void open(const std::string& path, rosbag::Bag* bag) {
  constexpr char kBegin[] = "#ROSBAG";
  errno = 0;
  std::ifstream file(path);
  if (!file) throw std::runtime_error(path + ": " + std::generic_category().message(errno));
  std::string begin(sizeof(kBegin) - 1, ' ');
  if (!file.read(begin.data(), static_cast<std::streamsize>(begin.size())) || begin != kBegin) {
    throw std::runtime_error(path + " is no bag, or an empty one: it does not begin with " +
                             kBegin);
  }
  try {
    bag->open(path, rosbag::bagmode::Read);
  } catch (const rosbag::BagUnindexedException&) {
    throw std::runtime_error(path +
                             " has no index: its recording has not ended, or was broken off. When "
                             "nothing records into it any more, run: rosbag reindex " +
                             path + " (it keeps the old file as .orig)");
  } catch (const std::exception& error) {
    throw unreadable(path, error.what());
  }
}

}  // namespace

BagReader::BagReader(const std::string& path, const BagTopics& wanted, WheelSource source)
    : path_(path), source_(source), queue_(kBatchesAhead) {
  // opening loads rosbag's plugins, which is not made for several threads
  static std::mutex opening;
  const std::lock_guard<std::mutex> lock(opening);
  open(path, &bag_);
  rosbag::View whole(bag_);
  topics_ = findTopics(whole, wanted, source);
  view_.addQuery(bag_, rosbag::TopicQuery(topics_.names()));
}

BagReader::~BagReader() {
  queue_.close();
  if (thread_.joinable()) thread_.join();
}

std::vector<BagMessage> BagReader::next() {
  if (!thread_.joinable()) thread_ = std::thread([this] { read(); });
  std::optional<std::vector<BagMessage>> batch = queue_.pop();
  if (batch) return std::move(*batch);
  if (error_) std::rethrow_exception(error_);
  return {};
}

void BagReader::read() {
  try {
    readAll();
  } catch (const std::exception& error) {
    error_ = std::make_exception_ptr(unreadable(path_, error.what()));
  } catch (...) {
    error_ = std::current_exception();
  }
  queue_.finish();
}

void BagReader::readAll() {
  // An image needs them, but a recorder may have received the first of them after it.
  std::vector<BagMessage> needed;
  for (const std::string& topic : {topics_.static_transforms, topics_.camera_info}) {
    rosbag::View of_topic(bag_, rosbag::TopicQuery(topic));
    for (const rosbag::MessageInstance& message : of_topic) {
      if (auto read = readMessage(message)) needed.push_back(std::move(*read));
      if (topic == topics_.camera_info) break;
    }
  }
  if (!needed.empty() && !queue_.push(std::move(needed))) return;
  auto message = view_.begin();
  const auto end = view_.end();
  while (message != end) {
    std::vector<BagMessage> batch;
    batch.reserve(kMessagesOfBatch);
    {
      const Timing timing(&reading_s_);
      std::size_t bytes = 0;
      for (; message != end && batch.size() < kMessagesOfBatch && bytes < kBytesOfBatch;
           ++message) {
        if (auto read = readMessage(*message)) batch.push_back(std::move(*read));
        bytes += message->size();
      }
    }
    if (!batch.empty() && !queue_.push(std::move(batch))) return;
  }
}

std::optional<BagMessage> BagReader::readMessage(const rosbag::MessageInstance& message) const {
  const std::string& topic = message.getTopic();
  if (topic == topics_.images) {
    return message.isType<sensor_msgs::Image>() ? readAs<sensor_msgs::Image>(message)
                                                : readAs<sensor_msgs::CompressedImage>(message);
  }
  if (topic == topics_.bearings) return readAs<LightBearings>(message);
  if (topic == topics_.camera_info) return readAs<sensor_msgs::CameraInfo>(message);
  if (topic == topics_.static_transforms) return readAs<tf2_msgs::TFMessage>(message);
  if (topic == topics_.plan) return readAs<geometry_msgs::PoseWithCovarianceStamped>(message);
  switch (source_) {
    case WheelSource::kTicks:
      return readAs<WheelTicks>(message);
    case WheelSource::kJointStates:
      return readAs<sensor_msgs::JointState>(message);
    case WheelSource::kOdometry:
      return readAs<nav_msgs::Odometry>(message);
    case WheelSource::kSeparateTicks:
      break;
  }
  const WheelSide side = topic == topics_.wheels ? WheelSide::kLeft : WheelSide::kRight;
  return BagMessage{message.getTime(),
                    BagWheelCount{side, message.instantiate<topic_tools::ShapeShifter>()}};
}

}  // namespace bearing_calibration::core
