#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <random>
#include <tuple>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/vision/bright_spots.h"

namespace bearing_calibration::core {
namespace {

using Moments =
    std::tuple<std::int64_t, std::int64_t, std::int64_t, std::int64_t, std::int64_t, std::int64_t>;

std::vector<PixelStrip> wholeImage(const cv::Mat& image) {
  std::vector<PixelStrip> strips;
  for (int v = 0; v < image.rows; ++v) strips.push_back({v, 0, image.cols});
  return strips;
}

std::vector<Moments> sortedMoments(const std::vector<Blob>& blobs) {
  std::vector<Moments> moments;
  for (const Blob& b : blobs) {
    moments.emplace_back(b.pixels, b.sum_u, b.sum_v, b.sum_uu, b.sum_uv, b.sum_vv);
  }
  std::sort(moments.begin(), moments.end());
  return moments;
}

/// The same by flooding from pixel to pixel.
std::vector<Moments> floodedMoments(const cv::Mat& image, int threshold) {
  cv::Mat open = image > threshold;
  std::vector<Blob> blobs;
  for (int v = 0; v < open.rows; ++v) {
    for (int u = 0; u < open.cols; ++u) {
      if (open.at<std::uint8_t>(v, u) == 0) continue;
      Blob blob;
      std::deque<cv::Point> queue{{u, v}};
      open.at<std::uint8_t>(v, u) = 0;
      while (!queue.empty()) {
        const cv::Point p = queue.front();
        queue.pop_front();
        blob.pixels += 1;
        blob.sum_u += p.x;
        blob.sum_v += p.y;
        blob.sum_uu += p.x * p.x;
        blob.sum_uv += p.x * p.y;
        blob.sum_vv += p.y * p.y;
        for (int neighbour = 0; neighbour < 9; ++neighbour) {
          const cv::Point q(p.x + neighbour % 3 - 1, p.y + neighbour / 3 - 1);
          if (q.x < 0 || q.y < 0 || q.x >= open.cols || q.y >= open.rows) continue;
          if (open.at<std::uint8_t>(q) == 0) continue;
          open.at<std::uint8_t>(q) = 0;
          queue.push_back(q);
        }
      }
      blobs.push_back(blob);
    }
  }
  return sortedMoments(blobs);
}

/// Bright blocks of random size and density; the wide ones cross the scan's blocks.
template <typename Level>
cv::Mat randomImage(int width, int height, double density, std::mt19937* random) {
  std::uniform_real_distribution<double> unit;
  cv::Mat image(height, width, cv::DataType<Level>::type, cv::Scalar(10));
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      if (unit(*random) < density) image.at<Level>(v, u) = 200;
    }
  }
  return image;
}

TEST(BlobSegmenter, AgreesWithFloodFillingOnRandomImages) {
  std::mt19937 random(3);
  BlobSegmenter segmenter;
  for (int width : {1, 63, 64, 65, 200}) {
    for (double density : {0.01, 0.2, 0.4, 0.6, 0.95}) {
      const cv::Mat narrow = randomImage<std::uint8_t>(width, 50, density, &random);
      EXPECT_EQ(sortedMoments(segmenter.segment(narrow, wholeImage(narrow), 100)),
                floodedMoments(narrow, 100))
          << width << " wide, density " << density;
      const cv::Mat wide = randomImage<std::uint16_t>(width, 50, density, &random);
      EXPECT_EQ(sortedMoments(segmenter.segment(wide, wholeImage(wide), 100)),
                floodedMoments(wide, 100))
          << width << " wide, density " << density;
    }
  }
}

