// Computes the figures of the paper as numbers in CSV files: paper_numbers FOLDER [RUNS [SECONDS]]
// (tools/paper/reproduce_paper.py draws them). The same for any number of cores.

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "bearing_calibration/common/angle.h"
#include "tools/common/command_line.h"
#include "tools/common/parallel.h"
#include "tools/paper/paper_figures.h"

namespace bearing_calibration::core {
namespace {

constexpr int kRuns = 200;

/// Where the files go, and how much is done.
class Output {
 public:
  explicit Output(std::string folder) : folder_(std::move(folder)) {}

  std::ofstream file(const std::string& name) const {
    std::ofstream out(folder_ + "/" + name + ".csv");
    out.exceptions(std::ios::failbit | std::ios::badbit);
    return out;
  }
  /// A line that is written over, a hundred times in all.
  static void progress(const std::string& what, int done, int all) {
    if (done < all && done % std::max(1, all / 100) != 0) return;
    std::fprintf(stderr, "\r%-20s %5d of %d ", what.c_str(), done, all);
    if (done == all) std::fputc('\n', stderr);
  }

 private:
  std::string folder_;
};

/// Runs with the seeds 1, 2, ... on all cores, added up in that order.
void writeRuns(const PaperFigure& figure, int runs, const Output& output) {
  std::vector<std::vector<PaperMoment>> moments(static_cast<std::size_t>(runs));
  std::atomic<int> done{0};
  const int cores = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  forEachInParallel(moments.size(), cores, [&](std::size_t i) {
    moments[i] =
        runPaperFilter(simulatedRun(figure, i + 1), figure.start, figure.stated_stddev_rad);
    Output::progress(figure.name, ++done, runs);
  });
  RunStatistics statistics;
  for (const std::vector<PaperMoment>& run : moments) statistics.add(run);
  std::ofstream out = output.file(figure.name + "_runs");
  statistics.write(out);
}

void writeFigure(const PaperFigure& figure, int runs, const Output& output) {
  std::ofstream out = output.file(figure.name + "_run");
  writeRun(figure, simulatedRun(figure, 1), out);
  writeRuns(figure, runs, output);
}

void writeExperiment(PaperFigure figure, int runs, const Output& output) {
  const int images = static_cast<int>(10.0 * figure.simulated.duration_s) + 1;  // at 10 Hz
  const CameraRun camera =
      renderedRun(figure, [images](int done) { Output::progress("fig5 images", done, images); });
  std::ofstream summary = output.file("fig5_camera");
  summary << "images,found,rms_error_deg,bias_deg\n"
          << camera.images << ',' << camera.found << ',' << degreesFromRadians(camera.rms_error_rad)
          << ',' << degreesFromRadians(camera.bias_rad) << '\n';
  std::ofstream out = output.file("fig5_run");
  writeRun(figure, camera.run, out);
  figure.simulated.robot.sensor.stddev_rad = camera.rms_error_rad;
  writeRuns(figure, runs, output);
  figure.name = "fig5_told";  // the same, the filter being told how good the bearings are
  figure.stated_stddev_rad = camera.rms_error_rad;
  writeRuns(figure, runs, output);
}

int run(int argc, char** argv) {
  const int runs = argc > 2 ? std::atoi(argv[2]) : kRuns;
  const double seconds = argc > 3 ? std::atof(argv[3]) : 0.0;
  if (argc < 2 || runs < 1 || seconds < 0.0) {
    std::fprintf(stderr,
                 "usage: paper_numbers FOLDER [RUNS [SECONDS]]\n"
                 "  RUNS     of each figure, %d without it\n"
                 "  SECONDS  at most of each run, for a quick look\n",
                 kRuns);
    return EXIT_FAILURE;
  }
  const Output output(argv[1]);
  const auto shortened = [seconds](PaperFigure figure) {
    double& duration_s = figure.simulated.duration_s;
    if (seconds > 0.0) duration_s = std::min(duration_s, seconds);
    return figure;
  };
  for (const PaperFigure& figure : simulatedFigures()) {
    writeFigure(shortened(figure), runs, output);
  }
  writeExperiment(shortened(experimentFigure()), runs, output);
  return EXIT_SUCCESS;
}

}  // namespace
}  // namespace bearing_calibration::core

int main(int argc, char** argv) {
  return bearing_calibration::core::runProgram(
      "paper_numbers", [&] { return bearing_calibration::core::run(argc, argv); });
}
