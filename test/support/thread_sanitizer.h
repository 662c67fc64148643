// Included before all else where the compiler's thread sanitizer is on (scripts/sanitize): GCC 12's
// does not know pthread_mutex_clocklock, by which std::timed_mutex waits, and would take all that
// such a mutex guards for unguarded.
#pragma once
#include <bits/c++config.h>
#undef _GLIBCXX_USE_PTHREAD_MUTEX_CLOCKLOCK
