#include "tools/owner/recording_csv.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <sstream>
#include <string>

namespace bearing_calibration::core {
namespace {

constexpr RecordingUnits kMillimetres{1e-3, 100.0};
constexpr std::int32_t kLandmark = 7;

std::vector<CounterRow> counters(const std::string& text) {
  std::istringstream stream(text);
  return readCounters(stream, "wheels.csv", kMillimetres);
}

std::vector<ObservationRow> observations(const std::string& text) {
  std::istringstream stream(text);
  return readObservations(stream, "observations.csv", kLandmark, kMillimetres);
}

/// The message of the RecordingError that `read` throws.
std::string errorOf(const std::function<void()>& read) {
  try {
    read();
  } catch (const RecordingError& error) {
    return error.what();
  }
  return "no error";
}

std::string counterError(const std::string& text) {
  return errorOf([&] { counters(text); });
}

std::string observationError(const std::string& text) {
  return errorOf([&] { observations(text); });
}

TEST(ReadCounters, IncrementsAreSummedBeforeTheyAreQuantised) {
  // 0.4 mm a row: each increment alone would round to no tick at all.
  const auto rows =
      counters("t_s,left_m,right_m\n0,0.0004,-0.0004\n1,0.0004,-0.0004\n2,0.0004,0\n");
  ASSERT_EQ(rows.size(), 3U);
  EXPECT_EQ(rows[0].left_ticks, 0);
  EXPECT_EQ(rows[1].left_ticks, 1);
  EXPECT_EQ(rows[2].left_ticks, 1);
  EXPECT_EQ(rows[1].right_ticks, -1);
  EXPECT_EQ(rows[2].right_ticks, -1);
}

TEST(ReadCounters, QuantisedSumStaysWithinHalfATick) {
  std::string text = "t_s,left_m,right_m\n";
  double left_m = 0.0;
  std::vector<double> expected_m;
  for (int i = 0; i < 1000; ++i) {
    const double increment_m = 0.000371 * std::sin(0.1 * i) + 0.00021;
    std::ostringstream row;
    row.precision(17);
    row << i << "," << increment_m << ",0\n";
    text += row.str();
    left_m += increment_m;
    expected_m.push_back(left_m);
  }
  const auto rows = counters(text);
  ASSERT_EQ(rows.size(), expected_m.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const double read_m = 1e-3 * static_cast<double>(rows[i].left_ticks);
    EXPECT_LE(std::abs(read_m - expected_m[i]), 0.5e-3 + 1e-9) << "row " << i;
  }
}

TEST(ReadCounters, CountsAreTakenAsTheyAre) {
  const auto rows = counters("t_s,left_ticks,right_ticks\n0,20795,-9223372036854775807\n");
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_EQ(rows[0].left_ticks, 20795);
  EXPECT_EQ(rows[0].right_ticks, -9223372036854775807);
}

TEST(ReadCounters, StampsStartAtTheStartTime) {
  const auto rows = counters("t_s,left_ticks,right_ticks\n0,0,0\n0.1,0,0\n");
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0].stamp, stampFromSeconds(100.0));
  EXPECT_EQ(rows[1].stamp, stampFromNanoseconds(100100000000));
}

TEST(ReadCounters, ColumnsAreFoundByName) {
  const auto rows = counters("battery, right_ticks ,t_s,left_ticks\r\n12.1,3,5,4\r\n\r\n");
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_EQ(rows[0].stamp, stampFromSeconds(105.0));
  EXPECT_EQ(rows[0].left_ticks, 4);
  EXPECT_EQ(rows[0].right_ticks, 3);
}

