#include "bearing_calibration/vision/spot_pixels.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "bearing_calibration/vision/processor_clones.h"

namespace bearing_calibration {
namespace {

// Pixels are copied so many at a time: what is too much is overwritten by the next row.
constexpr int kChunk = 16;

/// An ellipse and a smaller one of the same shape inside it, in rows from the first one on.
struct EllipseRows {
  float first_dv;  ///< of the first row from the centre
  float u0;
  float skew;       ///< by which a chord's middle moves from row to row
  float narrowing;  ///< of a chord's squared half length with the row's square
  float outer_half2;
  float inner_half2;  ///< squared half lengths in the middle row
  float width_px;     ///< of the image
};

BEARING_CALIBRATION_CLONES void cutChords(const EllipseRows& ellipse, int rows,
                                          PixelChord* chords) {
  const EllipseRows e = ellipse;
#pragma omp simd
  for (int row = 0; row < rows; ++row) {
    const float dv = e.first_dv + static_cast<float>(row);
    const float narrower = e.narrowing * dv * dv;
    const float outer = std::sqrt(std::max(0.0F, e.outer_half2 - narrower));
    const float inner = std::sqrt(std::max(0.0F, e.inner_half2 - narrower));
    const float middle = e.u0 + e.skew * dv + 1.0F;  // converting a positive number rounds down
    const auto column = [&](float u) {
      return static_cast<int>(std::min(std::max(u, 0.0F), e.width_px));
    };
    chords[row] = {column(middle - outer), column(middle - inner), column(middle + inner),
                   column(middle + outer)};
  }
}

/// Where the next pixels of a column are written.
struct ColumnEnd {
  explicit ColumnEnd(PixelColumn* column)
      : levels(column->levels.data()), u_px(column->u_px.data()), v_px(column->v_px.data()) {}

  float* levels;
  float* u_px;
  float* v_px;
};

/// Takes a row's pixels [begin, end); writes some more.
template <typename Level>
inline __attribute__((always_inline)) void append(const Level* row, int width, int begin, int end,
                                                  float u0, float dv, ColumnEnd* column) {
  const int count = std::max(0, end - begin);
  int copied = 0;
  for (; copied < count && begin + copied + kChunk <= width; copied += kChunk) {
    const float chunk_u = static_cast<float>(begin + copied) - u0;
    // Two loops, for bytes would hold the places back to narrower vectors.
#pragma omp simd
    for (int i = 0; i < kChunk; ++i) column->levels[copied + i] = row[begin + copied + i];
#pragma omp simd
    for (int i = 0; i < kChunk; ++i) {
      column->u_px[copied + i] = chunk_u + static_cast<float>(i);
      column->v_px[copied + i] = dv;
    }
  }
  for (; copied < count; ++copied) {  // beside the image's right edge
    column->levels[copied] = row[begin + copied];
    column->u_px[copied] = static_cast<float>(begin + copied) - u0;
    column->v_px[copied] = dv;
  }
  column->levels += count;
  column->u_px += count;
  column->v_px += count;
}

/// The rows of an image from `first` on, by their chords.
struct ChordRows {
  const cv::Mat& image;
  int first;
  const std::vector<PixelChord>& chords;
  float u0;
  float first_dv;
};

template <typename Level>
inline __attribute__((always_inline)) void gatherRows(const ChordRows& rows, PixelColumn* window,
                                                      PixelColumn* ring) {
  const int width = rows.image.cols;
  ColumnEnd window_end(window);
  ColumnEnd ring_end(ring);
  for (std::size_t i = 0; i < rows.chords.size(); ++i) {
    const PixelChord& chord = rows.chords[i];
    const Level* row = rows.image.ptr<Level>(rows.first + static_cast<int>(i));
    const float dv = rows.first_dv + static_cast<float>(i);
    append(row, width, chord.begin, chord.inner_begin, rows.u0, dv, &ring_end);
    append(row, width, chord.inner_begin, chord.inner_end, rows.u0, dv, &window_end);
    append(row, width, chord.inner_end, chord.end, rows.u0, dv, &ring_end);
  }
  window->size = static_cast<int>(window_end.levels - window->levels.data());
  ring->size = static_cast<int>(ring_end.levels - ring->levels.data());
}

BEARING_CALIBRATION_CLONES void gatherBytes(const ChordRows& rows, PixelColumn* window,
                                            PixelColumn* ring) {
  gatherRows<std::uint8_t>(rows, window, ring);
}
BEARING_CALIBRATION_CLONES void gatherWords(const ChordRows& rows, PixelColumn* window,
                                            PixelColumn* ring) {
  gatherRows<std::uint16_t>(rows, window, ring);
}

void gatherLevels(const ChordRows& rows, PixelColumn* window, PixelColumn* ring) {
  if (rows.image.depth() == CV_8U) {
    gatherBytes(rows, window, ring);
  } else {
    gatherWords(rows, window, ring);
  }
}

}  // namespace

void PixelColumn::makeRoom(std::size_t pixels) {
  const std::size_t wanted = pixels + kChunk;
  if (wanted <= levels.size()) return;
  levels.resize(wanted);
  u_px.resize(wanted);
  v_px.resize(wanted);
}

void SpotPixels::gather(const cv::Mat& image, const cv::Mat& sharp, const PixelEllipse& ellipse,
                        double inner_reach) {
  const Eigen::Matrix2d& covariance = ellipse.covariance_px2;
  const double half_height = ellipse.reach * std::sqrt(covariance(1, 1));
  const double v0 = ellipse.centre_px.y();
  const double last = image.rows;
  const int first_row = static_cast<int>(std::clamp(v0 - half_height + 1.0, 0.0, last));
  const int end_row = static_cast<int>(std::clamp(v0 + half_height + 1.0, 0.0, last));
  chords_.resize(static_cast<std::size_t>(std::max(0, end_row - first_row)));
  // The squared half length of the chord in row dv: det / C_vv (reach^2 - dv^2 / C_vv).
  const double half2 = covariance.determinant() / covariance(1, 1);
  const EllipseRows rows{static_cast<float>(first_row - v0),
                         static_cast<float>(ellipse.centre_px.x()),
                         static_cast<float>(covariance(0, 1) / covariance(1, 1)),
                         static_cast<float>(half2 / covariance(1, 1)),
                         static_cast<float>(half2 * ellipse.reach * ellipse.reach),
                         static_cast<float>(half2 * inner_reach * inner_reach),
                         static_cast<float>(image.cols)};
  cutChords(rows, static_cast<int>(chords_.size()), chords_.data());
  std::size_t pixels = 0;
  for (const PixelChord& chord : chords_)
    pixels += static_cast<std::size_t>(chord.end - chord.begin);
  window_.makeRoom(pixels);
  ring_.makeRoom(pixels);
  sharp_is_image_ = sharp.data == image.data;
  if (!sharp_is_image_) {
    sharp_window_.makeRoom(pixels);
    gatherLevels({sharp, first_row, chords_, rows.u0, rows.first_dv}, &sharp_window_, &ring_);
  }
  gatherLevels({image, first_row, chords_, rows.u0, rows.first_dv}, &window_, &ring_);
}

}  // namespace bearing_calibration
