#include "bearing_calibration/vision/pixel_kernels.h"

namespace bearing_calibration::core {

extern const PixelKernels kKernelsForAll;
#ifdef __x86_64__
extern const PixelKernels kKernelsForAvx2;
#endif

namespace {

const PixelKernels& fastestKernels() {
#ifdef __x86_64__
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return kKernelsForAvx2;
#endif
  return kKernelsForAll;
}

}  // namespace

const PixelKernels& pixelKernels() {
  static const PixelKernels& kernels = fastestKernels();
  return kernels;
}

const PixelKernels& portablePixelKernels() { return kKernelsForAll; }

}  // namespace bearing_calibration::core
