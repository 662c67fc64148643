#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace bearing_calibration::core {

/// A file to be written.
struct FileText {
  std::string name;  ///< in its folder
  std::string text;
  bool stays = false;  ///< with what replaces the other files of the folder
};

/// A folder in which this package replaces and removes what it has written itself, and nothing
/// else: a hidden list in it names the files that are its own.
///
/// The files of one result are written as one. They are made ready in a hidden folder beside them,
/// which is then renamed and emptied into its place. Whoever reads, at any moment and after any
/// crash, finds the first of the files whole, that of before or the new one, and beside it none but
/// its own. What a killed writer has begun is ended or removed when the folder is opened next.
///
/// An open folder is locked against other programs and threads. All functions throw
/// std::runtime_error, with a path in it, for what the file system refuses.
class OwnedFolder {
 public:
  /// The folder that `wanted` stands for: itself where it does not exist, is empty or is owned;
  /// otherwise the first such of wanted/bearing_calibration, wanted/bearing_calibration_2, ...
  static std::string find(const std::string& wanted);

  /// Opens find(wanted), which is made when it is missing. Waits for another program that writes
  /// there, for some seconds at most.
  explicit OwnedFolder(const std::string& wanted);

  const std::string& path() const { return path_.native(); }
  bool owns(const std::string& name) const;

  /// Throws when nothing can be written.
  void tryToWrite();
  /// Writes files in the place of all that are owned but those that stay. Where one of them would
  /// overwrite a file that is not owned, all go into a numbered folder instead. The first one is
  /// what the others go with.
  /// @returns the folder that they lie in
  std::string replace(std::vector<FileText> files);
  /// Writes one file more, in the place of an owned one of its name; the other files stay.
  /// @returns the folder that it lies in, as replace()
  std::string add(const FileText& file);
  /// Makes the folder an owned one before there is a file in it.
  void claim();
  /// Writes files into a folder of their own below this one: 1, or one more than the highest there.
  /// @returns that folder
  std::string writeNumbered(const std::vector<FileText>& files);
  /// Copies the owned files into a numbered folder. @returns that folder
  std::string copyNumbered() { return writeNumbered(ownedFiles()); }

 private:
  std::vector<FileText> ownedFiles() const;

  std::filesystem::path path_;
  std::shared_ptr<const void> lock_;
};

}  // namespace bearing_calibration::core
