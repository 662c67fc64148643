#include "bearing_calibration/common/atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <system_error>

namespace bearing_calibration {
namespace {

constexpr mode_t kReadableByAll = 0644;  // mkstemp makes a file that its owner alone can read

std::string lastSystemError() { return std::generic_category().message(errno); }

/// A new file beside its later place; removed again unless it is renamed.
class TemporaryFile {
 public:
  explicit TemporaryFile(const std::string& path) : path_(path + ".XXXXXX") {
    descriptor_ = ::mkstemp(path_.data());
  }
  ~TemporaryFile() {
    if (descriptor_ < 0) return;
    ::close(descriptor_);
    if (!renamed_) ::unlink(path_.c_str());
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;

  bool isOpen() const { return descriptor_ >= 0; }

  bool write(const std::string& text) {
    std::size_t written = 0;
    while (written < text.size()) {
      const ssize_t count = ::write(descriptor_, text.data() + written, text.size() - written);
      if (count < 0 && errno != EINTR) return false;
      if (count > 0) written += static_cast<std::size_t>(count);
    }
    return ::fchmod(descriptor_, kReadableByAll) == 0 && ::fsync(descriptor_) == 0;
  }

  bool renameTo(const std::string& path) {
    renamed_ = ::rename(path_.c_str(), path.c_str()) == 0;
    return renamed_;
  }

 private:
  std::string path_;
  int descriptor_ = -1;
  bool renamed_ = false;
};

/// The new name is on the disk only when the folder is.
void synchroniseFolder(const std::filesystem::path& folder) {
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY);
  if (descriptor < 0) return;
  ::fsync(descriptor);  // not every file system can; the file itself is whole all the same
  ::close(descriptor);
}

}  // namespace

std::optional<std::string> writeFileAtomically(const std::string& path, const std::string& text) {
  const std::filesystem::path folder = std::filesystem::absolute(path).parent_path();
  std::error_code folder_error;
  std::filesystem::create_directories(folder, folder_error);
  if (folder_error) return "cannot make folder " + folder.string() + ": " + folder_error.message();

  TemporaryFile file(path);
  if (!file.isOpen()) return "cannot write in folder " + folder.string() + ": " + lastSystemError();
  if (!file.write(text)) return "cannot write " + path + ": " + lastSystemError();
  if (!file.renameTo(path)) return "cannot replace " + path + ": " + lastSystemError();
  synchroniseFolder(folder);
  return std::nullopt;
}

}  // namespace bearing_calibration
