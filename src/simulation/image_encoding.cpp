#include "bearing_calibration/simulation/image_encoding.h"

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "bearing_calibration/common/parameters.h"

namespace bearing_calibration::core {
namespace {

using Layout = ImageEncoding::Layout;

/// Colours of the mosaic's first two rows: r, g or b of pixels (0, 0), (1, 0), (0, 1), (1, 1).
const char* mosaicOf(Layout layout) {
  switch (layout) {
    case Layout::kBayerBggr8:
      return "bggr";
    case Layout::kBayerGbrg8:
      return "gbrg";
    case Layout::kBayerGrbg8:
      return "grbg";
    case Layout::kBayerRggb8:
    case Layout::kBgr8:
      return "rggb";
    case Layout::kMono8:
      break;
  }
  return nullptr;
}

bool isMosaic(Layout layout) { return layout != Layout::kMono8 && layout != Layout::kBgr8; }

cv::Mat throughJpeg(const cv::Mat& image, int quality) {
  std::vector<std::uint8_t> file;
  cv::imencode(".jpg", image, file, {cv::IMWRITE_JPEG_QUALITY, quality});
  return cv::imdecode(file, cv::IMREAD_UNCHANGED);
}

}  // namespace

void ImageEncoding::declare(Parameters& params) {
  constexpr int kBestQuality = 100;
  constexpr double kLargestResponse = 2.0;  // green is the most sensitive in every known sensor
  params.choice("camera/encoding", layoutNames(), layout);
  params.integer("camera/jpeg_quality", jpeg_quality, 0, kBestQuality);
  params.that(jpeg_quality == 0 || !isMosaic(layout),
              "camera/jpeg_quality must be 0 for a mosaic in camera/encoding: JPEG destroys it");
  params.number("camera/red_response", red_response, 0.0, kLargestResponse);
  params.number("camera/blue_response", blue_response, 0.0, kLargestResponse);
}

double ImageEncoding::responseAt(int column, int row) const {
  const char* mosaic = mosaicOf(layout);
  if (mosaic == nullptr) return 1.0;
  const char colour = mosaic[2 * (row % 2) + column % 2];
  if (colour == 'r') return red_response;
  return colour == 'b' ? blue_response : 1.0;
}

const std::vector<std::string>& layoutNames() {
  static const std::vector<std::string> names = {"mono8",       "bayer_rggb8", "bayer_bggr8",
                                                 "bayer_gbrg8", "bayer_grbg8", "bgr8"};
  return names;
}

cv::Mat encode(const MonoImage& image, const ImageEncoding& encoding) {
  cv::Mat encoded(image.height_px, image.width_px, CV_8UC1);
  std::copy(image.values.begin(), image.values.end(), encoded.begin<std::uint8_t>());
  if (encoding.layout == Layout::kBgr8) {
    // OpenCV names a mosaic after the second row's second and third pixel.
    cv::Mat colour;
    cv::cvtColor(encoded, colour, cv::COLOR_BayerBG2BGR);
    encoded = colour;
  }
  return encoding.jpeg_quality > 0 ? throughJpeg(encoded, encoding.jpeg_quality) : encoded;
}

}  // namespace bearing_calibration::core