TEST(ReadCounters, ErrorsNameFileAndLine) {
  EXPECT_EQ(counterError(""), "wheels.csv:0: the file is empty or cannot be read");
  EXPECT_EQ(counterError("t_s,left_m\n0,1\n"),
            "wheels.csv:1: column 'right_m' is missing: it has t_s,left_m");
  EXPECT_EQ(counterError("time,left_m,right_m\n0,1,2\n"),
            "wheels.csv:1: column 't_s' is missing: it has time,left_m,right_m");
  EXPECT_EQ(counterError("0,1,2\n1,1,2\n"), "wheels.csv:1: column 't_s' is missing: it has 0,1,2");
  EXPECT_EQ(counterError("t_s,left_m,right_m,left_ticks,right_ticks\n"),
            "wheels.csv:1: has columns of metres and of ticks: which ones are meant?");
  EXPECT_EQ(counterError("t_s,left_m,right_m\n"),
            "wheels.csv:1: there are no rows below the names of the columns");
  EXPECT_EQ(counterError("t_s,left_m,right_m\n0,0,0\n1,0\n"),
            "wheels.csv:3: has 2 cells where the first line names 3 columns");
  EXPECT_EQ(counterError("t_s,left_m,right_m\n0,0,1 m\n"),
            "wheels.csv:2: right_m '1 m' is not a number");
  EXPECT_EQ(counterError("t_s,left_m,right_m\n0,,0\n"), "wheels.csv:2: left_m '' is not a number");
  EXPECT_EQ(counterError("t_s,left_m,right_m\n0,nan,0\n"),
            "wheels.csv:2: left_m 'nan' is not finite");
  EXPECT_EQ(counterError("t_s,left_m,right_m\n0,1e300,0\n"),
            "wheels.csv:2: left_m '1e300' adds up to more ticks than 64 bits hold");
  EXPECT_EQ(counterError("t_s,left_ticks,right_ticks\n0,1.5,0\n"),
            "wheels.csv:2: left_ticks '1.5' is not a whole number");
  EXPECT_EQ(counterError("t_s,left_ticks,right_ticks\n0,0,99999999999999999999\n"),
            "wheels.csv:2: right_ticks '99999999999999999999' does not fit 64 bits");
}

TEST(ReadCounters, AByteOrderMarkIsNoPartOfTheFirstName) {
  const auto rows = counters("\xEF\xBB\xBFt_s,left_ticks,right_ticks\r\n0,3,4\r\n");
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_EQ(rows[0].left_ticks, 3);
}

TEST(ReadCounters, AStampThatRoundsToZeroIsNone) {
  EXPECT_NE(
      counterError("t_s,left_ticks,right_ticks\n-99.9999999999,2,3\n").find("ROS cannot hold"),
      std::string::npos);
}

// A file that was being written when the power went: a number before zeros may have lost digits.
TEST(ReadCounters, ZeroBytesAreNoEndOfANumber) {
  using namespace std::string_literals;
  EXPECT_NE(counterError("t_s,left_ticks,right_ticks\n1,2,3\n2,4,5\0\0\0"s)
                .find("wheels.csv:3: has zero bytes"),
            std::string::npos);
}

TEST(ReadCounters, WhatSpreadsheetsWriteIsNamed) {
  const std::string utf_16 = "wheels.csv:1: the file is in UTF-16: save it as UTF-8";
  using namespace std::string_literals;
  EXPECT_EQ(counterError("\xFF\xFEt\0_\0s\0,\0l\0\n\0"s), utf_16);
  EXPECT_EQ(counterError("\xFE\xFF\0t\0_\0s\0,\0l\0\n"s), utf_16);
  EXPECT_EQ(counterError("t\0_\0s\0,\0l\0\n\0"s),
            "wheels.csv:1: has zero bytes: the file is damaged, or in UTF-16 (save it as UTF-8)");
  const std::string semicolons =
      "cells are separated by semicolons: separate them by commas, and write numbers with points";
  EXPECT_EQ(counterError("t_s;left_m;right_m\n0;0,1;0\n"), "wheels.csv:1: " + semicolons);
  EXPECT_EQ(counterError("t_s,left_m,right_m\n0,0,0\n1;0,1;0\n"), "wheels.csv:3: " + semicolons);
  EXPECT_EQ(counterError("t_s\tleft_m\tright_m\n0\t1\t0\n"),
            "wheels.csv:1: cells are separated by tabs: separate them by commas");
  EXPECT_EQ(counterError("t_s,left_m,right_m\r0,1,0\r"),
            "wheels.csv:1: lines end with carriage returns alone: save it with line feeds (Unix or "
            "Windows)");
  const std::string quotes = "has quotes: write the cells without them, numbers with points";
  EXPECT_EQ(counterError("\"t_s\",\"left_m\",\"right_m\"\n0,0,0\n"), "wheels.csv:1: " + quotes);
  EXPECT_EQ(counterError("t_s,left_m,right_m\n0,0,0\n\"0,1\",\"0,1\",\"0\"\n"),
            "wheels.csv:3: " + quotes);
  EXPECT_EQ(counterError("t_s,left_m,right_m\n0,1,0,25,0,25\n"),
            "wheels.csv:2: has 6 cells where the first line names 3 columns: a decimal comma? "
            "numbers have points");
}

