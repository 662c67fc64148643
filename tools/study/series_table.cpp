// Accuracy of a bearing in each condition of camera and light, on ray-traced images of a light at
// 0.5 to 5 m:
//
//     series_table [IMAGES PER ROW]

#include <cstdio>
#include <cstdlib>

#include "support/rendered_series.h"

int main(int argc, char** argv) {
  using namespace bearing_calibration::core;
  constexpr int kDefaultImages = 300;
  constexpr unsigned kSeed = 51;
  const int images = argc > 1 ? std::atoi(argv[1]) : kDefaultImages;
  if (images < 1) {
    std::fprintf(stderr, "usage: series_table [IMAGES PER ROW > 0]\n");
    return EXIT_FAILURE;
  }
  std::printf("| series | found %% | RMSE [deg] | bias [deg] | NEES |\n|---|---|---|---|---|\n");
  for (const test::RenderedSeries& series : test::renderedSeries()) {
    const test::BearingErrors errors = test::errorsOf(series, images, kSeed);
    std::printf("| %s | %.1f | %.4f | %.4f | %.2f |\n", series.name.c_str(),
                100.0 * errors.found / images, errors.rmse_deg(), errors.bias_deg(), errors.nees());
    std::fflush(stdout);
  }
  return EXIT_SUCCESS;
}
