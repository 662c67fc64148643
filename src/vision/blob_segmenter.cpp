#include "bearing_calibration/vision/blob_segmenter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core/hal/intrin.hpp>

#include "bearing_calibration/common/angle.h"

namespace bearing_calibration {
namespace {

// A light is some tens of runs. So many are noise: the threshold lies in the background.
constexpr std::size_t kMaxLabels = 20000;

// Mostly the scene is dark: a block without a bright pixel is skipped at the speed of reading it.
constexpr int kBlockPixels = 64;

constexpr int kVectors = kBlockPixels / cv::v_uint8x16::nlanes;

/// Where the vectors' pixels are above the threshold: the highest bit of each.
struct Brightness8 {
  explicit Brightness8(int threshold)
      : limit(cv::v_setall_u8(cv::saturate_cast<std::uint8_t>(threshold))) {}

  cv::v_uint8x16 operator()(const std::uint8_t* pixels) const { return cv::v_load(pixels) > limit; }

  cv::v_uint8x16 limit;
};
struct Brightness16 {
  explicit Brightness16(int threshold)
      : limit(cv::v_setall_u16(cv::saturate_cast<std::uint16_t>(threshold))) {}

  cv::v_uint8x16 operator()(const std::uint16_t* pixels) const {
    return cv::v_pack(cv::v_load(pixels) > limit,
                      cv::v_load(pixels + cv::v_uint16x8::nlanes) > limit);
  }

