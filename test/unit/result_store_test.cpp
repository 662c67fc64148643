#include "bearing_calibration/output/result_store.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <set>
#include <string>

#include "support/some_calibration.h"
#include "support/temporary_folder.h"

namespace bearing_calibration::core {
namespace {

namespace fs = std::filesystem;

class ResultStoreTest : public testing::Test {
 protected:
  void SetUp() override { terms_.targets = {0.01, 0.005}; }

  /// A result with a mark by which it is known again, and standard deviations times `scale`.
  static SavedCalibration marked(const std::string& mark, CalibrationState state, double scale) {
    SavedCalibration saved = someCalibration();
    saved.lasting = lastingPart(saved.mount());
    saved.result.advice = mark;
    saved.result.state = state;
    saved.result.base_from_sensor->covariance *= scale * scale;
    return saved;
  }
  static std::string markIn(const fs::path& folder) {
    const ResultFileContent content = readResultFile(folder / "result.yaml");
    return content.calibration ? content.calibration->result.advice : content.error;
  }
  static std::ptrdiff_t countIn(const fs::path& folder) {
    return std::distance(fs::directory_iterator(folder), {});
  }
  StoredResult store(const SavedCalibration& saved) { return storeResult(out_, saved, terms_); }

  static constexpr auto kConverged = CalibrationState::kConverged;
  static constexpr auto kConverging = CalibrationState::kConverging;
  static constexpr std::ptrdiff_t kFiles = 8;  ///< result.yaml, the six forms, and the list of them
  const TemporaryFolder own_;
  const fs::path top_ = own_.path();
  const fs::path out_ = top_ / "out";
  SavingTerms terms_;
};

TEST_F(ResultStoreTest, WritesTheResultAndItsForms) {
  const StoredResult stored = store(marked("first", kConverged, 1.0));
  EXPECT_TRUE(stored.success && stored.is_foremost);
  EXPECT_EQ(stored.message, "written to " + (out_ / "result.yaml").string());
  EXPECT_EQ(countIn(out_), kFiles);
  EXPECT_EQ(resultPathIn(out_), out_ / "result.yaml");
}

TEST_F(ResultStoreTest, ABetterOneReplacesAWorseOneGivesWay) {
  store(marked("first", kConverging, 1.0));
  EXPECT_TRUE(store(marked("second", kConverged, 1.0)).is_foremost);
  EXPECT_EQ(markIn(out_), "second");
  const StoredResult third = store(marked("third", kConverging, 0.1));
  EXPECT_FALSE(third.is_foremost);
  EXPECT_TRUE(third.success) << "a better one of its mount is there";
  EXPECT_EQ(third.folder, "");
  EXPECT_EQ(third.message,
            (out_ / "result.yaml").string() + " stays: it is CONVERGED, this one CONVERGING");
  EXPECT_EQ(markIn(out_), "second");
  EXPECT_EQ(countIn(out_), kFiles);
}

TEST_F(ResultStoreTest, AskedForAWorseOneIsWrittenBesideTheBetter) {
  store(marked("first", kConverged, 1.0));
  terms_.even_if_worse = true;
  terms_.more = {{"details.yaml", "more\n"}};
  const StoredResult second = store(marked("second", kConverging, 1.0));
  EXPECT_TRUE(second.success);
  EXPECT_EQ(second.folder, out_ / "1");
  EXPECT_NE(second.message.find("this one is written to " + (out_ / "1/result.yaml").string()),
            std::string::npos)
      << second.message;
  EXPECT_EQ(markIn(out_), "first");
  EXPECT_EQ(markIn(out_ / "1"), "second");
  EXPECT_EQ(countIn(out_ / "1"), kFiles + 1);
}

TEST_F(ResultStoreTest, AContradictedOneIsKeptWithAllItsFiles) {
  terms_.more = {{"details.yaml", "of the first\n"}};
  store(marked("first", kConverged, 1.0));
  SavedCalibration other = marked("second", kConverging, 1.0);
  other.result.base_from_sensor->mean.x() += 0.1;
  terms_.more = {};
  const StoredResult second = store(other);
  EXPECT_TRUE(second.is_foremost);
  EXPECT_NE(second.message.find("kept in " + (out_ / "1").string()), std::string::npos)
      << second.message;
  EXPECT_EQ(markIn(out_), "second");
  EXPECT_FALSE(fs::exists(out_ / "details.yaml")) << "it is not of the second";
  EXPECT_EQ(markIn(out_ / "1"), "first");
  EXPECT_EQ(countIn(out_ / "1"), kFiles + 1);
}

TEST_F(ResultStoreTest, AfterAResetTheOldOneIsKept) {
  store(marked("first", kConverged, 1.0));
  terms_.reset_between = true;
  EXPECT_TRUE(store(marked("second", kConverging, 1.0)).is_foremost);
  EXPECT_EQ(markIn(out_) + markIn(out_ / "1"), "secondfirst");
}

TEST_F(ResultStoreTest, WhatCannotBeReadIsKept) {
  store(marked("first", kConverged, 1.0));
  std::ofstream(out_ / "result.yaml") << "format: of the year after next\n";
  EXPECT_TRUE(store(marked("second", kConverging, 1.0)).is_foremost);
  EXPECT_EQ(markIn(out_), "second");
  EXPECT_TRUE(fs::exists(out_ / "1" / "result.yaml"));
}

TEST_F(ResultStoreTest, AnUntrustedOneHasNoForms) {
  EXPECT_TRUE(store(marked("first", CalibrationState::kInitialising, 1.0)).is_foremost);
  EXPECT_EQ(countIn(out_), 2);
  EXPECT_FALSE(store(marked("second", CalibrationState::kInitialising, 2.0)).success);
}

TEST_F(ResultStoreTest, ARunThatFoundNothingLeavesAResultAlone) {
  EXPECT_EQ(storeWithoutResult(out_, {{"details.yaml", "none\n"}}).folder, out_);
  EXPECT_EQ(store(marked("first", kConverged, 1.0)).folder, out_);
  EXPECT_FALSE(fs::exists(out_ / "details.yaml"));
  const StoredResult nothing = storeWithoutResult(out_, {{"details.yaml", "none\n"}});
  EXPECT_EQ(nothing.folder, out_ / "1");
  EXPECT_NE(nothing.message.find("is of an earlier run"), std::string::npos) << nothing.message;
  EXPECT_EQ(markIn(out_), "first");
}

TEST_F(ResultStoreTest, BesideOthersFilesItHasAFolderOfItsOwn) {
  fs::create_directory(out_);
  std::ofstream(out_ / "mount.urdf") << "the robot's own\n";
  const StoredResult stored = store(marked("first", kConverged, 1.0));
  EXPECT_EQ(stored.folder, out_ / "bearing_calibration");
  EXPECT_EQ(resultPathIn(out_), out_ / "bearing_calibration" / "result.yaml");
  EXPECT_EQ(countIn(out_), 2);
}

// Promise named: what the file system refuses
TEST_F(ResultStoreTest, SaysWhatTheFileSystemRefuses) {
  std::ofstream(out_) << "a file\n";
  const StoredResult stored = storeResult(out_ / "below", someCalibration(), terms_);
  EXPECT_FALSE(stored.success);
  EXPECT_NE(stored.message.find("Not a directory"), std::string::npos) << stored.message;
}

}  // namespace
}  // namespace bearing_calibration::core
