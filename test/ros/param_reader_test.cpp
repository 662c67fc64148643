#include "bearing_calibration_ros/param_reader.h"

#include <gtest/gtest.h>
#include <ros/ros.h>

#include <string>
#include <vector>

namespace bearing_calibration_ros {
namespace {

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

using Rows = std::vector<std::vector<double>>;

/// The parameters stand in param_reader.test.
class ParamReaderTest : public testing::Test {
 protected:
  /// Exactly one error so far, with all the parts in it.
  void expectOneErrorWith(const std::vector<std::string>& parts) const {
    ASSERT_EQ(params_.errors().size(), 1U);
    for (const std::string& part : parts) {
      EXPECT_TRUE(contains(params_.errors().front(), part))
          << "'" << part << "' is not in '" << params_.errors().front() << "'";
    }
  }

  /// What is read; as it was where it cannot be.
  template <typename Value>
  Value valueOf(const std::string& name, Value value = {}) {
    params_.read(name, value);
    return value;
  }
  Rows rowsOf(const std::string& name) {
    ParamReader::Rows rows{2, {}};
    params_.read(name, rows);
    return rows.rows;
  }

  ParamReader params_{ros::NodeHandle("~")};
};

enum class Greeting { kGoodMorning, kHello };

TEST_F(ParamReaderTest, ReadsEveryKind) {
  EXPECT_EQ(valueOf<double>("group/number"), 0.25);
  EXPECT_EQ(valueOf<double>("group/whole_number"), 2.0);
  EXPECT_EQ(valueOf<int>("group/whole_number"), 2);
  EXPECT_EQ(valueOf<double>("group/tiny"), 1e-6);
  EXPECT_EQ(valueOf<std::string>("group/text"), "hello");
  EXPECT_TRUE(valueOf<bool>("group/flag"));
  Greeting greeting = Greeting::kGoodMorning;
  params_.choice("group/text", {"good morning", "hello"}, greeting);
  EXPECT_EQ(greeting, Greeting::kHello);
  EXPECT_EQ(valueOf("group/pair", std::vector<double>(2)), (std::vector<double>{1.5, 2.0}));
  EXPECT_EQ(rowsOf("group/list"), (Rows{{1.0, 2.5}, {3.0, 4.0}}));
  EXPECT_TRUE(rowsOf("group/empty").empty());
  EXPECT_TRUE(params_.errors().empty()) << params_.errors().front();
}

TEST_F(ParamReaderTest, SaysWhatIsMissing) {
  EXPECT_EQ(valueOf("group/absent", 7.0), 7.0);
  expectOneErrorWith({"/param_reader/group/absent", "is missing"});
}

TEST_F(ParamReaderTest, SaysTheValueOfAWrongKind) {
  EXPECT_EQ(valueOf("group/text", 7.0), 7.0);
  expectOneErrorWith({"/param_reader/group/text", "finite number", "'hello'"});
}

TEST_F(ParamReaderTest, KnowsTheTrapOfYamlsExponents) {
  EXPECT_EQ(valueOf("group/text_number", 7.0), 7.0);
  expectOneErrorWith({"'1e-6'", "1.0e-6"});
}

TEST_F(ParamReaderTest, RefusesNumbersThatAreNone) {
  EXPECT_EQ(valueOf("group/not_a_number", 7.0), 7.0);
  EXPECT_EQ(valueOf("group/infinite", 7.0), 7.0);
  EXPECT_EQ(params_.errors().size(), 2U);
}

TEST_F(ParamReaderTest, TakesNoFractionForAnInteger) {
  EXPECT_EQ(valueOf("group/number", 7), 7);
  expectOneErrorWith({"an integer", "0.25"});
}

TEST_F(ParamReaderTest, TakesNoNumberForABoolean) {
  EXPECT_FALSE(valueOf<bool>("group/whole_number"));
  expectOneErrorWith({"true or false", "2"});
}

TEST_F(ParamReaderTest, TakesNoBooleanForAText) {
  EXPECT_EQ(valueOf<std::string>("group/flag"), "");
  expectOneErrorWith({"a string", "true"});
}

TEST_F(ParamReaderTest, ListsTheChoices) {
  Greeting greeting = Greeting::kHello;
  params_.choice("group/text", {"a", "b"}, greeting);
  EXPECT_EQ(greeting, Greeting::kHello);
  expectOneErrorWith({"one of (a, b)", "'hello'"});
}

TEST_F(ParamReaderTest, NamesTheBoundsThatAValueIsBeyond) {
  double number = 0.0;
  params_.number("group/number", number, 0.5, 1.0);
  expectOneErrorWith({"group/number must lie in [0.5, 1], but is 0.25"});
}

TEST_F(ParamReaderTest, NamesTheWrongRow) {
  EXPECT_TRUE(rowsOf("group/ragged").empty());
  expectOneErrorWith({"list of lists of 2", "row 1"});
}

TEST_F(ParamReaderTest, TakesNoListOfAnotherLength) {
  EXPECT_EQ(valueOf("group/pair", std::vector<double>(3)), std::vector<double>(3));
  expectOneErrorWith({"a list of 3 finite numbers", "a list of 2"});
}

TEST_F(ParamReaderTest, TakesNoGroupForAList) {
  EXPECT_TRUE(rowsOf("other").empty());
  expectOneErrorWith({"other", "a group of parameters"});
}

// Misspelt names are looked for in the groups that are read from, nowhere else.
TEST_F(ParamReaderTest, FindsMisspeltNames) {
  valueOf<double>("other/numbr");
  try {
    params_.throwIfAnyError();
    FAIL() << "nothing was thrown";
  } catch (const std::runtime_error& error) {
    EXPECT_TRUE(contains(error.what(), "2 wrong parameter(s):")) << error.what();
    EXPECT_TRUE(contains(error.what(), "other/numbr is missing")) << error.what();
    EXPECT_TRUE(contains(error.what(), "other/number is not known")) << error.what();
    EXPECT_FALSE(contains(error.what(), "group/")) << error.what();
    EXPECT_FALSE(contains(error.what(), "top_level")) << error.what();
  }
}

TEST_F(ParamReaderTest, ThrowsNothingWhenAllIsWell) {
  valueOf<double>("other/number");
  EXPECT_NO_THROW(params_.throwIfAnyError());
}

// The value that stands in for an unread parameter is no business of the user's.
TEST_F(ParamReaderTest, LeavesOutWhatIsSaidOfAnUnreadValueAndOfWhatWasSaid) {
  double number = 0.0;
  params_.number("group/absent", number, 1.0, 2.0);
  params_.number("group/absent", number, 1.0, 2.0);
  params_.that(false, "group/number and group/absent must not be equal");
  for (int i = 0; i < 2; ++i) params_.that(false, "group/absentee must be greater than 0");
  ASSERT_EQ(params_.errors().size(), 2U);
  EXPECT_EQ(params_.errors().back(), "group/absentee must be greater than 0");
}

}  // namespace
}  // namespace bearing_calibration_ros

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "param_reader");
  ros::NodeHandle keeps_ros_alive;
  return RUN_ALL_TESTS();
}
