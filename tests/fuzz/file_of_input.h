#pragma once
// A file that holds a fuzzer's input, for readers that want a path.

#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

namespace cloth::pipeline {

/// A folder of this process, made once.
inline const std::filesystem::path& folder_of_inputs() {
    static const std::filesystem::path folder = [] {
        const auto path =
            std::filesystem::temp_directory_path() / ("cloth_fuzz_" + std::to_string(::getpid()));
        std::filesystem::create_directories(path);
        return path;
    }();
    return folder;
}

inline std::filesystem::path file_of(const std::uint8_t* data, std::size_t size, const std::string& name) {
    const std::filesystem::path path = folder_of_inputs() / name;
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
    return path;
}

}  // namespace cloth::pipeline
