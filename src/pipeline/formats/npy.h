#pragma once
// NumPy's arrays in a zip (.npz), in and out.

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace cloth::pipeline {

/// A zip in the making at `path`, which stands for `target` in messages. Its arrays are not compressed, and
/// are written one behind the other. Each call throws Error(other) naming `target` where no more can be
/// written.
class NpzWriter {
  public:
    NpzWriter(const std::filesystem::path& path, std::filesystem::path target);
    NpzWriter(const NpzWriter&) = delete;
    NpzWriter& operator=(const NpzWriter&) = delete;
    ~NpzWriter();

    using Shape = std::vector<std::int64_t>;
    /// `type` as NumPy has it, "<f8": bytes of its numbers follow by write(), row by row, then end().
    void begin(const std::string& name, std::string_view type, const Shape& shape);
    void write(std::string_view bytes);
    void end();
    /// A whole array.
    void array(const std::string& name, std::string_view type, const Shape& shape, std::string_view bytes);
    void close();

  private:
    void check(int result) const;
    std::filesystem::path target_;
    void* zip_;
};

/// An array of floating-point or whole numbers, as doubles.
struct NumberArray {
    std::vector<std::int64_t> shape;
    std::vector<double> numbers;  ///< row by row
};

/// Throws Error(invalid_scene) naming the file where it is no zip, is damaged, or an array is of a kind that
/// is not read (strings, objects, higher byte first, column by column).
class NpzReader {
  public:
    explicit NpzReader(std::filesystem::path path);
    NpzReader(const NpzReader&) = delete;
    NpzReader& operator=(const NpzReader&) = delete;
    ~NpzReader();

    bool has(const std::string& name) const;
    NumberArray read(const std::string& name) const;

  private:
    std::filesystem::path path_;
    void* zip_;
};

}  // namespace cloth::pipeline
