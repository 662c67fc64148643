#include "bearing_calibration_ros/shutdown_hook.h"

#include <ros/console.h>
#include <ros/init.h>
#include <signal.h>
#include <sys/types.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstddef>
#include <cstdio>
#include <mutex>
#include <set>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

namespace bearing_calibration_ros {
namespace {

constexpr std::array<int, 3> kSignals = {SIGINT, SIGTERM, SIGHUP};
constexpr unsigned char kNoSignal = 0;
constexpr std::chrono::milliseconds kDelivery{100};  // of the last message, by ROS' own threads

/// Where the handler writes to: a pipe is what may be used in one.
std::atomic<int> pipe_end{-1};

void handleSignal(int number) {
  const int errno_before = errno;  // of whatever was interrupted
  const auto byte = static_cast<unsigned char>(number);
  const ssize_t written = write(pipe_end.load(), &byte, 1);
  static_cast<void>(written);  // nothing can be done here
  errno = errno_before;
}

}  // namespace

/// What all instances of a process share: the handlers, and the thread that waits for a signal.
class ShutdownHook::Listener {
 public:
  static std::shared_ptr<Listener> shared() {
    static std::mutex mutex;
    static std::weak_ptr<Listener> existing;
    const std::lock_guard<std::mutex> lock(mutex);
    std::shared_ptr<Listener> listener = existing.lock();
    if (!listener) existing = listener = std::make_shared<Listener>();
    return listener;
  }

  Listener() {
    if (pipe(pipe_.data()) != 0) throw std::runtime_error("no pipe for the signals");
    pipe_end = pipe_[1];
    struct sigaction ours {};
    ours.sa_handler = handleSignal;
    ours.sa_flags = SA_RESTART;
    for (std::size_t i = 0; i < kSignals.size(); ++i) {
      sigaction(kSignals[i], &ours, &before_[i]);
      const bool is_nohup = kSignals[i] == SIGHUP && before_[i].sa_handler == SIG_IGN;
      if (is_nohup) sigaction(SIGHUP, &before_[i], nullptr);
    }
    thread_ = std::thread([this] { listen(); });
  }
  ~Listener() {
    restore();
    const ssize_t written = write(pipe_[1], &kNoSignal, 1);
    static_cast<void>(written);
    thread_.join();
    pipe_end = -1;
    for (const int end : pipe_) close(end);
  }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  void add(ShutdownHook* words) {
    const std::lock_guard<std::mutex> lock(mutex_);
    all_.insert(words);
  }
  void remove(ShutdownHook* words) {
    const std::lock_guard<std::mutex> lock(mutex_);  // not while they speak
    all_.erase(words);
  }

 private:
  void listen() {
    unsigned char number = kNoSignal;
    if (read(pipe_[0], &number, 1) != 1 || number == kNoSignal) return;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      std::vector<std::thread> speakers;  // a robot does not wait for a file
      for (ShutdownHook* words : all_) speakers.emplace_back(words->speak_);
      for (std::thread& speaker : speakers) speaker.join();
    }
    std::this_thread::sleep_for(kDelivery);
    restore();
    kill(getpid(), number);
  }

  void restore() {
    for (std::size_t i = 0; i < kSignals.size(); ++i) {
      struct sigaction now {};
      sigaction(kSignals[i], nullptr, &now);
      if (now.sa_handler == handleSignal) sigaction(kSignals[i], &before_[i], nullptr);
    }
  }

  std::array<int, 2> pipe_{};
  std::array<struct sigaction, kSignals.size()> before_{};
  std::mutex mutex_;
  std::set<ShutdownHook*> all_;
  std::thread thread_;  ///< last: it uses the others
};

ShutdownHook::ShutdownHook(std::function<void()> speak)
    : listener_(Listener::shared()), speak_(std::move(speak)) {
  listener_->add(this);
}

ShutdownHook::~ShutdownHook() { listener_->remove(this); }

void sayAtTheEnd(const std::string& name, bool success, const std::string& text) {
  if (!ros::ok()) {
    std::fprintf(stderr, "%s: %s\n", name.c_str(), text.c_str());
  } else if (success) {
    ROS_INFO_NAMED(name, "%s", text.c_str());
    std::fflush(stdout);
  } else {
    ROS_WARN_NAMED(name, "%s", text.c_str());
  }
}

}  // namespace bearing_calibration_ros
