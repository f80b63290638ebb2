#pragma once
// Bytes as text.

#include <string>
#include <string_view>

namespace cloth::pipeline {

/// RFC 4648, with = at the end.
std::string base64(std::string_view bytes);

}  // namespace cloth::pipeline