TEST(BlobSegmenter, AgreesWithFloodFillingWhereAPostDividesTheRows) {
  constexpr int kPost = 31;
  std::mt19937 random(4);
  BlobSegmenter segmenter;
  for (double density : {0.01, 0.05, 0.2, 0.6}) {
    cv::Mat image = randomImage<std::uint8_t>(70, 200, density, &random);
    image.colRange(kPost - 1, kPost).setTo(200);  // touches all that crosses it
    std::vector<PixelStrip> strips;
    for (int v = 0; v < 20; ++v) strips.push_back({v, 0, 70});
    for (int v = 20; v < image.rows; ++v) {
      strips.push_back({v, 0, kPost});
      if (v % 5 != 0) strips.push_back({v, kPost + 1, 70});
    }
    cv::Mat seen = cv::Mat::zeros(image.size(), image.type());
    for (const PixelStrip& s : strips) {
      const cv::Rect rect(s.begin, s.row, s.end - s.begin, 1);
      image(rect).copyTo(seen(rect));
    }
    EXPECT_EQ(sortedMoments(segmenter.segment(image, strips, 100)), floodedMoments(seen, 100))
        << "density " << density;
  }
}

TEST(BlobSegmenter, AgreesWithFloodFillingInStripsThatLieAnywhere) {
  std::mt19937 random(5);
  BlobSegmenter segmenter;
  for (int width : {8, 31, 32, 33, 63, 64, 65, 130, 200}) {
    for (double density : {0.02, 0.5, 0.98}) {
      const cv::Mat image = randomImage<std::uint8_t>(width, 23, density, &random);
      std::vector<PixelStrip> strips;
      for (int v = 0; v < 3; ++v) strips.push_back({v, width / 4, width - width / 8});
      for (int v = 3; v < image.rows; ++v) {
        strips.push_back({v, v % 4, width / 2});
        strips.push_back({v, width / 2 + 1, width - v % 2});
      }
      cv::Mat seen = cv::Mat::zeros(image.size(), image.type());
      for (const PixelStrip& s : strips) {
        const cv::Rect rect(s.begin, s.row, s.end - s.begin, 1);
        image(rect).copyTo(seen(rect));
      }
      EXPECT_EQ(sortedMoments(segmenter.segment(image, strips, 100)), floodedMoments(seen, 100))
          << width << " wide, density " << density;
    }
  }
}

TEST(BlobSegmenter, TheThresholdItselfIsDark) {
  cv::Mat image(1, 130, CV_8UC1, cv::Scalar(100));
  BlobSegmenter segmenter;
  EXPECT_TRUE(segmenter.segment(image, wholeImage(image), 100).empty());
  EXPECT_EQ(segmenter.segment(image, wholeImage(image), 99).size(), 1u);
}

TEST(BlobSegmenter, OnlyTheStripsAreSeen) {
  const cv::Mat image(4, 20, CV_8UC1, cv::Scalar(200));
  BlobSegmenter segmenter;
  // Two strips in one row, and a row that the mask leaves out between two others.
  const std::vector<PixelStrip> strips{{0, 2, 5}, {0, 8, 10}, {1, 2, 4}, {3, 2, 5}};
  const std::vector<Blob>& blobs = segmenter.segment(image, strips, 100);
  std::vector<std::int64_t> sizes;
  for (const Blob& blob : blobs) sizes.push_back(blob.pixels);
  EXPECT_EQ(sizes, (std::vector<std::int64_t>{5, 2, 3}));
  EXPECT_TRUE(blobs[0].cut);
}

TEST(BlobSegmenter, ABlobInsideTheMaskIsNotCut) {
  cv::Mat image(3, 20, CV_8UC1, cv::Scalar(0));
  image.at<std::uint8_t>(1, 7) = 200;
  BlobSegmenter segmenter;
  EXPECT_FALSE(segmenter.segment(image, wholeImage(image), 100).front().cut);
}

TEST(BlobSegmenter, ABlobThatReachesTheLastRowIsCut) {
  cv::Mat image(6, 20, CV_8UC1, cv::Scalar(0));
  image(cv::Rect(7, 2, 3, 4)).setTo(200);
  BlobSegmenter segmenter;
  std::vector<PixelStrip> strips = wholeImage(image);
  EXPECT_TRUE(segmenter.segment(image, strips, 100).front().cut);
  strips.back().begin = 7;  // cut by its last row's begin
  EXPECT_TRUE(segmenter.segment(image, strips, 100).front().cut);
  image.row(5).setTo(0);
  EXPECT_FALSE(segmenter.segment(image, wholeImage(image), 100).front().cut);
}

