#pragma once
// Words and lines: suggestions, lists, and text that is safe inside a message, HTML or SVG.

#include <cstdint>
#include <string>
#include <vector>

namespace cloth {

/// Least number of inserted, removed and replaced bytes that make `a` out of `b`.
std::size_t edit_distance(const std::string& a, const std::string& b);

/// The candidate nearest to `word`, or "" where none is near: at most 2 edits or a third of its
/// length, and fewer than it has bytes.
std::string nearest_word(const std::string& word, const std::vector<std::string>& candidates);

/// "a, b, c".
std::string join(const std::vector<std::string>& items, const std::string& separator = ", ");

/// "1 face", "2 faces".
std::string plural(std::int64_t n, const std::string& noun);

/// The parts between separators; one empty part for an empty text.
std::vector<std::string> split(const std::string& text, char separator);

/// `text` with a blank for each control character, line ends too: a message is one line, whatever text a file
/// or an argument holds.
std::string one_line(std::string text);

/// `text` with &, <, > and " as HTML, SVG and XML want them.
std::string escaped(const std::string& text);

}  // namespace cloth
