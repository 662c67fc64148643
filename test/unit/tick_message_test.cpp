#include <gtest/gtest.h>
#include <std_msgs/Float32.h>
#include <std_msgs/Header.h>
#include <std_msgs/Int16.h>
#include <std_msgs/Int64.h>
#include <std_msgs/UInt16.h>
#include <std_msgs/UInt8.h>

#include <string>
#include <vector>

#include "bearing_calibration_ros/conversions.h"
#include "bearing_calibration_ros/wheel_input.h"

namespace bearing_calibration_ros {
namespace {

namespace core = bearing_calibration::core;

const ros::Time kReceived(50, 7);

/// As a subscriber to a topic of any type has it.
template <typename Message>
topic_tools::ShapeShifter shaped(const Message& message, const std::string& definition) {
  const std::uint32_t size = ros::serialization::serializationLength(message);
  std::vector<std::uint8_t> bytes(size);
  ros::serialization::OStream out(bytes.data(), size);
  ros::serialization::serialize(out, message);
  topic_tools::ShapeShifter shifter;
  shifter.morph(ros::message_traits::md5sum<Message>(), ros::message_traits::datatype<Message>(),
                definition, "");
  ros::serialization::IStream in(bytes.data(), size);
  shifter.read(in);
  return shifter;
}

template <typename Message>
core::WheelCount countOf(typename Message::_data_type value) {
  Message message;
  message.data = value;
  return countFromMessage(shaped(message, ros::message_traits::definition<Message>()), kReceived);
}

TEST(TickMessage, BareIntegersGetTheTimeOfReceipt) {
  EXPECT_EQ(countOf<std_msgs::Int16>(-12345).ticks, -12345);
  EXPECT_EQ(countOf<std_msgs::UInt16>(65535).ticks, 65535);
  EXPECT_EQ(countOf<std_msgs::UInt8>(255).ticks, 255);
  EXPECT_EQ(countOf<std_msgs::Int64>(-(std::int64_t{1} << 40)).ticks, -(std::int64_t{1} << 40));
  EXPECT_EQ(countOf<std_msgs::Int16>(1).stamp, stampFromRos(kReceived));
}

/// A type of its own, with the fields that Duckietown's has, in bytes.
TEST(TickMessage, AHeaderBeforeTheCountGivesTheStamp) {
  std_msgs::Header header;
  header.stamp = ros::Time(40, 3);
  header.frame_id = "left_wheel";
  const std::string definition =
      "# a comment int32 data\nuint8 INCREMENTAL=1\n\nstd_msgs/Header header\nint32 data # ticks\n"
      "uint16 resolution\n=====\nMSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id\n";
  EXPECT_TRUE(isWheelCount(definition));
  const std::uint32_t header_size = ros::serialization::serializationLength(header);
  std::vector<std::uint8_t> bytes(header_size + 6);
  ros::serialization::OStream out(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
  ros::serialization::serialize(out, header);
  ros::serialization::serialize(out, std::int32_t{-70000});
  ros::serialization::serialize(out, std::uint16_t{135});
  topic_tools::ShapeShifter shifter;
  shifter.morph("*", "some_msgs/Count", definition, "");
  ros::serialization::IStream in(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
  shifter.read(in);
  const core::WheelCount count = countFromMessage(shifter, kReceived);
  EXPECT_EQ(count.ticks, -70000);
  EXPECT_EQ(count.stamp, stampFromRos(header.stamp));
}

// Promise refused: wheel counts that are cut short
TEST(TickMessage, OnesCutShortAreNamed) {
  const std::string whole = ros::message_traits::definition<std_msgs::Int64>();
  for (const std::string& definition : {whole, "Header header\n" + whole}) {
    try {
      countFromMessage(shaped(std_msgs::Int16(), definition), kReceived);
      FAIL() << "not refused";
    } catch (const std::invalid_argument& error) {
      EXPECT_NE(std::string(error.what()).find("std_msgs/Int16 is cut short"), std::string::npos)
          << error.what();
    }
  }
}

TEST(TickMessage, OtherMessagesAreNamed) {
  for (const char* definition :
       {"float32 data", "geometry_msgs/Vector3 linear\n", "int32 ticks", "int32[] data", "",
        "Header header\nHeader other\nint32 data", "int32 first\nint32 data"}) {
    EXPECT_FALSE(isWheelCount(definition)) << definition;
  }
  try {
    countOf<std_msgs::Float32>(1.0F);
    FAIL() << "not refused";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("std_msgs/Float32"), std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace bearing_calibration_ros
