#include "bearing_calibration/vision/spot_patch.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace bearing_calibration {
namespace {

/// The squared half length of the chord in row dv is chord_var (reach^2 - dv^2 / C_vv).
EllipseChords chordsOf(const PixelEllipse& ellipse, const SpotPatch& patch) {
  const EllipseShape& shape = ellipse.shape;
  const Eigen::Vector2d centre = patch.fromImage(ellipse.centre_px);
  const double slope = shape.chord_var_px2 / (shape.stddev_v_px * shape.stddev_v_px);
  return {static_cast<float>(centre.x()), static_cast<float>(centre.y()),
          static_cast<float>(shape.skew), static_cast<float>(slope),
          static_cast<float>(shape.chord_var_px2 * ellipse.reach * ellipse.reach)};
}

template <typename Level>
ImageRows<Level> rowsOf(const cv::Mat& image, const PixelBox& box) {
  return {image.ptr<Level>(box.first_row) + box.first_column,
          static_cast<std::ptrdiff_t>(image.step1()), box.last_column - box.first_column};
}

}  // namespace

EllipseShape::EllipseShape(const Eigen::Matrix2d& covariance_px2)
    : information(covariance_px2.inverse()),
      stddev_u_px(std::sqrt(covariance_px2(0, 0))),
      stddev_v_px(std::sqrt(covariance_px2(1, 1))),
      skew(covariance_px2(0, 1) / covariance_px2(1, 1)),
      chord_var_px2(1.0 / information(0, 0)) {}

PixelBox PixelEllipse::box(const cv::Size& image) const {
  const double half_width = reach * shape.stddev_u_px;
  const double half_height = reach * shape.stddev_v_px;
  // Less than a pixel more than the ellipse on each side.
  const auto limited = [](double place, int last) {
    return static_cast<int>(std::clamp(place + 1.0, 0.0, static_cast<double>(last)));
  };
  return {limited(centre_px.y() - half_height - 1.0, image.height),
          limited(centre_px.y() + half_height, image.height),
          limited(centre_px.x() - half_width - 1.0, image.width),
          limited(centre_px.x() + half_width, image.width)};
}

void SpotPatch::copy(const cv::Mat& image, const PixelBox& box) {
  box_ = box;
  const int rows = box.last_row - box.first_row;
  const auto wanted = static_cast<std::size_t>(rows * columns() + kPixelLanes);
  if (levels_.size() < wanted) levels_.resize(wanted);
  if (rows <= 0 || columns() <= 0) return;
  if (image.depth() == CV_8U) {
    pixelKernels().copyBytes(rowsOf<std::uint8_t>(image, box), rows, levels_.data(), columns());
  } else {
    pixelKernels().copyWords(rowsOf<std::uint16_t>(image, box), rows, levels_.data(), columns());
  }
}

void PatchSpans::takeRows(const SpotPatch& patch, const PixelEllipse& ellipse, int pieces) {
  const double half_height = ellipse.reach * ellipse.shape.stddev_v_px;
  const double centre = patch.fromImage(ellipse.centre_px).y();
  const double last = patch.box().last_row - patch.box().first_row;
  const int first_row = static_cast<int>(std::clamp(centre - half_height + 1.0, 0.0, last));
  const int end_row = static_cast<int>(std::clamp(centre + half_height + 1.0, 0.0, last));
  const int rows = end_row - first_row;
  const int room = (rows + kPixelLanes - 1) / kPixelLanes * kPixelLanes;
  const auto wanted = static_cast<std::size_t>(pieces * room);
  if (begin_.size() < wanted) {
    begin_.resize(wanted);
    end_.resize(wanted);
  }
  spans_ = {first_row, rows, room, pieces, begin_.data(), end_.data()};
}

const RowSpans& PatchSpans::ofEllipse(const SpotPatch& patch, const PixelEllipse& ellipse) {
  takeRows(patch, ellipse, 1);
  pixelKernels().cutChords(chordsOf(ellipse, patch), spans_.first_row, spans_.rows, patch.columns(),
                           begin_.data(), end_.data());
  return spans_;
}

const RowSpans& PatchSpans::ofRing(const SpotPatch& patch, const PixelEllipse& inner,
                                   const PixelEllipse& outer) {
  takeRows(patch, outer, 2);
  // Left of the inner ellipse and right of it: [outer begin, begin) and [end, outer end).
  int* inner_begin = end_.data();
  int* inner_end = begin_.data() + spans_.room;
  int* outer_begin = begin_.data();
  int* outer_end = end_.data() + spans_.room;
  const PixelKernels& kernels = pixelKernels();
  kernels.cutChords(chordsOf(inner, patch), spans_.first_row, spans_.rows, patch.columns(),
                    inner_begin, inner_end);
  kernels.cutChords(chordsOf(outer, patch), spans_.first_row, spans_.rows, patch.columns(),
                    outer_begin, outer_end);
  return spans_;
}

}  // namespace bearing_calibration
