#pragma once
// Numbers as bytes of binary files.

#include <algorithm>
#include <bit>
#include <string>

namespace cloth::pipeline {

static_assert(std::endian::native == std::endian::little,
              "states and meshes are written as they lie in memory");

/// Lower byte first.
template <class T>
void put(std::string& bytes, T value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

/// Higher byte first.
template <class T>
void put_big_endian(std::string& bytes, T value) {
    put(bytes, value);
    std::reverse(bytes.end() - sizeof value, bytes.end());
}

/// All numbers of a matrix, row by row, as type T.
template <class T, class Matrix>
void put_all(std::string& bytes, const Matrix& numbers) {
    bytes.reserve(bytes.size() + static_cast<std::size_t>(numbers.size()) * sizeof(T));
    for (decltype(numbers.rows()) i = 0; i < numbers.rows(); ++i)
        for (decltype(numbers.cols()) k = 0; k < numbers.cols(); ++k)
            put(bytes, static_cast<T>(numbers(i, k)));
}

}  // namespace cloth::pipeline
