#include "bearing_calibration_ros/tick_message.h"

#include <ros/serialization.h>
#include <std_msgs/Header.h>

#include <cstdint>
#include <map>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "bearing_calibration_ros/conversions.h"

namespace bearing_calibration_ros {
namespace {

/// What lies at the beginning of a message.
struct Layout {
  bool has_header = false;
  std::string integer;  ///< its type in the message's definition
};

bool isInteger(const std::string& type) {
  for (const char* size : {"8", "16", "32", "64"}) {
    if (type == std::string("int") + size || type == std::string("uint") + size) return true;
  }
  return false;
}

std::optional<Layout> layoutOf(const std::string& definition) {
  Layout layout;
  std::istringstream lines(definition);
  for (std::string line; std::getline(lines, line);) {
    line = line.substr(0, line.find('#'));
    if (line.find('=') != std::string::npos) continue;  // a constant
    std::istringstream words(line);
    std::string type, name;
    if (!(words >> type >> name)) continue;
    const bool is_header = type == "Header" || type == "std_msgs/Header";
    if (is_header && !layout.has_header) {
      layout.has_header = true;
      continue;
    }
    layout.integer = type;
    return name == "data" && isInteger(type) ? std::optional(layout) : std::nullopt;
  }
  return std::nullopt;
}

/// Of the type of a message. Its definition is read once: topics of wheels have a type or two.
const std::optional<Layout>& layoutOf(const topic_tools::ShapeShifter& message) {
  thread_local std::map<std::string, std::optional<Layout>> layouts;  // by definition
  const auto [known, is_new] = layouts.try_emplace(message.getMessageDefinition());
  if (is_new) known->second = layoutOf(known->first);
  return known->second;
}

template <typename Integer>
std::int64_t readAs(ros::serialization::IStream* stream) {
  Integer value = 0;
  stream->next(value);
  return static_cast<std::int64_t>(value);
}

std::int64_t readInteger(const std::string& type, ros::serialization::IStream* stream) {
  if (type == "int8") return readAs<std::int8_t>(stream);
  if (type == "uint8") return readAs<std::uint8_t>(stream);
  if (type == "int16") return readAs<std::int16_t>(stream);
  if (type == "uint16") return readAs<std::uint16_t>(stream);
  if (type == "int32") return readAs<std::int32_t>(stream);
  if (type == "uint32") return readAs<std::uint32_t>(stream);
  if (type == "int64") return readAs<std::int64_t>(stream);
  return readAs<std::uint64_t>(stream);
}

}  // namespace

bool isWheelCount(const std::string& message_definition) {
  return layoutOf(message_definition).has_value();
}

core::WheelCount countFromMessage(const topic_tools::ShapeShifter& message,
                                  const ros::Time& received) {
  const std::optional<Layout>& layout = layoutOf(message);
  if (!layout) {
    throw std::invalid_argument("a message of type " + message.getDataType() +
                                " is no wheel's count: it has no integer 'data' in the first "
                                "place or after its header");
  }
  std::vector<std::uint8_t> bytes(message.size());
  ros::serialization::OStream writer(bytes.data(), message.size());
  message.write(writer);
  ros::serialization::IStream reader(bytes.data(), message.size());
  std_msgs::Header header;
  header.stamp = received;
  if (layout->has_header) reader.next(header);
  return {stampFromRos(header.stamp), readInteger(layout->integer, &reader)};
}

}  // namespace bearing_calibration_ros
