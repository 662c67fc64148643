// Parameters from files against the same ones as roslaunch puts them on the parameter server: the
// expected kinds are those of YAML 1.1, which rosparam reads.

#include "bearing_calibration_ros/parameter_files.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <string>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration_ros/param_reader.h"

namespace bearing_calibration_ros {
namespace {

class ParameterFiles : public testing::Test {
 protected:
  static std::string write(const std::string& name, const std::string& text) {
    std::string file = testing::TempDir() + "parameter_files_" + name;
    std::ofstream(file) << text;
    return file;
  }
};

TEST_F(ParameterFiles, HoldWhatRosparamReads) {
  ParamReader params(
      parametersFromFiles({write("kinds.yaml",
                                 "group: {whole: 2, number: 1.0e-6, text: 1e-6, quoted: '3', "
                                 "flag: true, angle: deg(30), rows: [[1, 2.5], [3, 4]]}")}),
      "");
  EXPECT_EQ(params.integer("group/whole"), 2);
  EXPECT_EQ(params.number("group/whole"), 2.0);
  EXPECT_EQ(params.number("group/number"), 1e-6);
  EXPECT_EQ(params.text("group/text"), "1e-6");
  EXPECT_EQ(params.text("group/quoted"), "3");
  EXPECT_TRUE(params.boolean("group/flag"));
  EXPECT_DOUBLE_EQ(params.number("group/angle"), bearing_calibration::kPi / 6.0);
  const std::vector<std::vector<double>> rows{{1.0, 2.5}, {3.0, 4.0}};
  EXPECT_EQ(params.rows("group/rows", 2), rows);
  EXPECT_NO_THROW(params.throwIfAnyError());
}

TEST_F(ParameterFiles, LaterOnesOverrideSingleValues) {
  ParamReader params(
      parametersFromFiles({write("first.yaml", "group: {kept: 1, changed: 2}\nother: {list: [1]}"),
                           write("second.yaml", "group: {changed: 3}\nother: {list: []}")}),
      "");
  EXPECT_EQ(params.integer("group/kept"), 1);
  EXPECT_EQ(params.integer("group/changed"), 3);
  EXPECT_TRUE(params.rows("other/list", 2).empty());
  EXPECT_TRUE(params.errors().empty());
}

TEST_F(ParameterFiles, ErrorsNameTheParameterWithItsPrefix) {
  ParamReader params(parametersFromFiles({write("misspelt.yaml", "group: {numbr: 1, none: }")}),
                     "scene.yaml: ");
  EXPECT_TRUE(std::isnan(params.number("group/number")));
  EXPECT_TRUE(std::isnan(params.number("group/none")));
  try {
    params.throwIfAnyError();
    FAIL() << "nothing was thrown";
  } catch (const std::runtime_error& error) {
    const std::string text = error.what();
    for (const char* part :
         {"scene.yaml: group/number is missing", "scene.yaml: group/none must be a finite number",
          "scene.yaml: group/numbr is not known"}) {
      EXPECT_NE(text.find(part), std::string::npos) << text;
    }
  }
}

TEST_F(ParameterFiles, ThatCannotBeReadAreNamed) {
  for (const std::string& file :
       {std::string("/no/such.yaml"), write("list.yaml", "[1, 2]"), write("broken.yaml", "a: [1"),
        write("empty.yaml", ""), write("large.yaml", "a: 99999999999999999999")}) {
    try {
      parametersFromFiles({file});
      ADD_FAILURE() << file << " was read";
    } catch (const std::runtime_error& error) {
      EXPECT_EQ(std::string(error.what()).find(file + ": "), 0U) << error.what();
    }
  }
}

}  // namespace
}  // namespace bearing_calibration_ros
