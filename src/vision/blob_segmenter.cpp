#include "bearing_calibration/vision/blob_segmenter.h"

#include <cmath>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/vision/image_levels.h"

namespace bearing_calibration::core {
namespace {

// A light is some tens of runs. So many blobs or runs are noise: the threshold lies in the
// background.
constexpr std::size_t kMaxLabels = 20000;
constexpr std::size_t kMaxEdges = 200000;

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

/// A blob's moments in units that need no division for each run.
struct BlobSegmenter::RunSums {
  void add(std::int64_t row, std::int64_t begin, std::int64_t end) {
    const std::int64_t run = end - begin;
    const std::int64_t twice_middle = begin + end - 1;
    const std::int64_t u = twice_middle * run;
    const std::int64_t v = row * run;
    pixels += run;
    twice_u += u;
    sum_v += v;
    twelve_uu += 3 * twice_middle * u + (run * run - 1) * run;
    twice_uv += row * u;
    sum_vv += row * v;
  }
  Blob blob() const {
    return {pixels, twice_u / 2, sum_v, twelve_uu / 12, twice_uv / 2, sum_vv, cut};
  }

  std::int64_t pixels = 0;
  std::int64_t twice_u = 0;
  std::int64_t sum_v = 0;
  std::int64_t twelve_uu = 0;
  std::int64_t twice_uv = 0;
  std::int64_t sum_vv = 0;
  bool cut = false;
};

BlobSegmenter::BlobSegmenter() {
  labels_.reserve(kMaxLabels);
  parents_.reserve(kMaxLabels + 1);
  blobs_.reserve(kMaxLabels + 1);
}

const std::vector<Blob>& BlobSegmenter::segment(const cv::Mat& image,
                                                const std::vector<PixelStrip>& strips,
                                                int threshold) {
  std::size_t rows = 0;
  for (const PixelStrip& strip : strips) rows += static_cast<std::size_t>(strip.rows);
  rows_.resize(rows);
  edges_.resize(kMaxEdges + static_cast<std::size_t>(image.cols));
  const BrightRuns runs{rows_.data(), edges_.data(), edges_.size()};
  const BrightCount bright = visitLevels(image, [&](const auto& levels, const auto& kernels) {
    return kernels.findRuns(levels, strips.data(), strips.size(), threshold, runs);
  });
  parents_.clear();
  blobs_.clear();
  complete_ = join(strips, bright.rows) && bright.complete;
  collect();
  return blobs_;
}

/// The first of a label's chain.
inline int BlobSegmenter::root(int label) {
  while (parents_[static_cast<std::size_t>(label)] != label) {
    int& parent = parents_[static_cast<std::size_t>(label)];
    parent = parents_[static_cast<std::size_t>(parent)];
    label = parent;
  }
  return label;
}

/// The label of the runs above that touch [begin, end), which become one; a new one without any.
inline int BlobSegmenter::labelOf(int begin, int end, RunRange* above) {
  const int* edges = edges_.data();
  while (above->first < above->last && edges[2 * above->first + 1] < begin) ++above->first;
  int label = kNoLabel;
  for (std::size_t run = above->first; run < above->last && edges[2 * run] <= end; ++run) {
    const int joined = root(labels_[run]);
    if (label == kNoLabel) label = joined;
    parents_[static_cast<std::size_t>(joined)] = label;
  }
  if (label != kNoLabel) return label;
  parents_.push_back(static_cast<int>(parents_.size()));
  blobs_.emplace_back();
  return parents_.back();
}

/// Adds the runs of rows [i, rows) as long as each has one that touches the one of the row above,
/// which has no other, either: most of a light. @return the place after the last of these rows
std::size_t BlobSegmenter::addLoneRuns(std::size_t i, std::size_t rows, int last_row,
                                       RunSums* total) {
  RunSums sums = *total;
  const int* edges = edges_.data();
  int run = rows_[i - 1].edges;
  const int label = labels_[static_cast<std::size_t>(run / 2 - 1)];
  for (; i < rows; ++i, run += 2) {
    const BrightRow& above = rows_[i - 1];
    const BrightRow& row = rows_[i];
    const bool lone = row.edges == run + 2 && (i + 1 == rows || rows_[i + 1].row != row.row);
    const int begin = edges[run];
    const int end = edges[run + 1];
    if (!lone || row.row != above.row + 1 || edges[run - 2] > end || edges[run - 1] < begin) break;
    labels_[static_cast<std::size_t>(run / 2)] = label;
    sums.add(row.row, begin, end);
    sums.cut |= begin == row.begin || end == row.end || row.row == last_row;
  }
  *total = sums;
  return i;
}

/// Sums up runs that touch under one label, or under labels of one root. @return whether there were
/// enough labels
bool BlobSegmenter::join(const std::vector<PixelStrip>& strips, std::size_t rows) {
  if (rows == 0) return true;
  labels_.resize(static_cast<std::size_t>(rows_[rows - 1].edges) / 2);
  const int first_row = strips.front().row;
  const int last_row = strips.back().row + strips.back().rows - 1;
  RunRange above;
  std::size_t row_begin = 0;
  std::size_t run = 0;
  int v = rows_[0].row;
  int owner = kNoLabel;
  RunSums sums;  // what the owner has got since it last was another
  for (std::size_t i = 0; i < rows;) {
    const BrightRow& row = rows_[i];
    if (row.row != v) {
      above = {row.row == v + 1 ? row_begin : run, run};
      row_begin = run;
      v = row.row;
    }
    for (const std::size_t last = static_cast<std::size_t>(row.edges) / 2; run < last; ++run) {
      const int begin = edges_[2 * run];
      const int end = edges_[2 * run + 1];
      const int label = labelOf(begin, end, &above);
      labels_[run] = label;
      if (label != owner) {
        if (owner != kNoLabel) addTo(&blobs_[static_cast<std::size_t>(owner)], sums.blob());
        if (blobs_.size() > kMaxLabels) return false;
        owner = label;
        sums = {};
      }
      sums.add(v, begin, end);
      sums.cut |= begin == row.begin || end == row.end || v == first_row || v == last_row;
    }
    ++i;
    if (run != row_begin + 1) continue;
    i = addLoneRuns(i, rows, last_row, &sums);
    v = rows_[i - 1].row;
    run = static_cast<std::size_t>(rows_[i - 1].edges) / 2;
    row_begin = run - 1;
  }
  if (owner != kNoLabel) addTo(&blobs_[static_cast<std::size_t>(owner)], sums.blob());
  return true;
}

/// Leaves the roots' blobs, with what belongs to them.
void BlobSegmenter::collect() {
  std::size_t roots = 0;
  for (std::size_t label = 0; label < blobs_.size(); ++label) {
    const auto owner = static_cast<std::size_t>(root(static_cast<int>(label)));
    if (owner != label) addTo(&blobs_[owner], blobs_[label]);
  }
  for (std::size_t label = 0; label < blobs_.size(); ++label) {
    if (parents_[label] == static_cast<int>(label)) blobs_[roots++] = blobs_[label];
  }
  blobs_.resize(roots);
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

}  // namespace bearing_calibration::core
