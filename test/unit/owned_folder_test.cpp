#include "bearing_calibration/common/owned_folder.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <memory>
#include <random>
#include <set>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "support/temporary_folder.h"

namespace bearing_calibration::core {
namespace {

namespace fs = std::filesystem;

/// A folder for each test, removed at the end.
class OwnedFolderTest : public testing::Test {
 protected:
  static std::string textOf(const fs::path& path) {
    std::ostringstream text;
    text << std::ifstream(path).rdbuf();
    return text.str();
  }
  static void write(const fs::path& path, const std::string& text) {
    fs::create_directories(path.parent_path());
    std::ofstream(path) << text;
  }
  /// Names in a folder, but for the list of what is owned.
  static std::set<std::string> namesIn(const fs::path& folder) {
    std::set<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder)) names.insert(entry.path().filename());
    names.erase(".bearing_calibration");
    return names;
  }

  using Names = std::set<std::string>;
  const TemporaryFolder own_;
  const fs::path top_ = own_.path();
  const fs::path out_ = top_ / "out";
};

TEST_F(OwnedFolderTest, MakesItWithWhatIsAboveIt) {
  const fs::path deep = top_ / "a" / "b";
  EXPECT_EQ(OwnedFolder(deep).replace({{"r", "1"}, {"f", "2"}}), deep);
  EXPECT_EQ(namesIn(deep), (Names{"f", "r"}));
  EXPECT_EQ(textOf(deep / "f"), "2");
}

TEST_F(OwnedFolderTest, IsTheSameOneWithASlashAtItsEnd) {
  EXPECT_EQ(OwnedFolder::find(out_.string() + "/"), out_);
  EXPECT_EQ(OwnedFolder::find((top_ / "x" / ".." / "out").string()), out_);
}

TEST_F(OwnedFolderTest, AnEmptyFolderIsTaken) {
  fs::create_directory(out_);
  EXPECT_EQ(OwnedFolder::find(out_), out_);
}

TEST_F(OwnedFolderTest, ReplacesItsOwnAndRemovesWhatIsNoMore) {
  OwnedFolder(out_).replace({{"r", "old"}, {"a", "old"}, {"b", "old"}});
  OwnedFolder(out_).replace({{"r", "new"}, {"b", "new"}});
  EXPECT_EQ(namesIn(out_), (Names{"b", "r"}));
  EXPECT_EQ(textOf(out_ / "r") + textOf(out_ / "b"), "newnew");
}

// Promise inside: a folder with somebody else's files
TEST_F(OwnedFolderTest, BesideOthersFilesItIsASubfolder) {
  write(out_ / "r", "mine");
  write(out_ / "f", "mine, too");
  EXPECT_EQ(OwnedFolder(out_).replace({{"r", "1"}}), out_ / "bearing_calibration");
  EXPECT_EQ(OwnedFolder(out_).replace({{"r", "2"}, {"f", "2"}}), out_ / "bearing_calibration");
  EXPECT_EQ(namesIn(out_), (Names{"bearing_calibration", "f", "r"}));
  EXPECT_EQ(textOf(out_ / "r") + textOf(out_ / "f"), "minemine, too");
}

TEST_F(OwnedFolderTest, ASubfolderOfThatNameIsNobodyElses) {
  write(out_ / "bearing_calibration" / "package.xml", "the sources");
  EXPECT_EQ(OwnedFolder::find(out_), out_ / "bearing_calibration_2");
}

// Somebody has put a file of a name of ours into our folder.
// Promise inside: a file of the same name that somebody else wrote
TEST_F(OwnedFolderTest, OverwritesNothingThatItDidNotWrite) {
  OwnedFolder(out_).replace({{"r", "1"}});
  write(out_ / "f", "mine");
  EXPECT_EQ(OwnedFolder(out_).replace({{"r", "2"}, {"f", "2"}}), out_ / "1");
  EXPECT_EQ(textOf(out_ / "f"), "mine");
  EXPECT_EQ(textOf(out_ / "r"), "1");
  EXPECT_EQ(textOf(out_ / "1" / "f"), "2");
  OwnedFolder(out_).replace({{"r", "3"}});
  EXPECT_EQ(textOf(out_ / "f"), "mine");
}

TEST_F(OwnedFolderTest, NumbersGoOnFromTheHighest) {
  OwnedFolder folder(out_);
  folder.replace({{"r", "1"}, {"f", "2"}});
  fs::create_directory(out_ / "7");
  fs::create_directory(out_ / "20261231");  // a date
  EXPECT_EQ(folder.copyNumbered(), out_ / "8");
  EXPECT_EQ(folder.writeNumbered({{"r", "3"}}), out_ / "9");
  EXPECT_EQ(namesIn(out_ / "8"), (Names{"f", "r"}));
  EXPECT_EQ(OwnedFolder::find(out_ / "8"), out_ / "8") << "a numbered one is owned, too";
}

TEST_F(OwnedFolderTest, AddsAFileToTheOthers) {
  OwnedFolder(out_).claim();
  fs::create_directory(out_ / "drive");
  EXPECT_EQ(OwnedFolder(out_).add({"c", "1"}), out_);
  OwnedFolder(out_).add({"d", "1"});
  OwnedFolder(out_).add({"c", "2"});
  EXPECT_EQ(namesIn(out_), (Names{"c", "d", "drive"}));
  EXPECT_EQ(textOf(out_ / "c"), "2");
}

