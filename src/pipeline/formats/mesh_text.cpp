#include "pipeline/formats/mesh_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <system_error>

namespace cloth::pipeline {

std::string quoted(std::string_view word) {
    return word.size() <= 40 ? fmt::format("\"{}\"", word) : fmt::format("\"{}…\"", word.substr(0, 40));
}

void split_at_blanks(std::string_view line, std::vector<std::string_view>& words) {
    words.clear();
    constexpr std::string_view blanks = " \t\r\v\f";
    while (true) {
        const std::size_t begin = line.find_first_not_of(blanks);
        if (begin == std::string_view::npos) return;
        line.remove_prefix(begin);
        const std::size_t end = std::min(line.find_first_of(blanks), line.size());
        words.push_back(line.substr(0, end));
        line.remove_prefix(end);
    }
}

double parse_double(std::string_view word, const FilePlace& place) {
    std::string_view digits = word;
    if (digits.size() > 1 && digits[0] == '+' && digits[1] != '-') digits.remove_prefix(1);
    double value = 0.0;
    const auto [end, problem] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (problem == std::errc::result_out_of_range) place.fail(quoted(word) + " does not fit a double");
    if (problem != std::errc() || end != digits.data() + digits.size())
        place.fail(quoted(word) + " is no number");
    if (!std::isfinite(value)) place.fail(quoted(word) + " is not a finite number");
    return value;
}

std::int64_t parse_integer(std::string_view word, const FilePlace& place) {
    std::int64_t value = 0;
    const auto [end, problem] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (problem == std::errc::result_out_of_range) place.fail(quoted(word) + " is too large");
    if (problem != std::errc() || end != word.data() + word.size())
        place.fail(quoted(word) + " is no whole number");
    return value;
}

}  // namespace cloth::pipeline