  cv::v_uint16x8 limit;
};

/// A bit for each pixel of a block, set where it is bright.
template <typename Level, typename Brightness>
std::uint64_t brightBits(const Level* block, const Brightness& brightness) {
  cv::v_uint8x16 bright[kVectors];
  for (int i = 0; i < kVectors; ++i) bright[i] = brightness(block + i * cv::v_uint8x16::nlanes);
  if (!cv::v_check_any((bright[0] | bright[1]) | (bright[2] | bright[3]))) return 0;
  std::uint64_t bits = 0;
  for (int i = 0; i < kVectors; ++i) {
    const auto part = static_cast<std::uint16_t>(cv::v_signmask(bright[i]));
    bits |= static_cast<std::uint64_t>(part) << static_cast<unsigned>(i * cv::v_uint8x16::nlanes);
  }
  return bits;
}

/// The same for the first of a block's pixels: some more may be looked at.
template <typename Level, typename Brightness>
std::uint64_t brightBitsOfPart(const Level* block, int pixels, const Brightness& brightness) {
  std::uint64_t bits = 0;
  for (int begin = 0; begin < pixels; begin += cv::v_uint8x16::nlanes) {
    const auto part = static_cast<std::uint16_t>(cv::v_signmask(brightness(block + begin)));
    bits |= static_cast<std::uint64_t>(part) << static_cast<unsigned>(begin);
  }
  return bits;
}

template <typename Level, typename Brightness>
std::uint64_t brightBitsOfTail(const Level* tail, int pixels, const Brightness& brightness) {
  std::array<Level, kBlockPixels> block{};
  std::copy(tail, tail + pixels, block.begin());
  return brightBits(block.data(), brightness);
}

/// Bits before `count`, which is at most all.
std::uint64_t lowBits(int count) {
  return count >= kBlockPixels ? ~std::uint64_t{0}
                               : (std::uint64_t{1} << static_cast<unsigned>(count)) - 1;
}

int firstBit(std::uint64_t bits) { return bits == 0 ? kBlockPixels : __builtin_ctzll(bits); }

/// Calls found(begin, end) for each run of pixels above the threshold in the interval.
template <typename Level, typename Brightness, typename Found>
void forEachRun(const Level* row, int width, const PixelInterval& interval,
                const Brightness& brightness, Found found) {
  constexpr int kNone = -1;
  int start = kNone;  // of the run that the block before ended with
  for (int block = interval.begin; block < interval.end; block += kBlockPixels) {
    // A block may reach beyond the interval, not beyond the row.
    const int left = interval.end - block;
    std::uint64_t bits = block + kBlockPixels > width
                             ? brightBitsOfTail(row + block, width - block, brightness)
                         : left < kBlockPixels ? brightBitsOfPart(row + block, left, brightness)
                                               : brightBits(row + block, brightness);
    bits &= lowBits(left);
    if (start != kNone) {
      const int length = firstBit(~bits);
      if (length == kBlockPixels) continue;
      found(start, block + length);
      start = kNone;
      bits &= ~lowBits(length);
    }
    while (bits != 0) {
      const int first = firstBit(bits);
      const int end = firstBit(~(bits | lowBits(first)));
      if (end == kBlockPixels) {
        start = block + first;
        break;
      }
      found(block + first, block + end);
      bits &= ~lowBits(end);
    }
  }
  if (start != kNone) found(start, interval.end);
}

/// Sum of squares of the integers below n.
std::int64_t squaresBelow(std::int64_t n) { return (n - 1) * n * (2 * n - 1) / 6; }

void addTo(Blob* blob, std::int64_t row, std::int64_t begin, std::int64_t end) {
  const std::int64_t pixels = end - begin;
  const std::int64_t sum_u = (begin + end - 1) * pixels / 2;
  blob->pixels += pixels;
  blob->sum_u += sum_u;
  blob->sum_v += row * pixels;
  blob->sum_uu += squaresBelow(end) - squaresBelow(begin);
  blob->sum_uv += row * sum_u;
  blob->sum_vv += row * row * pixels;
}

void addTo(Blob* blob, const Blob& part) {
  blob->pixels += part.pixels;
  blob->sum_u += part.sum_u;
  blob->sum_v += part.sum_v;
  blob->sum_uu += part.sum_uu;
  blob->sum_uv += part.sum_uv;
  blob->sum_vv += part.sum_vv;
  blob->cut = blob->cut || part.cut;
}

}  // namespace

BlobSegmenter::BlobSegmenter() {
  parents_.reserve(kMaxLabels);
  parts_.reserve(kMaxLabels);
  blobs_.reserve(kMaxLabels);
  for (std::vector<Run>& row : rows_) row.reserve(kMaxLabels);
}

const std::vector<Blob>& BlobSegmenter::segment(const cv::Mat& image,
                                                const std::vector<PixelInterval>& intervals,
                                                int threshold) {
  parents_.clear();
  parts_.clear();
  for (std::vector<Run>& row : rows_) row.clear();
  first_above_ = 0;
  complete_ = true;
  if (image.depth() == CV_8U) {
    scan<std::uint8_t>(image, intervals, Brightness8(threshold));
  } else {
    scan<std::uint16_t>(image, intervals, Brightness16(threshold));
  }
  collect();
  return blobs_;
}

/// Mostly the scene is dark: its rows are looked through without a branch.
template <typename Vector>
void BlobSegmenter::findBright(const cv::Mat& image, const std::vector<PixelInterval>& intervals,
                               const Vector& limit) {
  using Level = typename Vector::lane_type;
  bright_.resize(intervals.size());
  std::size_t found = 0;
  for (std::size_t i = 0; i < intervals.size(); ++i) {
    const PixelInterval& interval = intervals[i];
    // In whole vectors, and not beyond the row: some pixels beside the interval count as well.
    const int vectors = (interval.end - interval.begin + Vector::nlanes - 1) / Vector::nlanes;
    const int begin = std::min(interval.begin, image.cols - vectors * Vector::nlanes);
    bright_[found] = i;  // the next one's place when it is dark
    if (begin < 0) {     // an image narrower than a vector
      ++found;
      continue;
    }
    const Level* pixels = image.ptr<Level>(interval.row) + begin;
    Vector brightest = cv::v_load(pixels);
    for (int vector = 1; vector < vectors; ++vector) {
      brightest = cv::v_max(brightest, cv::v_load(pixels + vector * Vector::nlanes));
    }
    found += cv::v_check_any(brightest > limit) ? 1 : 0;
  }
  bright_.resize(found);
}

template <typename Level, typename Brightness>
void BlobSegmenter::scan(const cv::Mat& image, const std::vector<PixelInterval>& intervals,
                         const Brightness& brightness) {
  if (intervals.empty()) return;
  first_row_ = intervals.front().row;
  last_row_ = intervals.back().row;
  current_row_ = first_row_;
  findBright(image, intervals, brightness.limit);
  for (std::size_t i : bright_) {
    if (!complete_) return;
    const PixelInterval& interval = intervals[i];
    forEachRun(image.ptr<Level>(interval.row), image.cols, interval, brightness,
               [&](int begin, int end) { addRun(interval, begin, end); });
  }
}

void BlobSegmenter::startRow(int row) {
  if (row != current_row_ + 1) rows_[row_].clear();
  row_ = 1 - row_;
  rows_[row_].clear();
  current_row_ = row;
  first_above_ = 0;
}

void BlobSegmenter::addRun(const PixelInterval& interval, int begin, int end) {
  if (interval.row != current_row_) startRow(interval.row);
  int label = labelFromRowAbove(begin, end);
  constexpr int kNoLabel = -1;
  if (label == kNoLabel) {
    if (parts_.size() == kMaxLabels) {
      complete_ = false;
      return;
    }
    label = static_cast<int>(parts_.size());
    parents_.push_back(label);
    parts_.emplace_back();
  }
  Blob& part = parts_[static_cast<std::size_t>(label)];
  addTo(&part, interval.row, begin, end);
  part.cut = part.cut || begin == interval.begin || end == interval.end ||
             interval.row == first_row_ || interval.row == last_row_;
  rows_[row_].push_back({begin, end, label});
}

/// The label of the runs above that touch [begin, end), which become one; -1 without any.
int BlobSegmenter::labelFromRowAbove(int begin, int end) {
  int label = -1;
  const std::vector<Run>& row_above = rows_[1 - row_];
  while (first_above_ < row_above.size() && row_above[first_above_].end < begin) ++first_above_;
  for (std::size_t i = first_above_; i < row_above.size() && row_above[i].begin <= end; ++i) {
    const int above = root(row_above[i].label);
    if (label >= 0 && above != label) parents_[static_cast<std::size_t>(above)] = label;
    if (label < 0) label = above;
  }
  return label;
}

int BlobSegmenter::root(int label) {
  while (parents_[static_cast<std::size_t>(label)] != label) {
    int& parent = parents_[static_cast<std::size_t>(label)];
    parent = parents_[static_cast<std::size_t>(parent)];
    label = parent;
  }
  return label;
}

void BlobSegmenter::collect() {
  for (std::size_t label = 0; label < parts_.size(); ++label) {
    const int owner = root(static_cast<int>(label));
    if (owner == static_cast<int>(label)) continue;
    addTo(&parts_[static_cast<std::size_t>(owner)], parts_[label]);
  }
  blobs_.clear();
  for (std::size_t label = 0; label < parts_.size(); ++label) {
    if (parents_[label] == static_cast<int>(label)) blobs_.push_back(parts_[label]);
  }
}

BlobShape shapeOf(const Blob& blob) {
  constexpr double kPixelVariance = 1.0 / 12.0;  // of a square of side 1
  const double n = static_cast<double>(blob.pixels);
  const double u = static_cast<double>(blob.sum_u) / n;
  const double v = static_cast<double>(blob.sum_v) / n;
  BlobShape shape{u, v, 0.0, 0.0, 0.0, 0.0};
  shape.variance_uu_px2 = static_cast<double>(blob.sum_uu) / n - u * u + kPixelVariance;
  shape.variance_uv_px2 = static_cast<double>(blob.sum_uv) / n - u * v;
  shape.variance_vv_px2 = static_cast<double>(blob.sum_vv) / n - v * v + kPixelVariance;
  const double det =
      shape.variance_uu_px2 * shape.variance_vv_px2 - shape.variance_uv_px2 * shape.variance_uv_px2;
  shape.fill = n / (4.0 * kPi * std::sqrt(det));
  return shape;
}

}  // namespace bearing_calibration