TEST_F(OwnedFolderTest, KeepsWhatStaysWhereOthersAreReplaced) {
  OwnedFolder(out_).add({"stays", "1", true});
  OwnedFolder(out_).replace({{"r", "1"}, {"f", "1"}});
  OwnedFolder(out_).add({"c", "1"});
  OwnedFolder(out_).add({"stays", "2", true});
  OwnedFolder(out_).replace({{"r", "2"}});
  EXPECT_EQ(namesIn(out_), (Names{"r", "stays"}));
  EXPECT_EQ(textOf(out_ / "stays"), "2");
  OwnedFolder(out_).replace({{"r", "3"}, {"stays", "3"}});
  OwnedFolder(out_).replace({{"r", "4"}});
  EXPECT_EQ(namesIn(out_), (Names{"r"})) << "who writes it anew says whether it stays";
}

// Promise inside: a list of files that names some outside of the folder
TEST_F(OwnedFolderTest, NeverRemovesAnythingOutside) {
  OwnedFolder(out_).replace({{"r", "1"}});
  write(top_ / "precious", "mine");
  std::ofstream(out_ / ".bearing_calibration", std::ios::app) << "../precious\n..\n.\n";
  OwnedFolder(out_).replace({{"r", "2"}});
  EXPECT_EQ(textOf(top_ / "precious"), "mine");
  EXPECT_EQ(textOf(out_ / "r"), "2");
}

// Root may write anywhere, so the folder is one that cannot exist: below a file.
TEST_F(OwnedFolderTest, SaysWhyItCannotBeMade) {
  write(out_, "a file, not a folder");
  try {
    OwnedFolder folder(out_ / "below");
    FAIL() << "it was made";
  } catch (const std::exception& error) {
    EXPECT_NE(std::string(error.what()).find("Not a directory"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find(out_), std::string::npos) << error.what();
  }
}

// Promise kept: two programs that write the same folder
TEST_F(OwnedFolderTest, WaitsForAnotherWriter) {
  auto first = std::make_unique<OwnedFolder>(out_);
  std::thread later([&] { OwnedFolder(out_).replace({{"r", "second"}}); });
  first->replace({{"r", "first"}, {"f", "first"}});
  first.reset();
  later.join();
  EXPECT_EQ(namesIn(out_), (Names{"r"}));
}

// A reader that opened the old file reads it to its end, even when it is replaced meanwhile.
TEST_F(OwnedFolderTest, ReplacesInsteadOfOverwriting) {
  OwnedFolder(out_).replace({{"r", "old"}});
  std::ifstream reader(out_ / "r");
  OwnedFolder(out_).replace({{"r", "new"}});
  std::string seen;
  reader >> seen;
  EXPECT_EQ(seen, "old");
}

/// Writes one set of files after another, each of one letter, until it is killed.
[[noreturn]] void writeForEver(const fs::path& folder) {
  constexpr std::size_t kSize = 20000;  // more than one block
  for (char letter = 'a';; letter = letter == 'z' ? 'a' : static_cast<char>(letter + 1)) {
    std::vector<FileText> files{{"r", std::string(kSize, letter)}};
    for (const char* name : {"f", "g", "h"}) files.push_back({name, std::string(kSize, letter)});
    if (letter % 2 == 0) files.push_back({"only_even", std::string(kSize, letter)});
    OwnedFolder(folder).replace(files);
  }
}

// Killed at any moment: the first file is there and whole, and beside it lie none but its own. What
// was left behind is gone when the folder is opened again.
// Promise kept: a kill at any moment of writing
TEST_F(OwnedFolderTest, SurvivesAKillAtAnyMoment) {
  constexpr int kKills = 200;
  std::mt19937 random(1);
  std::uniform_int_distribution<int> delay_us(0, 20000);
  OwnedFolder(out_).replace({{"r", "start"}});
  Names sets;  // of files that were met
  for (int i = 0; i < kKills; ++i) {
    const pid_t writer = ::fork();
    if (writer == 0) writeForEver(out_);
    std::this_thread::sleep_for(std::chrono::microseconds(delay_us(random)));
    ::kill(writer, SIGKILL);
    ::waitpid(writer, nullptr, 0);

    const std::string first = textOf(out_ / "r");
    ASSERT_FALSE(first.empty());
    std::string met;
    for (const std::string& name : namesIn(out_)) {
      met += name + " ";
      if (name.front() == '.') continue;
      ASSERT_EQ(textOf(out_ / name), first) << name << " is not of r, kill " << i;
    }
    sets.insert(met);
    OwnedFolder(out_).tryToWrite();
    for (const std::string& name : namesIn(out_)) ASSERT_NE(name.front(), '.') << name;
    if (first != "start") {
      EXPECT_TRUE(fs::exists(out_ / "h"));
      EXPECT_EQ(fs::exists(out_ / "only_even"), textOf(out_ / "r").front() % 2 == 0);
    }
  }
  EXPECT_GT(sets.size(), 2U) << "the kills hit nothing that was under way";
}

}  // namespace
}  // namespace bearing_calibration::core
