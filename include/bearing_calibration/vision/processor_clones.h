#pragma once

/// Before a function whose loops are most of a detection's time: it is compiled for several
/// processors, and the best one is chosen when the library is loaded. Sanitizers and clang do
/// without.
#if defined(__x86_64__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
#define BEARING_CALIBRATION_CLONES __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define BEARING_CALIBRATION_CLONES
#endif
