// Parameters from files against the same ones as roslaunch puts them on the parameter server.

#include "bearing_calibration_ros/parameter_files.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/vision/optics_learner.h"
#include "bearing_calibration_ros/detection_params.h"
#include "bearing_calibration_ros/optics_file.h"
#include "bearing_calibration_ros/param_reader.h"
#include "support/temporary_folder.h"

namespace bearing_calibration_ros {
namespace {

namespace core = bearing_calibration::core;
namespace fs = std::filesystem;

class ParametersFromFiles : public testing::Test {
 protected:
  static std::string write(const std::string& name, const std::string& text) {
    std::string file = testing::TempDir() + "parameter_files_" + name;
    std::ofstream(file) << text;
    return file;
  }
};

using Rows = std::vector<std::vector<double>>;

/// What a reader makes of a name; as it was where it cannot.
template <typename Value>
Value valueOf(ParamReader& params, const std::string& name, Value value = {}) {
  params.read(name, value);
  return value;
}
Rows rowsOf(ParamReader& params, const std::string& name) {
  ParamReader::Rows rows{2, {}};
  params.read(name, rows);
  return rows.rows;
}

TEST_F(ParametersFromFiles, HoldWhatRosparamReads) {
  ParamReader params(
      parametersFromFiles({write("kinds.yaml",
                                 "group: {whole: 2, number: 1.0e-6, text: hello, quoted: '3', "
                                 "flag: true, angle: deg(30), rows: [[1, 2.5], [3, 4]]}")}),
      "");
  EXPECT_EQ(valueOf<int>(params, "group/whole"), 2);
  EXPECT_EQ(valueOf<double>(params, "group/whole"), 2.0);
  EXPECT_EQ(valueOf<double>(params, "group/number"), 1e-6);
  EXPECT_EQ(valueOf<std::string>(params, "group/text"), "hello");
  EXPECT_EQ(valueOf<std::string>(params, "group/quoted"), "3");
  EXPECT_TRUE(valueOf<bool>(params, "group/flag"));
  EXPECT_DOUBLE_EQ(valueOf<double>(params, "group/angle"), bearing_calibration::core::kPi / 6.0);
  EXPECT_EQ(rowsOf(params, "group/rows"), (Rows{{1.0, 2.5}, {3.0, 4.0}}));
  EXPECT_NO_THROW(params.throwIfAnyError());
}

TEST_F(ParametersFromFiles, LaterOnesOverrideSingleValues) {
  ParamReader params(
      parametersFromFiles({write("first.yaml", "group: {kept: 1, changed: 2}\nother: {list: [1]}"),
                           write("second.yaml", "group: {changed: 3}\nother: {list: []}")}),
      "");
  EXPECT_EQ(valueOf<int>(params, "group/kept"), 1);
  EXPECT_EQ(valueOf<int>(params, "group/changed"), 3);
  EXPECT_TRUE(rowsOf(params, "other/list").empty());
  EXPECT_TRUE(params.errors().empty());
}

// result.yaml has them: what cannot be read there could not be saved.
TEST_F(ParametersFromFiles, TextsReadBackAsTheyAre) {
  const std::string odd = "C:\\Query \"quoted\" # and\nso: on";
  ParameterMap parameters;
  parameters["group/text"] = odd;
  ParamReader params(parameters);
  valueOf<std::string>(params, "group/text");
  EXPECT_EQ(
      static_cast<std::string>(parametersFromYaml(params.texts().at("group/text"), "text").at("")),
      odd);
}

TEST_F(ParametersFromFiles, ErrorsNameTheParameterWithItsPrefix) {
  ParamReader params(parametersFromFiles({write("misspelt.yaml", "group: {numbr: 1, none: }")}),
                     "scene.yaml: ");
  valueOf<double>(params, "group/number");
  valueOf<double>(params, "group/none");
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

TEST_F(ParametersFromFiles, ThatCannotBeReadAreNamed) {
  for (const std::string& file : {std::string("/no/such.yaml"), write("list.yaml", "[1, 2]"),
                                  write("broken.yaml", "a: [1"), write("empty.yaml", "")}) {
    try {
      parametersFromFiles({file});
      ADD_FAILURE() << file << " was read";
    } catch (const std::runtime_error& error) {
      EXPECT_EQ(std::string(error.what()).find(file + ": "), 0U) << error.what();
    }
  }
}

using XmlRpc::XmlRpcValue;

XmlRpcValue::Type typeOf(const std::string& scalar) {
  return parametersFromYaml(scalar, "a test").at("").getType();
}

double numberOf(const std::string& scalar) {
  XmlRpcValue value = parametersFromYaml(scalar, "a test").at("");
  return value.getType() == XmlRpcValue::TypeInt ? static_cast<int>(value)
                                                 : static_cast<double>(value);
}

/// What `work` throws; empty when it throws nothing.
template <typename Work>
std::string errorOf(Work work) {
  try {
    work();
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return {};
}

void expectSaid(const std::string& text, const std::string& part) {
  EXPECT_NE(text.find(part), std::string::npos) << "'" << part << "' is not in '" << text << "'";
}

// What roslaunch takes for a number, a boolean or a string is one here.
TEST(ParametersFromYaml, TakesScalarsForWhatRoslaunchTakesThemFor) {
  for (const char* integer : {"0", "7", "-12", "+3", "0x1F"}) {
    EXPECT_EQ(typeOf(integer), XmlRpcValue::TypeInt) << integer;
  }
  for (const char* real : {"1.0", "-2.", ".5", "1.0e-6", "1.5E+3", ".inf", "-.inf", ".nan"}) {
    EXPECT_EQ(typeOf(real), XmlRpcValue::TypeDouble) << real;
  }
  for (const char* boolean : {"true", "False", "yes", "NO", "on", "off"}) {
    EXPECT_EQ(typeOf(boolean), XmlRpcValue::TypeBoolean) << boolean;
  }
  for (const char* text : {"hello", "\"1.0\"", "'true'", "1.2.3", "~/.ros"}) {
    EXPECT_EQ(typeOf(text), XmlRpcValue::TypeString) << text;
  }
}

// There it is a string, which a node refuses.
TEST(ParametersFromYaml, TakesANumberWithoutAPointForWhatIsMeant) {
  EXPECT_EQ(numberOf("1e-6"), 1e-6);
  EXPECT_EQ(numberOf("1.0e6"), 1e6);
}

TEST(ParametersFromYaml, ReadsValues) {
  EXPECT_EQ(numberOf("0x1F"), 31.0);
  EXPECT_EQ(numberOf("1.0e-6"), 1e-6);
  EXPECT_EQ(numberOf("-.inf"), -INFINITY);
  EXPECT_DOUBLE_EQ(numberOf("deg(30)"), M_PI / 6.0);
  EXPECT_DOUBLE_EQ(numberOf("deg( -30.0 )"), -M_PI / 6.0);
  EXPECT_DOUBLE_EQ(numberOf("rad(0.5)"), 0.5);
  ParameterMap parameters = parametersFromYaml("group: {list: [[1, 2.5]], text: 'a b'}", "a test");
  EXPECT_EQ(static_cast<double>(parameters.at("group/list")[0][1]), 2.5);
  EXPECT_EQ(static_cast<std::string>(parameters.at("group/text")), "a b");
}

TEST(ParametersFromYaml, NamesFileAndLineOfWhatCannotBeRead) {
  expectSaid(errorOf([] { parametersFromYaml("a: 1\nb: [2,\n", "robot.yaml"); }),
             "robot.yaml: line 3: ");
}

// roslaunch refuses it, too.
TEST(ParametersFromYaml, RefusesASecondDocument) {
  expectSaid(errorOf([] { parametersFromYaml("a: 1\n---\nb: 2\n", "robot.yaml"); }),
             "robot.yaml: line 3: a second document");
  EXPECT_EQ(parametersFromYaml("# robot\n---\na: 1\n...\n", "robot.yaml").count("a"), 1U);
  for (const char* comma : {",", "{a: 1},\n{b: 2}\n"}) {  // yaml-cpp finds documents without an end
    expectSaid(errorOf([&] { parametersFromYaml(comma, "robot.yaml"); }), "a second document");
  }
}

/// Two nodes that share one name.
class NodesFiles : public testing::Test {
 protected:
  void SetUp() override {
    files_.addNode("robot", write("robot.yaml", "frames: {sensor: camera}\nwheels: {radius: 0.1}"));
    files_.addNode("eye", write("eye.yaml", "frames: {sensor: camera}\nlens: {focus: 0.06}"));
  }

  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return (folder_ / name).string();
  }

  const core::TemporaryFolder own_;
  const fs::path folder_ = own_.path();
  ParameterFiles files_;
};

TEST_F(NodesFiles, WhatDiffersGoesToEveryNodeThatKnowsIt) {
  files_.overlay(write("mine.yaml", "frames: {sensor: laser}\nlens: {focus: 0.05}"));
  files_.set("wheels/radius=0.2");
  ParamReader robot = files_.reader("robot");
  ParamReader eye = files_.reader("eye");
  EXPECT_EQ(valueOf<std::string>(robot, "frames/sensor"), "laser");
  EXPECT_EQ(valueOf<double>(robot, "wheels/radius"), 0.2);
  EXPECT_EQ(valueOf<std::string>(eye, "frames/sensor"), "laser");
  EXPECT_EQ(valueOf<double>(eye, "lens/focus"), 0.05);
  EXPECT_NO_THROW(robot.throwIfAnyError());
  EXPECT_EQ(robot.texts().at("wheels/radius"), "0.2");
  EXPECT_EQ(robot.texts().at("frames/sensor"), "\"laser\"");
}

TEST_F(NodesFiles, SaysEveryNameThatNobodyKnowsAndWhereItStands) {
  files_.overlay(write("mine.yaml", "wheels: {radios: 0.2}\nweels: {radius: 0.2}"));
  files_.set("radius=0.2");
  files_.set("wheels=0.2");  // a group
  ParamReader robot = files_.reader("robot");
  const std::string error = errorOf([&] { robot.throwIfAnyError(); });
  expectSaid(error, "4 wrong parameter(s)");
  expectSaid(error, "parameter wheels/radios is not known (misspelt?): " + folder_.string());
  expectSaid(error, "parameter weels/radius is not known");
  expectSaid(error, "parameter radius is not known (misspelt?): the command line");
  expectSaid(error, "parameter wheels is not known");
}

TEST_F(NodesFiles, SaysAWrongKindAsANodeDoes) {
  files_.set("wheels/radius='0.1'");
  ParamReader robot = files_.reader("robot");
  valueOf<double>(robot, "wheels/radius");
  expectSaid(errorOf([&] { robot.throwIfAnyError(); }),
             "parameter wheels/radius must be a finite number, but is the string '0.1' (YAML "
             "needs a point and no quotes: 1.0e-6)");
}

TEST_F(NodesFiles, SaysAnIntegerThatDoesNotFit) {
  files_.set("wheels/radius=99999999999");
  ParamReader robot = files_.reader("robot");
  valueOf<int>(robot, "wheels/radius");
  expectSaid(errorOf([&] { robot.throwIfAnyError(); }),
             "parameter wheels/radius must be an integer, but is ");
}

TEST_F(NodesFiles, SaysWhichNumberIsTooLargeForADouble) {
  for (const char* text : {"1.0e+999", "-1.0e+999", "deg(1e999)"}) {
    ParameterFiles files = files_;
    files.set(std::string("wheels/radius=") + text);
    ParamReader robot = files.reader("robot");
    valueOf<double>(robot, "wheels/radius");
    expectSaid(errorOf([&] { robot.throwIfAnyError(); }),
               "parameter wheels/radius must be a finite number");
  }
  files_.set("wheels/radius=1.0e-999");
  ParamReader tiny = files_.reader("robot");
  EXPECT_EQ(valueOf(tiny, "wheels/radius", 1.0), 0.0);
  for (const std::string& text : {std::string("deg(.)"), std::string(5000, '7')}) {
    files_.set("wheels/radius=" + text);
    ParamReader robot = files_.reader("robot");
    valueOf<double>(robot, "wheels/radius");
    expectSaid(errorOf([&] { robot.throwIfAnyError(); }),
               "parameter wheels/radius must be a finite number, but is the string '" + text);
  }
}

// Each of them would fill the memory, the stack, or go on for ever.
TEST_F(NodesFiles, EndsAtOnceWithWhatIsNoParameterFile) {
  std::string bomb = "a0: &a0 [x, x, x, x, x, x, x, x, x]\n";
  for (int i = 1; i < 9; ++i) {
    const std::string before = "*a" + std::to_string(i - 1);
    bomb += "a" + std::to_string(i) + ": &a" + std::to_string(i) + " [" + before;
    for (int j = 1; j < 9; ++j) bomb += ", " + before;
    bomb += "]\n";
  }
  expectSaid(errorOf([&] { files_.overlay(write("bomb.yaml", bomb)); }),
             "bomb.yaml: line 1: more than 10000 values or 20 levels");
  expectSaid(errorOf([&] { files_.overlay(write("ring.yaml", "a: &a {b: *a}")); }),
             "ring.yaml: line 1: more than 10000 values or 20 levels");
  const std::string deep = "a: " + std::string(100, '[') + std::string(100, ']');
  expectSaid(errorOf([&] { files_.overlay(write("deep.yaml", deep)); }), "levels");
  const std::string large = "a: " + std::string(2000000, 'x');
  expectSaid(errorOf([&] { files_.overlay(write("large.yaml", large)); }),
             "large.yaml: more than 1 MB");
  expectSaid(errorOf([&] { files_.overlay("/dev/zero"); }), "/dev/zero: more than 1 MB");
}

TEST_F(NodesFiles, RefusesWhatIsNoAssignmentAndNoFile) {
  for (const char* text : {"", "wheels/radius", "=3", "wheels/radius="}) {
    expectSaid(errorOf([&] { files_.set(text); }), "NAME=VALUE");
  }
  expectSaid(errorOf([&] { files_.overlay("/none.yaml"); }), "/none.yaml: cannot be read");
  expectSaid(errorOf([&] { files_.overlay(write("list.yaml", "[1, 2]")); }),
             "not a list of names and values");
}

/// What a detection learns of lens and mirror, which begins with those of the simulated robot.
class SavedOptics : public ParametersFromFiles {
 protected:
  static DetectionNodeConfig started(const std::vector<std::string>& overrides) {
    ParameterFiles files;
    files.addNode("calibration", packagedConfig("calibration.yaml"));  // the robot's wheels are its
    files.addNode("detection", packagedConfig("detection.yaml"));
    files.overlay(packagedConfig("robots/simulated.yaml"));
    for (const std::string& file : overrides) files.overlay(file);
    return readConfig<DetectionNodeConfig>(files.reader("detection"));
  }

  /// What so many images of a light show of a mirror, to one who expects what is configured.
  static core::OpticsLearner learntFrom(const core::ConicMirror& mirror, int images,
                                        const core::DetectorConfig& configured) {
    core::OpticsLearner learner(configured);
    for (int i = 1; i <= images; ++i) {
      core::RangedSpot spot;
      spot.stamp = core::stampFromSeconds(i);
      spot.azimuth_rad = i;
      spot.distance_m = 0.6 + 0.4 * (i % 4);
      spot.image_radius_px = core::radiusFromLight(mirror, {spot.distance_m, -0.02}).value();
      const core::SpotBlur blur = core::expectedBlur(mirror, spot.image_radius_px, spot.distance_m);
      spot.variances_px2 << blur.tangential_diameter_px, blur.radial_diameter_px;
      spot.variances_px2 = (0.25 * spot.variances_px2).cwiseAbs2();
      learner.add(spot);
    }
    return learner;
  }
  static std::string textOf(const fs::path& file) {
    std::ostringstream text;
    text << std::ifstream(file).rdbuf();
    return text.str();
  }
};

TEST_F(SavedOptics, AreParametersOfTheNextStart) {
  const core::DetectorConfig before = started({}).detector;
  core::OpticsLearner learner(before);
  core::RangedSpot spot;
  spot.stamp = core::stampFromSeconds(1.0);
  spot.image_radius_px = 190.0;
  spot.variances_px2 << 22.0, 6.0;
  spot.distance_m = 1.0;
  ASSERT_TRUE(learner.add(spot));
  const core::DetectorConfig learnt = learner.applied(before);
  const core::DetectorConfig after =
      started({write("optics.yaml", core::yamlOf(learner))}).detector;
  constexpr double kDigits = 1e-9;
  EXPECT_NE(after.mirror.half_angle_rad, before.mirror.half_angle_rad);
  EXPECT_NEAR(after.mirror.half_angle_rad, learnt.mirror.half_angle_rad, kDigits);
  EXPECT_NEAR(after.mirror.focal_length_m, learnt.mirror.focal_length_m, kDigits);
  EXPECT_NEAR(after.mirror.aperture_m, learnt.mirror.aperture_m, kDigits);
  EXPECT_NEAR(after.mirror.focus_distance_m, learnt.mirror.focus_distance_m, kDigits);
  EXPECT_NEAR(after.optics_stddev.half_angle_rad, learnt.optics_stddev.half_angle_rad, kDigits);
  EXPECT_NEAR(after.optics_stddev.scale, learnt.optics_stddev.scale, kDigits);
  EXPECT_NEAR(after.optics_stddev.aperture, learnt.optics_stddev.aperture, kDigits);
  EXPECT_NEAR(after.optics_stddev.focus, learnt.optics_stddev.focus, kDigits);
}

// Promise kept: learnt optics of two cameras whose nodes share optics/folder
TEST_F(SavedOptics, OfTwoNodesLieInFilesOfTheirNames) {
  const fs::path folder = testing::TempDir() + "parameter_files_optics";
  fs::remove_all(folder);
  std::map<std::string, std::string> expected;
  for (const std::string camera : {"left", "right"}) {
    const core::DetectorConfig configured = started({}).detector;
    core::ConicMirror mirror = configured.mirror;
    if (camera == "left") mirror.aperture_m *= 1.25;  // than is configured
    const core::OpticsLearner learner = learntFrom(mirror, 100, configured);
    ASSERT_GT(learner.learntValues(), 0);
    expected[camera + ".light_detection.yaml"] = core::yamlOf(learner);
    OpticsFile(folder, "/" + camera + "/light_detection").see(learner);
  }
  ASSERT_NE(expected.begin()->second, expected.rbegin()->second);
  for (const auto& [file, text] : expected) {
    EXPECT_EQ(textOf(folder / file), text) << file;
  }
}

// Promise kept: learnt optics over which a shorter run has learnt less
TEST_F(SavedOptics, StayUntilAsManyValuesAreLearntAgain) {
  const fs::path folder = testing::TempDir() + "parameter_files_less";
  fs::remove_all(folder);
  const fs::path file = folder / "light_detection.yaml";
  const core::DetectorConfig configured = started({}).detector;
  const core::OpticsLearner most = learntFrom(configured.mirror, 200, configured);
  const core::OpticsLearner as_many = learntFrom(configured.mirror, 100, configured);
  core::OpticsLearner fewer = most;
  for (int i = 1; fewer.learntValues() != 1; ++i) {
    fewer = learntFrom(configured.mirror, i, configured);
  }
  ASSERT_GT(most.learntValues(), 1);
  ASSERT_EQ(as_many.learntValues(), most.learntValues());
  const auto run = [&](const core::OpticsLearner& learner) {
    OpticsFile(folder, "/light_detection").see(learner);
    return textOf(file);
  };
  EXPECT_EQ(run(fewer), core::yamlOf(fewer));
  EXPECT_EQ(run(most), core::yamlOf(most));
  EXPECT_EQ(run(fewer), core::yamlOf(most));
  EXPECT_EQ(run(as_many), core::yamlOf(as_many));
  // A run may begin again with what is configured, when the lens is turned: its own file is its
  // own.
  {
    OpticsFile own(folder, "/light_detection");
    own.see(most);
    own.see(fewer);
  }
  EXPECT_EQ(textOf(file), core::yamlOf(fewer));
}

TEST_F(SavedOptics, CountAgainstWhatIsConfigured) {
  const core::DetectorConfig configured = started({}).detector;
  const core::OpticsLearner learner = learntFrom(configured.mirror, 100, configured);
  const std::string saved = core::yamlOf(learner);
  EXPECT_EQ(learner.learntValuesIn(saved), learner.learntValues());
  EXPECT_EQ(learner.learntValuesIn(""), 0);
  const std::string remark = "# scale_stddev: 9.0, focus_stddev: 9.0 by the data sheet\n";
  EXPECT_EQ(learner.learntValuesIn(remark + saved), learner.learntValues());
  // One who starts with them has learnt nothing more yet, and replaces them when it has.
  const core::OpticsLearner next(started({write("saved.yaml", saved)}).detector);
  EXPECT_EQ(next.learntValuesIn(saved), 0);
}

// Promise kept: learnt optics in the folder of the results
TEST_F(SavedOptics, StayBesideAResult) {
  const fs::path folder = testing::TempDir() + "parameter_files_beside";
  fs::remove_all(folder);
  const core::DetectorConfig configured = started({}).detector;
  const core::OpticsLearner learner = learntFrom(configured.mirror, 100, configured);
  const auto save = [&](const std::string& name) {
    core::OwnedFolder(folder).replace({{"result.yaml", name}, {name, name}});
  };
  save("first");
  OpticsFile(folder, "/light_detection").see(learner);
  for (const std::string name : {"second", "third"}) {
    save(name);
    EXPECT_EQ(textOf(folder / "light_detection.yaml"), core::yamlOf(learner)) << name;
  }
  EXPECT_EQ(textOf(folder / "result.yaml"), "third");
  EXPECT_FALSE(fs::exists(folder / "first") || fs::exists(folder / "second"));
}

// The variances of a spot's centre are those along its axes: nearly the azimuth's and elevation's.
TEST_F(ParametersFromFiles, WithoutAMirrorAxesAreThoseOfTheImage) {
  const std::string file = write("camera.yaml",
                                 "mirror: {kind: none}\nmask: {last_row: 479}\n"
                                 "sensor: {width: 640, height: 480}\n");
  ParameterFiles files;
  files.addNode("detection", packagedConfig("detection.yaml"));
  files.overlay(file);
  const auto config = readConfig<DetectionNodeConfig>(files.reader("detection")).detector;
  for (const Eigen::Vector2d& place : {Eigen::Vector2d(0.0, 0.0), Eigen::Vector2d(639.0, 479.0)}) {
    const Eigen::Matrix2d axes = core::mirrorAxes(place, config.view.centre_px());
    EXPECT_NEAR(std::abs(axes(0, 0)), 0.0, 0.02);
    EXPECT_NEAR(std::abs(axes(1, 1)), 0.0, 0.02);
  }
}

// Promise refused: a file of learnt optics with a mistake
TEST_F(SavedOptics, AMistakeInThemIsNamed) {
  const auto refusal = [](const std::string& text) -> std::string {
    try {
      started({write("mistaken.yaml", text)});
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  };
  const auto names = [&](const std::string& name, const std::string& text) {
    return refusal(text).find(name) != std::string::npos;
  };
  EXPECT_TRUE(names("lens/apperture", "lens: {apperture: 0.002}"));
  EXPECT_TRUE(names("mirror/half_angle", "mirror: {half_angle: 52.5}"));
  EXPECT_TRUE(names("lens/focus_distance", "lens: {focus_distance: 0.001}"));
}

}  // namespace
}  // namespace bearing_calibration_ros
