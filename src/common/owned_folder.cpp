#include "bearing_calibration/common/owned_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <fstream>
#include <sstream>
#include <system_error>
#include <thread>

namespace bearing_calibration::core {
namespace {

namespace fs = std::filesystem;

constexpr char kList[] = ".bearing_calibration";  ///< names of the owned files, the first one first
constexpr char kStays = '+';                      ///< before a name there: the file stays
constexpr char kUnready[] = ".saving";            ///< files that are being written
constexpr char kReady[] = ".saved";               ///< whole: to be emptied into its parent
constexpr char kSubfolder[] = "bearing_calibration";

[[noreturn]] void throwSystemError(const std::string& what) {
  throw std::system_error(errno, std::generic_category(), what);
}

class Descriptor {
 public:
  Descriptor(const fs::path& path, int flags)
      : number_(::open(path.c_str(), flags | O_CLOEXEC, 0644)) {
    if (number_ < 0) throwSystemError("cannot open " + path.string());
  }
  ~Descriptor() { ::close(number_); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return number_; }

 private:
  int number_;
};

/// Returns when the text is on the disk.
void writeFile(const fs::path& path, const std::string& text) {
  const Descriptor file(path, O_WRONLY | O_CREAT | O_EXCL);
  std::size_t written = 0;
  while (written < text.size()) {
    const ssize_t count = ::write(file.get(), text.data() + written, text.size() - written);
    if (count < 0 && errno != EINTR) throwSystemError("cannot write " + path.string());
    if (count > 0) written += static_cast<std::size_t>(count);
  }
  if (::fsync(file.get()) != 0) throwSystemError("cannot write " + path.string());
}

/// New names are on the disk only when their folder is. Not every file system can.
void synchronise(const fs::path& folder) { ::fsync(Descriptor(folder, O_RDONLY).get()); }

std::string textOf(const fs::path& path) {
  std::ostringstream text;
  const std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error("cannot read " + path.string());
  text << file.rdbuf();
  return text.str();
}

/// The files that a folder owns, without their texts; none where it is not an owned one.
std::vector<FileText> listIn(const fs::path& folder) {
  std::vector<FileText> files;
  std::ifstream list(folder / kList);
  for (std::string name; std::getline(list, name);) {
    const bool stays = !name.empty() && name.front() == kStays;
    if (stays) name.erase(0, 1);
    const bool is_outside = name.empty() || name.front() == '.' || name.find('/') != name.npos;
    if (!is_outside) files.push_back({name, "", stays});
  }
  return files;
}

auto isNamed(const std::string& name) {
  return [&name](const FileText& file) { return file.name == name; };
}

bool isOwned(const fs::path& folder) {
  return fs::exists(folder / kList) || fs::exists(folder / kReady);
}

/// What a killed writer left in a folder does not count.
bool isEmpty(const fs::path& folder) {
  return std::all_of(fs::directory_iterator(folder), {},
                     [](const auto& entry) { return entry.path().filename() == kUnready; });
}

/// Empties what is ready into the folder; can be broken off and begun again anywhere. What it
/// replaces goes first, so that files of two results never lie side by side; but the first new file
/// replaces the old one of its name at a stroke.
void takeOverReady(const fs::path& folder) {
  const fs::path ready = folder / kReady;
  if (fs::exists(ready / kList)) {
    const std::string first = listIn(ready).empty() ? "" : listIn(ready).front().name;
    for (const FileText& file : listIn(folder)) {
      if (file.name != first) fs::remove(folder / file.name);
    }
    fs::rename(ready / kList, folder / kList);
  }
  for (const FileText& file : listIn(folder)) {
    if (fs::exists(ready / file.name)) fs::rename(ready / file.name, folder / file.name);
  }
  fs::remove(ready);
  synchronise(folder);
}

/// Makes files ready in a hidden folder, with the list that names them.
fs::path prepare(const fs::path& folder, const std::vector<FileText>& files) {
  const fs::path unready = folder / kUnready;
  fs::remove_all(unready);
  fs::create_directory(unready);
  std::string list;
  for (const FileText& file : files) {
    writeFile(unready / file.name, file.text);
    list += (file.stays ? std::string(1, kStays) : "") + file.name + "\n";
  }
  writeFile(unready / kList, list);
  synchronise(unready);
  return unready;
}

/// Locked for as long as it lives. Where the file system knows no locks there is none.
std::shared_ptr<const void> lock(const fs::path& folder) {
  constexpr int kTries = 300;
  constexpr std::chrono::milliseconds kPause{10};
  auto descriptor = std::make_shared<const Descriptor>(folder, O_RDONLY | O_DIRECTORY);
  for (int i = 0; ::flock(descriptor->get(), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK; ++i) {
    if (i == kTries) throw std::runtime_error("another program writes in " + folder.string());
    std::this_thread::sleep_for(kPause);
  }
  return descriptor;
}

int highestNumberIn(const fs::path& folder) {
  constexpr std::size_t kMostDigits = 6;  // longer ones are a date or the like
  int highest = 0;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename();
    const bool is_number =
        name.size() <= kMostDigits && name.find_first_not_of("0123456789") == std::string::npos;
    if (is_number) highest = std::max(highest, std::stoi(name));
  }
  return highest;
}

}  // namespace

std::string OwnedFolder::find(const std::string& wanted) {
  const fs::path folder = (fs::absolute(wanted) / "").lexically_normal().parent_path();
  fs::path candidate = folder;
  for (int i = 1; fs::is_directory(candidate) && !isOwned(candidate) && !isEmpty(candidate); ++i) {
    candidate = folder / (i == 1 ? kSubfolder : kSubfolder + ("_" + std::to_string(i)));
  }
  return candidate;
}

OwnedFolder::OwnedFolder(const std::string& wanted) : path_(find(wanted)) {
  std::error_code error;
  fs::create_directories(path_, error);
  if (error) throw std::runtime_error(path() + " cannot be made: " + error.message());
  lock_ = lock(path_);
  fs::remove_all(path_ / kUnready);
  if (fs::exists(path_ / kReady)) takeOverReady(path_);
}

bool OwnedFolder::owns(const std::string& name) const {
  const std::vector<FileText> files = listIn(path_);
  return std::any_of(files.begin(), files.end(), isNamed(name)) && fs::exists(path_ / name);
}

void OwnedFolder::tryToWrite() {
  try {
    fs::remove_all(prepare(path_, {}));
  } catch (const std::system_error& error) {
    throw std::runtime_error(path() + " cannot be written to: " + error.code().message());
  }
}

std::string OwnedFolder::replace(std::vector<FileText> files) {
  for (const FileText& file : files) {
    if (fs::exists(path_ / file.name) && !owns(file.name)) return writeNumbered(files);
  }
  for (const FileText& old : ownedFiles()) {
    if (old.stays && std::none_of(files.begin(), files.end(), isNamed(old.name))) {
      files.push_back(old);
    }
  }
  fs::rename(prepare(path_, files), path_ / kReady);
  synchronise(path_);
  takeOverReady(path_);
  return path();
}

std::string OwnedFolder::add(const FileText& file) {
  std::vector<FileText> files = ownedFiles();
  const auto same = std::find_if(files.begin(), files.end(), isNamed(file.name));
  if (same == files.end()) {
    files.push_back(file);
  } else {
    *same = file;
  }
  return replace(files);
}

void OwnedFolder::claim() {
  if (!isOwned(path_)) replace({});
}

std::string OwnedFolder::writeNumbered(const std::vector<FileText>& files) {
  const fs::path numbered = path_ / std::to_string(highestNumberIn(path_) + 1);
  fs::rename(prepare(path_, files), numbered);
  synchronise(path_);
  return numbered;
}

std::vector<FileText> OwnedFolder::ownedFiles() const {
  std::vector<FileText> files;
  for (const FileText& file : listIn(path_)) {
    if (owns(file.name)) files.push_back({file.name, textOf(path_ / file.name), file.stays});
  }
  return files;
}

}  // namespace bearing_calibration::core
