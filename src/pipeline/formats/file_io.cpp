#include "pipeline/formats/file_io.h"

#include <stdexcept>

#include "base/whole_file.h"
#include "pipeline/formats/error.h"

namespace cloth::pipeline {

void write_file(const std::filesystem::path& path, std::string_view bytes) {
    try {
        write_whole_file(path, bytes);
    } catch (const std::runtime_error& e) {
        throw Error(ExitCode::other, e.what());
    }
}

std::string read_file(const std::filesystem::path& path) {
    try {
        return read_whole_file(path);
    } catch (const std::runtime_error& e) {
        throw Error(ExitCode::other, e.what());
    }
}

}  // namespace cloth::pipeline