TEST(BlobSegmenter, ABlobInTheFirstOrTheLastRowIsCut) {
  for (int row : {0, 2}) {
    cv::Mat image(3, 20, CV_8UC1, cv::Scalar(0));
    image.at<std::uint8_t>(row, 7) = 200;
    BlobSegmenter segmenter;
    EXPECT_TRUE(segmenter.segment(image, wholeImage(image), 100).front().cut) << row;
  }
}

TEST(BlobSegmenter, GivesUpOnNoiseAndRecovers) {
  cv::Mat checkers(400, 400, CV_8UC1, cv::Scalar(0));
  for (int v = 0; v < checkers.rows; v += 2) {
    for (int u = 0; u < checkers.cols; u += 2) checkers.at<std::uint8_t>(v, u) = 200;
  }
  BlobSegmenter segmenter;
  segmenter.segment(checkers, wholeImage(checkers), 100);
  EXPECT_FALSE(segmenter.complete());
  const cv::Mat dark(10, 10, CV_8UC1, cv::Scalar(0));
  EXPECT_TRUE(segmenter.segment(dark, wholeImage(dark), 100).empty());
  EXPECT_TRUE(segmenter.complete());
}

Blob blobOf(const cv::Mat& mask) {
  BlobSegmenter segmenter;
  return segmenter.segment(mask, wholeImage(mask), 100).front();
}

// The area of a rectangle of squares is n, its moments are sides^2 / 12: fill = 12 / (4 pi).
TEST(BlobEllipse, ARectangleFillsThreeOverPi) {
  cv::Mat image(40, 60, CV_8UC1, cv::Scalar(0));
  image(cv::Rect(5, 7, 31, 12)).setTo(200);
  const LightEllipse ellipse = ellipseOf(blobOf(image), {0.0, 12.5});  // the radius is its row
  EXPECT_NEAR(ellipse.centre_px.x(), 20.0, 1e-12);
  EXPECT_NEAR(ellipse.centre_px.y(), 12.5, 1e-12);
  EXPECT_NEAR(ellipse.moments_px2(1, 1), 31.0 * 31.0 / 12.0, 1e-9);
  EXPECT_NEAR(ellipse.moments_px2(0, 0), 12.0 * 12.0 / 12.0, 1e-9);
  EXPECT_NEAR(ellipse.moments_px2(0, 1), 0.0, 1e-9);
  EXPECT_NEAR(ellipse.fill, 3.0 / kPi, 1e-9);
}

// An ellipse with semi-axes a and b has the moments a^2/4 and b^2/4 and the area pi a b: fill = 1.
// A digital one is off by its outline's pixels, whose errors are random: sqrt(outline) of the area.
TEST(BlobEllipse, AnEllipseFillsOne) {
  for (double angle : {0.0, 0.4, 1.2}) {
    cv::Mat image(100, 100, CV_8UC1, cv::Scalar(0));
    constexpr double kA = 20.0;
    constexpr double kB = 9.0;
    for (int v = 0; v < 100; ++v) {
      for (int u = 0; u < 100; ++u) {
        const double x = std::cos(angle) * (u - 50.3) + std::sin(angle) * (v - 49.6);
        const double y = -std::sin(angle) * (u - 50.3) + std::cos(angle) * (v - 49.6);
        if (x * x / (kA * kA) + y * y / (kB * kB) <= 1.0) image.at<std::uint8_t>(v, u) = 200;
      }
    }
    const LightEllipse ellipse = ellipseOf(blobOf(image), {0.0, 0.0});
    const double outline_error = std::sqrt(2.0 * kPi * kA) / (kPi * kA * kB);
    EXPECT_NEAR(ellipse.fill, 1.0, outline_error);
    EXPECT_NEAR(ellipse.centre_px.x(), 50.3, 0.1);
    EXPECT_NEAR(ellipse.variances_px2().sum(), 0.25 * (kA * kA + kB * kB), 2.0);
  }
}

}  // namespace
}  // namespace bearing_calibration::core