TEST(ReadCounters, AColumnThatNobodyReadsIsNotJudged) {
  EXPECT_EQ(counters("t_s,left_ticks,right_ticks,note\n0,3,4,\"so; so\"\n").size(), 1U);
}

TEST(ReadCounters, TimeMustGrow) {
  EXPECT_EQ(counterError("t_s,left_m,right_m\n1,0,0\n\n0.9,0,0\n"),
            "wheels.csv:4: t_s '0.9' is not later than that of the row before");
  EXPECT_EQ(counterError("t_s,left_m,right_m\n1,0,0\n1,0,0\n"),
            "wheels.csv:3: t_s '1' is not later than that of the row before");
  EXPECT_EQ(counterError("t_s,left_ticks,right_ticks\n1,5,6\n1,5,7\n"),
            "wheels.csv:3: t_s '1' is not later than that of the row before");
}

TEST(ReadCounters, TheSameReadingOnceMoreIsLeftOut) {
  std::istringstream stream("t_s,left_ticks,right_ticks\n1,5,6\n1,5,6\n2,7,8\n");
  EXPECT_EQ(readCounters(stream, "wheels.csv", kMillimetres).size(), 2U);
}

TEST(ReadCounters, StampsThatRosCannotHoldAreErrors) {
  EXPECT_NE(counterError("t_s,left_m,right_m\n-100,0,0\n").find("wheels.csv:2: t_s '-100'"),
            std::string::npos);
  EXPECT_NE(counterError("t_s,left_m,right_m\n1e10,0,0\n").find("wheels.csv:2: t_s '1e10'"),
            std::string::npos);
  std::istringstream stream("t_s,left_m,right_m\n0,0,0\n");
  EXPECT_THROW(readCounters(stream, "wheels.csv", {1e-3, std::nan("")}), RecordingError);
}

TEST(ReadCounters, WithoutATickSizeIsABrokenContract) {
  std::istringstream stream("t_s,left_m,right_m\n0,0,0\n");
  EXPECT_THROW(readCounters(stream, "wheels.csv", RecordingUnits{}), std::invalid_argument);
}

TEST(ReadObservations, TakesOneLandmarkInTheFilesOrder) {
  const auto rows = observations(
      "t_s,landmark_id,bearing_rad,range_m\n0,7,0.5,2\n0,8,0.6,2\n0.1,8,0.7,2\n0.1,7,-0.8,2\n");
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0].stamp, stampFromSeconds(100.0));
  EXPECT_DOUBLE_EQ(rows[0].bearing_rad, 0.5);
  EXPECT_EQ(rows[1].stamp, stampFromSeconds(100.1));
  EXPECT_DOUBLE_EQ(rows[1].bearing_rad, -0.8);
}

TEST(ReadObservations, ErrorsNameFileAndLine) {
  EXPECT_EQ(observationError("t_s,bearing_rad\n0,1\n"),
            "observations.csv:1: column 'landmark_id' is missing: it has t_s,bearing_rad");
  EXPECT_EQ(observationError("t_s,landmark_id,bearing_rad\n1,7,0\n0.5,8,0\n"),
            "observations.csv:3: t_s '0.5' is earlier than that of the row before");
  EXPECT_EQ(observationError("t_s,landmark_id,bearing_rad\n1,8,x\n"),
            "observations.csv:2: bearing_rad 'x' is not a number");
  EXPECT_EQ(
      observationError("t_s,landmark_id,bearing_rad\n1,7,3.1\n2,8,-57.3\n"),
      "observations.csv:3: bearing_rad '-57.3' lies beyond 2 pi: is it in degrees? bearings are in "
      "radians");
  EXPECT_EQ(observationError("t_s,landmark_id,bearing_rad\n1,8.5,0\n"),
            "observations.csv:2: landmark_id '8.5' is not a whole number");
  EXPECT_EQ(observationError("t_s,landmark_id,bearing_rad\n"),
            "observations.csv:1: there are no rows below the names of the columns");
  EXPECT_EQ(observationError("t_s,landmark_id,bearing_rad\n1,9,0\n1,8,0\n"),
            "observations.csv:3: landmark 7 is never seen, only (8, 9)");
}

}  // namespace
}  // namespace bearing_calibration::core
