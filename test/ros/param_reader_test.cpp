#include "bearing_calibration_ros/param_reader.h"

#include <gtest/gtest.h>
#include <ros/ros.h>

#include <cmath>
#include <string>
#include <vector>

namespace bearing_calibration_ros {
namespace {

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

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

  ParamReader params_{ros::NodeHandle("~")};
};

TEST_F(ParamReaderTest, ReadsEveryKind) {
  EXPECT_EQ(params_.number("group/number"), 0.25);
  EXPECT_EQ(params_.number("group/whole_number"), 2.0);
  EXPECT_EQ(params_.integer("group/whole_number"), 2);
  EXPECT_EQ(params_.number("group/tiny"), 1e-6);
  EXPECT_EQ(params_.text("group/text"), "hello");
  EXPECT_TRUE(params_.boolean("group/flag"));
  EXPECT_EQ(params_.choice("group/text", {"good morning", "hello"}), 1U);
  const std::vector<std::vector<double>> rows{{1.0, 2.5}, {3.0, 4.0}};
  EXPECT_EQ(params_.rows("group/list", 2), rows);
  EXPECT_TRUE(params_.rows("group/empty", 2).empty());
  EXPECT_TRUE(params_.errors().empty()) << params_.errors().front();
}

TEST_F(ParamReaderTest, SaysWhatIsMissing) {
  EXPECT_TRUE(std::isnan(params_.number("group/absent")));
  expectOneErrorWith({"/param_reader/group/absent", "is missing"});
}

TEST_F(ParamReaderTest, SaysTheValueOfAWrongKind) {
  EXPECT_TRUE(std::isnan(params_.number("group/text")));
  expectOneErrorWith({"/param_reader/group/text", "finite number", "'hello'"});
}

TEST_F(ParamReaderTest, KnowsTheTrapOfYamlsExponents) {
  EXPECT_TRUE(std::isnan(params_.number("group/text_number")));
  expectOneErrorWith({"'1e-6'", "1.0e-6"});
}

TEST_F(ParamReaderTest, RefusesNumbersThatAreNone) {
  EXPECT_TRUE(std::isnan(params_.number("group/not_a_number")));
  EXPECT_TRUE(std::isnan(params_.number("group/infinite")));
  EXPECT_EQ(params_.errors().size(), 2U);
}

TEST_F(ParamReaderTest, TakesNoFractionForAnInteger) {
  EXPECT_EQ(params_.integer("group/number"), 0);
  expectOneErrorWith({"an integer", "0.25"});
}

TEST_F(ParamReaderTest, TakesNoNumberForABoolean) {
  EXPECT_FALSE(params_.boolean("group/whole_number"));
  expectOneErrorWith({"true or false", "2"});
}

TEST_F(ParamReaderTest, TakesNoBooleanForAText) {
  EXPECT_EQ(params_.text("group/flag"), "");
  expectOneErrorWith({"a string", "true"});
}

TEST_F(ParamReaderTest, ListsTheChoices) {
  EXPECT_EQ(params_.choice("group/text", {"a", "b"}), 0U);
  expectOneErrorWith({"one of (a, b)", "'hello'"});
}

TEST_F(ParamReaderTest, NamesTheWrongRow) {
  EXPECT_TRUE(params_.rows("group/ragged", 2).empty());
  expectOneErrorWith({"list of lists of 2", "row 1"});
}

TEST_F(ParamReaderTest, TakesNoGroupForAList) {
  EXPECT_TRUE(params_.rows("other", 2).empty());
  expectOneErrorWith({"list of lists of 2", "a group of parameters"});
}

// Misspelt names are looked for in the groups that are read from, nowhere else.
TEST_F(ParamReaderTest, FindsMisspeltNames) {
  params_.number("other/numbr");
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
  params_.number("other/number");
  EXPECT_NO_THROW(params_.throwIfAnyError());
}

// The value that stands in for an unread parameter is no business of the user's.
TEST_F(ParamReaderTest, LeavesOutWhatAValidationSaysOfAnUnreadValue) {
  params_.number("group/absent");
  params_.addErrors({"group/absent must be greater than 0, but is nan",
                     "group/number and group/absent must not be equal",
                     "group/absentee must be greater than 0"});
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
