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

ParamReader robotWithout(const std::vector<std::string>& names) {
  ParameterMap parameters{{"wheels/radius", 0.1}, {"wheels/bits", 16}, {"lens/width", 640}};
  for (const std::string& name : names) parameters[name] = "required";
  return ParamReader(parameters, "/robot/");
}

std::string whatIsThrown(ParamReader& params) {
  try {
    params.throwIfAnyError();
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

TEST(RequiredNumbers, AreErrorsWhereNobodyHasGivenThemWithAllOthers) {
  ParamReader params = robotWithout({"wheels/radius", "lens/width"});
  double radius = 7.0;
  int bits = 0, width = 8;
  params.number("wheels/radius", radius, 0.01, 1.0);
  params.integer("wheels/bits", bits, 32, 64);
  params.integer("lens/width", width, 1, 4);
  EXPECT_EQ(radius, 7.0);
  EXPECT_EQ(whatIsThrown(params),
            "3 wrong parameter(s):\n"
            "  - parameter /robot/wheels/radius is required: a number of your robot (robots.md)\n"
            "  - parameter /robot/lens/width is required: a number of your camera and mirror "
            "(camera.md)\n"
            "  - wheels/bits must lie in [32, 64], but is 16");
}

TEST(RequiredNumbers, MayHaveAStandInThatAGivenNumberReplaces) {
  for (const bool is_given : {false, true}) {
    ParamReader params =
        is_given ? robotWithout({}) : robotWithout({"wheels/radius", "wheels/bits"});
    params.standIn("wheels/radius", 0.5);
    params.standIn("wheels/bits", 32.0);
    double radius = 0.0;
    int bits = 0;
    params.number("wheels/radius", radius, 0.01, 1.0);
    params.integer("wheels/bits", bits, 8, 64);
    EXPECT_EQ(radius, is_given ? 0.1 : 0.5);
    EXPECT_EQ(bits, is_given ? 16 : 32);
    EXPECT_EQ(whatIsThrown(params), "");
  }
}

TEST(RequiredNumbers, AreNoStandInForAMissingOne) {
  ParamReader params(ParameterMap{{"wheels/bits", 16}});
  params.standIn("wheels/radius", 0.5);
  double radius = 7.0;
  params.read("wheels/radius", radius);
  EXPECT_EQ(radius, 7.0);
  EXPECT_TRUE(contains(whatIsThrown(params), "wheels/radius is missing"));
}

TEST(RequiredNumbers, CanBeTakenOutOfTheErrors) {
  ParamReader params = robotWithout({"lens/width"});
  int width = 0, bits = 0;
  params.integer("lens/width", width, 1, 4);
  params.integer("wheels/bits", bits, 32, 64);
  double radius = 0.0;
  params.read("wheels/radius", radius);
  EXPECT_TRUE(contains(params.takeRequired(), "1 wrong parameter(s):\n  - parameter /robot/lens/"));
  EXPECT_EQ(params.takeRequired(), "");
  EXPECT_EQ(whatIsThrown(params),
            "1 wrong parameter(s):\n  - wheels/bits must lie in [32, 64], but is 16");
}

// The value that stands in for an unread parameter is no business of the user's.
TEST_F(ParamReaderTest, LeavesOutWhatIsSaidOfAnUnreadValueAndOfWhatWasSaid) {
  double number = 0.0;
  params_.number("group/absent", number, 1.0, 2.0);
  params_.number("group/absent", number, 1.0, 2.0);
  params_.that(false, "group/number and group/absent must not be equal");
  for (const char* mark : {":", ",", ";", "."}) {
    params_.that(false, std::string("group/number must not exceed group/absent") + mark + " or so");
  }
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
