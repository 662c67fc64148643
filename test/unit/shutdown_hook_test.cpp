#include "bearing_calibration_ros/shutdown_hook.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <thread>

namespace bearing_calibration_ros {
namespace {

/// What a child process ends with; it is killed by the test's own deadline when it hangs.
int statusOfChild(int (*work)()) {
  const pid_t child = ::fork();
  if (child == 0) {
    ::alarm(20);
    ::_exit(work());
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  return status;
}

// A signal may come between a system call and the look at its errno.
TEST(ShutdownHook, TheHandlerLeavesErrnoAlone) {
  const int status = statusOfChild([] {
    const ShutdownHook words([] {});
    constexpr int kMostDescriptors = 256;
    for (int i = 3; i < kMostDescriptors; ++i) ::close(i);  // the handler's write will fail
    errno = 0;
    ::raise(SIGTERM);
    return errno;
  });
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

// A terminal or a connection that is closed ends the process, but not one under nohup.
TEST(ShutdownHook, SpeaksBeforeAHangUpEndsTheProcess) {
  static int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  const int status = statusOfChild([] {
    const ShutdownHook words([] {
      if (::write(ends[1], "!", 1) != 1) ::_exit(1);
    });
    ::raise(SIGHUP);
    while (true) ::pause();
    return 0;
  });
  ::close(ends[1]);
  char said = 0;
  EXPECT_EQ(::read(ends[0], &said, 1), 1) << "it was ended at once";
  ::close(ends[0]);
  ASSERT_TRUE(WIFSIGNALED(status));
  EXPECT_EQ(WTERMSIG(status), SIGHUP);
}
TEST(ShutdownHook, AHangUpThatIsIgnoredStaysSo) {
  const int status = statusOfChild([] {
    ::signal(SIGHUP, SIG_IGN);
    const ShutdownHook words([] { ::_exit(1); });
    ::raise(SIGHUP);
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    return 0;
  });
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

// A robot is stopped while a file is being written.
TEST(ShutdownHook, NoneWaitsForAnother) {
  static std::atomic<int> speaking{0};
  static std::atomic<bool> have_met{false};
  const int status = statusOfChild([] {
    const auto meet = [] {
      ++speaking;
      constexpr int kTries = 500;
      for (int i = 0; i < kTries && speaking < 2; ++i) {
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
      }
      have_met = speaking == 2;
      if (!have_met) ::_exit(1);
    };
    const ShutdownHook first(meet), second(meet);
    ::raise(SIGTERM);
    while (true) ::pause();
    return 0;
  });
  ASSERT_TRUE(WIFSIGNALED(status)) << "one waited for the other";
  EXPECT_EQ(WTERMSIG(status), SIGTERM);
}

}  // namespace
}  // namespace bearing_calibration_ros
