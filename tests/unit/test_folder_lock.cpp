// Who may write in a folder, and who may look.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <thread>

#include "support/error.hpp"
#include "support/folder_lock.hpp"

using namespace dovetail;

namespace {

// A folder of this process with a lock file, as a killed run leaves it.
class Folder : public ::testing::Test {
protected:
  void SetUp() override {
    std::filesystem::create_directories(path_);
    std::ofstream(file_) << "process 1 on nowhere, since 2000-01-01 00:00:00";
  }
  void TearDown() override { std::filesystem::remove_all(path_); }

  // Another open file description, as another process would have it.
  int locked(int kind) const {
    const int descriptor = open(file_.c_str(), O_RDWR | O_CLOEXEC);
    EXPECT_EQ(flock(descriptor, kind | LOCK_NB), 0);
    return descriptor;
  }

  const std::filesystem::path path_ =
      std::filesystem::temp_directory_path() / ("dovetail_lock_" + std::to_string(getpid()));
  const std::filesystem::path file_ = path_ / "dovetail.lock";
};

} // namespace

TEST_F(Folder, that_nobody_holds_is_taken_and_freed) {
  EXPECT_NO_THROW(FolderLock::refuse_held(path_, "wait"));
  {
    const FolderLock mine(path_, "wait");
    EXPECT_THROW(FolderLock::refuse_held(path_, "wait"), InputError);
    EXPECT_THROW(FolderLock(path_, "wait"), InputError);
  }
  EXPECT_FALSE(std::filesystem::exists(file_));
  EXPECT_NO_THROW(FolderLock::refuse_held(path_, "wait"));
}

TEST_F(Folder, shows_other_ranks_what_its_holder_has_written) {
  FolderLock mine(path_, "wait");
  EXPECT_FALSE(mine.published().empty());
  EXPECT_TRUE(FolderLock::sees(path_, mine.published()));
}

TEST_F(Folder, is_looked_at_by_several_ranks_at_once) {
  const int other = locked(LOCK_SH);
  EXPECT_NO_THROW(FolderLock::refuse_held(path_, "wait"));
  close(other);
}

TEST_F(Folder, that_another_only_looks_at_is_taken_when_he_has_looked) {
  const int other = locked(LOCK_SH);
  std::thread looks([other] {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    close(other);
  });
  EXPECT_NO_THROW(FolderLock(path_, "wait"));
  looks.join();
}

TEST_F(Folder, that_another_holds_is_refused_with_his_name) {
  const int other = locked(LOCK_EX);
  try {
    FolderLock::refuse_held(path_, "wait");
    ADD_FAILURE() << "not refused";
  } catch (const InputError &error) {
    EXPECT_NE(std::string(error.what()).find("process 1 on nowhere"), std::string::npos) << error.what();
  }
  close(other);
}
