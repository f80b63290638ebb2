#pragma once
// One writer a folder.

#include <filesystem>
#include <string>
#include <string_view>

#include "base/whole_file.h"

namespace cloth::pipeline {

/// This computer's name.
std::string host_name();

/// The file that stands for the lock, in the folder.
inline constexpr std::string_view lock_name = "run.lock";

/// Keeps other programs from writing into a folder, for as long as this lives; the system takes it from a
/// program that dies. Throws Error(other): the folder is another's, naming its host and process, or nothing
/// can be written there.
class FolderLock {
  public:
    explicit FolderLock(const std::filesystem::path& folder);
    FolderLock(const FolderLock&) = delete;
    FolderLock& operator=(const FolderLock&) = delete;
    ~FolderLock();

  private:
    int file_ = -1;
    FileToRemove name_;
};

}  // namespace cloth::pipeline
